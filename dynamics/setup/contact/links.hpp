// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of instances, and what links them.
#pragma once

#include <functional>
#include <map>
#include <set>

#include "dynamics/motion/pointed_body.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// The points of an instance, in the order of their names, and behind them those that links need:
// the second end of a link, taken to where the first one is, so that what links them has no length.
std::vector<AveragePoint> points_of(const SceneIndex& index, const BuiltScene& built,
                                    Index instance);

// Nodes on a line, or one, leave a rotation to the shells' own: then those are nodes of the point.
void add_rotations(const Geometry& geometry, const Instance& instance, const Points& positions,
                   AveragePoint& point);

// Place of a named point among them.
Index point_place(const SceneIndex& index, const std::string& instance, const std::string& point);

// All points of all instances: the instance, the name, the point.
using PointVisit = std::function<void(Index, const std::string&, const Component::Point&)>;
void for_each_point(const SceneIndex& index, const PointVisit& visit);

// The nodes of points that links hold, that have mass or are rigid, by instance.
std::map<Index, std::set<Index>> linked_nodes(const SceneIndex& index, const BuiltScene& built);

// A pair of surfaces without faces for the translations that each link holds, and one for its
// rotations; the same for those that have springs, and for the masses of points, each with a joint
// behind the bodies; and one for what keeps a point's nodes rigid. contact_of_instance: places in
// Simulation::contact_nodes.
void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
               BuiltScene& built);

}  // namespace cbr
