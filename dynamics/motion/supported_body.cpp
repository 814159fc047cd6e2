// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/supported_body.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

Eigen::Map<const Vector> numbers_of(const Points& x) { return {x.data(), x.size()}; }

}  // namespace

SupportedBody::SupportedBody(std::unique_ptr<Body> inner, SupportPlan plan)
    : WrappedBody(std::move(inner)), plan_(std::move(plan)), mass_(plan_.shapes.mass()) {
  const Points& X = inner_->reference_positions();
  nodal_.resize(X.size(), n_shapes());
  for (Index i = 0; i < X.rows(); ++i)
    nodal_.middleRows(3 * i, 3) = plan_.T * plan_.shapes.psi.middleRows(plan_.n_modal + 3 * i, 3);
  for (Vector* sum :
       {&pushed_, &momenta_, &forces_[0], &forces_[1], &forces_start_[0], &forces_start_[1]})
    sum->setZero(n_shapes());
  if (n_drives() > 0 && plan_.has_inertia) {
    // What is free keeps its velocity when the supports begin with one
    const Vector g = velocity(0);
    if (!g.isZero(0))
      inner_->start_impulses()->add_start_impulse(-plan_.shapes.inertia.leftCols(n_drives()) * g);
  }
  energy_at_start_ = energy_of_motion();
}

// Before those that are given.
std::vector<BodyLoad> SupportedBody::with_inertia(const std::vector<BodyLoad>& loads) const {
  const Index k = plan_.n_modal, n = inner_->n_nodes();
  std::vector<BodyLoad> all;
  for (Index j = 0; j < n_drives(); ++j) {
    const Vector force = -plan_.shapes.inertia.col(j);
    const Points on_nodes = Eigen::Map<const Points>(force.data() + k, n, 3) * plan_.T.transpose();
    BodyLoad load{.history = plan_.drives[static_cast<std::size_t>(j)].acceleration()};
    if (!on_nodes.isZero(0)) load.fixed.forces = on_nodes;
    if (k > 0) load.fixed.modal = force.head(k);
    all.push_back(std::move(load));
  }
  all.insert(all.end(), loads.begin(), loads.end());
  return all;
}

void SupportedBody::take_plan(const BodyPlan& plan) {
  BodyPlan own = plan;
  if (plan_.has_inertia && !plan_.waits) own.loads = with_inertia(plan.loads);
  inner_->prepare(own);
  for (const BodyLoad& load : plan.loads) add_load(load);
}

Vector SupportedBody::displacement(double t) const {
  Vector g(n_drives());
  for (Index j = 0; j < g.size(); ++j)
    g[j] = plan_.drives[static_cast<std::size_t>(j)].displacement(t);
  return g;
}

Vector SupportedBody::velocity(double t) const {
  Vector g = Vector::Zero(n_drives());
  if (!plan_.has_inertia) return g;
  for (Index j = 0; j < g.size(); ++j) g[j] = plan_.drives[static_cast<std::size_t>(j)].velocity(t);
  return g;
}

// Energy beyond that of u_r: there is no strain energy of both, as K psi is 0 where u_r is not.
double SupportedBody::energy_of_motion() const {
  const Index m = n_drives();
  if (m == 0) return 0;
  const Vector g = displacement(now_), v = velocity(now_);
  double energy = 0.5 * g.dot(plan_.shapes.stiffness.topLeftCorner(m, m) * g);
  if (v.isZero(0)) return energy;
  Vector q, rates;
  inner_->coordinates(q, rates);
  energy += v.dot(plan_.shapes.inertia.leftCols(m).transpose() * rates.head(q.size())) +
            0.5 * v.dot(mass_.topLeftCorner(m, m) * v);
  return energy;
}

Matrix SupportedBody::rows_of(const std::vector<Index>& nodes) const {
  Matrix rows(3 * static_cast<Index>(nodes.size()), n_shapes());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    rows.middleRows(3 * static_cast<Index>(i), 3) = nodal_.middleRows(3 * nodes[i], 3);
  return rows;
}

Index SupportedBody::track(const std::vector<Index>& nodes) {
  NodeSet set{rows_of(nodes), Matrix::Zero(3, n_drives()), Matrix::Zero(3, n_drives())};
  for (Index j = 0; j < n_drives() && !nodes.empty(); ++j) {
    const Points psi =
        Eigen::Map<const Points>(set.psi.col(j).data(), static_cast<Index>(nodes.size()), 3);
    set.lower.col(j) = psi.colwise().minCoeff().transpose();
    set.upper.col(j) = psi.colwise().maxCoeff().transpose();
  }
  sets_.push_back(std::move(set));
  return inner_->track(nodes);
}

Index SupportedBody::track_mean(const std::vector<Index>& nodes) {
  Matrix mean = Matrix::Zero(3, n_drives());
  for (const Index node : nodes) mean += nodal_.block(3 * node, 0, 3, n_drives());
  means_.push_back(mean / static_cast<double>(nodes.size()));
  return inner_->track_mean(nodes);
}

