// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/half_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/superelement/massless_modes.hpp"

namespace cbr {
namespace {

// The modes that stay, ascending, of the first `count`.
std::vector<Index> better_half(const Vector& lambda, const Matrix& alpha, Index count, HalfBy by) {
  std::vector<Index> modes(count);
  std::iota(modes.begin(), modes.end(), Index{0});
  const auto worth = [&](Index j) {
    return by == HalfBy::frequency ? -lambda(j) : alpha.row(j).squaredNorm();
  };
  std::stable_sort(modes.begin(), modes.end(),
                   [&](Index i, Index j) { return worth(i) > worth(j); });
  modes.resize(modes.size() / 2);
  std::sort(modes.begin(), modes.end());
  return modes;
}

// Of massless_modes: free and tapered. u_c = V q_k + F f_c: statics stay as they were, F + V_e
// Lambda_e^-1 V_e^T of the elastic modes.
void keep_half_of_free(Superelement& s) {
  auto& m = s.massless;
  const Index n_rigid = (s.eigenvalues.array() == 0).count(), e = s.k() - n_rigid,
              kept = n_rigid + e / 2;
  const auto statics = [&] {
    const Index elastic = m.V.cols() - n_rigid;
    const Matrix B = m.V.rightCols(elastic) *
                     s.eigenvalues.tail(elastic).cwiseSqrt().cwiseInverse().asDiagonal();
    return Matrix(B * B.transpose());
  };
  m.F += statics();
  if (m.omega_fall > 0) {
    m.V *= falling_weights(s.eigenvalues, m.omega_fall).cwiseInverse().asDiagonal();
    m.omega_fall = kept > n_rigid ? end_of_fall(s, m.V, s.eigenvalues, kept, n_rigid) : 0;
  }
  m.V = Matrix(m.V.leftCols(kept));
  s.eigenvalues = Vector(s.eigenvalues.head(kept));
  if (m.omega_fall > 0) m.V *= falling_weights(s.eigenvalues, m.omega_fall).asDiagonal();
  m.F -= statics();
  // The highest frequency with the interface held: of Lambda + V^T F^-1 V   (k x k)
  const Cholesky F(m.F);
  if (!F.ok()) throw RunError("the compliance of a massless interface is not positive definite");
  Matrix K = m.V.transpose() * F.solve(m.V);
  K.diagonal() += s.eigenvalues;
  m.omega_closed = std::sqrt(symmetric_eigenvalues(K)(kept - 1));
}

void keep_half_of_fixed(Superelement& s, HalfBy by) {
  FixedModes modes = fixed_modes_of(s);
  const std::vector<Index> kept = better_half(modes.lambda, modes.alpha, s.k(), by);
  modes.lambda = Vector(modes.lambda(kept));
  modes.alpha = Matrix(modes.alpha(kept, Eigen::all));
  const Matrix R = s.massless.V.leftCols(s.massless.rigid_share.cols()),
               momentum = s.massless.rigid_momentum;
  try {
    take_fixed_modes(std::move(modes), R, momentum, s);
  } catch (const InputError& error) {
    throw InputError(std::string("--check-error: half of massless_modes: fixed is no basis: ") +
                     error.what());
  }
}

}  // namespace

void require_half(const Superelement& s) {
  if (s.is_characteristic())
    throw InputError(
        "--check-error is not available with basis: characteristic, whose coordinates mix modes "
        "and statics: "
        "reduce with fewer modes and compare");
  const auto& m = s.massless;
  if ((m.modes == "tapered" && m.omega_fall == 0 && (s.eigenvalues.array() > 0).any()) ||
      (m.modes == "fixed" && m.rigid_share.size() == 0))
    throw InputError(
        "--check-error: a file before version 1.5 does not tell what half of massless_modes: " +
        m.modes + " is: reduce again (cbr-reduce --force)");
  const Index r = m.rigid_share.cols();
  if (s.k() / 2 < r)
    throw InputError("--check-error: half of the " + std::to_string(s.k()) +
                     " fixed modes cannot carry the " + std::to_string(r) +
                     " rigid motions: reduce with at least " + std::to_string(2 * r));
}

Index keep_half(Superelement& s, HalfBy by) {
  const Index k = s.k();
  require_half(s);
  s.omega.resize(0);
  s.V.resize(0, 0);
  if (s.is_massless()) {
    if (s.massless.rigid_share.size() > 0)
      keep_half_of_fixed(s, by);
    else
      keep_half_of_free(s);
    return k - s.k();
  }
  const Index n_own = k - s.n_residual;
  std::vector<Index> kept = better_half(s.eigenvalues, s.M_kc, n_own, by);
  for (Index j = n_own; j < k; ++j) kept.push_back(j);
  s.eigenvalues = Vector(s.eigenvalues(kept));
  s.M_kc = Matrix(s.M_kc(kept, Eigen::all));
  for (auto& recovery : s.recovery) recovery.Phi = Matrix(recovery.Phi(Eigen::all, kept));
  std::vector<Index> rows = kept;
  for (Index i = k; i < k + s.c(); ++i) rows.push_back(i);
  for (auto& [name, load] : s.loads) load.force = Matrix(load.force(rows, Eigen::all));
  s.spin_couplings.resize(0, 0);  // of modes that are no longer
  if (s.spin_moments.size() > 0) s.spin_moments = Matrix(s.spin_moments(rows, Eigen::all));
  return k - s.k();
}

}  // namespace cbr
