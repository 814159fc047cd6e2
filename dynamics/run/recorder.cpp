// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/recorder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/stress_values.hpp"

namespace cbr {
namespace {

bool ends_finite(const std::vector<double>& series) {
  return series.empty() || std::isfinite(series.back());
}
bool ends_finite(const Series3& series) {
  const std::vector<double>& values = series.values;
  return std::all_of(values.end() - std::min<std::ptrdiff_t>(3, std::ssize(values)), values.end(),
                     [](double v) { return std::isfinite(v); });
}

// Checks all outputs, not only energies: an angular momentum overflows earlier.
bool ends_finite(const RunResult::OfBody& of) {
  return ends_finite(of.center_of_mass) && ends_finite(of.reaction) && ends_finite(of.momentum) &&
         ends_finite(of.angular_momentum) && ends_finite(of.kinetic_energy) &&
         ends_finite(of.strain_energy);
}
bool ends_finite(const RunResult::OfMonitor& of) {
  return ends_finite(of.mean_position) && ends_finite(of.mean_velocity) &&
         ends_finite(of.mean_acceleration) && ends_finite(of.force);
}
bool ends_finite(const RunResult::OfPair& of) {
  return std::all_of(of.series.begin(), of.series.end(),
                     [](const Series3& series) { return ends_finite(series); });
}

// Momentum from contact since the last output; without rows of moments.
Vector3 force_on(const Simulation& sim, std::size_t c, const ContactState& state) {
  const ContactNodes& nodes = sim.contact_nodes[c];
  const Points& ahead = state.ahead_since_output[c];
  const Points impulses = ahead.rows() > 0 ? Points(state.impulses_since_output[c] + ahead)
                                           : state.impulses_since_output[c];
  const BodyPoints* points = sim.bodies[nodes.body]->points();
  if (points == nullptr) return impulses.colwise().sum().transpose();
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < nodes.nodes.size(); ++i)
    if (points->takes_force(nodes.nodes[i])) sum += impulses.row(static_cast<Index>(i)).transpose();
  return sum;
}

// The `n` elements with the largest von Mises stress; of equal ones the first.
void add_worst(const Matrix& elements, Index n, RunResult::OfScan& of) {
  std::vector<Index> order = first_numbers(elements.rows());
  const auto is_worse = [&](Index a, Index b) {
    const double s = elements(a, von_mises_column), t = elements(b, von_mises_column);
    return s != t ? s > t : a < b;
  };
  std::partial_sort(order.begin(), order.begin() + n, order.end(), is_worse);
  for (const Index e : std::vector<Index>(order.begin(), order.begin() + n)) {
    of.worst.push_back(e);
    of.worst_stress.push_back(elements(e, von_mises_column));
  }
}

// m x 4: von Mises, its time, largest and smallest principal stress
void add_extremes(const Matrix& values, double t, Matrix& extremes) {
  const Index first = von_mises_column + 1, last = n_stress_values - 1;
  if (extremes.size() == 0) {
    extremes.resize(values.rows(), 4);
    extremes << values.col(von_mises_column), Vector::Constant(values.rows(), t), values.col(first),
        values.col(last);
    return;
  }
  for (Index i = 0; i < values.rows(); ++i) {
    auto of = extremes.row(i);
    if (values(i, von_mises_column) > of[0]) {
      of[0] = values(i, von_mises_column);
      of[1] = t;
    }
    of[2] = std::max(of[2], values(i, first));
    of[3] = std::min(of[3], values(i, last));
  }
}

// For a body with large rotation, whose stress is in rotating axes   (6 m, xx yy zz xy yz xz of
// each)
Vector in_scene(Vector stress, const std::optional<Eigen::Vector4d>& orientation) {
  if (!orientation) return stress;
  const Eigen::Vector4d& q = *orientation;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> rows(stress.data(),
                                                                             stress.size() / 6, 6);
  rows = turned_stress(rows, Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix());
  return stress;
}

}  // namespace

Recorder::Recorder(Simulation& simulation) : sim_(simulation) {
  result_.monitors.resize(sim_.monitors.size());
  result_.bodies.resize(sim_.bodies.size());
  result_.pairs.resize(sim_.pairs.size());
  result_.reactions.resize(sim_.reactions.size());
  result_.watches.resize(sim_.watches.size());
  result_.scans.resize(sim_.scans.size());
  last_.resize(sim_.bodies.size());
  work_.resize(sim_.bodies.size());
}

