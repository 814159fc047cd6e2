// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
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

// rad, the most that a body turns in a part of a step. Forces that turn with it are linear in time
// there, which is wrong by the square of this angle / 12: small beside what the first order in the
// strain leaves out. Moments of loads act at the ends of a part, and need smaller ones.
constexpr double largest_turn = 0.1, largest_turn_of_loads = 0.02;
// rad: beyond it a step has millions of parts, and the scene is wrong.
constexpr double largest_turn_of_step = 1e4;

// What couples modes acts at the ends of a step: it turns by this at most, and the phase of the
// highest coupled mode by that, rad.
constexpr double largest_turn_of_coupling = 0.1, largest_phase = 2;

}  // namespace

TurningBody::TurningBody(std::unique_ptr<Body> inner, SuperelementBody& modal, StaticsBody* statics,
                         bool late, const Vector3& angular_velocity, double end)
    : inner_(std::move(inner)),
      modal_(modal),
      statics_(statics),
      late_(late),
      feels_(!late && modal.feel_spin()),
      coupling_(feels_ ? modal.coupling() : nullptr),
      run_end_(end),
      J_0_(inertia_of(modal)),
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

// J, the most that coupled modes may get from the spin: all but what the axis of the largest
// inertia leaves, which swings. momentum: the most there can be, where loads bring any.
double TurningBody::energy_for_modes(double momentum) const {
  const double all =
      loads_.empty() ? spin_energy(now_) : 0.5 * momentum * momentum * now_.rate_per_momentum;
  const double left = loads_.empty() ? 0.5 * L_.squaredNorm() / (1.1 * largest_inertia_) : 0;
  return std::max(0.0, all - left);
}

void TurningBody::damp(const Damping& damping) { inner_->damp(damping); }

Index TurningBody::track(const std::vector<Index>& nodes) {
  placed_.emplace_back();
  return inner_->track(nodes);
}

void TurningBody::positions(Index set, Points& x) const {
  inner_->positions(set, x);
  turn_about(modal_.center_of_mass(), q_, x);
  if (!late_) placed_[set] = {x, true};
}

void TurningBody::predicted_positions(Index set, Points& x) const {
  inner_->predicted_positions(set, x);
  turn_about(modal_.predicted_center_of_mass(), end(), x);
  if (late_) placed_[set] = {x, true};
}

