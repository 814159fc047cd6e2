// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/surface_distance.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

constexpr double most_comparisons = 2e6;  // of a node and a face: some hundredths of a second

// Least distance of nodes of `a` from faces of `b`, when below `least`.
double from_nodes_to_faces(const PlacedSurface& a, const PlacedSurface& b, double least) {
  const Index n_faces = b.surface.faces.rows();
  Points centres(n_faces, 3);
  Vector radii(n_faces);
  for (Index f = 0; f < n_faces; ++f) {
    const Points corners = b.points(b.surface.faces.row(f), Eigen::all);
    centres.row(f) = corners.colwise().mean();
    radii[f] = std::sqrt((corners.rowwise() - centres.row(f)).rowwise().squaredNorm().maxCoeff());
  }
  const double all = static_cast<double>(a.surface.nodes.size()) * static_cast<double>(n_faces);
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_comparisons)));
  for (std::size_t i = 0; i < a.surface.nodes.size(); i += stride) {
    const Vector3 x = a.points.row(a.surface.nodes[i]).transpose() + a.shift - b.shift;
    for (Index f = 0; f < n_faces; ++f) {
      const double reach = least + radii[f];
      if ((centres.row(f).transpose() - x).squaredNorm() > reach * reach) continue;
      const auto corner = [&](Index k) { return Vector3(b.points.row(b.surface.faces(f, k))); };
      for (Index half = 0; half < (is_triangle(b.surface, f) ? 1 : 2); ++half)
        least = std::min(
            least, (x - nearest_point({corner(0), corner(1 + half), corner(2 + half)}, x)).norm());
    }
  }
  return least;
}

}  // namespace

Vector3 nearest_point(const Triangle& t, const Vector3& x) {
  const Vector3 a = t[1] - t[0], b = t[2] - t[0], r = x - t[0];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), ra = r.dot(a), rb = r.dot(b),
               det = aa * bb - ab * ab;
  if (det > 0) {
    const double u = (bb * ra - ab * rb) / det, v = (aa * rb - ab * ra) / det;
    if (u >= 0 && v >= 0 && u + v <= 1) return t[0] + u * a + v * b;
  }
  Vector3 nearest = t[0];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 edge = t[(i + 1) % 3] - t[i];
    const double length = edge.squaredNorm();
    const Vector3 p =
        t[i] + (length > 0 ? std::clamp((x - t[i]).dot(edge) / length, 0.0, 1.0) : 0.0) * edge;
    if ((p - x).squaredNorm() < (nearest - x).squaredNorm()) nearest = p;
  }
  return nearest;
}

double distance_between(const PlacedSurface& a, const PlacedSurface& b) {
  const double of_a = from_nodes_to_faces(a, b, HUGE_VAL);
  return from_nodes_to_faces(b, a, of_a);
}

}  // namespace cbr
