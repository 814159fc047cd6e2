// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of instances: those that the scene names, and those that its links need.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynamics/motion/pointed_body.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// The points of an instance, in the order of their names, and behind them those that links need:
// the second end of a link, taken to where the first one is, so that what links them has no length;
// and the sliding ones.
std::vector<AveragePoint> points_of(const SceneIndex& index, const BuiltScene& built,
                                    Index instance);

// Nodes on a line, or one, leave a rotation to the shells' own: then those are nodes of the point.
void add_rotations(const Geometry& geometry, const Instance& instance, const Points& positions,
                   AveragePoint& point);

// Place of a named point among them.
Index point_place(const SceneIndex& index, const std::string& instance, const std::string& point);
// Of the second end of a link among those of its instance.
Index second_place(const SceneIndex& index, const LinkOptions& link);

// Whether an end turns by any angle.
bool turns(const SceneIndex& index, const LinkOptions& link);
// Whether what acts on the first end acts at the place of the second: the two may move apart, and
// the directions in which they are held turn with the first. The place of its sliding point among
// those of the first end's instance.
bool slides(const SceneIndex& index, const LinkOptions& link);
Index sliding_place(const SceneIndex& index, const LinkOptions& link);

// All points of all instances: the instance, the name, the point.
using PointVisit = std::function<void(Index, const std::string&, const Component::Point&)>;
void for_each_point(const SceneIndex& index, const PointVisit& visit);

// The nodes of points that links hold, that have mass or are rigid, by instance.
std::map<Index, std::set<Index>> linked_nodes(const SceneIndex& index, const BuiltScene& built);

}  // namespace cbr
