// SPDX-License-Identifier: GPL-3.0-or-later
// Points of the interface: nodes of six dofs, each of which moves a set of the mesh as a rigid
// body (docs/theory.md, "Points of the interface").
#pragma once

#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

struct RigidPoint {
  std::string name;
  std::vector<Index> nodes;  // of the mesh, ascending
  Vector3 at = Vector3::Zero();
};

// Those of reduction.points, by name. Without `at` a point is in the middle of its set, of the
// faces' area if it is a sideset. InputError: a set that the mesh does not have, without nodes, or
// whose nodes are on one line; a node in two of the sets, or in the interface's; a name that a set
// of the mesh has.
std::vector<RigidPoint> rigid_points(const Mesh& mesh, const Component& component);

// K <- G^T K G and M <- G^T M G, u = G [u_others; U_1; theta_1; U_2; ...]: at a point's nodes
// u = U + theta x r, r from the point. In the place of its nodes stand two at the end of all, of
// its translation and its rotation; `row` of its nodes is that of the translation. x: of the
// model's nodes, those of the points included.
void couple_rigidly(const Mesh& mesh, const std::vector<RigidPoint>& points,
                    FiniteElementModel& model, Points& x);

// [1, -[r]x]: the motion of a place r from a point, of its translation and rotation.
Eigen::Matrix<double, 3, 6> motion_at(const Vector3& r);

}  // namespace cbr
