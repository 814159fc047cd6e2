// SPDX-License-Identifier: GPL-3.0-or-later
// Where bodies can touch: what search finds, response weighs and enforcement loads, for node-face,
// mortar and walls alike.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// coefficient x position of a contact node of a contact body (or x its displacement, its velocity).
struct ContactTerm {
  Index body = 0, node = 0;
  double coefficient = 0;
};

// What an impulse on a point has to obey.
enum class ContactLaw : char {
  frictionless,  // one row: p_n >= 0, g_n >= 0, p_n g_n = 0
  coulomb,  // three: the same, and |p_t| <= mu p_n, against the slip when they are equal, no slip
            // below it
  tied      // three: nothing separates, in any direction
};

inline Index n_rows(ContactLaw law) { return law == ContactLaw::frictionless ? 1 : 3; }

// One per contact point; rows of gaps, impulses and W follow each other point by point, n_rows(law)
// each (normal first).
struct PointLaw {
  ContactLaw law = ContactLaw::frictionless;
  double friction = 0;  // mu > 0, of coulomb
};

// A weighted relative position r = sum of terms: slave nodes with coefficients that sum to 1,
// master nodes with ones that sum to -1 (none against a rigid wall). A node against a face has one
// slave node and up to four master nodes; a mortar point has the slave nodes and master nodes that
// share the support of its multiplier.
struct ContactPoint {
  // Rows: the unit normal, outward from the master, and two unit tangents (right-handed). Impulses
  // and gaps have these axes.
  Matrix3 frame = Matrix3::Identity();
  // (0): normal . r - offset at the end of the step, without impulses. (1), (2): the slip tangents
  // . (r_end - r_start) over the step. tied: all three are what separates at the end of the step.
  Vector3 gap = Vector3::Zero();
  double start_gap = 0;  // normal . r - offset at the start of the step
  double area = 0;       // of the slave surface that it stands for, undeformed
  // slave node (position in the slave surface's nodes) that it belongs to
  Index slot = 0;
  Index face = -1;                    // master face; of several the one with the largest share
  Index first_term = 0, n_terms = 0;  // in ContactList::terms
  Index n_slave_terms = 1;            // those of the slave come first
  Vector3 normal() const { return frame.row(0).transpose(); }
};

struct ContactList {
  std::vector<ContactPoint> points;
  std::vector<ContactTerm> terms;
  bool empty() const { return points.empty(); }
};

struct ContactBody;

// sum of coefficient x (end - start) over the point's terms: a relative displacement over the step,
// scene axes.
Vector3 relative_motion(const ContactList& list, const ContactPoint& point,
                        const std::vector<ContactBody>& bodies);

// sum of coefficient x end over the slave terms: where the point is at the end of the step.
Vector3 slave_position(const ContactList& list, const ContactPoint& point,
                       const std::vector<ContactBody>& bodies);

// Completes a unit normal to a right-handed frame (rows normal, t1, t2); the tangents depend on the
// normal alone and do not jump where the normal turns a little, except at one pole.
Matrix3 contact_frame(const Vector3& normal);

}  // namespace cbr
