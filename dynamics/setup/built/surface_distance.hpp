// SPDX-License-Identifier: GPL-3.0-or-later
// Distance of a point from triangles, and of two surfaces.
#pragma once

#include <array>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

using Triangle = std::array<Vector3, 3>;

// Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5, by its edges).
Vector3 nearest_point(const Triangle& t, const Vector3& x);

// Faces of a surface for searches of those nearest to a point. `points`: of all contact nodes of
// its body; both must outlive it.
class NearFaces {
 public:
  NearFaces(const ContactSurface& surface, const Points& points);

  Index size() const { return radii_.size(); }
  // False: no point of the face is nearer to x than `least`.
  bool may_be_nearer(Index face, const Vector3& x, double least) const {
    const double reach = least + radii_[face];
    return !((centres_.row(face).transpose() - x).squaredNorm() > reach * reach);
  }
  // Takes the triangles of the face, one or two.
  template <typename Take>
  void triangles(Index face, const Take& take) const {
    const auto corner = [&](Index k) { return Vector3(points_.row(surface_.faces(face, k))); };
    for (Index half = 0; half < (is_triangle(surface_, face) ? 1 : 2); ++half)
      take(Triangle{corner(0), corner(1 + half), corner(2 + half)});
  }

 private:
  const ContactSurface& surface_;
  const Points& points_;
  Points centres_;
  Vector radii_;
};

// Contact points of the surface in place: `points` of all contact nodes of its body, with a common
// shift.
struct PlacedSurface {
  const ContactSurface& surface;
  const Points& points;  // m x 3
  Vector3 shift = Vector3::Zero();
};

// Least distance of nodes of each from faces of the other, and of sharp edges from edges; never
// below 0. Large surfaces: a subset of nodes and edges.
double distance_between(const PlacedSurface& a, const PlacedSurface& b);

}  // namespace cbr
