// SPDX-License-Identifier: GPL-3.0-or-later
// A = M + theta K of a coupled model, or K, factored once: a step only solves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/coupled/coupled_model.hpp"

namespace cbr {

// The modal coordinates q_k of the parts are eliminated exactly, D = I + theta diag(lambda) being
// diagonal: S = sum over parts (M_cc + theta K_cc - M_kc^T D^-1 M_kc) + M + theta K of meshes and
// shells, on the free nodal dofs. S is dense for one superelement alone, sparse by dense blocks
// (CHOLMOD, supernodal) otherwise; a diagonal S (lumped masses) is divided by. One object is for
// one thread at a time; `model` and `free` must outlive it.
class CoupledFactor {
 public:
  // A = K where theta is infinite. RunError when A is not positive definite, named by `where`.
  CoupledFactor(const CoupledModel& model, const FreeDofs& free, double theta,
                const std::string& where);
  ~CoupledFactor();
  CoupledFactor(CoupledFactor&&) noexcept;
  CoupledFactor& operator=(CoupledFactor&&) noexcept;

  double theta() const;
  // x (n coordinates of the model) = Z A_free^-1 Z^T f, in place: the answer to forces f when held
  // directions are held. No allocation.
  void solve(Vector& f) const;
  // The block of A_free^-1 on the free nodal dofs, S^-1, in place: free x m. What forces on nodes
  // do to nodes.
  void solve_free(Eigen::Ref<Matrix> Y) const;
  // G A^-1 G^T of the displacements of nodes in axes turned by T: rows 3 i + a of G are T_a .
  // u(nodes[i])   (3m x 3m).
  Matrix nodal_inverse(const std::vector<Index>& nodes, const Matrix3& T) const;
  // The least of the diagonal of S that its elimination leaves, as a share of it.
  double smallest_pivot() const;
  // S when it is diagonal, else empty.
  const Vector& diagonal() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
