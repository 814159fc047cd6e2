// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/half_modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/error.hpp"

namespace cbr {
namespace {

// The modes that stay, ascending, of those from `first` to `last`.
std::vector<Index> better_half(const Superelement& s, Index first, Index last, HalfBy by) {
  std::vector<Index> modes(last - first);
  std::iota(modes.begin(), modes.end(), first);
  const auto worth = [&](Index j) { return by == HalfBy::frequency ? -s.eigenvalues(j) : s.M_kc.row(j).squaredNorm(); };
  std::stable_sort(modes.begin(), modes.end(), [&](Index i, Index j) { return worth(i) > worth(j); });
  modes.resize(modes.size() / 2);
  std::sort(modes.begin(), modes.end());
  return modes;
}

// u_c = V q_k + F f_c: statics stay as they were, F + V_d Lambda_d^-1 V_d^T of the dropped modes d.
void keep_half_of_massless(Superelement& s) {
  auto& m = s.massless;
  const Index n_rigid = (s.eigenvalues.array() == 0).count(), e = s.k() - n_rigid, kept = n_rigid + e / 2, dropped = s.k() - kept;
  const Matrix B = m.V.rightCols(dropped) * s.eigenvalues.tail(dropped).cwiseSqrt().cwiseInverse().asDiagonal();
  m.F += B * B.transpose();
  m.V = Matrix(m.V.leftCols(kept));
  s.eigenvalues = Vector(s.eigenvalues.head(kept));
  // The highest frequency with the interface held: of Lambda + V^T F^-1 V   (k x k)
  const Eigen::LLT<Matrix> F(m.F);
  if (F.info() != Eigen::Success) throw RunError("the compliance of a massless interface is not positive definite");
  Matrix K = m.V.transpose() * F.solve(m.V);
  K.diagonal() += s.eigenvalues;
  m.omega_closed = std::sqrt(Eigen::SelfAdjointEigenSolver<Matrix>(K, Eigen::EigenvaluesOnly).eigenvalues()(kept - 1));
}

}  // namespace

void require_half(const Superelement& s) {
  if (s.is_characteristic())
    throw InputError(
        "--check-error has no half to leave out of basis: characteristic, whose coordinates are modes and statics together: "
        "reduce with fewer modes and compare");
}

Index keep_half(Superelement& s, HalfBy by) {
  const Index k = s.k();
  require_half(s);
  s.omega.resize(0);
  s.V.resize(0, 0);
  if (s.is_massless()) {
    keep_half_of_massless(s);
    return k - s.k();
  }
  const Index n_own = k - s.n_residual;
  std::vector<Index> kept = better_half(s, 0, n_own, by);
  for (Index j = n_own; j < k; ++j) kept.push_back(j);
  s.eigenvalues = Vector(s.eigenvalues(kept));
  s.M_kc = Matrix(s.M_kc(kept, Eigen::all));
  for (auto& recovery : s.recovery) recovery.Phi = Matrix(recovery.Phi(Eigen::all, kept));
  std::vector<Index> rows = kept;
  for (Index i = k; i < k + s.c(); ++i) rows.push_back(i);
  for (auto& [name, load] : s.loads) load.force = Matrix(load.force(rows, Eigen::all));
  return k - s.k();
}

}  // namespace cbr
