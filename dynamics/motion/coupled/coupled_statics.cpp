// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "dynamics/motion/coupled/coupled_system.hpp"

namespace cbr {
namespace {

// Of the stiffest rows: far below elastic motion, and above what round-off leaves of rigid motion.
constexpr double first_shift = 1e-13;
// Rigid motions come out at some round-off of the shift, elastic ones of slender parts far above.
constexpr double rigid_limit = 10;
// Of a diagonal entry, what is left of it when it is eliminated: below this K is singular.
constexpr double least_pivot = 1e-13;
constexpr Index first_block = 14;  // the rigid motions of two parts, and two elastic ones
constexpr int sweeps = 4;
constexpr double no_motion = 1e-9;  // of a rigid motion, at a node that is held

// Of R's combinations those that move no held direction.
Matrix unheld(const Matrix& R, Index n_modal, const std::vector<HeldDirection>& held) {
  Matrix at_held(static_cast<Index>(held.size()), R.cols());
  for (std::size_t i = 0; i < held.size(); ++i)
    at_held.row(static_cast<Index>(i)) =
        held[i].direction.transpose() * R.middleRows(n_modal + 3 * held[i].node, 3);
  if (held.empty()) return R;
  return R * null_space(at_held, no_motion);
}

bool comes_before(const HeldDirection& a, const HeldDirection& b) { return a.node < b.node; }

// Adds as many held directions as R has columns, such that none of its motions is left.
std::vector<HeldDirection> anchored(const CoupledModel& model, const Matrix& R,
                                    std::vector<HeldDirection> held) {
  const Index n = 3 * model.coordinates.rows();
  Matrix motions = R.middleRows(model.n_modal(), n).transpose();
  for (const Index node : model.turning) motions.middleCols(3 * node, 3).setZero();
  const PivotedQr qr(motions);
  for (Index j = 0; j < std::min(R.cols(), n); ++j) {
    HeldDirection anchor{qr.column(j) / 3, Vector3::Unit(qr.column(j) % 3)};
    for (const HeldDirection& h : held)
      if (h.node == anchor.node)
        anchor.direction -= anchor.direction.dot(h.direction) * h.direction;
    anchor.direction.normalize();
    held.push_back(anchor);
  }
  std::stable_sort(held.begin(), held.end(), comes_before);
  return held;
}

// Equilibrium under forces at the held directions alone, which stay where psi has them: psi - K^+ K
// psi. What nothing holds stays where it is. The second pass takes round-off out.
void relax(CoupledSystem& system, Vector& psi) {
  Vector d(psi.size());
  for (int pass = 0; pass < 2; ++pass) {
    system.multiply_stiffness(psi, d);
    system.drop_held(d);
    system.statics().solve(d);
    psi -= d;
  }
}

}  // namespace

// Mostly the model is one part, so that its rigid motions are all that floats.
CoupledStatics::CoupledStatics(CoupledSystem& system, const std::vector<HeldDirection>& held,
                               std::string where)
    : system_(system), held_(held), where_(std::move(where)) {
  const CoupledModel& model = system_.model();
  const Matrix R = rigid_motions(model) * rigid_scales(model.rigid_body).asDiagonal();
  Matrix floating = unheld(R, model.n_modal(), held_);
  if (!is_anchored(floating)) {
    floating = softest_motions();
    if (!is_anchored(floating))
      throw RunError(where_ + ": its stiffness is not positive definite: statics have no solution");
  }
  make_unit(std::move(floating));
}

// Factors K_a.
bool CoupledStatics::is_anchored(const Matrix& R) {
  factor_.reset();
  free_ = free_dofs(system_.model(), anchored(system_.model(), R, held_));
  try {
    factor_ = std::make_unique<CoupledFactor>(system_.model(), free_, HUGE_VAL, where_);
  } catch (const RunError&) {
    return false;
  }
  return factor_->smallest_pivot() > least_pivot;
}

// What K hardly resists, by subspace iteration with K + shift M. Rigid motions grow by far more
// than elastic ones, so that Gram and Schmidt's steps are done twice.
Matrix CoupledStatics::softest_motions() {
  const double shift = first_shift * std::pow(system_.largest_frequency(), 2);
  const Index n = system_.n();
  for (Index k = std::min(first_block, system_.n_free());; k = std::min(2 * k, system_.n_free())) {
    Matrix X(n, k), MX(n, k), KX(n, k);
    unsigned seed = 1;
    for (Index i = 0; i < MX.size(); ++i) {
      seed = seed * 1664525U + 1013904223U;
      MX.data()[i] = static_cast<double>(seed) / 4294967296.0 - 0.5;
    }
    Vector x(n), y(n), lambda;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (Index j = 0; j < k; ++j) {
        x = MX.col(j);
        system_.drop_held(x);
        system_.factor(1 / shift).solve(x);
        for (int pass = 0; pass < 2; ++pass) x -= X.leftCols(j) * (MX.leftCols(j).transpose() * x);
        system_.multiply_mass(x, y);
        const double length = std::sqrt(x.dot(y));
        X.col(j) = x / length;
        MX.col(j) = y / length;
        x = X.col(j);
        system_.multiply_stiffness(x, y);
        KX.col(j) = y;
      }
      const Matrix A = X.transpose() * KX;
      const Eigenpairs pairs = dense_eigenpairs(A, k);
      if (!pairs.converged || !A.allFinite()) return Matrix(n, 0);
      lambda = pairs.lambda;
      X = (X * pairs.Phi).eval();
      MX = (MX * pairs.Phi).eval();
    }
    const Index n_soft = (lambda.array() <= rigid_limit * shift).count();
    if (n_soft < k || k == system_.n_free()) return X.leftCols(n_soft);
  }
}

