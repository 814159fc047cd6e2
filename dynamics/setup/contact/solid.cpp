// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/solid.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cbr {
namespace {

// Corners, a triangle's last one twice; `key` is equal for both sides of an interior face.
struct Face {
  std::array<Index, 4> corners, key;
};

std::vector<Face> faces_of(const Mesh& mesh) {
  std::vector<Face> faces;
  for (const Block& block : mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (int side = 1; side <= n_sides(block.type); ++side) {
        const std::vector<int>& local = side_nodes(block.type, side);
        const int n = n_corners(side_kind(block.type, side));
        Face face;
        for (int i = 0; i < 4; ++i)
          face.corners[i] = block.connectivity(e, local[std::min(i, n - 1)]);
        face.key = face.corners;
        std::sort(face.key.begin(), face.key.end());
        faces.push_back(face);
      }
    }
  }
  return faces;
}

}  // namespace

Solid::Solid(const Mesh& mesh) {
  std::vector<Face> faces = faces_of(mesh);
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.key < b.key; });
  const auto is_inner = [&](std::size_t f) {
    return (f > 0 && faces[f - 1].key == faces[f].key) ||
           (f + 1 < faces.size() && faces[f + 1].key == faces[f].key);
  };
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (is_inner(f)) continue;
    const auto corner = [&](std::size_t i) {
      return Vector3(mesh.coordinates.row(faces[f].corners[i]));
    };
    triangles_.push_back({corner(0), corner(1), corner(2)});
    if (faces[f].corners[2] != faces[f].corners[3])
      triangles_.push_back({corner(0), corner(2), corner(3)});
  }
}

bool Solid::holds(const Vector3& x) const {
  double half_angles = 0;
  for (const auto& triangle : triangles_) {
    const Vector3 a = triangle[0] - x, b = triangle[1] - x, c = triangle[2] - x;
    const double A = a.norm(), B = b.norm(), C = c.norm();
    half_angles +=
        std::atan2(a.dot(b.cross(c)), A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
  }
  return std::abs(half_angles) > std::numbers::pi;
}

}  // namespace cbr
