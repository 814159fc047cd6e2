// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Of the reduced mass about the centre of mass, scene axes.
Matrix3 inertia_of(const SuperelementBody& modal) {
  const auto E = modal.form().E.rightCols(3);
  return modal.axes() * (E.transpose() * E) * modal.axes().transpose();
}

// Rows of x: c + R (x - c). A body without spin keeps its bits.
void turn_about(const Vector3& c, const Eigen::Quaterniond& q, Points& x) {
  if (q.vec().isZero(0)) return;
  const Matrix3 R = q.toRotationMatrix();
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = (c + R * (x.row(i).transpose() - c)).transpose();
}

Vector3 moment_about(const Vector3& c, const Points& x, const Points& impulses) {
  Vector3 sum = Vector3::Zero();
  for (Index i = 0; i < x.rows(); ++i)
    sum += (x.row(i).transpose() - c).cross(Vector3(impulses.row(i).transpose()));
  return sum;
}

}  // namespace

TurningBody::TurningBody(std::unique_ptr<SuperelementBody> inner, const Vector3& angular_velocity,
                         double end)
    : Body(inner->facts()),
      inner_(std::move(inner)),
      modal_(*inner_),
      late_(facts().kicks_at_end),
      feels_(!late_ && modal_.feel_spin()),
      coupling_(feels_ ? modal_.coupling() : nullptr),
      run_end_(end),
      J_0_(inertia_of(modal_)),
      largest_inertia_(symmetric_eigen(J_0_).values.maxCoeff()),
      now_(J_0_),
      step_(J_0_),
      L_(J_0_ * angular_velocity) {
  assert(modal_.form().n_rigid == 6 && modal_.is_exact());
  modal_.carry(R_);
  expect_turning();
}

// Bounds of the factors until the end of the run. Of the spin: |g| <= |w|^2, however its axes lie,
// and a tenth more for the inertia that swings.
void TurningBody::expect_turning() {
  if (!feels_ && loads_.empty()) return;
  double momentum = L_.norm();
  for (const TurningLoad& load : loads_)
    momentum += load.largest_moment() * std::max(0.0, run_end_ - t_);
  const double w = now_.rate_per_momentum * (momentum + now_.inner.norm());
  const Index n_spin = feels_ ? 6 : 0;
  Vector largest(n_spin + 6 * static_cast<Index>(loads_.size()));
  largest.head(n_spin).setConstant(1.1 * w * w);
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    auto of_load = largest.segment<6>(n_spin + 6 * static_cast<Index>(l));
    of_load.head<3>().setConstant(loads_[l].largest_vector());
    of_load.tail<3>().setConstant(loads_[l].largest_resultant());
  }
  modal_.expect_turning(largest, is_coupled() ? energy_for_modes(momentum) : -1);
}

Index TurningBody::own_track(const std::vector<Index>& nodes) {
  placed_.emplace_back();
  return inner_->track(nodes);
}

void TurningBody::own_positions(Index set, Points& x) const {
  inner_->positions(set, x);
  turn_about(modal_.center_of_mass(), q_, x);
  if (!late_) placed_[set] = {x, true};
}

void TurningBody::own_predicted_positions(Index set, Points& x) const {
  inner_->predicted_positions(set, x);
  turn_about(modal_.predicted_center_of_mass(), end(), x);
  if (late_) placed_[set] = {x, true};
}

const Eigen::Quaterniond& TurningBody::end() const {
  if (ends_there_) return q_end_;
  const Vector3 L = late_ ? L_ : Vector3(L_ + kick_);
  if (loads_.empty()) {
    q_end_ = step_.turned(q_, L, h_);
  } else {
    eta_end_ = modal_.predicted_modal_coordinates();
    const TurnInertia at_end{2 * step_.J - now_.J, 2 * step_.inner - now_.inner};
    const TurnAtEnd to = turn_at_end(L, at_end);
    q_end_ = to.q;
    L_end_ = to.L;
    work_end_ = to.work;
  }
  ends_there_ = true;
  return q_end_;
}

// Nodes stay within a ball about the centre of mass, however the body turns.
MotionBound TurningBody::in_any_position(MotionBound bound) const {
  const Vector3 c = modal_.center_of_mass();
  const double radius = (c - bound.lower).cwiseAbs().cwiseMax((bound.upper - c).cwiseAbs()).norm();
  bound.lower = c.array() - radius;
  bound.upper = c.array() + radius;
  bound.growth.setConstant(bound.growth.norm());
  return bound;
}

void TurningBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  inner_->mean_motion(set, position, velocity);
  const Vector3 c = modal_.center_of_mass(), v_c = modal_.center_velocity();
  const Vector3 arm = q_ * (position - c);
  position = c + arm;
  velocity = v_c + now_.angular_velocity(q_, L_).cross(arm) + q_ * (velocity - v_c);
}

// Impulses come in the axes of the middle of the step: so the inner body's symmetric answer is that
// of the turned one to second order in the angle of a step.
void TurningBody::take_axes() {
  Eigen::Quaterniond middle;
  middle.coeffs() = q_.coeffs() + q_end_.coeffs();  // of parts of a turn; opposite signs cannot be
  if (middle.coeffs().isZero(1e-3)) middle = q_;
  R_ = q_.vec().isZero(0) && q_end_.vec().isZero(0) ? Matrix3::Identity()
                                                    : middle.normalized().toRotationMatrix();
  modal_.carry(R_);
}

void TurningBody::predict_end() {
  kick_.setZero();
  is_kicked_ = false;
  if (!loads_.empty()) eta_start_ = eta_end_ = modal_.modal_coordinates();
  const bool spins = feels_ && !L_.isZero(0);
  if (feels_ && L_.isZero(0) && loads_.empty()) modal_.turn_forces({});
  if (!is_coupled()) modal_.uncouple();
  if (spins || !loads_.empty()) turn_inner(now_);
  if (spins) {
    inner_->predict(t_, h_);
    turn_inner(predicted_turn());
  }
  inner_->predict(t_, h_);
  if (feels_) step_ = FreeTurn::between(now_, predicted_turn(), 0.5);
  ends_there_ = false;
  end();
  take_axes();
}

double TurningBody::spin_energy(const FreeTurn& of) const { return of.energy(q_, L_); }

void TurningBody::add_moment(const Vector3& moment) {
  is_kicked_ = true;
  kick_ += moment;
  ends_there_ = late_;
}

void TurningBody::add_moments(Index set, const Points& impulses) {
  Points x;
  if (!placed_[set].known && late_) own_predicted_positions(set, x);
  if (!placed_[set].known && !late_) own_positions(set, x);
  const Vector3 c = late_ ? modal_.predicted_center_of_mass() : modal_.center_of_mass();
  add_moment(moment_about(c, placed_[set].x, impulses));
}

void TurningBody::own_take_impulses(Index set, const Impulses& impulses) {
  add_moments(set, impulses.all);
  const Points turned = impulses.all * R_;
  inner_->take_impulses(set, {turned, impulses.move, impulses.still});
}

// What moments do to a spin that goes from w to w + J^-1 M as `share_of_kick` of J^-1 M is there.
void TurningBody::book(const Vector3& moment, const Vector3& w, const Vector3& share_of_kick) {
  work_.contact += moment.dot(w + share_of_kick);
}

void TurningBody::own_accept() {
  const double longest = is_coupled() && !is_kicked_ ? longest_part() : h_;
  if (!(h_ > longest)) return accept_part();
  // Nothing pushed it, and no one looks at it in between
  const double t = t_, n = std::ceil(h_ / longest), h = h_ / n;
  for (double i = 0; i < n; ++i) {
    predict(t + i * h, h);
    accept_part();
  }
}

void TurningBody::accept_part() {
  const Vector3 w = now_.angular_velocity(q_, L_);
  // What kicks of the modes bring to what moves inside is none of the turn's
  Vector3 inside = Vector3::Zero();
  if (is_coupled() && modal_.kick() != nullptr)
    inside = axial(coupling_->momentum(modal_.modal_coordinates(), *modal_.kick()));
  inner_->accept();
  if (late_) {
    // From the middle of the kick at the start to that of the kick at the end
    book(0.5 * last_kick_, w, -0.25 * now_.change(q_, last_kick_));
    q_ = end();
    if (!loads_.empty()) {
      L_ = L_end_;
      work_.external += work_end_;
    }
    book(0.5 * kick_, now_.angular_velocity(q_, L_), 0.25 * now_.change(q_, kick_));
    last_kick_ = kick_;
    L_ += kick_;
  } else {
    const Vector3 of_turn = kick_ - q_ * inside;
    book(of_turn, w, 0.5 * now_.change(q_, of_turn));
    L_ += kick_;
    now_.inner += inside;
    move_on();
  }
  kick_.setZero();
  t_ += h_;
  expect_turning();
  for (PlacedSet& of : placed_) of.known = false;
}

