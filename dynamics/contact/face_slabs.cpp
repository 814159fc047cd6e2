// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/face_slabs.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/contact/bilinear_face.hpp"

namespace cbr {
// A node over the face at some time is at x = c + xi a + eta b + xi eta w + z n, |xi|, |eta| <= 1 + 2 edge. c, a, b and w change
// linearly in the step, so that a bound at both ends holds between them; n leans from the normal of the end by no more than the
// sides turn and twist.
FaceSlab face_slab(const FaceCorners& start, const FaceCorners& end, bool triangle, double edge) {
  FaceSlab slab;
  if (triangle) return slab;
  const BilinearFace p0(start), p1(end);
  const double h11 = p1.a.squaredNorm(), h22 = p1.b.squaredNorm(), h12 = p1.a.dot(p1.b), determinant = h11 * h22 - h12 * h12;
  if (!(determinant > 1e-6 * h11 * h22)) return slab;
  slab.across = {(h22 * p1.a - h12 * p1.b) / determinant, (h11 * p1.b - h12 * p1.a) / determinant};
  slab.start_centre = p0.c, slab.end_centre = p1.c;
  const double reach = 1 + 2 * edge;
  const double turn = (p1.a - p0.a).norm() + (p1.b - p0.b).norm() + 2 * reach * std::max(p0.w.norm(), p1.w.norm());
  // 1.5: what second order may add
  const double lean = 1.5 * turn * std::max(slab.across[0].norm(), slab.across[1].norm());
  if (!(lean < 0.7)) return slab;
  slab.is_known = true;
  for (int k = 0; k < 2; ++k) {
    const Vector3& across = slab.across[k];
    const auto most = [&](const Vector3& at_start, const Vector3& at_end) {
      return std::max(std::abs(across.dot(at_start)), std::abs(across.dot(at_end)));
    };
    slab.limit[k] = reach * (most(p0.a, p1.a) + most(p0.b, p1.b)) + reach * reach * most(p0.w, p1.w);
    slab.lean[k] = lean * across.norm();
  }
  return slab;
}

bool is_beside(const FaceSlab& slab, const Vector3& start, const Vector3& end) {
  if (!slab.is_known) return false;
  const Vector3 before = start - slab.start_centre, after = end - slab.end_centre;
  // Between the two the distance from the centre is not larger than at both
  const double far = std::sqrt(std::max(before.squaredNorm(), after.squaredNorm()));
  for (int k = 0; k < 2; ++k) {
    const double x0 = slab.across[k].dot(before), x1 = slab.across[k].dot(after), most = slab.limit[k] + slab.lean[k] * far;
    if ((x0 > most && x1 > most) || (x0 < -most && x1 < -most)) return true;
  }
  return false;
}

}  // namespace cbr
