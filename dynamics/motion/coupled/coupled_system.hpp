// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model with held directions, ready to move: its products and factors, shared by the
// instances that are held alike.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/coupled/coupled_model.hpp"
#include "dynamics/motion/nodal/block_matrix.hpp"
#include "dynamics/motion/prescribed_motion.hpp"

namespace cbr {

// A = M + theta K of a coupled model, or K, factored once: a step only solves.
//
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

class CoupledStatics;

// For one thread at a time; products and solves allocate nothing.
class CoupledSystem {
 public:
  // `held`: ascending by node, component axes. Factors the mass: RunError when it is not positive
  // definite, named by `where`.
  CoupledSystem(std::shared_ptr<const CoupledModel> model, std::vector<HeldDirection> held,
                std::string where);

  const CoupledModel& model() const { return *model_; }
  Index n() const { return n_; }
  Index n_modal() const { return n_modal_; }
  Index n_free() const { return n_modal_ + free_.Z.cols(); }
  const Matrix& rigid_momentum() const { return MR_; }  // M R, n x 6

  // y = K x, n. The mean translation of x, which has no stiffness, is taken out first: a body that
  // flies far keeps its digits.
  void multiply_stiffness(const Vector& x, Vector& y);
  void multiply_mass(const Vector& x, Vector& y);
  // the part of nodal forces or displacements along held directions := 0
  void drop_held(Vector& f) const;
  bool is_held(Index node) const;
  // A = M + theta K on the free directions; the mass and the last two others are kept.
  const CoupledFactor& factor(double theta);
  // rad/s, of the model as it is held; computed when first asked for.
  double largest_frequency();

  // Found when first asked for.
  CoupledStatics& statics();
  ~CoupledSystem();

 private:
  void multiply_nodal(const BlockMatrix& A, const Vector& x, Vector& y);
  void multiply_stiffness_as_is(const Vector& x, Vector& y);
  bool translations_are_free();

  std::shared_ptr<const CoupledModel> model_;
  std::vector<HeldDirection> held_;
  std::string where_;
  FreeDofs free_;
  Index n_ = 0, n_modal_ = 0;
  BlockMatrix K_, M_;
  RowThreads threads_;
  Matrix MR_;
  bool takes_translation_out_ = false;
  Vector deformation_;
  std::vector<Vector> part_in_, part_out_;
  std::unique_ptr<CoupledFactor> mass_, recent_, before_;
  double largest_frequency_ = -1;
  std::unique_ptr<CoupledStatics> statics_;
};

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

// How a coupled model rests when its supports are moved. Column j of `motion` (held x m) moves the
// held directions in the j-th way. RunError: a mass that is not positive definite, named by
// `where`.
SupportShapes coupled_shapes(const std::shared_ptr<const CoupledModel>& model,
                             const std::vector<HeldDirection>& held, const Matrix& motion,
                             const std::string& where);

}  // namespace cbr