// To the end of the step, whose moments L has. The error of the splitting in the energy is booked
// as numerical work.
void TurningBody::move_on() {
  const double energy = spin_energy(now_);
  SpinCoupling::Shape shape;
  const FreeTurn after = feels_ ? FreeTurn(present_turn(shape)) : now_;
  if (feels_ && !ends_there_) step_ = FreeTurn::between(now_, after, 0.5);
  double work = 0;
  if (!loads_.empty()) {
    eta_end_ = modal_.modal_coordinates();
    const TurnAtEnd to = turn_at_end(L_, after);
    q_end_ = to.q;
    L_ = to.L;
    work = to.work;
  } else if (!ends_there_) {
    q_end_ = step_.turned(q_, L_, h_);
  }
  ends_there_ = true;
  q_ = q_end_;
  now_ = after;
  take_drift(shape);
  work_.external += work;
  if (feels_ && !L_.isZero(0))
    work_.numerical += spin_energy(now_) - energy - work + modal_.spin_work();
}

NodeResponse TurningBody::own_response(Index set, double h) const {
  NodeResponse response = inner_->response(set, h);
  response.axes = R_ * response.axes;
  return response;
}

void TurningBody::take_plan(const BodyPlan& plan) {
  BodyPlan inner = plan;
  inner.loads.clear();
  for (const BodyLoad& load : plan.loads) {
    if (load.fixed.modal.size() > 0) require_no_modal_forces(load, name());
    if (load.acceleration) inner.loads.push_back(gravity_load(*load.acceleration, load.history));
    if (load.fixed.forces) add_fixed_forces(load.fixed.forces.on_nodes(), load.history);
    if (load.vector) add_vector_force(*load.vector, load.history);
  }
  inner_->prepare(inner);
}

// Forces that stay in the scene's axes, on nodes that turn.
void TurningBody::add_fixed_forces(const Points& forces, const LoadHistory& history) {
  for (Index d = 0; d < 3; ++d) {
    if (forces.col(d).isZero(0)) continue;
    VectorForce along;
    along.value = Vector3::Unit(d);
    for (Index a = 0; a < 3; ++a) {
      Points pattern = Points::Zero(forces.rows(), 3);
      pattern.col(a) = forces.col(d);
      along.patterns[static_cast<std::size_t>(a)].forces = pattern;
    }
    add_vector_force(along, history);
  }
}

void TurningBody::add_vector_force(const VectorForce& force, const LoadHistory& history) {
  const TurningLoad added(force, history, modal_);
  const DiagonalForm& form = modal_.form();
  const auto E = form.E.topLeftCorner(form.n_rigid, 3);
  for (Index a = 0; a < 3; ++a) {
    modal_.add_turning_force(added.elastic().col(a), history);
    modal_.residual().add_turning_load(force.patterns[static_cast<std::size_t>(a)].forces,
                                       force.value[a], history);
  }
  // The centre of mass moves in the scene's axes, as under SuperelementBody::carry()
  for (Index d = 0; d < 3; ++d) {
    Vector column = Vector::Zero(n_dofs());
    column.head(form.n_rigid) =
        E * (modal_.axes().transpose() * Vector3::Unit(d) / E.col(0).squaredNorm());
    modal_.add_turning_force(column, history);
  }
  loads_.push_back(added);
  expect_turning();
}

// Energy in the middle of a late kick, momentum at its end, as of the inner body.
BodyState TurningBody::own_state() const {
  BodyState state = inner_->state();
  const Vector3 half = 0.5 * last_kick_, l = L_ - half;
  state.angular_momentum = L_ + state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += now_.energy(q_, l);
  state.rotation = 0;
  state.orientation = Eigen::Vector4d(q_.w(), q_.x(), q_.y(), q_.z());
  return state;
}

BodyWork TurningBody::own_work() const {
  BodyWork work = inner_->work();
  work.external += work_.external;
  work.contact += work_.contact;
  work.numerical += work_.numerical;
  return work;
}

void TurningBody::own_turn(const Points& X, Points& u, Points& v) const {
  turn_points(turn_now(), modal_.center_velocity(), angular_velocity(), X, u, v);
}

void TurningBody::own_displacements(Points& u, Points& v) const {
  inner_->displacements(u, v);
  own_turn(own_nodes(), u, v);
}

void TurningBody::own_keep_state(StateArchive& archive) {
  inner_->keep_state(archive);
  if (!loads_.empty()) archive(t_);
  archive(q_.coeffs(), L_, R_, last_kick_, work_);
  if (archive.restores() && feels_) {
    SpinCoupling::Shape shape;
    now_ = FreeTurn(present_turn(shape));
    take_drift(shape);
  }
  expect_turning();
}

}  // namespace cbr
