// SPDX-License-Identifier: GPL-3.0-or-later
// What the time integrations of all bodies share: the impulses of a step, the numbers of Newmark's
// method and its HHT-alpha form.
#pragma once

#include "common/base/types.hpp"
#include "dynamics/motion/body_readings.hpp"

namespace cbr {

// The sum of the impulses of a step   (n); false: there are none.
class Kick {
 public:
  explicit Kick(Index n = 0) : sum_(Vector::Zero(n)) {}
  void clear() { any_ = false; }
  void add(const Vector& impulse) {
    if (!any_) sum_.setZero(impulse.size());
    sum_ += impulse;
    any_ = true;
  }
  explicit operator bool() const { return any_; }
  const Vector& sum() const { return sum_; }

 private:
  Vector sum_;
  bool any_ = false;
};

// Of an impulse on coordinates of mass 1 whose rates are v before it.
inline void book_kick(const Vector& impulse, const Vector& v, BodyWork& work) {
  work.contact += impulse.dot(v) + 0.5 * impulse.squaredNorm();
}

// M a_{n+1} + (1 + alpha) (K u_{n+1} - f_{n+1}) - alpha (K u_n - f_n) = 0 (Hilber, Hughes, Taylor
// 1977, doi 10.1002/eqe.4290050306), alpha in [-1/3, 0]; 0: average acceleration (Newmark 1959),
// which keeps all energy. Second order and stable for any step. An impulse p of contact is a force
// p / h that is constant over the step and no part of a:
//   v_{n+1} = v_n + h ((1 - gamma) a_n + gamma a_{n+1}) + M^-1 G^T p,   u_{n+1} = ... + h / 2 M^-1
//   G^T p,
// so it moves the end by h / 2 A^-1 G^T p, A = M + (1 + alpha) beta h^2 K, and for any alpha
//   v_{n+1} = 2 / h (u_{n+1} - u_n) - v_n - alpha^2 / 2 h (a_{n+1} - a_n).
// The impulse's work is p . G (u_{n+1} - u_n) / h: where the gap at the end is nil, -p g_n / h,
// never above 0, at any step. (A kick at the start, as under central differences, brings energy
// above the critical step: several times that of an impact at 10 to 20 of it.) Velocities of what
// is closed are settled afterwards, see settle_velocities() of
// dynamics/contact/enforce/enforcement.hpp.
struct NewmarkOptions {
  double alpha = 0;
  double beta() const { return 0.25 * (1 - alpha) * (1 - alpha); }
  double gamma() const { return 0.5 - alpha; }
  // theta: A = M + theta K
  double stiffness_factor(double h) const { return (1 + alpha) * beta() * h * h; }
};

}  // namespace cbr
