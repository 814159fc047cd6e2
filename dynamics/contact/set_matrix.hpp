// SPDX-License-Identifier: GPL-3.0-or-later
// The linear system of one Newton step: what is closed, sticks and slides is fixed.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/contact_laws.hpp"

namespace cbr {

enum class PointState : char {
  open,    // p = 0
  normal,  // gap_n = 0, one row
  stick,   // all three gaps 0; tied points always
  slide    // gap_n = 0, p_t along the slip
};

struct ContactSet {
  std::vector<PointState> states;
  Points slides;  // of sliding points: (d_1, d_2, alpha), d the unit direction of p_t
  bool slides_anywhere() const;
};

// What the natural map says about p and gap = g + W p: the argument of each projection decides.
ContactSet contact_set(const ContactProblem& problem, const Vector& p, const Vector& gap);

// K = R^T W C + diag(alpha)   (n x n), p = C x; symmetric when nothing slides.
class SetMatrix {
 public:
  SetMatrix(const ContactProblem& problem, const ContactSet& set);
  ~SetMatrix();
  SetMatrix(SetMatrix&&) noexcept;
  SetMatrix& operator=(SetMatrix&&) noexcept;
  // p (m) with R^T (g + W C x) + alpha x = 0.
  Vector solve(const Vector& g) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
