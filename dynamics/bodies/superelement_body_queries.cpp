// SPDX-License-Identifier: GPL-3.0-or-later
// What a superelement answers about itself: response, masses, loads, momentum, energy.
#include <Eigen/Dense>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "dynamics/bodies/superelement_body.hpp"

namespace cbr {

NodeResponse SuperelementBody::response(Index set, double h) const {
  const NodeSet& s = sets_[set];
  // S = V_c diag(w) V_c^T   (3m x 3m), w = sin(omega h)/omega, h, or h/2 / (1 + theta omega^2). Positive weights (exact: below
  // omega h = pi) are half the work.
  Vector weight = Vector::Constant(form_->omega.size(), h);
  if (is_exact()) weight = propagator(h).s;
  if (scheme_ == Scheme::newmark) weight = 0.5 * newmark_weight(h);
  NodeResponse response;
  Matrix S = Matrix::Zero(s.Vt.cols(), s.Vt.cols());
  if (weight.size() == 0) {  // every dof is held
  } else if (weight.minCoeff() >= 0) {
    const Matrix scaled = weight.cwiseSqrt().asDiagonal() * s.Vt;
    S.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  } else {
    S.noalias() = s.Vt.transpose() * (weight.asDiagonal() * s.Vt);
  }
  S.triangularView<Eigen::StrictlyUpper>() = S.transpose();
  response.set_block(std::move(S));
  return response;
}

Points SuperelementBody::nodal_masses(Index set) const {
  const NodeSet& s = sets_[set];
  const Index k = superelement_->k(), c = superelement_->c();
  assert(superelement_->M_cc.rows() == c);
  Points masses(static_cast<Index>(s.nodes.size()), 3);
  for (Index i = 0; i < masses.rows(); ++i) {
    Vector3 of_node = Vector3::Zero();  // component axes
    for (int d = 0; d < 3; ++d) {
      const Index row = rows_(s.nodes[i], d) - k;
      for (Index j = 0; row >= 0 && j < c; ++j)
        of_node[d] += superelement_->dof_component[j] == d ? superelement_->M_cc(j, row) : 0;
    }
    masses.row(i) = (placement_.T.cwiseAbs2() * of_node).transpose();
  }
  return masses;
}

void SuperelementBody::fill_velocity_map(NodeSet& set) const {
  const Index k = superelement_->k(), c = superelement_->c(), m = static_cast<Index>(set.nodes.size());
  assert(superelement_->M_cc.rows() == c);
  // M^ of unit velocities in scene axes: columns [M_kc; M_cc] T^T   ((k + c) x 3m)
  Matrix columns = Matrix::Zero(k + c, 3 * m);
  for (Index i = 0; i < m; ++i) {
    for (int d = 0; d < 3; ++d) {
      const Index j = rows_(set.nodes[i], d) - k;
      if (j < 0) continue;
      for (int a = 0; a < 3; ++a) {
        columns.col(3 * i + a).head(k) += placement_.T(a, d) * superelement_->M_kc.col(j);
        columns.col(3 * i + a).tail(c) += placement_.T(a, d) * superelement_->M_cc.col(j);
      }
    }
  }
  set.B.noalias() = form_->V.topRows(k + c).transpose() * columns;  // rows beyond: rotations, whose inertia is their own
}

void SuperelementBody::add_load_history(Vector amplitude, const History& history) {
  loads_.push_back({std::move(amplitude), history});
  // Loads often share a history: a breakpoint that stood twice would cut out a step of no length
  breakpoints_.insert(breakpoints_.end(), history.time.begin(), history.time.end());
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
  regular_ = other_ = ModalPropagator{};
}

void SuperelementBody::add_force(const Points& forces, const History& history) {
  // V^T f with f in component axes: T^T f of each node
  Vector f = Vector::Zero(form_->V.rows());
  for (Index i = 0; i < forces.rows(); ++i) {
    const Vector3 local = placement_.T.transpose() * forces.row(i).transpose();
    for (int d = 0; d < 3; ++d) {
      if (rows_(i, d) >= 0) f[rows_(i, d)] += local[d];
    }
  }
  add_load_history(form_->V.transpose() * f, history);
}

void SuperelementBody::add_gravity(const Vector3& acceleration, const History& history) {
  add_load_history(form_->E.leftCols(3) * (placement_.T.transpose() * acceleration), history);
}

// Central differences: the mid-step velocity, half a step on under the internal forces and loads, second order at t_.
Vector SuperelementBody::present_rates() const {
  if (scheme_ != Scheme::central_difference) return v_;
  Vector f(eta_.size());
  load_amplitudes(t_, f);
  return v_ + 0.5 * last_h_ * (f - form_->omega.cwiseAbs2().cwiseProduct(eta_));
}

BodyState SuperelementBody::state() const {
  const RigidBody& rigid = superelement_->rigid_body;
  const Matrix3& T = placement_.T;
  BodyState state;
  // The first three columns of E^T eta are mass times displacement of the centre of mass, the last three inertia times rotation.
  Vector moment = Vector::Zero(6), rate = moment;
  if (eta_.size() > 0) moment = form_->E.transpose() * eta_, rate = form_->E.transpose() * present_rates();
  state.center_of_mass = T * (rigid.center + moment.head<3>() / rigid.mass) + placement_.position;
  state.momentum = T * rate.head<3>();
  // A rotation is a pseudo-vector: a mirror changes its sign.
  state.angular_momentum = T.determinant() * (T * rate.tail<3>()) + state.center_of_mass.cross(state.momentum);
  state.rotation = rigid.inertia.ldlt().solve(moment.tail<3>()).norm();
  if (!std::isfinite(state.rotation)) state.rotation = 0;
  const auto omega = form_->omega.array();
  const double strain = 0.5 * (omega * eta_.array()).square().sum();
  if (scheme_ != Scheme::central_difference) {
    state.kinetic_energy = 0.5 * v_.squaredNorm();
  } else {
    // 1/2 v- . v+ with v+ of the internal forces alone: what leapfrog conserves together with the strain energy
    state.kinetic_energy = 0.5 * v_.squaredNorm() - 0.5 * last_h_ * (omega.square() * eta_.array() * v_.array()).sum();
  }
  state.strain_energy = strain;
  return state;
}

void SuperelementBody::coordinates(Vector& q, Vector& rates) const {
  const Index k = superelement_->k(), n = X_.rows();
  q.setZero(k + 3 * n), rates.setZero(k + 3 * n);
  if (eta_.size() == 0) return;
  const Vector all = form_->V * eta_, all_rates = form_->V * present_rates();
  q.head(k) = all.head(k), rates.head(k) = all_rates.head(k);
  for (Index i = 0; i < n; ++i) {
    for (int d = 0; d < 3; ++d) {
      if (rows_(i, d) >= 0) q[k + 3 * i + d] = all[rows_(i, d)], rates[k + 3 * i + d] = all_rates[rows_(i, d)];
    }
  }
}

void SuperelementBody::displacements(Points& u, Points& v) const {
  Vector q, rates;
  coordinates(q, rates);
  const Index k = superelement_->k(), n = X_.rows();
  u = Eigen::Map<const Points>(q.data() + k, n, 3) * placement_.T.transpose();
  v = Eigen::Map<const Points>(rates.data() + k, n, 3) * placement_.T.transpose();
}

}  // namespace cbr
