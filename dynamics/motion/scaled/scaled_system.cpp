// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/scaled/scaled_system.hpp"

#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/dense_factor.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/huge_pages.hpp"

namespace cbr {
namespace {

// M^ R = [M_kc R_c; M_cc R_c]   ((k + c) x 6)
Matrix mass_times(const Superelement& s, const Matrix& R) {
  Matrix MR(s.n(), R.cols());
  if (s.k() > 0) MR.topRows(s.k()).noalias() = s.M_kc * R.bottomRows(s.c());
  MR.bottomRows(s.c()).noalias() = s.M_cc * R.bottomRows(s.c());
  return MR;
}

}  // namespace

ScaledSystem::ScaledSystem(std::shared_ptr<const Superelement> superelement,
                           const std::vector<HeldDirection>& held, std::string where)
    : superelement_(std::move(superelement)),
      where_(std::move(where)),
      held_(!held.empty()),
      lambda_(superelement_->eigenvalues) {
  const Superelement& s = *superelement_;
  if (k() > 0 && !(lambda_.minCoeff() > 1e-12 * lambda_.maxCoeff()))
    throw RunError(where_ +
                   ": time.mass_scaling: a fixed-interface mode has no stiffness: store the "
                   "diagonal form with the "
                   "superelement, or leave out time.mass_scaling");
  if (held_) {
    // K = Z^T K_cc Z, M = Z^T M_cc Z, A = M_kc Z
    Z_ = free_interface_basis(s, held);
    const SparseMatrix Zt = Z_.transpose();
    Matrix half = s.K_cc * Z_;
    K_held_ = Zt * half;
    half = s.M_cc * Z_;
    M_held_ = Zt * half;
    A_held_ = s.M_kc * Z_;
  }
  if (f() == 0)
    throw RunError(where_ +
                   ": time.mass_scaling: no interface dof is free: leave out time.mass_scaling");
  find_rigid_modes(held);
}

// N: the rigid motions that held directions allow, M-orthonormal.
void ScaledSystem::find_rigid_modes(const std::vector<HeldDirection>& held) {
  const Superelement& s = *superelement_;
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  MR_ = mass_times(s, R);
  Matrix R_f = gather(R).bottomRows(f());
  if (held_) {
    // What Z cannot follow, in units of length: its square is a 6 x 6 matrix whose kernel are the
    // free motions
    const double size = std::sqrt(
        std::max(s.rigid_body.inertia.trace() / std::max(s.rigid_body.mass, 1e-300), 1e-300));
    Matrix blocked = R.bottomRows(s.c()) - Z_ * R_f;
    blocked.rightCols(3) /= size;
    R_f.rightCols(3) /= size;
    const Matrix resisted = resisted_rigid_motions(s);
    const SymmetricEigen motions =
        symmetric_eigen(blocked.transpose() * blocked + resisted.transpose() * resisted);
    const Index free = n_free_rigid_motions(R, s.rigid_body, displacement_rows(s), held, resisted);
    R_f = (R_f * motions.vectors.leftCols(free)).eval();
  } else if ((K() * R_f).norm() > 1e-8 * K().norm() * R_f.norm()) {
    R_f.resize(f(), 0);  // held by what the reduction joined to it
  }
  N_ = std::move(R_f);
  if (N_.cols() > 0) {
    const Cholesky mass(N_.transpose() * (M() * N_));
    if (!mass.ok())
      throw RunError(where_ +
                     ": time.mass_scaling: the interface does not tell all rigid motions apart: "
                     "store the diagonal form " +
                     "with the superelement, or leave out time.mass_scaling");
    mass.divide_by_upper(N_);
  }
  MN_.resize(n(), N_.cols());
  if (N_.cols() == 0) return;
  if (k() > 0) MN_.topRows(k()).noalias() = A() * N_;
  MN_.bottomRows(f()).noalias() = M() * N_;
}

Matrix ScaledSystem::times_mass(const Eigen::Ref<const Matrix>& X) const {
  const auto X_k = X.topRows(k()), X_f = X.bottomRows(f());
  Matrix Y(n(), X.cols());
  Y.bottomRows(f()).noalias() = M() * X_f;
  if (k() == 0) return Y;
  Y.bottomRows(f()).noalias() += A().transpose() * X_k;
  Y.topRows(k()) = X_k;
  Y.topRows(k()).noalias() += A() * X_f;
  return Y;
}

Matrix ScaledSystem::spread(const Matrix& X) const {
  if (!held_) return X;
  Matrix U(superelement_->n(), X.cols());
  U.topRows(k()) = X.topRows(k());
  U.bottomRows(superelement_->c()) = Z_ * X.bottomRows(f());
  return U;
}

Matrix ScaledSystem::gather(const Matrix& F) const {
  if (!held_) return F;
  Matrix B(n(), F.cols());
  B.topRows(k()) = F.topRows(k());
  B.bottomRows(f()) = Z_.transpose() * F.bottomRows(superelement_->c());
  return B;
}

Matrix ScaledSystem::interface_block(const Matrix& G, const std::vector<Index>& coordinates) const {
  const Index m = static_cast<Index>(coordinates.size());
  Matrix S = zeros_on_huge_pages(m, m);
  if (!held_) {
    for (Index j = 0; j < m; ++j) {
      if (coordinates[j] < 0) continue;
      const double* column = G.data() + (coordinates[j] - k()) * G.rows();
      for (Index i = 0; i < m; ++i)
        if (coordinates[i] >= 0) S(i, j) = column[coordinates[i] - k()];
    }
    return S;
  }
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index i = 0; i < m; ++i)
    if (coordinates[i] >= 0) entries.emplace_back(coordinates[i] - k(), i, 1.0);
  SparseMatrix chosen(superelement_->c(), m);
  chosen.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix rows = Z_.transpose() * chosen;  // f x m
  const Matrix half = G * rows;
  S = rows.transpose() * half;
  return S;
}

