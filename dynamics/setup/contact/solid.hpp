// SPDX-License-Identifier: GPL-3.0-or-later
// Volume of a mesh.
#pragma once

#include <array>
#include <vector>

#include "common/mesh/mesh.hpp"

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

}  // namespace cbr
