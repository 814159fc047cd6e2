// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "common/base/types.hpp"

namespace cbr {

// |A^-1|_1 from below, mostly within a factor of 2, by a handful of solves (Hager 1984,
// doi 10.1137/0905023; Higham 1988, doi 10.1145/50063.214386). solve: x <- A^-1 x (n).
double inverse_norm(Index n, const std::function<void(Vector&)>& solve);

// The same search as questions and answers, for those who have several at a time.
class InverseNorm {
 public:
  explicit InverseNorm(Index n);

  bool is_done() const { return next_ == Next::nothing; }
  const Vector& asked() const { return asked_; }  // n
  void answer(const Vector& y);                   // A^-1 asked()
  double norm() const { return norm_; }

 private:
  enum class Next { length, slope, second_guess, nothing };

  void measure(const Vector& y);
  void climb(const Vector& z);
  void guess_again();

  Vector x_, asked_;
  double norm_ = 0;
  Index last_ = -1;
  int round_ = 0;
  Next next_ = Next::length;
};

}  // namespace cbr
