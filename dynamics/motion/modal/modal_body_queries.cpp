// SPDX-License-Identifier: GPL-3.0-or-later
// Queries of a modal body: response, masses, loads, momentum, energy. And equilibrium: its modes
// are uncoupled, so that nothing is solved.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {
namespace {

// Of the highest omega^2: below, it is round-off of a mode without stiffness.
constexpr double no_stiffness = 1e-12;

}  // namespace

// quick: of elastic motion the same spread for all nodes, from the largest that each mode moves
// one.
MotionBound ModalBody::own_motion_bound(Index set, bool quick) const {
  assert(is_exact());
  const NodeSet& s = sets_[set];
  const Matrix3& T = placement_.T;
  const auto Vt = s.rows->Vt();
  const Index r = form_->n_rigid, e = now_.eta.size() - r, n_nodes = s.X.rows();
  const auto omega = form_->omega.tail(e).array();
  Vector force = Vector::Zero(now_.eta.size());  // largest modal force at any time
  for (const auto& load : flow_.loads()) force += load.history.largest() * load.force.cwiseAbs();
  if (flow_.lasting().size() > 0) force += flow_.lasting().cwiseAbs();
  if (!flow_.turning().empty()) force += flow_.turning().largest_force();
  const Vector force_of_loads = flow_.turning().largest_load();
  // Amplitude sqrt(eta^2 + (v / omega)^2); a force adds at most its impulse / omega.
  const Vector amplitude =
      (now_.eta.tail(e).array().square() + (now_.v.tail(e).array() / omega).square()).sqrt();
  const Vector rate = force.tail(e).array() / omega;
  // Coupled modes, the first m elastic ones, exchange energy, and get some from the spin: beyond
  // that loads alone drive them
  const Index m = flow_.turning().n_coupled();
  double together = 0, together_rate = 0;
  if (m > 0) {
    together = std::sqrt((omega.head(m) * amplitude.head(m).array()).matrix().squaredNorm() +
                         2 * flow_.turning().energy_of_spin());
    // of eta' = p + G eta, of which the latter is the smaller
    together_rate = 2 * force_of_loads.segment(r, m).norm();
  }
  Vector3 spread = Vector3::Zero(), growth = spread, acceleration = spread;
  if (quick && e > 0) {
    const auto envelope = s.rows->envelope().bottomRows(e);
    spread = envelope.bottomRows(e - m).transpose() * amplitude.tail(e - m);
    if (flow_.may_be_driven()) growth = envelope.bottomRows(e - m).transpose() * rate.tail(e - m);
    for (int d = 0; d < 3 && m > 0; ++d) {
      const double per_root = (envelope.col(d).head(m).array() / omega.head(m)).matrix().norm();
      spread[d] += together * per_root;
      growth[d] += together_rate * per_root;
    }
  }
  // between here and x + t v
  const bool slows = is_damped() && r > 0 && damping_.c.head(r).maxCoeff() > 0;
  const bool swings = !quick && (!amplitude.isZero(0) || m > 0);
  MotionBound bound;
  bound.lower = bound.lower_speed = Vector3::Constant(HUGE_VAL);
  bound.upper = bound.upper_speed = Vector3::Constant(-HUGE_VAL);
  bound.growth = bound.acceleration = Vector3::Zero();
  for (Index i = 0; i < n_nodes; ++i) {
    Vector3 u, speed;
    for (int d = 0; d < 3; ++d) {
      const auto rigid = Vt.col(3 * i + d).head(r);
      const auto elastic = Vt.col(3 * i + d).tail(e).cwiseAbs();
      u[d] = rigid.dot(now_.eta.head(r));
      speed[d] = rigid.dot(now_.v.head(r));
      const double per_root =
          m > 0 && !quick ? (elastic.head(m).array() / omega.head(m)).matrix().norm() : 0;
      if (swings) spread[d] = elastic.tail(e - m).dot(amplitude.tail(e - m)) + together * per_root;
      if (!flow_.may_be_driven()) continue;
      acceleration[d] = rigid.cwiseAbs().dot(force.head(r));
      if (!quick) growth[d] = elastic.tail(e - m).dot(rate.tail(e - m)) + together_rate * per_root;
    }
    const Vector3 x = T * u + s.X.row(i).transpose(), v = T * speed, w = T.cwiseAbs() * spread;
    bound.lower = bound.lower.cwiseMin(x - w);
    bound.upper = bound.upper.cwiseMax(x + w);
    bound.lower_speed = bound.lower_speed.cwiseMin(v);
    bound.upper_speed = bound.upper_speed.cwiseMax(v);
    if (slows) {
      bound.lower_speed = bound.lower_speed.cwiseMin(0);
      bound.upper_speed = bound.upper_speed.cwiseMax(0);
    }
    bound.growth = bound.growth.cwiseMax(T.cwiseAbs() * growth);
    bound.acceleration = bound.acceleration.cwiseMax(T.cwiseAbs() * acceleration);
  }
  residual_.add_bound(set, bound);
  return frame_ ? frame_->in_any_position(bound) : bound;
}

