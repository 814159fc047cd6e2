// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/surface_distance.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

constexpr double most_comparisons = 2e6;  // of a node and a face: a few hundredths of a second

// Least distance of nodes of `a` from faces of `b`, if below `least`.
double from_nodes_to_faces(const PlacedSurface& a, const PlacedSurface& b, double least) {
  const NearFaces faces(b.surface, b.points);
  const double all =
      static_cast<double>(a.surface.nodes.size()) * static_cast<double>(faces.size());
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_comparisons)));
  for (std::size_t i = 0; i < a.surface.nodes.size(); i += stride) {
    const Vector3 x = a.points.row(a.surface.nodes[i]).transpose() + a.shift - b.shift;
    for (Index f = 0; f < faces.size(); ++f)
      if (faces.may_be_nearer(f, x, least))
        faces.triangles(f, [&](const Triangle& t) {
          least = std::min(least, (x - nearest_point(t, x)).norm());
        });
  }
  return least;
}

// Distance of two segments along the common normal of their lines (Ericson 2005, 5.1.9), if its
// ends are within both.
double across(const Vector3& a0, const Vector3& a1, const Vector3& b0, const Vector3& b1) {
  const Vector3 u = a1 - a0, v = b1 - b0, r = a0 - b0, n = u.cross(v);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return HUGE_VAL;
  const double s = v.cross(r).dot(n) / n2, t = u.cross(r).dot(n) / n2;
  return s >= 0 && s <= 1 && t >= 0 && t <= 1 ? std::abs(r.dot(n)) / std::sqrt(n2) : HUGE_VAL;
}

// Least distance of crossing edges, if below `least`.
double from_edges_to_edges(const PlacedSurface& a, const PlacedSurface& b, double least) {
  const auto sharp = [](const SurfaceEdge& edge) { return edge.sharp; };
  const auto n_sharp = std::count_if(a.surface.edges.begin(), a.surface.edges.end(), sharp);
  const double all = static_cast<double>(n_sharp) * static_cast<double>(b.surface.edges.size());
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_comparisons)));
  const Vector3 shift = a.shift - b.shift;
  std::size_t i = 0;
  for (const SurfaceEdge& edge : a.surface.edges) {
    if (!edge.sharp || i++ % stride != 0) continue;
    const Vector3 a0 = a.points.row(edge.a).transpose() + shift,
                  a1 = a.points.row(edge.b).transpose() + shift;
    for (const SurfaceEdge& other : b.surface.edges)
      least = std::min(least, across(a0, a1, b.points.row(other.a).transpose(),
                                     b.points.row(other.b).transpose()));
  }
  return least;
}

}  // namespace

NearFaces::NearFaces(const ContactSurface& surface, const Points& points)
    : surface_(surface),
      points_(points),
      centres_(surface.faces.rows(), 3),
      radii_(surface.faces.rows()) {
  for (Index f = 0; f < size(); ++f) {
    const Points corners = points(surface.faces.row(f), Eigen::all);
    centres_.row(f) = corners.colwise().mean();
    radii_[f] = std::sqrt((corners.rowwise() - centres_.row(f)).rowwise().squaredNorm().maxCoeff());
  }
}

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
  double least = from_nodes_to_faces(a, b, HUGE_VAL);
  least = from_nodes_to_faces(b, a, least);
  least = from_edges_to_edges(a, b, least);
  return from_edges_to_edges(b, a, least);
}

}  // namespace cbr
