// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/driven_body.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

DrivenBody::DrivenBody(std::unique_ptr<Body> inner, DrivenMotion motion, double mass,
                       bool has_inertia, bool waits, std::vector<Index> rotations)
    : WrappedBody(std::move(inner)),
      motion_(std::move(motion)),
      rotations_(std::move(rotations)),
      mass_(mass),
      has_inertia_(has_inertia),
      waits_(waits) {}

// Before those that are given.
std::vector<BodyLoad> DrivenBody::with_inertia(const std::vector<BodyLoad>& loads) const {
  std::vector<BodyLoad> all;
  for (int c = 0; c < 3; ++c)
    if (!motion_.axes[c].empty())
      all.push_back(gravity_load(-Vector3::Unit(c), motion_.axes[c].front().acceleration()));
  all.insert(all.end(), loads.begin(), loads.end());
  return all;
}

void DrivenBody::take_plan(const BodyPlan& plan) {
  BodyPlan own = plan;
  if (has_inertia_ && !waits_) own.loads = with_inertia(plan.loads);
  inner_->prepare(own);
  energy_at_start_ = energy_of_motion();
}

void DrivenBody::relax(double t, double share) {
  t_ = t;
  h_ = 0;
  for (Vector3& force : forces_) force.setZero();
  inner_->statics()->relax(t, share);
}

void DrivenBody::add_static_forces(Index set, const Points& forces, ImpulseKind kind) {
  forces_[kind == ImpulseKind::friction] += resultant(set, forces);
  inner_->statics()->add_static_forces(set, forces, kind);
}

Settled DrivenBody::settle() {
  now_ = t_;
  return inner_->statics()->settle();
}

// Forces work on the supports' way; the supports do as much against them.
void DrivenBody::end_load_step() {
  inner_->statics()->end_load_step();
  const Vector3 way = motion_.displacement(now_) - motion_.displacement(start_);
  contact_ += 0.5 * way.dot(forces_start_[0] + forces_[0]);
  friction_ += 0.5 * way.dot(forces_start_[1] + forces_[1]);
  for (int kind = 0; kind < 2; ++kind) forces_start_[kind] = forces_[kind];
  start_ = now_;
}

void DrivenBody::start_motion(double h, const std::vector<BodyLoad>& loads) {
  contact_ = friction_ = 0;
  inner_->statics()->start_motion(h, std::exchange(waits_, false) ? with_inertia(loads) : loads);
}

// Kinetic energy beyond that in the moving axes: v_s . P + m v_s^2 / 2, P the momentum there.
double DrivenBody::energy_of_motion() const {
  const Vector3 v = support_velocity(now_);
  return v.isZero(0) ? 0 : v.dot(inner_->state().momentum) + 0.5 * mass_ * v.squaredNorm();
}

Index DrivenBody::track(const std::vector<Index>& nodes) {
  const Index set = inner_->track(nodes);
  std::vector<Index> rows;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (std::binary_search(rotations_.begin(), rotations_.end(), nodes[i]))
      rows.push_back(static_cast<Index>(i));
  if (!rows.empty()) rotation_rows_[set] = std::move(rows);
  return set;
}

void DrivenBody::shift(Index set, const Vector3& s, Points& x) const {
  x.rowwise() += s.transpose();
  if (const auto found = rotation_rows_.find(set); found != rotation_rows_.end())
    for (const Index row : found->second) x.row(row) -= s.transpose();
}

void DrivenBody::shift_all(const Vector3& s, Points& x) const {
  x.rowwise() += s.transpose();
  for (const Index node : rotations_) x.row(node) -= s.transpose();
}

// Of forces; moments stand in the rows of rotations.
Vector3 DrivenBody::resultant(Index set, const Points& forces) const {
  Vector3 sum = forces.colwise().sum().transpose();
  if (const auto found = rotation_rows_.find(set); found != rotation_rows_.end())
    for (const Index row : found->second) sum -= forces.row(row).transpose();
  return sum;
}

