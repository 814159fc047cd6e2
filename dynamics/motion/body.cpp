// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/body.hpp"

#include <Eigen/Geometry>

#include <stdexcept>

#include "common/base/error.hpp"
#include "common/files/state_archive.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/prescribed_motion.hpp"

namespace cbr {

Body::Body(BodyFacts facts) : facts_(std::move(facts)) {}

Body::~Body() = default;

const Points& Body::reference_positions() const {
  return points_ ? points_->positions() : own_nodes();
}

void Body::move_supports(SupportPlan plan) {
  supports_ = std::make_unique<PrescribedMotion>(std::move(plan), own_nodes().rows());
  const Vector impulse = supports_->start_impulse();
  if (impulse.size() > 0) add_start_impulse(impulse);
}

void Body::add_points(std::vector<AveragePoint> points) {
  points_ = std::make_unique<BodyPoints>(std::move(points), own_nodes());
}

bool Body::has_points(Index set) const { return points_ && points_->has_points(set); }

Index Body::track(const std::vector<Index>& nodes) {
  const std::vector<Index> own = points_ ? points_->track(nodes) : nodes;
  if (supports_) supports_->track(own);
  return own_track(own);
}

Index Body::track_mean(const std::vector<Index>& nodes) {
  if (supports_) supports_->track_mean(nodes);
  return own_track_mean(nodes);
}

void Body::prepare(const BodyPlan& plan) {
  if (is_prepared_ || has_moved_)
    throw std::logic_error("Body::prepare() of '" + name() + "': it has its plan, or has moved");
  is_prepared_ = true;
  if (!supports_) return take_plan(plan);
  BodyPlan own = plan;
  own.loads = supports_->loads_at_start(plan.loads);
  take_plan(own);
  supports_->begin(plan.loads, own_state(), own_rates());
}

// Of all own coordinates, where the supports have shapes; else empty.
Vector Body::own_rates() const {
  Vector q, rates;
  if (!supports_->is_translation()) own_coordinates(q, rates);
  return rates;
}

void Body::positions(Index set, Points& x) const {
  const bool turned = has_points(set) && turns();
  turned ? unturned_positions(set, x) : own_positions(set, x);
  if (supports_) supports_->move_now(set, x);
  if (has_points(set)) points_->extend(set, turned ? turn_now() : BodyTurn(), x);
}

void Body::predicted_positions(Index set, Points& x) const {
  const bool turned = has_points(set) && turns();
  turned ? unturned_end(set, x) : own_predicted_positions(set, x);
  if (supports_) supports_->move_end(set, x);
  if (has_points(set)) points_->extend(set, turned ? turn_at_end() : BodyTurn(), x);
}

MotionBound Body::motion_bound(Index set, bool quick) const {
  const MotionBound bound = own_motion_bound(set, quick);
  return supports_ ? supports_->moved(set, bound) : bound;
}

bool Body::at_rest() const { return own_at_rest() && !(supports_ && supports_->moves()); }

void Body::predict(double t, double h, Index n_steps) {
  has_moved_ = true;
  t_ = t;
  h_ = h;
  n_steps_ = n_steps;
  if (supports_) supports_->predict(t, h);
  predict_end();
}

// On the body's own nodes.
const Points& Body::spread_on(Index set, const Points& impulses, Points& room) const {
  if (!has_points(set)) return impulses;
  return room = points_->spread(set, impulses);
}

void Body::push(Index set, const Impulses& impulses) {
  own_take_impulses(set, impulses);
  if (supports_) supports_->take_impulses(set, impulses, scheme() == Scheme::newmark);
}

void Body::take_impulses(Index set, const Impulses& impulses) {
  if (!has_points(set)) return push(set, impulses);
  const Points& p = impulses.all;
  if (!turns()) return push(set, {points_->spread(set, p)});
  const Matrix3 R = turn_of_step();
  const Points nodal = points_->spread(set, p * R) * R.transpose();
  push(set, {nodal});
  Points x;
  unturned_positions(set, x);
  add_moment(points_->missing_moment(set, turn_now(), x, p, nodal));
}

void Body::expect_forces(Index set, const Points& forces) {
  Points spread;
  const Points& own = forces.rows() > 0 ? spread_on(set, forces, spread) : forces;
  own_expect_forces(set, own);
  if (supports_) supports_->expect_forces(set, own, lasting_share());
}

double Body::residual_friction(Index set, const Points& impulses, bool between) {
  Points spread;
  const Points& own = impulses.rows() > 0 ? spread_on(set, impulses, spread) : impulses;
  return own_residual_friction(set, own, between);
}

void Body::accept() {
  own_accept();
  if (supports_) supports_->accept();
}

NodeResponse Body::response(Index set, double h) const {
  if (!has_points(set)) return own_response(set, h);
  if (!turns()) return points_->extended(set, own_response(set, h));
  return points_->turned_response(set, h, turn_of_step(),
                                  [&] { return unturned_response(set, h); });
}

Vector3 Body::add_velocities(Index set, const Points& velocities, const Vector3& momentum) {
  if (supports_) supports_->take_momentum(momentum);
  return own_add_velocities(set, velocities, momentum);
}

void Body::end_velocities(Index set, Points& v) {
  own_end_velocities(set, v);
  if (supports_) supports_->add_end_velocities(set, v);
  if (has_points(set)) points_->extend_rates(set, v);
}

NodeResponse Body::velocity_response(Index set) const {
  const NodeResponse own = own_velocity_response(set);
  return has_points(set) ? points_->extended(set, own) : own;
}

void Body::add_end_impulses(Index set, const Points& impulses) {
  Points spread;
  const Points& own = spread_on(set, impulses, spread);
  own_add_end_impulses(set, own);
  if (supports_) supports_->add_end_impulses(set, own);
}

void Body::relax(double t, double share) {
  if (supports_) supports_->relax(t);
  own_relax(t, share);
}

Matrix Body::floating_motions(Index set) const {
  const Matrix own = own_floating_motions(set);
  return has_points(set) ? points_->extended(set, own) : own;
}

NodeResponse Body::static_response(Index set) const {
  const NodeResponse own = own_static_response(set);
  return has_points(set) ? points_->extended(set, own) : own;
}

void Body::add_static_forces(Index set, const Points& forces) {
  Points spread;
  const Points& own = spread_on(set, forces, spread);
  if (supports_) supports_->add_static_forces(set, own);
  own_add_static_forces(set, own);
}

Settled Body::settle() {
  Settled settled = own_settle();
  if (supports_) settled.energy += supports_->settle();
  return settled;
}

void Body::end_load_step() {
  own_end_load_step();
  if (supports_) supports_->end_load_step();
}

void Body::start_motion(double h, const std::vector<BodyLoad>& loads) {
  own_start_motion(h, supports_ ? supports_->start_motion(loads) : loads);
}

std::vector<Reaction> Body::take_reactions(double t, double interval) {
  return supports_->take_reactions(t, interval, own_rates());
}

std::vector<Reaction> Body::static_reactions(double t) const {
  return supports_->static_reactions(t);
}

BodyState Body::state() const {
  const BodyState state = own_state();
  return supports_ && supports_->moves() ? supports_->moved(state, own_rates()) : state;
}

BodyWork Body::work() const {
  const BodyWork work = own_work();
  return supports_ && supports_->moves() ? supports_->worked(work, own_state(), own_rates()) : work;
}

void Body::displacements(Points& u, Points& v) const {
  own_displacements(u, v);
  if (supports_) supports_->add_displacements(u, v);
}

void Body::coordinates(Vector& q, Vector& rates) const {
  own_coordinates(q, rates);
  if (supports_) supports_->add_coordinates(q, rates);
}

void Body::turn(const Points& X, Points& u, Points& v) const {
  own_turn(X, u, v);
  if (supports_) supports_->translate(u, v);
}

void Body::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  own_mean_motion(set, position, velocity);
  if (supports_) supports_->add_mean_motion(set, position, velocity);
}

