// SPDX-License-Identifier: GPL-3.0-or-later
// What space a mesh fills.
#pragma once

#include <array>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace cbr {

// The boundary of the mesh's volume elements as triangles; faces of second order by their corners,
// quadrilaterals cut in two.
class Solid {
 public:
  explicit Solid(const Mesh& mesh);
  // Whether x (the mesh's axes) is inside: the solid angle that the boundary takes up of all
  // directions, seen from there, is above one half. Triangles by Van Oosterom, Strackee 1983
  // (doi 10.1109/TBME.1983.325207). On the boundary either answer is possible.
  bool holds(const Vector3& x) const;
  Index n_triangles() const { return static_cast<Index>(triangles_.size()); }

 private:
  std::vector<std::array<Vector3, 3>> triangles_;
};

}  // namespace cbr