void DrivenBody::positions(Index set, Points& x) const {
  inner_->positions(set, x);
  shift(set, motion_.displacement(now_), x);
}

void DrivenBody::predicted_positions(Index set, Points& x) const {
  inner_->predicted_positions(set, x);
  shift(set, motion_.displacement(t_ + h_), x);
}

MotionBound DrivenBody::moved(MotionBound bound) const {
  const Vector3 s = motion_.displacement(now_);
  bound.lower += s;
  bound.upper += s;
  bound.growth += motion_.largest_speed();
  return bound;
}

void DrivenBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  inner_->mean_motion(set, position, velocity);
  position += motion_.displacement(now_);
  velocity += support_velocity(now_);
}

void DrivenBody::accept() {
  inner_->accept();
  now_ = t_ + h_;
}

void DrivenBody::book(const Vector3& impulse, ImpulseKind kind, double t) {
  (kind == ImpulseKind::contact ? contact_ : friction_) += impulse.dot(support_velocity(t));
}

void DrivenBody::take_impulses(Index set, const Impulses& impulses) {
  inner_->take_impulses(set, impulses);
  impulses.each([&](const Points& p, ImpulseKind kind) { book(resultant(set, p), kind, t_); });
}

// The momentum has a share of what lasts before it is given, and so has the work.
void DrivenBody::expect_forces(Index set, const Impulses& forces) {
  inner_->expect_forces(set, forces);
  Vector3 now[2] = {Vector3::Zero(), Vector3::Zero()};
  forces.each([&](const Points& f, ImpulseKind kind) {
    now[kind == ImpulseKind::friction] = resultant(set, f);
  });
  for (const ImpulseKind kind : {ImpulseKind::contact, ImpulseKind::friction}) {
    Vector3& last = lasting_[kind == ImpulseKind::friction];
    const Vector3& next = now[kind == ImpulseKind::friction];
    book(lasting_share() * h_ * (next - last), kind, t_ + h_);
    last = next;
  }
}

Vector3 DrivenBody::add_velocities(Index set, const Points& velocities, const Vector3& momentum) {
  book(momentum, ImpulseKind::contact, t_);
  return inner_->nodal()->add_velocities(set, velocities, momentum);
}

void DrivenBody::end_velocities(Index set, Points& v) {
  inner_->end_impulses()->end_velocities(set, v);
  shift(set, support_velocity(t_ + h_), v);
}

void DrivenBody::add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  inner_->end_impulses()->add_end_impulses(set, impulses, kind);
  book(resultant(set, impulses), kind, t_ + h_);
}

BodyState DrivenBody::state() const {
  BodyState state = inner_->state();
  const Vector3 v = support_velocity(now_), s = motion_.displacement(now_), own = mass_ * v;
  state.kinetic_energy += v.dot(state.momentum) + 0.5 * mass_ * v.squaredNorm();
  state.angular_momentum +=
      state.center_of_mass.cross(own) + s.cross(Vector3(state.momentum + own));
  state.momentum += own;
  state.center_of_mass += s;
  return state;
}

BodyWork DrivenBody::work() const {
  BodyWork work = inner_->work();
  work.external += energy_of_motion() - energy_at_start_ - contact_ - friction_;
  work.contact += contact_;
  work.friction += friction_;
  return work;
}

void DrivenBody::turn(const Points& X, Points& u, Points& v) const {
  inner_->turn(X, u, v);
  u.rowwise() += motion_.displacement(now_).transpose();
  v.rowwise() += support_velocity(now_).transpose();
}

void DrivenBody::displacements(Points& u, Points& v) const {
  inner_->displacements(u, v);
  shift_all(motion_.displacement(now_), u);
  shift_all(support_velocity(now_), v);
}

void DrivenBody::keep_state(StateArchive& archive) {
  inner_->keep_state(archive);
  archive(now_, contact_, friction_, start_, forces_start_[0], forces_start_[1]);
  archive(lasting_[0], lasting_[1]);
}

}  // namespace cbr
