// SPDX-License-Identifier: GPL-3.0-or-later
// Contact points, for node-face, mortar and walls: the result of the search, the rows of the
// response and the points of the enforcement.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// coefficient x position of a contact node of a contact body (or x displacement, x velocity).
struct ContactTerm {
  Index body = 0, node = 0;
  double coefficient = 0;
};

// Conditions on the impulse at a point.
enum class ContactLaw : char {
  frictionless,  // one row: p_n >= 0, g_n >= 0, p_n g_n = 0
  // three rows: the same, and |p_t| <= mu p_n; at equality p_t opposes the slip, below it the point
  // sticks
  coulomb,
  tied  // three rows: no separation in any direction
};

inline Index n_rows(ContactLaw law) { return law == ContactLaw::frictionless ? 1 : 3; }

// One per contact point. Rows of gaps, impulses and W are ordered by point, n_rows(law) each,
// normal first.
struct PointLaw {
  ContactLaw law = ContactLaw::frictionless;
  double friction = 0;  // mu > 0 in this step, for coulomb: laws/friction_law.hpp
  bool operator==(const PointLaw&) const = default;
};

// A weighted relative position r = sum of terms. Coefficients of slave nodes sum to 1, those of
// master nodes to -1 (none for a rigid wall). A node against a face: one slave node and up to four
// master nodes. A mortar point: the slave and master nodes that share the support of its
// multiplier.
struct ContactPoint {
  // Rows: the unit normal, outward from the master, and two unit tangents (right-handed). Axes of
  // impulses and gaps.
  Matrix3 frame = Matrix3::Identity();
  // (0): normal . r - offset at the end of the step, without impulses. (1), (2): the slip tangents
  // . (r_end - r_start) over the step. tied: all three are separations at the end of the step.
  Vector3 gap = Vector3::Zero();
  double start_gap = 0;  // normal . r - offset at the start of the step
  double area = 0;       // tributary area of the slave surface, undeformed
  // its slave node, as a position in the slave surface's nodes
  Index slot = 0;
  Index face = -1;                    // master face; of several the one with the largest area
  Index first_term = 0, n_terms = 0;  // in ContactList::terms
  Index n_slave_terms = 1;            // they precede those of the master
  Vector3 normal() const { return frame.row(0).transpose(); }
};

struct ContactList {
  std::vector<ContactPoint> points;
  std::vector<ContactTerm> terms;
  bool empty() const { return points.empty(); }
};

struct ContactBody;

// Sum of coefficient x (end - start) over the point's terms: relative displacement in the step,
// scene axes.
Vector3 relative_motion(const ContactList& list, const ContactPoint& point,
                        const std::vector<ContactBody>& bodies);

// Sum of coefficient x end over the slave terms: position of the point at the end of the step.
Vector3 slave_position(const ContactList& list, const ContactPoint& point,
                       const std::vector<ContactBody>& bodies);

// Completes a unit normal to a right-handed frame (rows normal, t1, t2). The tangents are
// continuous functions of the normal, except at one pole.
Matrix3 contact_frame(const Vector3& normal);

}  // namespace cbr
