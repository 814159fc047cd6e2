// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model in equilibrium.
#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"

namespace cbr {
namespace {

// Of the stiffest rows: far below elastic motion, and above what round-off leaves of rigid motion.
constexpr double first_shift = 1e-13;
// Rigid motions come out at some round-off of the shift, elastic ones of slender parts far above.
constexpr double rigid_limit = 10;
// Of a regular K.
constexpr double pull_of_held = 1e-9;
constexpr Index block = 14;  // the rigid motions of two parts, and two elastic ones
constexpr int sweeps = 4;

}  // namespace

// About the lowest eigenvalues of K x = lambda M x, from above: subspace iteration with K + shift
// M. Rigid motions grow by far more than elastic ones, so that Gram and Schmidt's steps are done
// twice.
Vector CoupledSystem::lowest_eigenvalues(double shift, Index n) {
  Matrix X(n_, n), MX(n_, n), KX(n_, n);
  unsigned seed = 1;
  for (Index i = 0; i < MX.size(); ++i) {
    seed = seed * 1664525U + 1013904223U;
    MX.data()[i] = static_cast<double>(seed) / 4294967296.0 - 0.5;
  }
  Vector x(n_), y(n_), lambda;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (Index j = 0; j < n; ++j) {
      x = MX.col(j);
      drop_held(x);
      factor(1 / shift).solve(x);
      for (int pass = 0; pass < 2; ++pass) x -= X.leftCols(j) * (MX.leftCols(j).transpose() * x);
      multiply_mass(x, y);
      const double length = std::sqrt(x.dot(y));
      X.col(j) = x / length;
      MX.col(j) = y / length;
      x = X.col(j);
      multiply_stiffness(x, y);
      KX.col(j) = y;
    }
    const Matrix A = X.transpose() * KX;
    const Eigenpairs pairs = dense_eigenpairs(A, n);
    if (!pairs.converged || !A.allFinite()) return {};
    lambda = pairs.lambda;
    MX = (MX * pairs.Phi).eval();
  }
  return lambda;
}

double CoupledSystem::static_pull() {
  if (static_pull_ >= 0) return static_pull_;
  const double largest = std::pow(largest_frequency(), 2);
  if (!(largest > 0)) return static_pull_ = 1;  // nothing elastic to compare with
  const double shift = first_shift * largest;
  const Index n = std::min(block, n_free());
  const Vector lambda = lowest_eigenvalues(shift, n);
  double elastic = 0;
  for (Index j = 0; j < lambda.size() && elastic == 0; ++j)
    if (lambda[j] > rigid_limit * shift) elastic = lambda[j];
  const bool is_held = lambda.size() > 0 && lambda[0] > rigid_limit * shift;
  if (elastic == 0) elastic = 1e3 * shift;  // many parts, each with its rigid motions
  return static_pull_ = elastic * (is_held ? pull_of_held : static_pull_share);
}

// With A = M + theta K, theta = 1 / sigma:   (K + sigma M)^-1 = theta A^-1.
void CoupledBody::relax(const Rest& rest) {
  if (statics_.empty()) statics_.begin(u_);
  pull_ = system_->static_pull() * rest.hold;
  Vector& f = work_vector_;
  load(rest.t, f);
  f *= rest.share;
  statics_.begin_iteration(f);
  u_end_ = f - stiffness_force();
  system_->factor(1 / pull_).solve(u_end_);
  u_end_ /= pull_;
  u_end_ += u_;
}

NodeResponse CoupledBody::static_response(Index set, double hold) const {
  const double pull = system_->static_pull() * hold;
  NodeResponse response;
  response.set_block(system_->nodal_inverse(1 / pull, sets_[set], placement_.T) / pull);
  return response;
}

void CoupledBody::add_static_forces(Index set, const Points& forces, ImpulseKind kind) {
  const auto& nodes = sets_[set];
  Vector& f = work_vector_;
  f.setZero();
  for (Index i = 0; i < forces.rows(); ++i)
    f.segment<3>(system_->n_modal() + 3 * nodes[i]) +=
        placement_.T.transpose() * forces.row(i).transpose();
  system_->drop_held(f);
  statics_.add(f, kind);
  system_->factor(1 / pull_).solve(f);
  u_end_ += f / pull_;
}

Settled CoupledBody::settle() {
  const Vector move = u_end_ - u_;
  Settled settled;
  settled.change =
      move.dot(statics_.loads + statics_.contact + statics_.friction - stiffness_force());
  system_->multiply_mass(move, work_vector_);
  settled.way = std::sqrt(std::max(0.0, move.dot(work_vector_)) / system_->model().rigid_body.mass);
  u_ = u_end_;
  Ku_is_current_ = v_now_is_current_ = false;
  settled.energy = u_.dot(stiffness_force());
  return settled;
}

void CoupledBody::end_load_step() { statics_.book(u_, work_); }

// Central differences keep rates half a step before, of a body at rest under all forces.
void CoupledBody::start_motion(double h, const std::vector<BodyLoad>& loads) {
  add_loads(loads);
  work_ = BodyWork();
  if (scheme() == Scheme::central_difference && !statics_.empty()) last_h_ = h;
}

}  // namespace cbr
