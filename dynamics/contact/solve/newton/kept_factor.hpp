// SPDX-License-Identifier: GPL-3.0-or-later
// Cholesky factor of a dense W over the rows in contact, updated for changes of a few rows.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

class StateArchive;

// Solves W_AA p_A = b over a set A of rows, W scaled to a unit diagonal. The factor L L^T is of a
// set F. Rows of A outside F are appended. For rows of F outside A, p is constrained to 0: with X =
// L^-1 E_removed, p = L^-T (I - X (X^T X)^-1 X^T) L^-1 b.
class KeptFactor {
 public:
  // Factors `rows` (ascending), by updates if they cost less than a new factor, see
  // docs/decisions/contact-solver.md. False, and empty, if W over the rows is singular within
  // round-off.
  bool adapt(const Matrix& W, const std::vector<Index>& rows);
  // Whether adapt() would not need a new factor.
  bool is_near(const std::vector<Index>& rows) const;
  // b, p: entries of the rows of the last adapt().
  void solve(const Vector& b, Vector& p) const;
  void keep_state(StateArchive& archive);
  void clear();
  bool empty() const { return n_ == 0; }

 private:
  struct Change {
    std::vector<Index> added, removed, returned;  // rows; positions; positions
  };
  Change change(const std::vector<Index>& rows) const;
  bool is_small(const Change& change) const;
  bool factor(const Matrix& W, const std::vector<Index>& rows);
  bool append(const Matrix& W, const std::vector<Index>& rows);
  bool remove(const Change& change);
  void place(const std::vector<Index>& rows);

  Index n_ = 0;                   // rows of the factor
  Matrix L_;                      // capacity x capacity, the leading n x n lower triangle in use
  std::vector<Index> row_;        // of W, per position in the factor
  Vector scale_;                  // per position
  std::vector<Index> removed_;    // positions
  Matrix X_;                      // n x removed: L^-1 E_removed
  Matrix gram_;                   // removed x removed: X^T X, then its factor (lower)
  std::vector<Index> positions_;  // of the rows of the last adapt()
  double pivot_ = 0;              // smallest
  mutable Vector y_, small_;
};

}  // namespace cbr