void SupportedBody::move(Index set, const Vector& g, Points& x) const {
  if (g.size() == 0) return;
  const Vector s = sets_[static_cast<std::size_t>(set)].psi.leftCols(g.size()) * g;
  x += Eigen::Map<const Points>(s.data(), s.size() / 3, 3);
}

void SupportedBody::positions(Index set, Points& x) const {
  inner_->positions(set, x);
  move(set, displacement(now_), x);
}

void SupportedBody::predicted_positions(Index set, Points& x) const {
  inner_->predicted_positions(set, x);
  move(set, displacement(t_ + h_), x);
}

MotionBound SupportedBody::moved(MotionBound bound, Index set) const {
  const NodeSet& of = sets_[static_cast<std::size_t>(set)];
  const Vector g = displacement(now_);
  for (Index j = 0; j < g.size(); ++j) {
    const Vector3 a = g[j] * of.lower.col(j), b = g[j] * of.upper.col(j);
    bound.lower += a.cwiseMin(b);
    bound.upper += a.cwiseMax(b);
    bound.growth += plan_.drives[static_cast<std::size_t>(j)].largest_speed() *
                    of.lower.col(j).cwiseAbs().cwiseMax(of.upper.col(j).cwiseAbs());
  }
  return bound;
}

void SupportedBody::mean_motion(Index set, Vector3& position, Vector3& velocity_now) const {
  inner_->mean_motion(set, position, velocity_now);
  const Matrix& mean = means_[static_cast<std::size_t>(set)];
  position += mean * displacement(now_);
  velocity_now += mean * velocity(now_);
}

void SupportedBody::accept() {
  inner_->accept();
  now_ = t_ + h_;
}

Vector SupportedBody::on_shapes(Index set, const Points& impulses) const {
  return sets_[static_cast<std::size_t>(set)].psi.transpose() * numbers_of(impulses);
}

void SupportedBody::book(const Vector& on, ImpulseKind kind, double t) {
  pushed_ += on;
  if (n_drives() > 0)
    (kind == ImpulseKind::contact ? contact_ : friction_) += on.head(n_drives()).dot(velocity(t));
}

void SupportedBody::take_impulses(Index set, const Impulses& impulses) {
  inner_->take_impulses(set, impulses);
  impulses.each([&](const Points& p, ImpulseKind kind) { book(on_shapes(set, p), kind, t_); });
}

// The momentum has a share of what lasts before it is given.
void SupportedBody::expect_forces(Index set, const Impulses& forces) {
  inner_->expect_forces(set, forces);
  Vector now[2] = {Vector::Zero(n_shapes()), Vector::Zero(n_shapes())};
  forces.each([&](const Points& f, ImpulseKind kind) {
    now[kind == ImpulseKind::friction] = on_shapes(set, f);
  });
  for (const ImpulseKind kind : {ImpulseKind::contact, ImpulseKind::friction}) {
    Vector& last = lasting_[kind == ImpulseKind::friction];
    const Vector& next = now[kind == ImpulseKind::friction];
    if (last.size() == 0) last.setZero(n_shapes());
    book(lasting_share() * h_ * (next - last), kind, t_ + h_);
    last = next;
  }
}

void SupportedBody::end_velocities(Index set, Points& v) {
  inner_->end_impulses()->end_velocities(set, v);
  move(set, velocity(t_ + h_), v);
}

void SupportedBody::add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  inner_->end_impulses()->add_end_impulses(set, impulses, kind);
  book(on_shapes(set, impulses), kind, t_ + h_);
}

void SupportedBody::relax(double t, double share) {
  t_ = t;
  h_ = 0;
  for (Vector& force : forces_) force.setZero();
  inner_->statics()->relax(t, share);
}

void SupportedBody::add_static_forces(Index set, const Points& forces, ImpulseKind kind) {
  forces_[kind == ImpulseKind::friction ? 1 : 0] += on_shapes(set, forces);
  inner_->statics()->add_static_forces(set, forces, kind);
}

Settled SupportedBody::settle() {
  now_ = t_;
  Settled settled = inner_->statics()->settle();
  const Index m = n_drives();
  const Vector g = displacement(now_);
  settled.energy += g.dot(plan_.shapes.stiffness.topLeftCorner(m, m) * g);
  return settled;
}

// Forces work on the supports' way; the supports do as much against them.
void SupportedBody::end_load_step() {
  inner_->statics()->end_load_step();
  const Index m = n_drives();
  const Vector way = displacement(now_) - displacement(start_);
  contact_ += 0.5 * way.dot((forces_start_[0] + forces_[0]).head(m));
  friction_ += 0.5 * way.dot((forces_start_[1] + forces_[1]).head(m));
  for (int kind = 0; kind < 2; ++kind) forces_start_[kind] = forces_[kind];
  start_ = now_;
}

void SupportedBody::start_motion(double h, const std::vector<BodyLoad>& loads) {
  const bool begins = std::exchange(plan_.waits, false) && plan_.has_inertia;
  contact_ = friction_ = 0;
  inner_->statics()->start_motion(h, begins ? with_inertia(loads) : loads);
}

