// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/contact_surface.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {

Vector3 mean_normal(const FaceCorners& x) {
  const Vector3 across = (x[2] - x[0]).cross(x[3] - x[1]);
  const double length2 = across.squaredNorm();
  // Where squares neither overflow nor underflow, this saves two divisions
  if (length2 > 1e-200 && length2 < 1e200) return across * (1 / std::sqrt(length2));
  return across.stableNormalized();
}

Vector3 centre(const FaceCorners& x) {
  return x[2] == x[3] ? Vector3((x[0] + x[1] + x[2]) / 3)
                      : Vector3((x[0] + x[1] + x[2] + x[3]) / 4);
}

Vector3 mean_motion(const ContactSurface& surface, const ContactBody& body) {
  Vector3 sum = Vector3::Zero();
  for (const Index node : surface.nodes)
    sum += (body.end.row(node) - body.start.row(node)).transpose();
  return sum / static_cast<double>(std::max<std::size_t>(1, surface.nodes.size()));
}

double largest_motion(const ContactSurface& surface, const ContactBody& body,
                      const Vector3& drift) {
  double largest = 0;
  for (const Index node : surface.nodes)
    largest =
        std::max(largest, (body.end.row(node) - body.start.row(node) - drift.transpose()).norm());
  return largest;
}

}  // namespace cbr
