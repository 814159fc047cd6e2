// SPDX-License-Identifier: GPL-3.0-or-later
// The stiffness of a coupled model as statics need it: its inverse where it has one, and the
// motions that it does not resist.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/coupled/coupled_system.hpp"

namespace cbr {

// K u = f with K of rank n - k: u = K^+ f + R a. R^T M R = m I, m the mass of the model, so that a
// is a length. K^+ = P K_a^-1 P^T (inertia relief): P = I - R R^T M / m, and K_a is K with k
// directions more that are held, which carry nothing when P^T f is in equilibrium.
class CoupledStatics {
 public:
  // `held`: of the system. RunError when K is not positive semi-definite, named by `where`.
  CoupledStatics(CoupledSystem& system, const std::vector<HeldDirection>& held, std::string where);

  const Matrix& floating() const { return R_; }  // R, n x k
  const Matrix& inertia() const { return MR_; }  // M R, n x k
  void solve(Vector& f);                         // f <- K^+ f, n
  // G K^+ G^T of the displacements of nodes (3 m x 3 m), component axes; the same nodes get the
  // same.
  std::shared_ptr<const Matrix> nodal_inverse(const std::vector<Index>& nodes);

 private:
  bool is_anchored(const Matrix& R);
  Matrix softest_motions();
  void make_unit(Matrix R);
  void project(const Matrix& A, const Matrix& B, Vector& x) const;

  CoupledSystem& system_;
  std::vector<HeldDirection> held_;
  std::string where_;
  FreeDofs free_;  // of K_a
  std::unique_ptr<CoupledFactor> factor_;
  Matrix R_, MR_;
  std::vector<std::pair<std::vector<Index>, std::shared_ptr<const Matrix>>> known_;
};

}  // namespace cbr
