// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/prescribed_motion.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

Eigen::Map<const Vector> numbers_of(const Points& x) { return {x.data(), x.size()}; }

Eigen::Map<const Points> nodes_of(const Vector& x) { return {x.data(), x.size() / 3, 3}; }

}  // namespace

PrescribedMotion::PrescribedMotion(SupportPlan plan, Index n_nodes) : plan_(std::move(plan)) {
  if (is_translation()) {
    nodal_ = plan_.directions.replicate(n_nodes, 1);
    for (const Index node : plan_.rotations) nodal_.middleRows(3 * node, 3).setZero();
    mass_ = plan_.mass * plan_.directions.transpose() * plan_.directions;
    plan_.shapes.stiffness.setZero(n_drives(), n_drives());
    plan_.shapes.momentum.setZero(6, n_drives());
    plan_.shapes.momentum.topRows(3) = plan_.mass * plan_.directions;
  } else {
    const Matrix& psi = plan_.shapes.psi;
    nodal_.resize(3 * n_nodes, psi.cols());
    for (Index i = 0; i < 3 * n_nodes; i += 3)
      nodal_.middleRows(i, 3) = plan_.T * psi.middleRows(plan_.n_modal + i, 3);
    mass_ = plan_.shapes.mass();
  }
  for (Vector* sum : {&pushed_, &momenta_, &forces_, &forces_start_, &lasting_})
    sum->setZero(n_shapes());
}

Vector PrescribedMotion::start_impulse() const {
  if (is_translation() || !moves() || velocity(0).isZero(0)) return {};
  return -plan_.shapes.inertia.leftCols(n_drives()) * velocity(0);
}

// Before those that are given.
std::vector<BodyLoad> PrescribedMotion::with_inertia(const std::vector<BodyLoad>& loads) const {
  const Index k = plan_.n_modal;
  std::vector<BodyLoad> all;
  for (Index j = 0; j < n_drives(); ++j) {
    const LoadHistory& history = plan_.drives[j].acceleration();
    if (is_translation()) {
      all.push_back(gravity_load(-plan_.directions.col(j), history));
      continue;
    }
    const Vector force = -plan_.shapes.inertia.col(j);
    const Points on_nodes = nodes_of(force.tail(nodal_.rows())) * plan_.T.transpose();
    BodyLoad load{.history = history};
    if (!on_nodes.isZero(0)) load.fixed.forces = on_nodes;
    if (k > 0) load.fixed.modal = force.head(k);
    all.push_back(std::move(load));
  }
  all.insert(all.end(), loads.begin(), loads.end());
  return all;
}

std::vector<BodyLoad> PrescribedMotion::loads_at_start(const std::vector<BodyLoad>& loads) const {
  return plan_.has_inertia && !plan_.waits ? with_inertia(loads) : loads;
}

void PrescribedMotion::begin(const std::vector<BodyLoad>& loads, const BodyState& own,
                             const Vector& own_rates) {
  for (const BodyLoad& load : loads) add_load(load);
  energy_at_start_ = energy(own.momentum, own_rates);
}