void SupportedBody::add_load(const BodyLoad& load) {
  if (plan_.sets.empty()) return;
  const ForcePattern forces = forces_of(load);
  Vector on = Vector::Zero(n_shapes());
  if (forces.forces) on += nodal_.transpose() * numbers_of(forces.forces.on_nodes());
  if (forces.modal.size() > 0)
    on += plan_.shapes.psi.topRows(forces.modal.size()).transpose() * forces.modal;
  if (load.acceleration)
    on += plan_.shapes.momentum.topRows(3).transpose() * (plan_.T.transpose() * *load.acceleration);
  const auto same = std::find_if(loads_.begin(), loads_.end(),
                                 [&](const auto& other) { return other.history == load.history; });
  if (same != loads_.end()) {
    same->on_shapes += on;
  } else {
    loads_.push_back({std::move(on), load.history});
  }
}

std::vector<SupportedBody::Reaction> SupportedBody::by_sets(const Vector& on_shapes) const {
  std::vector<Reaction> reactions;
  for (Index i = n_drives(); i < on_shapes.size(); i += 6)
    reactions.push_back({on_shapes.segment<3>(i), on_shapes.segment<3>(i + 3)});
  return reactions;
}

Vector SupportedBody::momenta() const {
  Vector q, rates;
  inner_->coordinates(q, rates);
  return plan_.shapes.inertia.transpose() * rates + mass_.leftCols(n_drives()) * velocity(now_);
}

std::vector<SupportedBody::Reaction> SupportedBody::take_reactions(double t, double interval) {
  const Vector before = std::exchange(momenta_, momenta()),
               pushed = std::exchange(pushed_, Vector(Vector::Zero(n_shapes())));
  if (!(interval > 0)) return by_sets(Vector::Zero(n_shapes()));
  Vector impulse = momenta_ - before - pushed;
  for (const WorkingLoad& load : loads_)
    impulse -= load.history.integral(t - interval, t) * load.on_shapes;
  for (Index j = 0; j < n_drives(); ++j) {
    const DrivenAxis& drive = plan_.drives[static_cast<std::size_t>(j)];
    impulse += (drive.displacement_integral(t) - drive.displacement_integral(t - interval)) *
               plan_.shapes.stiffness.col(j);
  }
  return by_sets(impulse / interval);
}

std::vector<SupportedBody::Reaction> SupportedBody::static_reactions(double t) const {
  Vector force = -forces_[0] - forces_[1];
  for (const WorkingLoad& load : loads_) force -= load.history.value(t) * load.on_shapes;
  if (n_drives() > 0) force += plan_.shapes.stiffness.leftCols(n_drives()) * displacement(t);
  return by_sets(force);
}

BodyState SupportedBody::state() const {
  BodyState state = inner_->state();
  const Index m = n_drives();
  if (m == 0) return state;
  const Matrix3& T = plan_.T;
  const Vector g = displacement(now_), v = velocity(now_);
  const Vector moved = plan_.shapes.momentum.leftCols(m) * g,
               own = plan_.shapes.momentum.leftCols(m) * v;
  const Vector3 spin = state.angular_momentum - state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += energy_of_motion();
  const double strain = 0.5 * g.dot(plan_.shapes.stiffness.topLeftCorner(m, m) * g);
  state.kinetic_energy -= strain;
  state.strain_energy += strain;
  state.momentum += T * own.head<3>();
  state.center_of_mass += T * moved.head<3>() / plan_.mass;
  // A rotation is a pseudo-vector: a mirror changes its sign.
  state.angular_momentum =
      spin + T.determinant() * (T * own.tail<3>()) + state.center_of_mass.cross(state.momentum);
  state.rotation += solve_symmetric(plan_.inertia, moved.tail<3>()).norm();
  return state;
}

BodyWork SupportedBody::work() const {
  BodyWork work = inner_->work();
  if (n_drives() == 0) return work;
  work.external += energy_of_motion() - energy_at_start_ - contact_ - friction_;
  work.contact += contact_;
  work.friction += friction_;
  return work;
}

void SupportedBody::displacements(Points& u, Points& v) const {
  inner_->displacements(u, v);
  const Index m = n_drives();
  if (m == 0) return;
  const Vector s = nodal_.leftCols(m) * displacement(now_),
               rate = nodal_.leftCols(m) * velocity(now_);
  u += Eigen::Map<const Points>(s.data(), u.rows(), 3);
  v += Eigen::Map<const Points>(rate.data(), v.rows(), 3);
}

void SupportedBody::coordinates(Vector& q, Vector& rates) const {
  inner_->coordinates(q, rates);
  const Index m = n_drives();
  if (m == 0) return;
  q += plan_.shapes.psi.leftCols(m) * displacement(now_);
  rates += plan_.shapes.psi.leftCols(m) * velocity(now_);
}

void SupportedBody::keep_state(StateArchive& archive) {
  inner_->keep_state(archive);
  archive(now_, contact_, friction_, pushed_, momenta_, start_);
  archive(forces_[0], forces_[1], forces_start_[0], forces_start_[1]);
  archive(lasting_[0], lasting_[1]);
}

}  // namespace cbr
