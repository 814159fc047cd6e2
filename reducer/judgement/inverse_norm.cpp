// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/inverse_norm.hpp"

#include <algorithm>

namespace cbr {
namespace {

constexpr int most_rounds = 5;

}  // namespace

double inverse_norm(Index n, const std::function<void(Vector&)>& solve) {
  InverseNorm search(n);
  while (!search.is_done()) {
    Vector x = search.asked();
    solve(x);
    search.answer(x);
  }
  return search.norm();
}

InverseNorm::InverseNorm(Index n)
    : x_(Vector::Constant(n, n > 0 ? 1.0 / static_cast<double>(n) : 0)), asked_(x_) {
  if (n == 0) next_ = Next::nothing;
}

void InverseNorm::answer(const Vector& y) {
  switch (next_) {
    case Next::length:
      return measure(y);
    case Next::slope:
      return climb(y);
    case Next::second_guess:
      norm_ = std::max(norm_, 2 * y.lpNorm<1>() / (3 * static_cast<double>(y.size())));
      next_ = Next::nothing;
      return;
    case Next::nothing:
      return;
  }
}

void InverseNorm::measure(const Vector& y) {
  const double found = y.lpNorm<1>();
  if (round_ > 0 && !(found > norm_)) return guess_again();
  norm_ = found;
  asked_ = y.unaryExpr([](double v) { return v >= 0 ? 1.0 : -1.0; });
  next_ = Next::slope;
}

void InverseNorm::climb(const Vector& z) {
  Index j = 0;
  const double steepest = z.cwiseAbs().maxCoeff(&j);
  if (!(steepest > z.dot(x_)) || j == last_ || ++round_ == most_rounds) return guess_again();
  x_.setZero();
  x_(j) = 1;
  last_ = j;
  asked_ = x_;
  next_ = Next::length;
}

// Higham's second guess, for matrices that are made to mislead the first.
void InverseNorm::guess_again() {
  const Index n = x_.size();
  for (Index i = 0; i < n; ++i)
    asked_(i) = (i % 2 == 0 ? 1 : -1) *
                (1 + static_cast<double>(i) / static_cast<double>(std::max<Index>(n - 1, 1)));
  next_ = Next::second_guess;
}

}  // namespace cbr
