// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/contact_point.hpp"

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

Matrix3 contact_frame(const Vector3& normal) {
  const double x = normal[0], y = normal[1], z = normal[2], s2 = x * x + y * y;
  Matrix3 frame;
  frame.row(0) = normal.transpose();
  // The smallest rotation from z to the normal, applied to x and y. 1 + z = s2 / (1 - z) avoids
  // cancellation near the pole z = -1.
  const double one_plus_z = z > 0 ? 1 + z : s2 / (1 - z);
  if (!(one_plus_z > 1e-30)) {
    frame.row(1) << 0, -1, 0;
    frame.row(2) << -1, 0, 0;
    return frame;
  }
  const double b = -x * y / one_plus_z;
  frame.row(1) << 1 - x * x / one_plus_z, b, -x;
  frame.row(2) << b, 1 - y * y / one_plus_z, -y;
  return frame;
}

Vector3 relative_motion(const ContactList& list, const ContactPoint& point,
                        const std::vector<ContactBody>& bodies) {
  Vector3 motion = Vector3::Zero();
  for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
    const ContactTerm& term = list.terms[t];
    motion +=
        term.coefficient *
        (bodies[term.body].end.row(term.node) - bodies[term.body].start.row(term.node)).transpose();
  }
  return motion;
}

Vector3 slave_position(const ContactList& list, const ContactPoint& point,
                       const std::vector<ContactBody>& bodies) {
  Vector3 x = Vector3::Zero();
  for (Index t = point.first_term; t < point.first_term + point.n_slave_terms; ++t) {
    const ContactTerm& term = list.terms[t];
    x += term.coefficient * bodies[term.body].end.row(term.node).transpose();
  }
  return x;
}

}  // namespace cbr
