// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/contact_surface.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {

void sweep(ContactBody& body) {
  body.swept = {Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  double way2 = 0;
  for (Index i = 0; i < body.end.rows(); ++i) {
    const Vector3 x0 = body.start.row(i).transpose(), x1 = body.end.row(i).transpose();
    body.swept.lower = body.swept.lower.cwiseMin(x0).cwiseMin(x1);
    body.swept.upper = body.swept.upper.cwiseMax(x0).cwiseMax(x1);
    way2 = std::max(way2, (x1 - x0).squaredNorm());
  }
  body.longest_way = std::sqrt(way2);
}

FaceCorners corners(const ContactSurface& surface, Index face, const Points& points) {
  FaceCorners x;
  for (int a = 0; a < 4; ++a) x[a] = points.row(surface.faces(face, a)).transpose();
  return x;
}

Index slot_of(const ContactSurface& surface, Index face, int corner) {
  return std::lower_bound(surface.nodes.begin(), surface.nodes.end(), surface.faces(face, corner)) -
         surface.nodes.begin();
}

double facing_area(double area, const Vector3& area_vector, const Vector3& normal) {
  constexpr double least_share = 0.2;
  return std::max(-area_vector.dot(normal), least_share * area);
}

double facing_area(const ContactSurface& surface, Index slot, const ContactBody& body,
                   const Vector3& normal) {
  if (surface.area_vectors.rows() == 0) return surface.areas[slot];
  return facing_area(surface.areas[slot], surface.area_vectors.row(slot),
                     body.turn ? body.turn->transpose() * normal : normal);
}

double bend(const ContactSurface& surface) {
  if (surface.area_vectors.rows() == 0) return 0;
  std::vector<double> of_nodes;  // without mid-side nodes of second-order faces, whose area is 0
  for (Index i = 0; i < surface.areas.size(); ++i)
    if (surface.areas[i] > 0)
      of_nodes.push_back(1 - surface.area_vectors.row(i).norm() / surface.areas[i]);
  if (of_nodes.empty()) return 0;
  const auto middle = of_nodes.begin() + static_cast<std::ptrdiff_t>(of_nodes.size() / 2);
  std::nth_element(of_nodes.begin(), middle, of_nodes.end());
  return std::max(0.0, *middle);
}

namespace {

// Centre and normal of a face.
struct FacePlane {
  Vector3 centre, normal;
};

// Whether two faces that share a corner node form a concave corner sharper than 15 degrees.
bool make_a_corner(const FacePlane& a, const FacePlane& b) {
  if (!(a.normal.dot(b.normal) < nearly_flat)) return false;
  const Vector3 between = b.centre - a.centre;
  return a.normal.dot(between) > 0 && b.normal.dot(between) < 0;
}

void fill_rising(ContactSurface& surface, const Points& points) {
  const Index n = surface.faces.rows();
  std::vector<FacePlane> planes(static_cast<std::size_t>(n));
  std::vector<std::vector<Index>> faces_of(surface.nodes.size());
  for (Index f = 0; f < n; ++f) {
    const FaceCorners x = corners(surface, f, points);
    planes[f] = {centre(x), mean_normal(x)};
    for (int a = 0; a < n_corners(surface, f); ++a) faces_of[slot_of(surface, f, a)].push_back(f);
  }
  surface.rising.clear();
  surface.rising_begin.assign(1, 0);
  for (Index f = 0; f < n; ++f) {
    const std::ptrdiff_t first = surface.rising_begin.back();
    for (int a = 0; a < n_corners(surface, f); ++a)
      for (const Index other : faces_of[slot_of(surface, f, a)])
        if (other != f && make_a_corner(planes[f], planes[other]) &&
            std::find(surface.rising.begin() + first, surface.rising.end(), other) ==
                surface.rising.end())
          surface.rising.push_back(other);
    surface.rising_begin.push_back(static_cast<Index>(surface.rising.size()));
  }
  if (surface.rising.empty()) surface.rising_begin.clear();
}

}  // namespace

void fill_sizes(ContactSurface& surface, const Points& points) {
  surface.sizes.resize(surface.faces.rows());
  surface.extent.setZero();
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const FaceCorners x = corners(surface, f, points);
    // Half the cross product of the diagonals, also valid for a triangle with a repeated corner
    surface.sizes[f] = std::sqrt(0.5 * (x[2] - x[0]).cross(x[3] - x[1]).norm());
    for (int a = 1; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        surface.extent = surface.extent.cwiseMax((x[a] - x[b]).cwiseAbs());
  }
  fill_rising(surface, points);
  surface.size = surface.sizes.size() ? surface.sizes.mean() : 0;
  surface.areas.setZero(static_cast<Index>(surface.nodes.size()));
  surface.area_vectors.setZero(surface.areas.size(), 3);
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const FaceCorners x = corners(surface, f, points);
    const Vector3 outward = 0.5 * (x[2] - x[0]).cross(x[3] - x[1]);
    const int n = n_corners(surface, f);
    for (int a = 0; a < n; ++a) {
      const Index slot = slot_of(surface, f, a);
      surface.areas[slot] += surface.sizes[f] * surface.sizes[f] / n;
      surface.area_vectors.row(slot) += outward.transpose() / n;
    }
  }
}

}  // namespace cbr