void Recorder::record(double t, std::optional<double> interval, const std::vector<char>& resting,
                      ContactState& state, const ContactOutcome& outcome) {
  const double span = interval.value_or(1);
  result_.time.push_back(t);
  coordinates_.clear();
  record_energy(resting, state.friction_work);
  record_reactions(t, interval, state);
  record_monitors(span, state);
  record_stress(t);
  if (interval ? looks_now() : result_.time.size() > 1) look_at_depths(sim_, outcome);
  record_pairs(span, outcome);
  record_pressure(span, state);
  check_finite(t, outcome);
}

// A look costs as much as two or three explicit steps in contact, less than one of Newmark. The
// first step finds initial overlaps.
bool Recorder::looks_now() const {
  constexpr Index steps_a_look = 10;
  const TimePlan& plan = sim_.plan;
  const auto output = static_cast<Index>(result_.time.size()) - 1;
  const Index outputs_a_look = (steps_a_look - 1) / plan.steps_per_output + 1;
  return output > 0 && (plan.newmark_alpha || output % outputs_a_look == 0 ||
                        result_.time.back() == plan.time(plan.n_steps()));
}

void Recorder::record_pairs(double interval, const ContactOutcome& outcome) {
  double active = 0;
  const std::size_t before = result_.time.size() - 1;
  for (const Index p : outcome.met) {
    ContactPair& pair = sim_.pairs[p];
    std::vector<double> none;
    add_values({pair, outcome.active[p], interval}, before,
               pair.has_state() ? pair.state().kept : none, result_.pairs[p]);
    active += static_cast<double>(outcome.active[p]);
    if (!pair.has_state()) continue;
    PairState& next = pair.state();
    next.penetration = std::max(next.penetration, next.recent_penetration);
    next.residual = std::max(next.residual, next.recent_residual);
    next.recent_penetration = next.recent_residual = 0;
  }
  result_.active.push_back(active);
}

// Pressures from nodal impulses on second-order faces: corner values, linear between the corners,
// with equal work on linear motions. A uniform pressure is exact, also on curved faces.
static void add_corner_pressures(const Points& impulses, double interval, const Body& body,
                                 ContactNodes& nodes) {
  if (nodes.corner_values.size() == 0 || impulses.isZero(0)) return;
  Matrix at_corners = nodes.corner_values.transpose() * impulses;
  if (body.turns()) at_corners = (at_corners * body.turn_of_step()).eval();
  Vector pressure = Vector::Zero(at_corners.rows());
  for (Index a = 0; a < pressure.size(); ++a) {
    const Vector3 impulse = at_corners.row(a).transpose(),
                  normal = nodes.corner_normals.row(a).transpose();
    // Excludes impulses on the other side of an edge
    if (-impulse.dot(normal) > same_side * impulse.norm() * normal.norm())
      pressure[a] = -impulse.dot(normal) / (normal.squaredNorm() * interval);
  }
  nodes.pressure += nodes.corner_values * pressure;
}

void Recorder::record_pressure(double interval, ContactState& state) {
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    ContactNodes& nodes = sim_.contact_nodes[c];
    Points& impulses = state.normal_since_output[c];
    if (impulses.rows() == 0) continue;
    const Body& body = *sim_.bodies[nodes.body];
    nodes.pressure.setZero(impulses.rows());
    for (Index i = 0; i < impulses.rows() && interval > 0; ++i) {
      const double J = impulses.row(i).norm();
      if (J == 0) continue;
      const Vector3 normal = impulses.row(i).transpose() / J;
      const double area =
          facing_area(nodes.areas[i], nodes.area_vectors.row(i),
                      body.turns() ? body.turn_of_step().transpose() * normal : normal);
      if (area > 0) nodes.pressure[i] = J / (area * interval);
    }
    if (interval > 0) add_corner_pressures(impulses, interval, body, nodes);
    Points& pressures = state.pressure_since_output[c];
    if (interval > 0) nodes.pressure += pressures.rowwise().norm() / interval;
    impulses.setZero();
    pressures.setZero();
  }
}

