// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that overlap before the first step.
#pragma once

#include <array>
#include <vector>

#include "common/app/report.hpp"
#include "common/mesh/mesh.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Boundary of the mesh's volume elements as triangles; second-order faces by their corners,
// quadrilaterals cut in two.
class Solid {
 public:
  explicit Solid(const Mesh& mesh);
  // Whether x (mesh axes) is inside: the boundary's solid angle at x is above half of all
  // directions. Triangles by Van Oosterom, Strackee 1983 (doi 10.1109/TBME.1983.325207). On the
  // boundary either result is possible.
  bool holds(const Vector3& x) const;
  Index n_triangles() const { return static_cast<Index>(triangles_.size()); }

 private:
  std::vector<std::array<Vector3, 3>> triangles_;
};

// Checks every pair of two bodies. Candidates are nodes of each within the other's extents,
// straight behind the nearest of its faces. Deeper than a face, and inside the other's mesh: a
// warning with pair, depth and node id. Contact would take such a node to be beyond a thin body.
// Less deep, between bodies at rest, which are not searched: recorded as the pair's initial
// overlap. Large surfaces: every k-th node.
void look_for_overlaps(const Scene& scene, BuiltScene& built, Report& report);

}  // namespace cbr
