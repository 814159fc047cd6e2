// SPDX-License-Identifier: GPL-3.0-or-later
// What is closed, sticks and slides, and the unknowns that this leaves.
#pragma once

#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"

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

// Unknowns x of a set. `rows`: the k rows of points that are not open, those that no impulse moves
// left out. Over these rows p = C x (k x n); equations R^T gap + alpha x = 0 (n), R with
// orthonormal columns. C = R when nothing slides.
struct SetBases {
  std::vector<Index> rows;
  SparseMatrix R, C;
  Vector alpha;
  bool symmetric = true;
  Index size() const { return R.cols(); }
};

SetBases set_bases(const ContactProblem& problem, const ContactSet& set);

}  // namespace cbr