void Recorder::record_monitors(double interval, ContactState& state) {
  for (std::size_t i = 0; i < sim_.monitors.size(); ++i) {
    const Monitor& monitor = sim_.monitors[i];
    Vector3 position, velocity, impulse = Vector3::Zero();
    if (monitor.has_point) {
      Vector3 theta, spin;
      const Body& body = *sim_.bodies[monitor.body];
      const BodyPoints& points = *body.points();
      points.point_motion(body, monitor.point, position, theta, velocity, spin);
      position += points.positions().row(points.translation_node(monitor.point)).transpose();
      result_.monitors[i].rotation.add(theta);
    } else if (monitor.is_inside()) {
      const auto& [q, rates] = coordinates(monitor.body);
      // Large rotation and prescribed motion are the same affine map for all points, and so for
      // their mean
      const Points X = monitor.reference.transpose();
      Points u = (monitor.rows * q).transpose(), v = (monitor.rows * rates).transpose();
      sim_.bodies[monitor.body]->turn(X, u, v);
      position = monitor.reference + u.row(0).transpose();
      velocity = v.row(0).transpose();
    } else {
      sim_.bodies[monitor.body]->mean_motion(monitor.mean_set, position, velocity);
    }
    for (const Index slot : monitor.contact_slots)
      impulse += state.impulses_since_output[monitor.contact].row(slot).transpose();
    const std::vector<double>& velocities = result_.monitors[i].mean_velocity.values;
    Vector3 acceleration = Vector3::Zero();
    if (interval > 0 && velocities.size() >= 3)
      acceleration =
          (velocity - Eigen::Map<const Vector3>(velocities.data() + velocities.size() - 3)) /
          interval;
    result_.monitors[i].mean_acceleration.add(acceleration);
    result_.monitors[i].mean_position.add(position);
    result_.monitors[i].mean_velocity.add(velocity);
    result_.monitors[i].force.add(interval > 0 ? Vector3(impulse / interval) : Vector3::Zero());
  }
  for (auto& impulses : state.impulses_since_output) impulses.setZero();
  for (auto& ahead : state.ahead_since_output) ahead.setZero();
}

void Recorder::record_energy(const std::vector<char>& resting, double friction) {
  double total = 0, external = 0, contact = -friction, damping = 0, numerical = 0;
  for (std::size_t b = 0; b < sim_.bodies.size(); ++b) {
    if (!resting[b] || result_.time.size() == 1) {
      last_[b] = sim_.bodies[b]->state();
      work_[b] = sim_.bodies[b]->work();
    }
    const BodyState& now = last_[b];
    const BodyWork& work = work_[b];
    auto& series = result_.bodies[b];
    series.center_of_mass.add(now.center_of_mass);
    series.momentum.add(now.momentum);
    series.angular_momentum.add(now.angular_momentum);
    series.kinetic_energy.push_back(now.kinetic_energy);
    series.strain_energy.push_back(now.strain_energy);
    if (now.orientation)
      series.orientation.insert(series.orientation.end(), now.orientation->begin(),
                                now.orientation->end());
    total += now.kinetic_energy + now.strain_energy;
    external += work.external;
    contact += work.contact;
    damping += work.damping;
    numerical += work.numerical;
    result_.largest_rotation = std::max(result_.largest_rotation, now.rotation);
    series.rotation = std::max(series.rotation, now.rotation);
    if (now.rotation > small_rotation && !series.turned_at) series.turned_at = result_.time.back();
  }
  for (const ContactPair& pair : sim_.pairs) {
    if (!pair.wall && !pair.driven) continue;
    const PairState& seen = pair.seen();
    external += seen.wall_work + seen.wall_friction_work;
    contact -= seen.wall_work;
    friction -= seen.wall_friction_work;
  }
  if (result_.time.size() == 1) {
    before_ = {external, contact, damping, numerical};
    friction_before_ = friction;
  }
  external -= before_.external;
  contact -= before_.contact;
  friction -= friction_before_;
  damping -= before_.damping;
  numerical -= before_.numerical;
  result_.total.push_back(total);
  result_.work_external.push_back(external);
  result_.work_contact.push_back(contact);
  result_.work_friction.push_back(friction);
  result_.work_damping.push_back(damping);
  result_.work_numerical.push_back(numerical);
}

