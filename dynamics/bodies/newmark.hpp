// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark's method and its HHT-alpha form: the numbers that all bodies share.
#pragma once

namespace cbr {

// M a_{n+1} + (1 + alpha) (K u_{n+1} - f_{n+1}) - alpha (K u_n - f_n) = 0 (Hilber, Hughes, Taylor 1977,
// doi 10.1002/eqe.4290050306), alpha in [-1/3, 0]; 0: average acceleration (Newmark 1959), which keeps all energy. Second order and
// stable for any step. An impulse p of contact kicks the velocities at the start of the step, v := v + M^-1 G^T p, and so moves the
// end by h A^-1 G^T p with A = M + (1 + alpha) beta h^2 K, whatever alpha.
struct NewmarkOptions {
  double alpha = 0;
  double beta() const { return 0.25 * (1 - alpha) * (1 - alpha); }
  double gamma() const { return 0.5 - alpha; }
  double stiffness_factor(double h) const { return (1 + alpha) * beta() * h * h; }  // theta: A = M + theta K
};

}  // namespace cbr