const Eigen::Quaterniond& TurningBody::end() const {
  if (ends_there_) return q_end_;
  const Vector3 L = late_ ? L_ : Vector3(L_ + kick_.all);
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

void TurningBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
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

// J_0 + 2 (tr S 1 - S): what the modes make of the inertia, first order; shape: S, component axes,
// as xx, yy, zz, xy, yz, xz.
Matrix3 TurningBody::inertia(const Vector& shape) const {
  Matrix3 S;
  S << shape[0], shape[3], shape[5], shape[3], shape[1], shape[4], shape[5], shape[4], shape[2];
  return J_0_ +
         2 * (S.trace() * Matrix3::Identity() - modal_.axes() * S * modal_.axes().transpose());
}

// An axial vector of the component's axes in those of the body, and back.
Vector3 TurningBody::axial(const Vector3& of_component) const {
  return modal_.axes().determinant() * (modal_.axes() * of_component);
}

Vector3 TurningBody::in_component(const Vector3& axial) const {
  return modal_.axes().determinant() * (modal_.axes().transpose() * axial);
}

// Of the body as its modes are, where it feels its spin.
TurnInertia TurningBody::present_turn(SpinCoupling::Shape& shape) const {
  const Matrix3 J = inertia(modal_.spin_shape());
  if (!is_coupled()) return {J};
  shape = coupling_->shape(modal_.modal_coordinates(), modal_.modal_velocities());
  return with(J, shape);
}

TurnInertia TurningBody::predicted_turn() const {
  const Matrix3 J = inertia(modal_.predicted_spin_shape());
  if (!is_coupled()) return {J};
  return with(J, coupling_->shape(modal_.predicted_modal_coordinates(),
                                  modal_.predicted_modal_velocities()));
}

TurnInertia TurningBody::with(const Matrix3& J, const SpinCoupling::Shape& shape) const {
  return {J + modal_.axes() * shape.inertia * modal_.axes().transpose(), axial(shape.momentum)};
}

void TurningBody::take_drift(const SpinCoupling::Shape& shape) {
  modal_.take_drift(is_coupled() ? Vector(shape.drift * in_component(q_.conjugate() *
                                                                     now_.angular_velocity(q_, L_)))
                                 : Vector());
}

// Of the forces that turn with the body: of the spin, and of each load its vector, for the elastic
// modes, and its resultant, for the centre of mass. w: scene axes.
Vector TurningBody::factors(const Eigen::Quaterniond& q, const Vector3& w) const {
  const Index n_spin = feels_ ? 6 : 0;
  Vector g(n_spin + 6 * static_cast<Index>(loads_.size()));
  if (feels_) g.head(6) = centrifugal(modal_.axes().transpose() * (q.conjugate() * w));
  for (std::size_t l = 0; l < loads_.size(); ++l)
    g.segment<6>(n_spin + 6 * static_cast<Index>(l)) << loads_[l].vector(q), loads_[l].resultant(q);
  return g;
}

// A part of the step, from t = from to `to`: a moment changes the momentum at either end by its
// integral with the weight of a hat that is 1 there. `share` of the step has gone at this end.
void TurningBody::add_moments_of_loads(double from, double to, double share, bool at_end,
                                       const FreeTurn& turn, TurnAtEnd& end) const {
  const Vector eta = (1 - share) * eta_start_ + share * eta_end_;
  Vector3 sum = Vector3::Zero();
  for (const TurningLoad& load : loads_) {
    const double rising = load.history().rising_integral(from, to);
    sum += load.moment(end.q, eta) * (at_end ? rising : load.history().integral(from, to) - rising);
  }
  end.work += sum.dot(turn.angular_velocity(end.q, end.L + 0.5 * sum));
  end.L += sum;
}

// From here, with L, while the inertia goes from what it is to that of `last`.
TurningBody::TurnAtEnd TurningBody::turn_at_end(Vector3 L, const TurnInertia& last) const {
  double momentum = L.norm();
  for (const TurningLoad& load : loads_) momentum += load.largest_moment() * h_;
  const double most = loads_.empty() ? largest_turn : largest_turn_of_loads;
  const double angle = now_.rate_per_momentum * momentum * h_;
  if (!(angle < largest_turn_of_step))
    throw RunError(
        format_text("instance '%s' turns by %.3g rad in a step of %.3g s at t = %.4g s: "
                    "look at the loads and their units, or at the step",
                    name().c_str(), angle, h_, t_));
  const auto n = std::max<Index>(1, static_cast<Index>(std::ceil(angle / most)));
  const auto part = 1 / static_cast<double>(n);
  const auto at = [&](double share) { return FreeTurn::between(now_, last, share); };
  TurnAtEnd end{q_, L, 0, {}, Vector3::Zero()};
  for (Index i = 0; i <= n; ++i) {
    const double share = static_cast<double>(i) * part;
    if (i > 0) {
      const double before = share - part, from = t_ + before * h_, to = t_ + share * h_;
      if (!loads_.empty()) add_moments_of_loads(from, to, before, false, at(before), end);
      end.q = at(share - 0.5 * part).turned(end.q, end.L, h_ * part);
      if (!loads_.empty()) add_moments_of_loads(from, to, share, true, at(share), end);
    }
    end.w = at(share).angular_velocity(end.q, end.L);
    const Vector g = factors(end.q, end.w);
    if (i == 0) end.g.resize(g.size(), n + 1);
    end.g.col(i) = g;
  }
  return end;
}

void TurningBody::turn_inner(const TurnInertia& last) {
  TurnAtEnd to = turn_at_end(L_, last);
  if (is_coupled())
    modal_.couple(in_component(q_.conjugate() * now_.angular_velocity(q_, L_)),
                  in_component(to.q.conjugate() * to.w));
  if (statics_ != nullptr && !loads_.empty()) {
    const auto n = static_cast<Index>(loads_.size());
    Vector of_loads(3 * n), largest(3 * n);
    for (Index l = 0; l < n; ++l) {
      const Index row = (feels_ ? 6 : 0) + 6 * l;
      of_loads.segment<3>(3 * l) = to.g.col(to.g.cols() - 1).segment<3>(row);
      largest.segment<3>(3 * l).setConstant(loads_[static_cast<std::size_t>(l)].largest_vector());
    }
    statics_->turn_statics(of_loads, largest);
  }
  modal_.turn_forces(std::move(to.g));
}

void TurningBody::predict(double t, double h) {
  t_ = t;
  h_ = h;
  kick_ = {};
  is_kicked_ = false;
  if (!loads_.empty()) eta_start_ = eta_end_ = modal_.modal_coordinates();
  const bool spins = feels_ && !L_.isZero(0);
  if (feels_ && L_.isZero(0) && loads_.empty()) modal_.turn_forces({});
  if (!is_coupled()) modal_.uncouple();
  if (spins || !loads_.empty()) turn_inner(now_);
  if (spins) {
    inner_->predict(t, h);
    turn_inner(predicted_turn());
  }
  inner_->predict(t, h);
  if (feels_) step_ = FreeTurn::between(now_, predicted_turn(), 0.5);
  ends_there_ = false;
  end();
  take_axes();
}

double TurningBody::spin_energy(const FreeTurn& of) const { return of.energy(q_, L_); }

void TurningBody::add_moment(const Vector3& moment, ImpulseKind kind) {
  is_kicked_ = true;
  kick_.all += moment;
  if (kind == ImpulseKind::friction) kick_.friction += moment;
  ends_there_ = late_;
}

void TurningBody::add_moments(Index set, const Points& impulses, ImpulseKind kind) {
  Points x;
  if (!placed_[set].known && late_) predicted_positions(set, x);
  if (!placed_[set].known && !late_) positions(set, x);
  const Vector3 c = late_ ? modal_.predicted_center_of_mass() : modal_.center_of_mass();
  add_moment(moment_about(c, placed_[set].x, impulses), kind);
}

void TurningBody::add_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  add_moments(set, impulses, kind);
  inner_->add_impulses(set, impulses * R_, kind);
}

