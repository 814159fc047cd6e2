// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/contact_group.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace cbr {
namespace {

// Points of the group with constraints. Springs are excluded, as their velocities are independent.
struct Holding {
  std::vector<Index> places;
  ContactList list;
  std::vector<PointLaw> laws;
  Points p;
  Points walls;  // velocities of walls at the points
};

// Velocity at the end of the partner whose motion is given, scene axes.
Vector3 given_velocity(const ContactPair& pair, const ContactPoint& point) {
  const RigidWall::Shift* shift = pair.shift();
  if (shift == nullptr) return Vector3::Zero();
  return pair.driven ? Vector3(point.frame.transpose() * shift->velocity) : shift->velocity;
}

Holding holding_points(const Simulation& sim, const ContactGroup& group, const Points& p) {
  Holding of;
  for (const ContactSearch& search : group.searches)
    for (auto i = search.first; !sim.pairs[search.pair].yields && i < search.last; ++i)
      of.places.push_back(static_cast<Index>(i));
  of.walls.setZero(static_cast<Index>(of.places.size()), 3);
  for (Index row = 0; const ContactSearch& search : group.searches) {
    if (sim.pairs[search.pair].yields) continue;
    const auto n = static_cast<Index>(search.last - search.first);
    for (Index i = 0; i < n; ++i)
      of.walls.row(row + i) = given_velocity(
          sim.pairs[search.pair], group.list.points[search.first + static_cast<std::size_t>(i)]);
    row += n;
  }
  if (of.places.size() == group.list.points.size()) {
    of.list = group.list;
    of.laws = group.laws;
    of.p = p;
    return of;
  }
  of.list.terms = group.list.terms;
  for (const Index i : of.places) {
    of.list.points.push_back(group.list.points[i]);
    of.laws.push_back(group.laws[i]);
  }
  of.p = p(of.places, Eigen::all);
  return of;
}

// Relative velocities of the points, in their frames.
Points relative_velocities(const ContactList& list, const std::map<Index, Points>& v,
                           const Points& walls) {
  Points relative(static_cast<Index>(list.points.size()), 3);
  for (Index i = 0; i < relative.rows(); ++i) {
    const ContactPoint& point = list.points[i];
    Vector3 sum = -walls.row(i).transpose();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      sum += term.coefficient * v.at(term.body).row(term.node).transpose();
    }
    relative.row(i) = (point.frame * sum).transpose();
  }
  return relative;
}

// Unknowns restricted to the rows of the points `places`.
ContactUnknowns some_of(ContactUnknowns unknowns, const std::vector<PointLaw>& laws,
                        const std::vector<Index>& places) {
  if (places.size() == laws.size()) return unknowns;
  const std::vector<Index> first = first_rows(laws);
  std::vector<Index> to(static_cast<std::size_t>(first.back()), -1);
  Index n = 0;
  for (const Index place : places)
    for (Index row = first[place]; row < first[place + 1]; ++row) to[row] = n++;
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index u = 0; u < unknowns.A.cols(); ++u)
    for (SparseMatrix::InnerIterator it(unknowns.A, u); it; ++it)
      if (to[it.row()] >= 0) entries.emplace_back(to[it.row()], u, it.value());
  unknowns.A.resize(n, unknowns.A.cols());
  unknowns.A.setFromTriplets(entries.begin(), entries.end());
  return unknowns;
}

// Relative velocities of the points at the start of the step, in their frames.
Points start_velocities(const Simulation& sim, const ContactGroup& group, double h,
                        const ContactState& state) {
  std::map<Index, Points> v;
  for (const Index b : group.bodies) {
    const ContactNodes& nodes = sim.contact_nodes[b];
    const Body& body = *sim.bodies[nodes.body];
    v[b] = (state.bodies[b].end - state.bodies[b].start) / h;  // of points
    Points displacements, velocities;
    body.displacements(displacements, velocities);
    for (std::size_t i = 0; i < nodes.nodes.size(); ++i)
      if (nodes.nodes[i] < velocities.rows())
        v[b].row(static_cast<Index>(i)) = velocities.row(nodes.nodes[i]);
  }
  Points walls = Points::Zero(static_cast<Index>(group.list.points.size()), 3);
  for (const ContactSearch& of : group.searches)
    for (auto i = of.first; sim.pairs[of.pair].wall && i < of.last; ++i)
      walls.row(static_cast<Index>(i)) = sim.pairs[of.pair].wall->shift().way().transpose() / h;
  return relative_velocities(group.list, v, walls);
}

// Whether the change of a gap over a step is that of a velocity: not in an elastic body.
bool is_of_rigid_bodies(const Simulation& sim, const ContactPair& pair) {
  const auto frequency = [&](Index contact) {
    return sim.bodies[sim.contact_nodes[contact].body]->largest_frequency();
  };
  return frequency(pair.slave->body) == 0 && frequency(pair.master->body) == 0;
}