void CoupledStatics::make_unit(Matrix R) {
  Vector x(system_.n()), y(system_.n());
  MR_.resize(R.rows(), R.cols());
  const auto multiply = [&] {
    for (Index j = 0; j < R.cols(); ++j) {
      x = R.col(j);
      system_.multiply_mass(x, y);
      MR_.col(j) = y;
    }
  };
  multiply();
  if (R.cols() > 0) {
    const double root = std::sqrt(system_.model().rigid_body.mass);
    const Cholesky mass(R.transpose() * MR_);
    mass.divide_by_upper(R);
    R *= root;
    multiply();
  }
  R_ = std::move(R);
}

// x -= A B^T x / m
void CoupledStatics::project(const Matrix& A, const Matrix& B, Vector& x) const {
  if (A.cols() == 0) return;
  const Vector share = B.transpose() * x / system_.model().rigid_body.mass;
  x -= A * share;
}

void CoupledStatics::solve(Vector& f) {
  project(MR_, R_, f);
  factor_->solve(f);
  project(R_, MR_, f);
}

// With Y = G K_a^-1 M R, B = G R and Z = R^T M K_a^-1 M R:  S_a - (B Y^T + Y B^T) / m + B Z B^T /
// m^2
std::shared_ptr<const Matrix> CoupledStatics::nodal_inverse(const std::vector<Index>& nodes) {
  for (const auto& [of, S] : known_)
    if (of == nodes) return S;
  Matrix S = factor_->nodal_inverse(nodes, Matrix3::Identity());
  const Index k = R_.cols(), m = static_cast<Index>(nodes.size());
  const double mass = system_.model().rigid_body.mass;
  Matrix B(3 * m, k), Y(3 * m, k), Z(k, k);
  Vector x;
  for (Index j = 0; j < k; ++j) {
    x = MR_.col(j);
    factor_->solve(x);
    Z.col(j) = MR_.transpose() * x;
    for (Index i = 0; i < m; ++i) {
      const Index row = system_.n_modal() + 3 * nodes[i];
      B.block<3, 1>(3 * i, j) = R_.block<3, 1>(row, j);
      Y.block<3, 1>(3 * i, j) = x.segment<3>(row);
    }
  }
  if (k > 0) {
    const Matrix half = (0.5 / mass * (B * Z) - Y) * B.transpose() / mass;
    S += half + half.transpose();
  }
  return known_.emplace_back(nodes, std::make_shared<const Matrix>(std::move(S))).second;
}

