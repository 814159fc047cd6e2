// SPDX-License-Identifier: GPL-3.0-or-later
// What a scaled body answers about itself: response, bounds of its motion, momentum, energy,
// displacements.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/motion/scaled/scaled_body.hpp"

namespace cbr {

NodeResponse ScaledBody::own_response(Index set, double h) const {
  require_plan(true);
  const NodeSet& s = sets_[set];
  if (!s.rows) s.rows = modes_->node_rows(s.nodes);
  NodeResponse response;
  response.block = s.rows->response(h, contact_step_, gain_);
  response.axes = placement_.T;
  return response;
}

double ScaledBody::scaled_energy() const {
  if (!is_scaled()) return 0;
  return std::max(0.0, scaled_kinetic_energy(now_) + scaled_strain_energy(now_, modes_->clip));
}

BodyState ScaledBody::own_state() const {
  require_plan(true);
  const RigidBody& body = model_->superelement().rigid_body;
  const Matrix3& T = placement_.T;
  // Mass times displacement of the centre of mass, inertia times rotation; and their rates
  Eigen::Matrix<double, 6, 1> moment = Eigen::Matrix<double, 6, 1>::Zero(), rate = moment;
  for (int c = 0; c < 6; ++c) {
    if (now_.eta.size() > 0) {
      moment[c] = modes_->E.col(c).dot(now_.eta);
      rate[c] = modes_->E.col(c).dot(now_.v);
    }
    if (rigid_scaled_.size() > 0) {
      moment[c] += rigid_scaled_.row(c).dot(now_.r);
      rate[c] += rigid_scaled_.row(c).dot(now_.dr);
    }
  }
  BodyState state;
  state.center_of_mass = T * (body.center + moment.head<3>() / body.mass) + placement_.position;
  state.momentum = T * rate.head<3>();
  // A rotation is a pseudo-vector: a mirror changes its sign.
  state.angular_momentum =
      T.determinant() * (T * rate.tail<3>()) + state.center_of_mass.cross(state.momentum);
  state.rotation = solve_symmetric(body.inertia, moment.tail<3>()).norm();
  if (!std::isfinite(state.rotation)) state.rotation = 0;
  state.kinetic_energy = 0.5 * now_.v.squaredNorm();
  state.strain_energy = 0.5 * modes_->omega.cwiseProduct(now_.eta).squaredNorm();
  if (is_scaled()) {
    state.kinetic_energy += scaled_kinetic_energy(now_);
    state.strain_energy += scaled_strain_energy(now_, modes_->clip);
  }
  state.scaled_energy = scaled_energy();
  return state;
}

MotionBound ScaledBody::own_motion_bound(Index set, bool) const {
  require_plan(true);
  const NodeSet& s = sets_[set];
  const Matrix3& T = placement_.T;
  const double clip = modes_->clip;
  const Index n_rigid = modes_->n_rigid, n_kept = modes_->n_kept(), loads = load_modal_.cols();
  Vector largest = Vector::Zero(loads);  // of the histories, at any time
  for (Index l = 0; l < loads; ++l)
    if (loads_[l].is_load) largest[l] = loads_[l].history.largest();
  const Vector force = load_modal_.cwiseAbs().lazyProduct(largest);
  // Amplitude sqrt(eta^2 + (v / omega)^2); a force adds at most its impulse / omega.
  Vector amplitude = Vector::Zero(n_kept), growth = amplitude;
  for (Index j = n_rigid; j < n_kept; ++j) {
    amplitude[j] = std::hypot(now_.eta[j], now_.v[j] / modes_->omega[j]);
    growth[j] = force[j] / modes_->omega[j];
  }
  MotionBound bound;
  bound.lower = bound.lower_speed = Vector3::Constant(HUGE_VAL);
  bound.upper = bound.upper_speed = Vector3::Constant(-HUGE_VAL);
  bound.growth = bound.acceleration = Vector3::Zero();
  for (std::size_t i = 0; i < s.slot.size(); ++i) {
    const Index at = 3 * s.slot[i];
    Vector3 x = s.X.row(static_cast<Index>(i)), speed = Vector3::Zero(), spread = speed,
            grown = speed, pushed = speed;
    for (Index j = 0; j < n_kept; ++j) {
      const Vector3 row = T * Vector3(rows_->Vt(j, at), rows_->Vt(j, at + 1), rows_->Vt(j, at + 2));
      if (j < n_rigid) {
        x += row * now_.eta[j];
        speed += row * now_.v[j];
        pushed += row.cwiseAbs() * force[j];
      } else {
        spread += row.cwiseAbs() * amplitude[j];
        grown += row.cwiseAbs() * growth[j];
      }
    }
    if (is_scaled()) {
      // All of one frequency: each displacement is an oscillator by itself
      const Vector3 y = T * now_.y.segment<3>(at), dy = T * now_.dy.segment<3>(at);
      spread += (y.array().square() + (dy / clip).array().square()).sqrt().matrix();
      for (Index l = 0; l < loads; ++l)
        grown += (T * load_scaled_.col(l).segment<3>(at)).cwiseAbs() * (largest[l] / clip);
    }
    bound.lower = bound.lower.cwiseMin(x - spread);
    bound.upper = bound.upper.cwiseMax(x + spread);
    bound.lower_speed = bound.lower_speed.cwiseMin(speed);
    bound.upper_speed = bound.upper_speed.cwiseMax(speed);
    bound.growth = bound.growth.cwiseMax(grown);
    bound.acceleration = bound.acceleration.cwiseMax(pushed);
  }
  return bound;
}

// Coordinates and rates in the order of V's rows: V eta + S (forces of r)   (n x 2)
Matrix ScaledBody::whole_motion() const {
  Matrix eta(modes_->n_kept(), 2);
  eta << now_.eta, now_.v;
  Matrix q = modes_->V.lazyProduct(eta);
  if (!is_scaled()) return q;
  const Index n = n_tracked(), loads = load_modal_.cols();
  Matrix r(n + loads, 2);
  r << now_.r, now_.dr;
  Matrix F = Matrix::Zero(q.rows(), 2), rigid = Matrix::Zero(6, 2);
  if (loads > 0) F = force_columns().lazyProduct(r.bottomRows(loads));
  for (Index l = 0; l < loads; ++l) rigid += loads_[l].rigid * r.row(n + l);
  for (Index i = 0; i < n; ++i)
    if (const Index row = modes_->rows(tracked_[i / 3], i % 3); row >= 0) F.row(row) += r.row(i);
  q += modes_->part->times(F);
  if (modes_->rigid_gram.size() > 0) q += modes_->rigid_response.lazyProduct(rigid);
  return q;
}

void ScaledBody::own_coordinates(Vector& q, Vector& rates) const {
  const Index k = model_->superelement().k(), n = own_nodes().rows();
  q.setZero(k + 3 * n);
  rates.setZero(k + 3 * n);
  if (!modes_) return;
  const Matrix all = whole_motion();
  q.head(k) = all.col(0).head(k);
  rates.head(k) = all.col(1).head(k);
  for (Index i = 0; i < n; ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index row = modes_->rows(i, d); row >= 0) {
        q[k + 3 * i + d] = all(row, 0);
        rates[k + 3 * i + d] = all(row, 1);
      }
}

void ScaledBody::own_displacements(Points& u, Points& v) const {
  if (modes_ && tracked_.size() == slot_of_.size()) {
    u.resize(own_nodes().rows(), 3);
    v.resize(own_nodes().rows(), 3);
    for (Index i = 0; i < own_nodes().rows(); ++i) {
      const Index at = 3 * slot_of_[i];
      Vector3 of_node = Vector3::Zero(), rate = of_node;
      for (int c = 0; c < 3 && now_.eta.size() > 0; ++c) {
        of_node[c] = rows_->Vt.col(at + c).dot(now_.eta);
        rate[c] = rows_->Vt.col(at + c).dot(now_.v);
      }
      if (is_scaled()) {
        of_node += now_.y.segment<3>(at);
        rate += now_.dy.segment<3>(at);
      }
      u.row(i) = (placement_.T * of_node).transpose();
      v.row(i) = (placement_.T * rate).transpose();
    }
    return;
  }
  const Index k = model_->superelement().k(), n = own_nodes().rows();
  Vector q, rates;
  own_coordinates(q, rates);
  u = Eigen::Map<const Points>(q.data() + k, n, 3) * placement_.T.transpose();
  v = Eigen::Map<const Points>(rates.data() + k, n, 3) * placement_.T.transpose();
}

void ScaledBody::own_keep_state(StateArchive& archive) {
  if (!modes_) scale(HUGE_VAL);  // as the first step does
  archive.expect(now_.eta.size());
  archive.expect(now_.r.size());
  archive(now_.eta, now_.v, now_.r, now_.dr, now_.y, now_.dy, t_, work_);
}

}  // namespace cbr
