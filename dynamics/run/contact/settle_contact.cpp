// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/settle_contact.hpp"

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

Holding holding_points(const Simulation& sim, const ContactGroup& group, const Points& p) {
  Holding of;
  for (const ContactSearch& search : group.searches)
    for (auto i = search.first; !sim.pairs[search.pair].yields && i < search.last; ++i)
      of.places.push_back(static_cast<Index>(i));
  of.walls.setZero(static_cast<Index>(of.places.size()), 3);
  for (Index row = 0; const ContactSearch& search : group.searches) {
    if (sim.pairs[search.pair].yields) continue;
    const auto n = static_cast<Index>(search.last - search.first);
    if (const auto& wall = sim.pairs[search.pair].wall)
      of.walls.middleRows(row, n).rowwise() = wall->shift().velocity.transpose();
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

}  // namespace

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