// w = sin(omega h)/omega, h, or h/2 / (1 + theta omega^2), twice that where impulses act at the
// start
ResponseOf ModalBody::response_of(double h, Vector& weight) const {
  ResponseOf of{ResponseOf::Weight::central, h, 0};
  if (is_exact()) {
    of.weight = ResponseOf::Weight::exact;
    of.contact_step = flow_.contact_step();
    weight = flow_.propagator(h).s;
    flow_.amplify(weight);
  } else if (scheme() == Scheme::newmark) {
    of.weight = newmark_.kicks_at_start(h) ? ResponseOf::Weight::newmark_at_start
                                           : ResponseOf::Weight::newmark;
    of.theta = newmark_.stiffness_factor(h);
    weight = newmark_.kick_weight(h);
  } else {
    weight.setConstant(form_->omega.size(), h);
    weight.array() /= 1 + 0.5 * h * damping_.c.array();
  }
  of.damping = damping_.hash;
  return of;
}

// S = V_c diag(w) V_c^T + B F B^T / following(h)   (3m x 3m)
NodeResponse ModalBody::unturned_response(Index set, double h) const {
  Vector weight;
  const ResponseOf of = response_of(h, weight);
  return answer(set, of, weight);
}

NodeResponse ModalBody::own_response(Index set, double h) const {
  NodeResponse response = unturned_response(set, h);
  if (frame_) response.axes = frame_->R() * response.axes;
  return response;
}

NodeResponse ModalBody::own_velocity_response(Index set) const {
  return answer(set, {ResponseOf::Weight::velocity}, Vector::Ones(form_->omega.size()));
}

NodeResponse ModalBody::answer(Index set, const ResponseOf& of, const Vector& weight) const {
  const NodeRows& rows = *sets_[set].rows;
  NodeResponse response;
  response.axes = placement_.T;
  if (form_->residual) {
    response.thin = residual_.response(set, of, weight);
  } else if (rows.has_few_modes()) {
    response.thin = rows.thin_response(of, weight);
  } else {
    response.block = rows.response(of, weight);
  }
  return response;
}

Points ModalBody::nodal_masses(Index set) const {
  if (form_->residual) lacks_nodal_masses();
  const auto& nodes = sets_[set].rows->nodes();
  const Index k = superelement_->k(), c = superelement_->c();
  if (superelement_->M_cc.rows() != c) return Points::Zero(static_cast<Index>(nodes.size()), 3);
  Points masses(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < masses.rows(); ++i) {
    Vector3 of_node = Vector3::Zero();  // component axes
    for (int d = 0; d < 3; ++d) {
      const Index row = (*rows_)(nodes[i], d) - k;
      for (Index j = 0; row >= 0 && j < c; ++j)
        of_node[d] += superelement_->dof_component[j] == d ? superelement_->M_cc(j, row) : 0;
    }
    masses.row(i) = (placement_.T.cwiseAbs2() * of_node).transpose();
  }
  return masses;
}