// Reactions: change of momentum, of which equilibrium has none, without loads and contact. Call
// before the sums of contact are reset.
void Recorder::record_reactions(double t, std::optional<double> interval,
                                const ContactState& state) {
  std::vector<Vector3> of_contact(sim_.supports.empty() ? 0 : sim_.bodies.size(), Vector3::Zero());
  for (std::size_t c = 0; c < sim_.contact_nodes.size() && !of_contact.empty(); ++c)
    of_contact[sim_.contact_nodes[c].body] += force_on(sim_, c, state);
  for (std::size_t b = 0; b < sim_.supports.size(); ++b) {
    if (!sim_.supports[b]) continue;
    RunResult::OfBody& of = result_.bodies[b];
    Vector3 rest = Vector3::Zero();
    if (interval) {
      const std::vector<double>& momentum = of.momentum.values;
      if (!(*interval > 0) || momentum.size() < 6) {
        of.reaction.add(rest);
        continue;
      }
      const Eigen::Map<const Vector3> now(momentum.data() + momentum.size() - 3),
          before(momentum.data() + momentum.size() - 6);
      rest = now - before;
    }
    rest -= of_contact[b];
    for (const Supports::Resultant& load : sim_.supports[b]->loads)
      rest -=
          (interval ? load.history.integral(t - *interval, t) : load.history.value(t)) * load.force;
    of.reaction.add(rest / interval.value_or(1));
  }
  std::vector<Reaction> of_body;
  for (std::size_t i = 0; i < sim_.reactions.size(); ++i) {
    const ReactionWatch& watch = sim_.reactions[i];
    if (watch.set == 0)
      of_body =
          interval ? watch.body->take_reactions(t, *interval) : watch.body->static_reactions(t);
    result_.reactions[i].force.add(of_body[watch.set].force);
    result_.reactions[i].moment.add(of_body[watch.set].moment);
  }
}

void Recorder::check_finite(double t, const ContactOutcome& outcome) const {
  const RunResult& r = result_;
  std::vector<std::string> where;
  if (!not_finite_.empty()) where.push_back(not_finite_);
  for (std::size_t b = 0; b < r.bodies.size(); ++b)
    if (!ends_finite(r.bodies[b])) where.push_back("instance '" + sim_.bodies[b]->name() + "'");
  for (const Index p : outcome.met)
    if (!ends_finite(r.pairs[p])) where.push_back("contact " + sim_.pairs[p].name);
  for (std::size_t w = 0; w < r.watches.size(); ++w) {
    const auto n = static_cast<std::ptrdiff_t>(6 * sim_.watches[w].ids.size());
    if (!std::all_of(r.watches[w].end() - n, r.watches[w].end(),
                     [](double v) { return std::isfinite(v); }))
      where.push_back("stress of " + sim_.watches[w].name);
  }
  for (std::size_t i = 0; i < r.reactions.size(); ++i)
    if (!ends_finite(r.reactions[i].force) || !ends_finite(r.reactions[i].moment))
      where.push_back("reaction of instance '" + sim_.reactions[i].instance + "'");
  for (std::size_t m = 0; m < r.monitors.size(); ++m)
    if (!ends_finite(r.monitors[m])) where.push_back("surface " + sim_.monitors[m].name);
  if (where.empty() && ends_finite(r.total) && ends_finite(r.work_external) &&
      ends_finite(r.work_contact) && ends_finite(r.work_friction) && ends_finite(r.work_damping) &&
      ends_finite(r.work_numerical) && std::isfinite(r.largest_rotation))
    return;
  constexpr std::size_t most = 4;  // names
  if (where.size() > most) {
    where.resize(most);
    where.emplace_back("...");
  }
  std::ostringstream message;
  message << "the motion is no longer finite at t = " << t << " s" << (where.empty() ? "" : ", ")
          << join(where)
          << ": is the step above the critical one (time.force)? Or are loads, velocities or units "
             "beyond a double's reach?";
  throw RunError(message.str());
}

const std::pair<Vector, Vector>& Recorder::coordinates(Index body) {
  const auto [found, is_new] = coordinates_.try_emplace(body);
  if (is_new) sim_.bodies[body]->coordinates(found->second.first, found->second.second);
  return found->second;
}

void Recorder::record_stress(double t) {
  for (std::size_t w = 0; w < sim_.watches.size(); ++w) {
    const Index body = sim_.watches[w].body;
    const Vector stress =
        in_scene(sim_.watches[w].stress(coordinates(body).first), last_[body].orientation);
    result_.watches[w].insert(result_.watches[w].end(), stress.begin(), stress.end());
  }
  Matrix elements, nodes;
  for (std::size_t i = 0; i < sim_.scans.size(); ++i) {
    const StressScan& scan = sim_.scans[i];
    scan.stresses(coordinates(scan.body).first, elements, nodes);
    if (!elements.allFinite() || !nodes.allFinite()) {
      not_finite_ = "stress of " + scan.name;
      return;
    }
    if (scan.n_worst > 0) add_worst(elements, scan.n_worst, result_.scans[i]);
    if (!scan.envelope) continue;
    add_extremes(elements, t, result_.scans[i].of_elements);
    add_extremes(nodes, t, result_.scans[i].of_nodes);
  }
}

}  // namespace cbr
