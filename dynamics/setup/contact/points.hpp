// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of instances: those in the scene, and those of its links.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynamics/motion/body_points.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// The points of an instance by name, then those of links. For a link: its second end, at the
// position of the first, so that the link has no length; and sliding points.
std::vector<AveragePoint> points_of(const SceneIndex& index, const BuiltScene& built,
                                    Index instance);

// Nodes on a line, or a single one, do not define a rotation: the point then uses rotation nodes of
// shells.
void add_rotations(const Geometry& geometry, const Instance& instance, const Points& positions,
                   AveragePoint& point);

// Index of a named point in points_of().
Index point_place(const SceneIndex& index, const std::string& instance, const std::string& point);
// Index of a link's second end in points_of() of its instance.
Index second_place(const SceneIndex& index, const LinkOptions& link);

// Whether an end has large rotation.
bool turns(const SceneIndex& index, const LinkOptions& link);
// Whether the link's force on the first end acts at the position of the second. Ends may then
// separate, and the constrained directions rotate with the first. And the index of the sliding
// point in points_of() of the first end's instance.
bool slides(const SceneIndex& index, const LinkOptions& link);
Index sliding_place(const SceneIndex& index, const LinkOptions& link);

// Visits all points of all instances: instance, name, point.
using PointVisit = std::function<void(Index, const std::string&, const Component::Point&)>;
void for_each_point(const SceneIndex& index, const PointVisit& visit);

// Nodes of linked points, and of points with mass or rigid, by instance.
std::map<Index, std::set<Index>> linked_nodes(const SceneIndex& index, const BuiltScene& built);

}  // namespace cbr