const Matrix& ModalBody::velocity_map(const NodeRows& rows) const {
  if (rows.velocity_map.size() > 0) return rows.velocity_map;
  const Index k = superelement_->k(), c = superelement_->c();
  assert(superelement_->M_cc.rows() == c);
  // M^ of unit velocities: columns [M_kc; M_cc]   ((k + c) x 3m)
  Matrix columns = Matrix::Zero(k + c, rows.n_dofs());
  for (Index i = 0; i < columns.cols(); ++i) {
    const Index j = (*rows_)(rows.nodes()[i / 3], i % 3) - k;
    if (j < 0) continue;
    columns.col(i).head(k) = superelement_->M_kc.col(j);
    columns.col(i).tail(c) = superelement_->M_cc.col(j);
  }
  // Rows of V beyond are rotations, whose inertia is their own
  rows.velocity_map.noalias() = form_->V.topRows(k + c).transpose() * columns;
  return rows.velocity_map;
}

Vector ModalBody::load_amplitude() const {
  Vector sum = Vector::Zero(form_->omega.size());
  for (const auto& load : flow_.loads()) sum += load.force;
  return sum;
}

void ModalBody::take_shape(const Vector& eta) {
  now_.eta = eta;
  now_.v.setZero(eta.size());
}

void ModalBody::take_form(std::shared_ptr<const ModalForm> form) {
  form_ = std::move(form);
  facts_.n_dofs = form_->omega.size();
  take_shape(Vector::Zero(form_->omega.size()));
}

void ModalBody::take_plan(const BodyPlan& given) {
  const BodyPlan plan = frame_ ? frame_->take_plan(given) : given;
  for (const BodyLoad& load : plan.loads) take_load(load);
  const double h = plan.contact_step;
  if (h > 0 && is_exact() && form_->highest() * h <= 2.1)
    flow_.set_contact_step(h);  // above: forced steps
}

void ModalBody::take_load(const BodyLoad& load) {
  const auto [forces, modal] = forces_of(load);
  if (forces) {
    residual_.add_load(forces, load.history);
    if (forces_.size() > 0) forces_ += forces.on_nodes() * placement_.T;
    flow_.add_load(modal_force({forces}), load.history);
  }
  if (modal.size() > 0)
    flow_.add_load(form_->V.topRows(modal.size()).transpose() * modal, load.history);
  if (load.acceleration)
    flow_.add_load(form_->E.leftCols(3) * (placement_.T.transpose() * *load.acceleration),
                   load.history);
}

// f in component axes: T^T f of each node, of few most often
Vector ModalBody::modal_force(const ForcePattern& pattern) const {
  Vector amplitude = Vector::Zero(form_->V.cols());
  const Points forces = pattern.forces.on_nodes();
  for (Index i = 0; i < forces.rows(); ++i) {
    if (forces.row(i).isZero(0)) continue;
    const Vector3 local = placement_.T.transpose() * forces.row(i).transpose();
    for (int d = 0; d < 3; ++d)
      if (const Index row = (*rows_)(i, d); row >= 0 && local[d] != 0)
        amplitude += local[d] * form_->V.row(row).transpose();
  }
  if (pattern.modal.size() > 0)
    amplitude += form_->V.topRows(pattern.modal.size()).transpose() * pattern.modal;
  return amplitude;
}