void Body::keep_state(StateArchive& archive) {
  own_keep_state(archive);
  if (supports_) supports_->keep_state(archive);
  if (points_ && turns()) points_->keep_state(archive);
}

void Body::lacks(const char* ability) const {
  throw std::logic_error("body '" + name() + "' has no " + ability);
}

void Body::lacks_statics() const {
  throw InputError("instance '" + name() +
                   "': statics (time.static, time.preload) cannot be had of it");
}

void Body::lacks_nodal_masses() const {
  throw InputError("instance '" + name() +
                   "': enforcement: nodal has no masses of nodes to weigh with newmark, rotations: "
                   "large, or an interface without mass: take enforcement impulse or penalty");
}

Points Body::nodal_masses(Index) const { lacks_nodal_masses(); }
Vector3 Body::own_add_velocities(Index, const Points&, const Vector3&) { lacks_nodal_masses(); }
MotionBound Body::own_motion_bound(Index, bool) const { lacks("motion bounds"); }
void Body::own_end_velocities(Index, Points&) { lacks("end velocities"); }
NodeResponse Body::own_velocity_response(Index) const { lacks("end velocities"); }
void Body::own_add_end_impulses(Index, const Points&) { lacks("end velocities"); }
void Body::own_relax(double, double) { lacks_statics(); }
Matrix Body::own_floating_motions(Index) const { lacks_statics(); }
FloatingForces Body::floating_forces() const { lacks_statics(); }
void Body::float_by(const Vector&) { lacks_statics(); }
NodeResponse Body::own_static_response(Index) const { lacks_statics(); }
void Body::own_add_static_forces(Index, const Points&) { lacks_statics(); }
Settled Body::own_settle() { lacks_statics(); }
void Body::own_end_load_step() { lacks_statics(); }
void Body::own_start_motion(double, const std::vector<BodyLoad>&) { lacks_statics(); }
void Body::add_start_impulse(const Vector&) { lacks("impulses at the start"); }
void Body::add_moment(const Vector3&) { lacks("turn"); }

void turn_points(const BodyTurn& turn, const Vector3& velocity, const Vector3& spin,
                 const Points& X, Points& u, Points& v) {
  for (Index i = 0; i < X.rows(); ++i) {
    const Vector3 arm = turn.R * (X.row(i) + u.row(i) - turn.center.transpose()).transpose();
    const Vector3 rate = turn.R * (v.row(i).transpose() - velocity);
    u.row(i) = (turn.center + arm).transpose() - X.row(i);
    v.row(i) = (velocity + spin.cross(arm) + rate).transpose();
  }
}

void keep_state(StateArchive& archive, BodyState& state) {
  archive(state.center_of_mass, state.momentum, state.angular_momentum, state.kinetic_energy,
          state.strain_energy);
  archive(state.rotation);
  bool turns = state.orientation.has_value();
  archive(turns);
  if (!turns) return;
  Eigen::Vector4d orientation = state.orientation.value_or(Eigen::Vector4d::Zero());
  archive(orientation);
  state.orientation = orientation;
}

void keep_state(StateArchive& archive, BodyWork& work) {
  archive(work.external, work.contact, work.damping, work.numerical);
}

}  // namespace cbr