void TurningBody::add_answered_impulses(Index set, const Points& contact, const Points& friction,
                                        const Points& move, const Vector& still) {
  add_moments(set, contact, ImpulseKind::contact);
  if (!friction.isZero(0)) add_moments(set, friction, ImpulseKind::friction);
  inner_->add_answered_impulses(set, contact * R_, friction * R_, move, still);
}

// What moments do to a spin that goes from w to w + J^-1 M as `share_of_kick` of J^-1 M is there.
void TurningBody::book(const Moments& moments, const Vector3& w, const Vector3& share_of_kick) {
  const double friction = moments.friction.dot(w + share_of_kick);
  work_.contact += moments.all.dot(w + share_of_kick) - friction;
  work_.friction += friction;
}

void TurningBody::accept() {
  const double longest = is_coupled() && !is_kicked_ ? longest_part() : h_;
  if (!(h_ > longest)) return accept_part();
  // Nothing pushed it, and no one looks at it in between
  const double t = t_, n = std::ceil(h_ / longest), h = h_ / n;
  for (double i = 0; i < n; ++i) {
    predict(t + i * h, h);
    accept_part();
  }
}

// s, of a step in which the ends may stand for all of it.
double TurningBody::longest_part() const {
  const Index highest = coupling_->first() + coupling_->size() - 1;
  const double w = now_.angular_velocity(q_, L_).norm();
  return std::min(largest_phase / modal_.form().omega[highest], largest_turn_of_coupling / w);
}

