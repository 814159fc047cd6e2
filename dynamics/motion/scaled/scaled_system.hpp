// SPDX-License-Identifier: GPL-3.0-or-later
// The reduced matrices of a component with some thousand interface dofs, and its elastic
// flexibility: what modal mass scaling needs when all modes would cost too much.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/diagonal_form.hpp"

namespace cbr {

// Free coordinates [q_k; u_f], u_c = Z u_f: K^ = [Lambda, 0; 0, K], M^ = [I, A; A^T, M].
class ScaledSystem {
 public:
  // RunError, named by `where`: fixed-interface modes or the interface that move without stiffness;
  // no mass.
  ScaledSystem(std::shared_ptr<const Superelement> superelement,
               const std::vector<HeldDirection>& held, std::string where);

  Index k() const { return lambda_.size(); }
  Index f() const { return K().rows(); }
  Index n() const { return k() + f(); }
  Index n_rigid() const { return N_.cols(); }
  const Vector& lambda() const { return lambda_; }
  const Matrix& K() const { return held_ ? K_held_ : superelement_->K_cc; }
  const Matrix& M() const { return held_ ? M_held_ : superelement_->M_cc; }
  const Matrix& A() const { return held_ ? A_held_ : superelement_->M_kc; }
  // rows of u_f, f x n_rigid: N^T M N = I; those of q_k are 0
  const Matrix& rigid_modes() const { return N_; }
  const Matrix& rigid_momentum() const { return MN_; }  // M^ [0; N], n x n_rigid
  // M^ R, (k + c) x 6, R about the centre of mass
  const Matrix& momentum() const { return MR_; }
  bool is_held() const { return held_; }
  const std::string& where() const { return where_; }

  Matrix times_mass(const Eigen::Ref<const Matrix>& X) const;  // M^ X, n x q
  Matrix spread(const Matrix& X) const;                        // [q_k; Z u_f], (k + c) x q
  Matrix gather(const Matrix& F) const;                        // [f_k; Z^T f_c], n x q
  // Z G Z^T at some coordinates of [q_k; u_c], which are interface dofs or -1: then 0   (G: f x f)
  Matrix interface_block(const Matrix& G, const std::vector<Index>& coordinates) const;
  double largest_frequency() const;  // rad/s; takes f x f while it runs

 private:
  void find_rigid_modes(const std::vector<HeldDirection>& held);

  std::shared_ptr<const Superelement> superelement_;
  std::string where_;
  bool held_ = false;
  Vector lambda_;
  SparseMatrix Z_;
  Matrix K_held_, M_held_, A_held_, N_, MN_, MR_;
};

// F = sum of V_j V_j^T / omega_j^2 over the elastic modes of a system, from one factor of K.
class ElasticFlexibility {
 public:
  // RunError: there are more motions without stiffness than the rigid ones. Keeps f x f.
  explicit ElasticFlexibility(std::shared_ptr<const ScaledSystem> system);

  void solve(Eigen::Ref<Matrix> B) const;                               // B <- F B, n x q
  Matrix interface_block(const std::vector<Index>& coordinates) const;  // of F; see ScaledSystem

 private:
  std::shared_ptr<const ScaledSystem> system_;
  Matrix G_;  // (K + s N^ N^^T)^-1, f x f
  Matrix X_;  // the rigid part that is taken out of G: F_ff = G - N X^T - X N^T, f x n_rigid
};

}  // namespace cbr