double ScaledSystem::largest_frequency() const {
  // M^-1 by the Schur complement of the modal coordinates: M - A^T A = L L^T
  Matrix L = M();
  if (k() > 0) L.selfadjointView<Eigen::Lower>().rankUpdate(A().transpose(), -1);
  if (!dense_cholesky(L)) throw RunError(where_ + ": the reduced mass is not positive definite");
  const auto lower = L.triangularView<Eigen::Lower>();
  const auto upper = L.transpose().triangularView<Eigen::Upper>();
  const LinearMap multiply_K = [&](const Vector& x, Vector& y) {
    y.resize(n());
    y.head(k()) = lambda_.cwiseProduct(x.head(k()));
    y.tail(f()).noalias() = K().selfadjointView<Eigen::Lower>() * x.tail(f());
  };
  const LinearMap solve_M = [&](const Vector& b, Vector& x) {
    x = b;
    auto x_f = x.tail(f());
    if (k() > 0) x_f.noalias() -= A().transpose() * b.head(k());
    lower.solveInPlace(x_f);
    upper.solveInPlace(x_f);
    if (k() > 0) x.head(k()).noalias() -= A() * x_f;
  };
  return std::sqrt(largest_eigenvalue(n(), multiply_K, solve_M));
}

ElasticFlexibility::ElasticFlexibility(std::shared_ptr<const ScaledSystem> system)
    : system_(std::move(system)), G_(system_->K()) {
  const ScaledSystem& s = *system_;
  const Index r = s.n_rigid();
  const Vector diagonal = G_.diagonal();
  if (r > 0) {
    // Stiffness of its own for the rigid motions makes K definite; where they are taken out, its
    // size does not matter
    const Matrix N = orthonormal_basis(s.rigid_modes());
    G_.selfadjointView<Eigen::Lower>().rankUpdate(N, diagonal.mean());
  }
  const Vector before = G_.diagonal();
  if (!dense_cholesky(G_) || !(G_.diagonal().cwiseAbs2().cwiseQuotient(before).minCoeff() > 1e-13))
    throw RunError(s.where() +
                   ": time.mass_scaling: a part of the component moves without stiffness: store "
                   "the diagonal form with " +
                   "the superelement, or leave out time.mass_scaling");
  dense_inverse_of_cholesky(G_);
  if (r == 0) return;
  // (I - N P^T) G^ (I - N P^T)^T with P = M^ N = [P_k; P_f], G^ = [1/Lambda, 0; 0, G]: at the
  // interface G - N X^T - X N^T,  X = G P_f - N (P_k^T 1/Lambda P_k + P_f^T G P_f) / 2   (f x r)
  const auto P_k = s.rigid_momentum().topRows(s.k()), P_f = s.rigid_momentum().bottomRows(s.f());
  X_.noalias() = G_ * P_f;
  Matrix twice = P_f.transpose() * X_;
  if (s.k() > 0) twice += P_k.transpose() * s.lambda().cwiseInverse().asDiagonal() * P_k;
  X_ -= 0.5 * (s.rigid_modes() * twice);
}

void ElasticFlexibility::solve(Eigen::Ref<Matrix> B) const {
  const ScaledSystem& s = *system_;
  const bool rigid = s.n_rigid() > 0;
  auto B_k = B.topRows(s.k()), B_f = B.bottomRows(s.f());
  // F B = Q G^ Q^T B, Q = I - N P^T
  if (rigid) {
    const Matrix moved = s.rigid_modes().transpose() * B_f;
    B.noalias() -= s.rigid_momentum() * moved;
  }
  B_k.array().colwise() /= s.lambda().array();
  const Matrix load = B_f;
  B_f.noalias() = G_ * load;
  if (!rigid) return;
  const Matrix moved = s.rigid_momentum().transpose() * B;
  B_f.noalias() -= s.rigid_modes() * moved;
}

Matrix ElasticFlexibility::interface_block(const std::vector<Index>& coordinates) const {
  const ScaledSystem& s = *system_;
  Matrix S = s.interface_block(G_, coordinates);
  if (s.n_rigid() == 0) return S;
  Matrix N = Matrix::Zero(s.n(), s.n_rigid()), X = N;
  N.bottomRows(s.f()) = s.rigid_modes();
  X.bottomRows(s.f()) = X_;
  const Matrix N_all = s.spread(N), X_all = s.spread(X);
  Matrix N_m = Matrix::Zero(S.rows(), N.cols()), X_m = N_m;
  for (Index i = 0; i < S.rows(); ++i)
    if (coordinates[i] >= 0) {
      N_m.row(i) = N_all.row(coordinates[i]);
      X_m.row(i) = X_all.row(coordinates[i]);
    }
  S.noalias() -= N_m * X_m.transpose();
  S.noalias() -= X_m * N_m.transpose();
  return S;
}

}  // namespace cbr