CoupledStatics& CoupledSystem::statics() {
  if (!statics_) statics_ = std::make_unique<CoupledStatics>(*this, held_, where_);
  return *statics_;
}

CoupledSystem::~CoupledSystem() = default;

// Of the state, from what the motions do to momenta: R^T M u / m.
void CoupledBody::own_relax(double t, double share) {
  if (statics_.empty()) statics_.begin(u_);
  Vector& f = work_vector_;
  loads_.sum(t, f);
  f *= share;
  statics_.begin_iteration(f);
  u_end_ = f;
  CoupledStatics& K = system_->statics();
  K.solve(u_end_);
  const Vector a = K.inertia().transpose() * u_ / system_->model().rigid_body.mass;
  u_end_ += K.floating() * a;
}

Matrix CoupledBody::own_floating_motions(Index set) const {
  const Matrix& R = system_->statics().floating();
  const std::vector<Index>& nodes = sets_[set];
  Matrix motions(3 * static_cast<Index>(nodes.size()), R.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    motions.middleRows(3 * static_cast<Index>(i), 3) =
        placement_.T * R.middleRows(system_->n_modal() + 3 * nodes[i], 3);
  return motions;
}

FloatingForces CoupledBody::floating_forces() const {
  const Matrix& R = system_->statics().floating();
  const Vector f = statics_.loads + statics_.contact;
  const Vector parts = R.cwiseAbs().transpose() * f.cwiseAbs();
  return {R.transpose() * f, parts.size() > 0 ? parts.maxCoeff() : 0};
}

void CoupledBody::float_by(const Vector& move) { u_end_ += system_->statics().floating() * move; }

NodeResponse CoupledBody::own_static_response(Index set) const {
  NodeResponse response;
  response.block = system_->statics().nodal_inverse(sets_[set]);
  response.axes = placement_.T;
  return response;
}

void CoupledBody::own_add_static_forces(Index set, const Points& forces) {
  Vector& f = work_vector_;
  spread(sets_[set], forces, f);
  statics_.add(f);
  system_->statics().solve(f);
  u_end_ += f;
}

Settled CoupledBody::own_settle() {
  const Vector move = u_end_ - u_, before = stiffness_force();
  u_ = u_end_;
  Ku_is_current_ = v_now_is_current_ = false;
  const Vector& after = stiffness_force();
  return {move.dot(after - before), u_.dot(after)};
}

void CoupledBody::own_end_load_step() { statics_.book(u_, work_); }

// Central differences keep rates half a step before, of a body at rest under all forces.
void CoupledBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  add_loads(loads);
  work_ = BodyWork();
  if (scheme() == Scheme::central_difference && !statics_.empty()) last_h_ = h;
}

SupportShapes coupled_shapes(const std::shared_ptr<const CoupledModel>& model,
                             const std::vector<HeldDirection>& held, const Matrix& motion,
                             const std::string& where) {
  CoupledSystem system(model, held, where);
  const Index n = system.n(), m = motion.cols(), k = system.n_modal();
  SupportShapes shapes;
  shapes.psi.setZero(n, m);
  shapes.inertia.resize(n, m);
  Matrix force(n, m);
  Vector psi(n), product(n);
  for (Index j = 0; j < m; ++j) {
    psi.setZero();
    for (std::size_t i = 0; i < held.size(); ++i)
      psi.segment<3>(k + 3 * held[i].node) += motion(static_cast<Index>(i), j) * held[i].direction;
    if (!psi.isZero(0)) relax(system, psi);
    shapes.psi.col(j) = psi;
    system.multiply_mass(psi, product);
    shapes.inertia.col(j) = product;
    system.multiply_stiffness(psi, product);
    force.col(j) = product;
  }
  const Matrix stiffness = shapes.psi.transpose() * force;
  shapes.stiffness = 0.5 * (stiffness + stiffness.transpose());
  shapes.momentum = system.rigid_momentum().transpose() * shapes.psi;
  return shapes;
}

}  // namespace cbr
