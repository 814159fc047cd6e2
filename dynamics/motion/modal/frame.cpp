// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/frame.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {
namespace {

// Of the reduced mass about the centre of mass, scene axes.
Matrix3 inertia_of(const ModalBody& modal) {
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

Frame::Frame(ModalBody& modal, const Vector3& angular_velocity, double end)
    : modal_(modal),
      late_(modal.facts().kicks_at_end),
      feels_(!late_ &&
             modal.flow_.turning().feel_spin(*modal.superelement_, modal.form(), modal.damping_)),
      coupling_(feels_ ? modal.flow_.turning().coupling() : nullptr),
      run_end_(end),
      J_0_(inertia_of(modal_)),
      largest_inertia_(symmetric_eigen(J_0_).values.maxCoeff()),
      now_(J_0_),
      step_(J_0_),
      L_(J_0_ * angular_velocity) {
  assert(modal_.form().n_rigid == 6 && modal_.is_exact());
  expect_turning();
}

// Bounds of the factors until the end of the run. Of the spin: |g| <= |w|^2, however its axes lie,
// and a tenth more for the inertia that oscillates.
void Frame::expect_turning() {
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
  modal_.flow_.turning().expect(largest, is_coupled() ? energy_for_modes(momentum) : -1);
}

BodyTurn Frame::now() const { return {modal_.center_of_mass(), q_.toRotationMatrix()}; }

BodyTurn Frame::at_end() const {
  return {modal_.predicted_center_of_mass(), end().toRotationMatrix()};
}

void Frame::turn_positions(Index set, Points& x) const {
  turn_about(modal_.center_of_mass(), q_, x);
  if (!late_) placed_[set] = {x, true};
}

void Frame::turn_predicted_positions(Index set, Points& x) const {
  turn_about(modal_.predicted_center_of_mass(), end(), x);
  if (late_) placed_[set] = {x, true};
}

const Eigen::Quaterniond& Frame::end() const {
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
MotionBound Frame::in_any_position(MotionBound bound) const {
  const Vector3 c = modal_.center_of_mass();
  const double radius = (c - bound.lower).cwiseAbs().cwiseMax((bound.upper - c).cwiseAbs()).norm();
  bound.lower = c.array() - radius;
  bound.upper = c.array() + radius;
  bound.growth.setConstant(bound.growth.norm());
  return bound;
}

void Frame::turn_mean_motion(Vector3& position, Vector3& velocity) const {
  const Vector3 c = modal_.center_of_mass(), v_c = modal_.center_velocity();
  const Vector3 arm = q_ * (position - c);
  position = c + arm;
  velocity = v_c + now_.angular_velocity(q_, L_).cross(arm) + q_ * (velocity - v_c);
}

// The modes take impulses in the axes of the middle of the step: so their symmetric response is
// that of the rotated body to second order in the angle of a step.
void Frame::take_axes() {
  Eigen::Quaterniond middle;
  middle.coeffs() = q_.coeffs() + q_end_.coeffs();  // of parts of a turn; opposite signs cannot be
  if (middle.coeffs().isZero(1e-3)) middle = q_;
  R_ = q_.vec().isZero(0) && q_end_.vec().isZero(0) ? Matrix3::Identity()
                                                    : middle.normalized().toRotationMatrix();
}

void Frame::predict(double t, double h) {
  t_ = t;
  h_ = h;
  kick_.setZero();
  is_kicked_ = false;
  if (!loads_.empty()) eta_start_ = eta_end_ = modal_.modal_coordinates();
  const bool spins = feels_ && !L_.isZero(0);
  if (feels_ && L_.isZero(0) && loads_.empty()) modal_.flow_.turning().take_factors({});
  if (!is_coupled()) modal_.flow_.turning().uncouple();
  if (spins || !loads_.empty()) turn_modes(now_);
  if (spins) {
    modal_.predict_modes();
    turn_modes(predicted_turn());
  }
  modal_.predict_modes();
  if (feels_) step_ = FreeTurn::between(now_, predicted_turn(), 0.5);
  ends_there_ = false;
  end();
  take_axes();
}

double Frame::spin_energy(const FreeTurn& of) const { return of.energy(q_, L_); }

void Frame::add_moment(const Vector3& moment) {
  is_kicked_ = true;
  kick_ += moment;
  ends_there_ = late_;
}

void Frame::add_moments(Index set, const Points& impulses) {
  Points x;
  if (!placed_[set].known)
    late_ ? modal_.own_predicted_positions(set, x) : modal_.own_positions(set, x);
  const Vector3 c = late_ ? modal_.predicted_center_of_mass() : modal_.center_of_mass();
  add_moment(moment_about(c, placed_[set].x, impulses));
}

void Frame::take_impulses(Index set, const Impulses& impulses) {
  add_moments(set, impulses.all);
  const Points turned = impulses.all * R_;
  modal_.push_modes(set, {turned, impulses.move, impulses.still});
}

// Work of moments on a spin that goes from w to w + J^-1 M; share_of_kick: the mean part of J^-1 M.
void Frame::book(const Vector3& moment, const Vector3& w, const Vector3& share_of_kick) {
  work_.contact += moment.dot(w + share_of_kick);
}

void Frame::accept() {
  const double longest = is_coupled() && !is_kicked_ ? longest_part() : h_;
  if (!(h_ > longest)) return accept_part();
  // No impulses in this step, and no output in between
  const double t = t_, n = std::ceil(h_ / longest), h = h_ / n;
  for (double i = 0; i < n; ++i) {
    modal_.predict(t + i * h, h);
    accept_part();
  }
}

void Frame::accept_part() {
  const Vector3 w = now_.angular_velocity(q_, L_);
  // The momentum of kicks in the motion of the modes is no part of the rotation's
  Vector3 inside = Vector3::Zero();
  if (is_coupled() && modal_.kick_)
    inside = axial(coupling_->momentum(modal_.modal_coordinates(), modal_.kick_.sum()));
  modal_.accept_modes();
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
void Frame::move_on() {
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
    work_.numerical += spin_energy(now_) - energy - work + modal_.spin_work_;
}

BodyPlan Frame::take_plan(const BodyPlan& plan) {
  BodyPlan of_modes = plan;
  of_modes.loads.clear();
  for (const BodyLoad& load : plan.loads) {
    if (load.fixed.modal.size() > 0) require_no_modal_forces(load, modal_.name());
    if (load.acceleration) of_modes.loads.push_back(gravity_load(*load.acceleration, load.history));
    if (load.fixed.forces) add_fixed_forces(load.fixed.forces.on_nodes(), load.history);
    if (load.vector) add_vector_force(*load.vector, load.history);
  }
  return of_modes;
}

// Forces that stay in the scene's axes, on nodes that turn.
void Frame::add_fixed_forces(const Points& forces, const LoadHistory& history) {
  for (Index d = 0; d < 3; ++d) {
    if (forces.col(d).isZero(0)) continue;
    VectorForce along;
    along.value = Vector3::Unit(d);
    for (Index a = 0; a < 3; ++a) {
      Points pattern = Points::Zero(forces.rows(), 3);
      pattern.col(a) = forces.col(d);
      along.patterns[a].forces = pattern;
    }
    add_vector_force(along, history);
  }
}

void Frame::add_vector_force(const VectorForce& force, const LoadHistory& history) {
  const TurningLoad added(force, history, modal_);
  const ModalForm& form = modal_.form();
  const auto E = form.E.topLeftCorner(form.n_rigid, 3);
  for (Index a = 0; a < 3; ++a) {
    modal_.flow_.add_turning_force(added.elastic().col(a), history);
    modal_.residual_.add_turning_load(force.patterns[a].forces, force.value[a], history);
  }
  // The centre of mass moves in the scene's axes
  for (Index d = 0; d < 3; ++d) {
    Vector column = Vector::Zero(modal_.n_dofs());
    column.head(form.n_rigid) =
        E * (modal_.axes().transpose() * Vector3::Unit(d) / E.col(0).squaredNorm());
    modal_.flow_.add_turning_force(column, history);
  }
  loads_.push_back(added);
  expect_turning();
}

// Energy in the middle of a late kick, momentum at its end, as of the modes.
void Frame::turn_state(BodyState& state) const {
  const Vector3 half = 0.5 * last_kick_, l = L_ - half;
  state.angular_momentum = L_ + state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += now_.energy(q_, l);
  state.rotation = 0;
  state.orientation = Eigen::Vector4d(q_.w(), q_.x(), q_.y(), q_.z());
}

void Frame::turn(const Points& X, Points& u, Points& v) const {
  turn_points(now(), modal_.center_velocity(), angular_velocity(), X, u, v);
}

void Frame::keep_state(StateArchive& archive) {
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