void ModalBody::add_start_impulse(const Vector& impulse) {
  const Index k = superelement_->k();
  now_.v += form_->V.topRows(k).transpose() * impulse.head(k);
  for (Index i = 0; i < rows_->rows(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index row = (*rows_)(i, d); row >= 0)
        now_.v += impulse[k + 3 * i + d] * form_->V.row(row).transpose();
}

// Central differences: the mid-step velocity, half a step on under the internal forces and loads,
// second order at t_.
const Vector& ModalBody::present_rates() const {
  if (scheme() != Scheme::central_difference) {
    return flow_.turning().drift().size() > 0 ? rates_ = now_.v + flow_.turning().drift() : now_.v;
  }
  rates_.resize(now_.eta.size());
  flow_.loads().sum(t_, rates_);
  if (flow_.lasting().size() > 0) rates_ += 2 * lasting_share() * flow_.lasting();
  rates_ = now_.v + 0.5 * last_h_ * (rates_ - form_->omega.cwiseAbs2().cwiseProduct(now_.eta));
  rates_.array() /= 1 + 0.5 * last_h_ * damping_.c.array();
  return rates_;
}

BodyState Placement::state(const RigidBody& rigid, const Vector& moment, const Vector& rate) const {
  BodyState state;
  state.center_of_mass = T * (rigid.center + moment.head<3>() / rigid.mass) + position;
  state.momentum = T * rate.head<3>();
  // A rotation is a pseudo-vector: a mirror changes its sign.
  state.angular_momentum =
      T.determinant() * (T * rate.tail<3>()) + state.center_of_mass.cross(state.momentum);
  state.rotation = solve_symmetric(rigid.inertia, moment.tail<3>()).norm();
  if (!std::isfinite(state.rotation)) state.rotation = 0;
  return state;
}

// E^T eta: mass times displacement of the centre of mass
Vector3 ModalBody::center_at(const Vector& eta) const {
  const RigidBody& rigid = superelement_->rigid_body;
  const Vector3 moment = form_->E.leftCols(3).transpose() * eta;
  return placement_.T * (rigid.center + moment / rigid.mass) + placement_.position;
}

Vector3 ModalBody::center_velocity() const {
  return placement_.T * Vector3(form_->E.leftCols(3).transpose() * present_rates() /
                                superelement_->rigid_body.mass);
}

BodyState ModalBody::own_state() const {
  // The first three columns of E^T eta are mass times displacement of the centre of mass, the last
  // three inertia times rotation.
  Vector moment = Vector::Zero(6), rate = moment;
  if (now_.eta.size() > 0) {
    moment = form_->E.transpose() * now_.eta;
    rate = form_->E.transpose() * present_rates();
  }
  BodyState state = placement_.state(superelement_->rigid_body, moment, rate);
  const auto omega = form_->omega.array();
  if (scheme() != Scheme::central_difference) {
    // In the middle of a kick of forces
    state.kinetic_energy = 0.5 * now_.v.squaredNorm();
    if (late_)
      state.kinetic_energy -= 0.5 * late_.start.dot(now_.v) - 0.125 * late_.start.squaredNorm();
  } else {
    // 1/2 v- . v+ with v+ of the forces of strain and contact alone: leapfrog conserves this
    // together with the strain energy
    const auto before = [&](const Vector& v) {
      return late_ ? v.dot(now_.v - late_.start) : v.dot(now_.v);
    };
    state.kinetic_energy =
        0.5 * before(now_.v) - 0.5 * last_h_ * before((omega.square() * now_.eta.array()).matrix());
  }
  state.strain_energy = 0.5 * (omega * now_.eta.array()).square().sum();
  residual_.add_strain_energy(state.strain_energy);
  if (frame_) frame_->turn_state(state);
  return state;
}

void ModalBody::own_coordinates(Vector& q, Vector& rates) const {
  const Index k = superelement_->k(), n = own_nodes().rows();
  q.setZero(k + 3 * n);
  rates.setZero(k + 3 * n);
  if (now_.eta.size() > 0) {
    add_to_coordinates(*rows_, form_->V * now_.eta, q);
    add_to_coordinates(*rows_, form_->V * present_rates(), rates);
  }
  residual_.add_coordinates(now_.eta, q, rates);
}

void ModalBody::own_displacements(Points& u, Points& v) const {
  unturned_displacements(u, v);
  own_turn(own_nodes(), u, v);
}

void ModalBody::unturned_displacements(Points& u, Points& v) const {
  Vector q, rates;
  own_coordinates(q, rates);
  const Index k = superelement_->k(), n = own_nodes().rows();
  u = Eigen::Map<const Points>(q.data() + k, n, 3) * placement_.T.transpose();
  v = Eigen::Map<const Points>(rates.data() + k, n, 3) * placement_.T.transpose();
}

void ModalBody::own_keep_state(StateArchive& archive) {
  archive.expect(now_.eta.size());
  archive(now_.eta, now_.v, t_, last_h_, work_);
  archive(newmark_, late_.start);
  if (late_.end.size() != late_.start.size()) late_.end.setZero(late_.start.size());
  archive(statics_, flow_);
  residual_.keep_state(archive);
  if (frame_) frame_->keep_state(archive);
}

// The first modes, those of further parts of the body included.
Index ModalBody::n_floating() const {
  const auto omega2 = form_->omega.array().square();
  return std::max(form_->n_rigid,
                  (omega2 <= no_stiffness * (omega2.size() > 0 ? omega2.maxCoeff() : 0)).count());
}

void ModalBody::own_relax(double t, double share) {
  if (statics_.empty()) statics_.begin(now_.eta);
  flow_.loads().sum(t, f_);
  f_ *= share;
  statics_.begin_iteration(f_);
  end_.eta = now_.eta;
  const Index n = f_.size() - n_floating();
  end_.eta.tail(n) = f_.tail(n).array() / form_->omega.tail(n).array().square();
  residual_.relax(t, share);
}

ResponseOf ModalBody::static_response_of(Vector& weight) const {
  ResponseOf of;
  of.weight = ResponseOf::Weight::statics;
  of.h = 1;
  const Index n = n_floating();
  weight.setZero(form_->omega.size());
  weight.tail(weight.size() - n) = 1 / form_->omega.tail(weight.size() - n).array().square();
  return of;
}

NodeResponse ModalBody::own_static_response(Index set) const {
  Vector weight;
  const ResponseOf of = static_response_of(weight);
  if (!residual_.is_massless()) return answer(set, of, weight);
  NodeResponse response;
  response.set_block(*sets_[set].rows->response(of, weight) + residual_.compliance(set));
  response.axes = placement_.T;
  return response;
}

// Modes have a unit mass.
Matrix ModalBody::own_floating_motions(Index set) const {
  const Index n = n_floating();
  const auto Vt = sets_[set].rows->Vt();
  Matrix motions(Vt.cols(), n);
  for (Index i = 0; i < Vt.cols(); i += 3)
    motions.middleRows(i, 3) = std::sqrt(mass()) * placement_.T * Vt.block(0, i, n, 3).transpose();
  return motions;
}

FloatingForces ModalBody::floating_forces() const {
  const Vector f = std::sqrt(mass()) * (statics_.loads + statics_.contact);
  return {f.head(n_floating()), f.size() > 0 ? f.lpNorm<Eigen::Infinity>() : 0};
}

void ModalBody::float_by(const Vector& move) {
  end_.eta.head(move.size()) += std::sqrt(mass()) * move;
}

void ModalBody::own_add_static_forces(Index set, const Points& forces) {
  residual_.push(set, {forces});
  sets_[set].rows->kick(forces, placement_.T, local_, f_);
  statics_.add(f_);
  const Index n = f_.size() - n_floating();
  end_.eta.tail(n).array() += f_.tail(n).array() / form_->omega.tail(n).array().square();
}

Settled ModalBody::own_settle() {
  const auto omega2 = form_->omega.array().square();
  const Vector move = end_.eta - now_.eta;
  now_.eta = end_.eta;
  Settled settled{(omega2 * move.array().square()).sum(),
                  (omega2 * now_.eta.array().square()).sum()};
  residual_.settle(settled);
  return settled;
}

void ModalBody::own_end_load_step() {
  statics_.book(now_.eta, work_);
  residual_.end_load_step();
}

// Change of the rates by lasting forces of contact (empty: none), as impulses of steps h.
Vector ModalBody::contact_kick(double h, const Vector& force) const {
  if (force.size() == 0) return Vector::Zero(now_.eta.size());
  Vector kick = h * force;
  flow_.amplify(kick);
  return kick;
}

// With `exact` the forces of contact go on, at the ends of steps beside a massless interface.
// Newmark's impulses at the start of steps hold the body where it is at their ends, where it has
// half of a kick less than in the mean. With central differences its rates are those half a step
// before, of a body at rest under all forces.
void ModalBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) take_load(load);
  residual_.start_motion(h, now_.eta);
  if (statics_.empty()) return;
  work_ = BodyWork();
  if (scheme() != Scheme::newmark) flow_.let_last(statics_.contact);
  if (scheme() == Scheme::newmark && newmark_.kicks_at_start(h))
    now_.v -= 0.5 * contact_kick(h, statics_.contact);
  if (scheme() == Scheme::central_difference) last_h_ = h;
  if (!facts_.kicks_at_end) return;
  late_.begin(now_.eta.size());
  if (is_exact()) return;
  late_.start = contact_kick(h, statics_.contact);
  now_.v += late_.start;
}

}  // namespace cbr