void TurningBody::accept_part() {
  const Vector3 w = now_.angular_velocity(q_, L_);
  // What kicks of the modes bring to what moves inside is none of the turn's
  Moments inside;
  if (is_coupled() && modal_.kick() != nullptr) {
    const Vector& eta = modal_.modal_coordinates();
    inside.all = axial(coupling_->momentum(eta, *modal_.kick()));
    if (modal_.friction_kick() != nullptr)
      inside.friction = axial(coupling_->momentum(eta, *modal_.friction_kick()));
  }
  inner_->accept();
  if (late_) {
    // From the middle of the kick at the start to that of the kick at the end
    const Moments half{0.5 * last_kick_.all, 0.5 * last_kick_.friction};
    book(half, w, -0.25 * now_.change(q_, last_kick_.all));
    q_ = end();
    if (!loads_.empty()) {
      L_ = L_end_;
      work_.external += work_end_;
    }
    const Moments next{0.5 * kick_.all, 0.5 * kick_.friction};
    book(next, now_.angular_velocity(q_, L_), 0.25 * now_.change(q_, kick_.all));
    last_kick_ = kick_;
    L_ += kick_.all;
  } else {
    const Moments of_turn{kick_.all - q_ * inside.all, kick_.friction - q_ * inside.friction};
    book(of_turn, w, 0.5 * now_.change(q_, of_turn.all));
    L_ += kick_.all;
    now_.inner += inside.all;
    move_on();
  }
  kick_ = {};
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

NodeResponse TurningBody::response(Index set, double h) const {
  NodeResponse response = inner_->response(set, h);
  response.axes = R_ * response.axes;
  return response;
}

void TurningBody::add_force(const Points& forces, const LoadHistory& history) {
  for (Index d = 0; d < 3; ++d) {
    if (forces.col(d).isZero(0)) continue;
    VectorLoad load;
    load.value = Vector3::Unit(d);
    load.history = history;
    for (Index a = 0; a < 3; ++a) {
      Points& pattern = load.patterns[static_cast<std::size_t>(a)].forces;
      pattern.setZero(forces.rows(), 3);
      pattern.col(a) = forces.col(d);
    }
    add_vector_load(load);
  }
}

void TurningBody::add_vector_load(const VectorLoad& load) {
  const TurningLoad added(load, modal_);
  const DiagonalForm& form = modal_.form();
  const auto E = form.E.topLeftCorner(form.n_rigid, 3);
  for (Index a = 0; a < 3; ++a) {
    modal_.add_turning_force(added.elastic().col(a), load.history);
    const Points& forces = load.patterns[static_cast<std::size_t>(a)].forces;
    if (statics_ != nullptr)
      statics_->add_turning_statics(forces.rows() > 0 ? forces : Points(Points::Zero(n_nodes(), 3)),
                                    load.value[a], load.history);
  }
  // The centre of mass moves in the scene's axes, as under SuperelementBody::carry()
  for (Index d = 0; d < 3; ++d) {
    Vector column = Vector::Zero(n_dofs());
    column.head(form.n_rigid) =
        E * (modal_.axes().transpose() * Vector3::Unit(d) / E.col(0).squaredNorm());
    modal_.add_turning_force(column, load.history);
  }
  loads_.push_back(added);
  expect_turning();
}

// Energy in the middle of a late kick, momentum at its end, as of the inner body.
BodyState TurningBody::state() const {
  BodyState state = inner_->state();
  const Vector3 half = 0.5 * last_kick_.all, l = L_ - half;
  state.angular_momentum = L_ + state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += now_.energy(q_, l);
  state.rotation = 0;
  state.orientation = Eigen::Vector4d(q_.w(), q_.x(), q_.y(), q_.z());
  return state;
}

BodyWork TurningBody::work() const {
  BodyWork work = inner_->work();
  work.external += work_.external;
  work.contact += work_.contact;
  work.friction += work_.friction;
  work.numerical += work_.numerical;
  return work;
}

void TurningBody::turn(const Points& X, Points& u, Points& v) const {
  turn_points(turn_now(), modal_.center_velocity(), angular_velocity(), X, u, v);
}

void TurningBody::displacements(Points& u, Points& v) const {
  inner_->displacements(u, v);
  turn(reference_positions(), u, v);
}

void TurningBody::keep_state(StateArchive& archive) {
  inner_->keep_state(archive);
  if (!loads_.empty()) archive(t_);
  archive(q_.coeffs(), L_, R_, last_kick_.all, last_kick_.friction, work_);
  if (archive.restores() && feels_) {
    SpinCoupling::Shape shape;
    now_ = FreeTurn(present_turn(shape));
    take_drift(shape);
  }
  expect_turning();
}

}  // namespace cbr