// The gap that a point's impulse has to close so that it rebounds, with its normal velocity v at
// the start of the step; without a rebound its own gap. Energy is that of an impact where the gap
// is 0, under the acceleration of this step. A flight that ends within the step is none.
double gap_to_rebound(const ContactPoint& point, double v, double restitution, double h) {
  constexpr double round_off = 1e-9;  // points of a flat impact land together
  const double gap = point.gap[0], height = std::max(0.0, point.start_gap);
  if (!(v < 0) || !(gap < -round_off * v * h) || !(restitution > 0)) return gap;
  const double a = 2 * (point.start_gap + v * h - gap) / (h * h),
               square = restitution * restitution * (v * v + 2 * a * height) - 2 * a * height,
               up = std::sqrt(std::max(0.0, square));
  return up > a * h ? std::min(gap, (v - up) * h) : gap;
}

}  // namespace

EnforcementResult enforce_and_rebound(Simulation& sim, ContactGroup& group, double h,
                                      ContactState& state, ImpulseMemory& memory) {
  const auto solve = [&] {
    return enforce_impulse(group.list, group.laws, group.guess, h, state.bodies, memory,
                           functions_of(sim, group));
  };
  if (std::none_of(group.searches.begin(), group.searches.end(), [&](const ContactSearch& of) {
        return sim.pairs[of.pair].restitution > 0 && of.last > of.first;
      }))
    return solve();
  const Points v = start_velocities(sim, group, h, state);
  std::vector<ContactPoint>& points = group.list.points;
  const std::vector<ContactPoint> free = points;
  constexpr double less = 0.8, least = 0.2, round_off = 1e-9;
  for (double share = 1;; share = share > least ? less * share : 0) {
    bool rebounds = false;
    for (const ContactSearch& of : group.searches) {
      for (auto i = of.first; i < of.last; ++i) {
        points[i].gap[0] = gap_to_rebound(free[i], v(static_cast<Index>(i), 0),
                                          share * sim.pairs[of.pair].restitution, h);
        rebounds |= points[i].gap[0] != free[i].gap[0];
      }
    }
    EnforcementResult result = solve();
    if (!rebounds) return result;
    double work = 0, size = 0;
    for (const ContactSearch& of : group.searches) {
      const bool counts = is_of_rigid_bodies(sim, sim.pairs[of.pair]);
      for (auto i = of.first; i < of.last; ++i) {
        const auto row = static_cast<Index>(i);
        const Vector3 p = result.p.row(row), before = v.row(row);
        const Vector3 change = (result.gap.row(row).transpose() - points[i].gap) / h;
        result.gap(row, 0) += free[i].gap[0] - points[i].gap[0];
        // What starts behind a face is pushed out, with any restitution
        if (!counts || (free[i].start_gap < 0 && points[i].gap[0] == free[i].gap[0])) continue;
        work += p.dot(before + 0.5 * change);
        size += p.norm() * (before.norm() + change.norm());
      }
    }
    points = free;
    if (!(work > round_off * size) || share == 0) return result;
    for (const Index b : group.bodies) clear_impulses(state.bodies[b]);
  }
}

bool is_newmark(const Simulation& sim, const ContactGroup& group) {
  return !group.bodies.empty() &&
         sim.bodies[sim.contact_nodes[group.bodies.front()].body]->scheme() == Scheme::newmark;
}

void settle(Simulation& sim, const ContactGroup& group, const ImpulseMemory* memory,
            ContactState& state, EnforcementResult& result) {
  const Holding holding = holding_points(sim, group, result.p);
  if (holding.p.isZero(0)) return;
  std::map<Index, Points> v;
  for (const Index b : group.bodies) {
    const ContactNodes& nodes = sim.contact_nodes[b];
    ContactBody& contact = state.bodies[b];
    Body& body = *sim.bodies[nodes.body];
    body.end_velocities(nodes.set, v[b]);
    if (contact.velocity_response.empty())
      contact.velocity_response = body.velocity_response(nodes.set);
    contact.impulses.setZero();
    contact.friction.setZero();
  }
  const Points relative = relative_velocities(holding.list, v, holding.walls);
  ImpulseMemory& settled = state.settled[group.searches.front().pair];
  Points change;
  if (memory != nullptr && memory->unknowns.reduced) {
    Vector x = memory->x;
    change = settle_unknowns(holding.list, holding.laws,
                             some_of(memory->unknowns, group.laws, holding.places), relative,
                             state.bodies, x, settled);
    if (change.allFinite()) result.held = held_points(memory->unknowns, x);
  } else {
    change =
        settle_velocities(holding.list, holding.laws, holding.p, relative, state.bodies, settled);
  }
  if (!change.allFinite()) {
    result.residual = std::numeric_limits<double>::infinity();
    return;
  }
  spread_impulses(holding.list, holding.laws, change, state.bodies);
  for (const Index b : group.bodies) {
    ContactBody& contact = state.bodies[b];
    const ContactNodes& nodes = sim.contact_nodes[b];
    Body& body = *sim.bodies[nodes.body];
    const Points all = contact.impulses + contact.friction;
    if (!all.isZero(0)) body.add_end_impulses(nodes.set, all);
    if (!contact.friction.isZero(0)) {
      Points after;
      body.end_velocities(nodes.set, after);
      state.friction_work += 0.5 * contact.friction.cwiseProduct(v[b] + after).sum();
    }
    state.impulses_since_output[b] += all;
  }
  for (std::size_t i = 0; i < holding.places.size(); ++i)
    result.p.row(holding.places[i]) += change.row(static_cast<Index>(i));
}

}  // namespace cbr