void PrescribedMotion::add_load(const BodyLoad& load) {
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

Vector PrescribedMotion::displacement(double t) const {
  Vector g(n_drives());
  for (Index j = 0; j < g.size(); ++j) g[j] = plan_.drives[j].displacement(t);
  return g;
}

Vector PrescribedMotion::velocity(double t) const {
  Vector g = Vector::Zero(n_drives());
  if (!plan_.has_inertia) return g;
  for (Index j = 0; j < g.size(); ++j) g[j] = plan_.drives[j].velocity(t);
  return g;
}

void PrescribedMotion::track(const std::vector<Index>& nodes) {
  NodeSet set{Matrix(3 * static_cast<Index>(nodes.size()), n_shapes()), Matrix::Zero(3, n_drives()),
              Matrix::Zero(3, n_drives())};
  for (std::size_t i = 0; i < nodes.size(); ++i)
    set.psi.middleRows(3 * static_cast<Index>(i), 3) = nodal_.middleRows(3 * nodes[i], 3);
  for (Index j = 0; j < n_drives() && !nodes.empty(); ++j) {
    const Vector column = set.psi.col(j);
    set.lower.col(j) = nodes_of(column).colwise().minCoeff().transpose();
    set.upper.col(j) = nodes_of(column).colwise().maxCoeff().transpose();
  }
  sets_.push_back(std::move(set));
}

void PrescribedMotion::track_mean(const std::vector<Index>& nodes) {
  Matrix mean = Matrix::Zero(3, n_drives());
  for (const Index node : nodes) mean += nodal_.block(3 * node, 0, 3, n_drives());
  means_.push_back(mean / static_cast<double>(nodes.size()));
}

void PrescribedMotion::predict(double t, double h) {
  t_ = t;
  h_ = h;
}

void PrescribedMotion::move(Index set, const Vector& g, Points& x) const {
  if (g.size() == 0) return;
  const Vector s = sets_[set].psi.leftCols(g.size()) * g;
  x += nodes_of(s);
}

MotionBound PrescribedMotion::moved(Index set, MotionBound bound) const {
  const NodeSet& of = sets_[set];
  const Vector g = displacement(now_);
  for (Index j = 0; j < g.size(); ++j) {
    const Vector3 a = g[j] * of.lower.col(j), b = g[j] * of.upper.col(j);
    bound.lower += a.cwiseMin(b);
    bound.upper += a.cwiseMax(b);
    bound.growth += plan_.drives[j].largest_speed() *
                    of.lower.col(j).cwiseAbs().cwiseMax(of.upper.col(j).cwiseAbs());
  }
  return bound;
}

void PrescribedMotion::add_mean_motion(Index set, Vector3& position, Vector3& velocity_now) const {
  const Matrix& mean = means_[set];
  position += mean * displacement(now_);
  velocity_now += mean * velocity(now_);
}

Vector PrescribedMotion::on_shapes(Index set, const Points& impulses) const {
  return sets_[set].psi.transpose() * numbers_of(impulses);
}

void PrescribedMotion::book(const Vector& on, const Vector& velocity) {
  pushed_ += on;
  contact_ += on.head(n_drives()).dot(velocity);
}

void PrescribedMotion::take_impulses(Index set, const Impulses& impulses, bool lasts) {
  book(on_shapes(set, impulses.all),
       lasts ? Vector((displacement(t_ + h_) - displacement(t_)) / h_) : velocity(t_));
}

void PrescribedMotion::take_momentum(const Vector3& momentum) {
  book(plan_.directions.transpose() * momentum, velocity(t_));
}

void PrescribedMotion::add_end_impulses(Index set, const Points& impulses) {
  book(on_shapes(set, impulses), velocity(t_ + h_));
}

// The momentum has a share of what lasts before it is given, and so has the work.
void PrescribedMotion::expect_forces(Index set, const Points& forces, double lasting_share) {
  const Vector next = forces.rows() > 0 ? on_shapes(set, forces) : Vector(Vector::Zero(n_shapes()));
  book(lasting_share * h_ * (next - lasting_), velocity(t_ + h_));
  lasting_ = next;
}

void PrescribedMotion::relax(double t) {
  predict(t, 0);
  forces_.setZero();
}

void PrescribedMotion::add_static_forces(Index set, const Points& forces) {
  forces_ += on_shapes(set, forces);
}

double PrescribedMotion::settle() {
  now_ = t_;
  return 2 * strain_energy(displacement(now_));
}

// Forces work on the supports' path; the supports do as much against them.
void PrescribedMotion::end_load_step() {
  const Index m = n_drives();
  const Vector path = displacement(now_) - displacement(start_);
  contact_ += 0.5 * path.dot((forces_start_ + forces_).head(m));
  forces_start_ = forces_;
  start_ = now_;
}

std::vector<BodyLoad> PrescribedMotion::start_motion(const std::vector<BodyLoad>& loads) {
  contact_ = 0;
  const bool begins = std::exchange(plan_.waits, false) && plan_.has_inertia;
  return begins ? with_inertia(loads) : loads;
}

double PrescribedMotion::strain_energy(const Vector& g) const {
  return 0.5 * g.dot(plan_.shapes.stiffness.topLeftCorner(g.size(), g.size()) * g);
}

double PrescribedMotion::kinetic_energy(const Vector& v, const Vector3& own_momentum,
                                        const Vector& own_rates) const {
  if (v.isZero(0)) return 0;
  const Index m = n_drives();
  const Vector momenta = is_translation()
                             ? Vector(plan_.directions.transpose() * own_momentum)
                             : Vector(plan_.shapes.inertia.leftCols(m).transpose() * own_rates);
  return v.dot(momenta) + 0.5 * v.dot(mass_.topLeftCorner(m, m) * v);
}

// Beyond the body's own: there is no strain energy of both, as K psi is 0 where u_r is not.
double PrescribedMotion::energy(const Vector3& own_momentum, const Vector& own_rates) const {
  return strain_energy(displacement(now_)) +
         kinetic_energy(velocity(now_), own_momentum, own_rates);
}

BodyState PrescribedMotion::moved(BodyState state, const Vector& own_rates) const {
  const Index m = n_drives();
  const Matrix3& T = plan_.T;
  const Vector g = displacement(now_), v = velocity(now_);
  const Vector moved = plan_.shapes.momentum.leftCols(m) * g,
               own = plan_.shapes.momentum.leftCols(m) * v;
  const Vector3 spin = state.angular_momentum - state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += kinetic_energy(v, state.momentum, own_rates);
  state.strain_energy += strain_energy(g);
  state.momentum += T * own.head<3>();
  state.center_of_mass += T * moved.head<3>() / plan_.mass;
  // A rotation is a pseudo-vector: a mirror changes its sign.
  state.angular_momentum =
      spin + T.determinant() * (T * own.tail<3>()) + state.center_of_mass.cross(state.momentum);
  if (!is_translation()) state.rotation += solve_symmetric(plan_.inertia, moved.tail<3>()).norm();
  return state;
}

BodyWork PrescribedMotion::worked(BodyWork work, const BodyState& own,
                                  const Vector& own_rates) const {
  work.external += energy(own.momentum, own_rates) - energy_at_start_ - contact_;
  work.contact += contact_;
  return work;
}

void PrescribedMotion::add_displacements(Points& u, Points& v) const {
  if (!moves()) return;
  const auto psi = nodal_.leftCols(n_drives());
  const Vector s = psi * displacement(now_), rate = psi * velocity(now_);
  u += nodes_of(s);
  v += nodes_of(rate);
}

void PrescribedMotion::add_coordinates(Vector& q, Vector& rates) const {
  if (!moves() || is_translation()) return;
  const auto psi = plan_.shapes.psi.leftCols(n_drives());
  q += psi * displacement(now_);
  rates += psi * velocity(now_);
}

void PrescribedMotion::translate(Points& u, Points& v) const {
  if (!is_translation()) return;
  u.rowwise() += (plan_.directions * displacement(now_)).transpose();
  v.rowwise() += (plan_.directions * velocity(now_)).transpose();
}

std::vector<Reaction> PrescribedMotion::by_sets(const Vector& on_shapes) const {
  std::vector<Reaction> reactions;
  for (Index i = n_drives(); i < on_shapes.size(); i += 6)
    reactions.push_back({on_shapes.segment<3>(i), on_shapes.segment<3>(i + 3)});
  return reactions;
}

std::vector<Reaction> PrescribedMotion::take_reactions(double t, double interval,
                                                       const Vector& own_rates) {
  const Vector momenta =
      plan_.shapes.inertia.transpose() * own_rates + mass_.leftCols(n_drives()) * velocity(now_);
  const Vector before = std::exchange(momenta_, momenta),
               pushed = std::exchange(pushed_, Vector(Vector::Zero(n_shapes())));
  if (!(interval > 0)) return by_sets(Vector::Zero(n_shapes()));
  Vector impulse = momenta_ - before - pushed;
  for (const WorkingLoad& load : loads_)
    impulse -= load.history.integral(t - interval, t) * load.on_shapes;
  for (Index j = 0; j < n_drives(); ++j) {
    const DrivenAxis& drive = plan_.drives[j];
    impulse += (drive.displacement_integral(t) - drive.displacement_integral(t - interval)) *
               plan_.shapes.stiffness.col(j);
  }
  return by_sets(impulse / interval);
}

std::vector<Reaction> PrescribedMotion::static_reactions(double t) const {
  Vector force = -forces_;
  for (const WorkingLoad& load : loads_) force -= load.history.value(t) * load.on_shapes;
  if (moves()) force += plan_.shapes.stiffness.leftCols(n_drives()) * displacement(t);
  return by_sets(force);
}

void PrescribedMotion::keep_state(StateArchive& archive) {
  archive(now_, contact_, pushed_, momenta_, start_, forces_, forces_start_, lasting_);
}

}  // namespace cbr
