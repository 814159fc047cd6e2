// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/integrators/contact_step.hpp"

#include <algorithm>
#include <numeric>

#include "common/error.hpp"

namespace cbr {
namespace {

// The constraints of some pairs, solved together.
struct Group {
  std::vector<Index> pairs;
  std::vector<Constraint> constraints;
  std::vector<std::size_t> first;  // of each pair, and the end
  std::vector<char> guess;
};

Group collect(Simulation& sim, const std::vector<Index>& pairs, bool initial, const ContactState& state) {
  Group group;
  group.pairs = pairs;
  for (const Index p : pairs) {
    group.first.push_back(group.constraints.size());
    ContactPair& pair = sim.pairs[p];
    detect(pair.slave, state.bodies[pair.slave.body], pair.master, state.bodies[pair.master.body], initial, sim.detection,
           pair.memory, group.constraints);
    for (std::size_t i = group.first.back(); i < group.constraints.size(); ++i)
      group.guess.push_back(pair.memory.face[group.constraints[i].slot] >= 0);
  }
  group.first.push_back(group.constraints.size());
  return group;
}

// Pairs of one enforcement, those that share a body together.
std::vector<std::vector<Index>> islands(const Simulation& sim, const std::vector<Index>& due, Enforcement enforcement) {
  std::vector<Index> root(sim.contact_nodes.size());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index b) {
    while (root[b] != b) b = root[b];
    return b;
  };
  for (const Index p : due)
    if (sim.pairs[p].enforcement == enforcement) root[find(sim.pairs[p].slave.body)] = find(sim.pairs[p].master.body);
  std::map<Index, std::vector<Index>> by_root;
  for (const Index p : due)
    if (sim.pairs[p].enforcement == enforcement) by_root[find(sim.pairs[p].slave.body)].push_back(p);
  std::vector<std::vector<Index>> list;
  for (auto& [body, pairs] : by_root) list.push_back(std::move(pairs));
  return list;
}

void book(Simulation& sim, const Group& group, const EnforcementResult& result, ContactOutcome& outcome) {
  for (std::size_t k = 0; k < group.pairs.size(); ++k) {
    ContactPair& pair = sim.pairs[group.pairs[k]];
    const auto first = group.first[k], last = group.first[k + 1];
    outcome.near[group.pairs[k]] = last > first;
    for (auto i = first; i < last; ++i) {
      outcome.active[group.pairs[k]] += result.p[i] > 0;
      // A penalty looks at gaps at the start of a step
      const double gap = pair.enforcement == Enforcement::penalty ? group.constraints[i].start_gap : result.gap[i];
      pair.recent_penetration = std::max(pair.recent_penetration, -gap);
    }
    pair.recent_residual = std::max(pair.recent_residual, result.residual);
    pair.n_fallbacks += result.fallback;
    remember(group.constraints, first, last, result.gap, result.p, 1e-6 * pair.master.size, pair.memory);
  }
}

void clear_impulses(const Group& group, ContactState& state) {
  for (const Constraint& c : group.constraints) {
    for (const Index b : {c.slave_body, c.master_body})
      if (!state.bodies[b].impulses.isZero(0)) state.bodies[b].impulses.setZero();
  }
}

std::vector<Index> bodies_of(const Group& group) {
  std::vector<Index> list;
  for (const Constraint& c : group.constraints) list.push_back(c.slave_body), list.push_back(c.master_body);
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

// end += S p, over the dofs that an impulse acts on.
void move_end(ContactBody& body) {
  Eigen::Map<Vector> end(body.end.data(), body.end.size());
  const double* p = body.impulses.data();
  for (Index i = 0; i < body.impulses.size(); ++i) {
    if (p[i] == 0) continue;
    if (body.response.is_diagonal()) {
      end[i] += body.response.diagonal[i] * p[i];
    } else {
      end += p[i] * body.response.dense.col(i);
    }
  }
}

// Hands the impulses of the group to the bodies; nodal: as velocities of the nodes alone.
void deliver(Simulation& sim, const Group& group, bool nodal, double h, ContactState& state, ContactOutcome& outcome) {
  for (const Index b : bodies_of(group)) {
    ContactBody& body = state.bodies[b];
    if (body.impulses.isZero(0)) continue;
    const ContactNodes& nodes = sim.contact_nodes[b];
    outcome.touched[b] = 1;
    state.impulses_since_output[b] += body.impulses;
    if (nodal) {
      const Points velocities = body.impulses.cwiseQuotient(state.masses[b]);
      const Vector3 momentum = body.impulses.colwise().sum().transpose();
      const Vector3 extra = sim.bodies[nodes.body]->add_velocities(nodes.set, velocities, momentum);
      body.end += h * (velocities.rowwise() + extra.transpose());
    } else {
      sim.bodies[nodes.body]->add_impulses(nodes.set, body.impulses);
      move_end(body);
    }
  }
}

void prepare(const Simulation& sim, const Group& group, double h, ContactState& state) {
  for (const Index b : bodies_of(group)) {
    ContactBody& body = state.bodies[b];
    if (body.response_h == h) continue;
    body.response = sim.bodies[sim.contact_nodes[b].body]->response(sim.contact_nodes[b].set, h);
    body.response_h = h;
  }
  clear_impulses(group, state);
}

double largest_frequency(const Simulation& sim, const Group& group) {
  double omega = 0;
  for (const Index b : bodies_of(group)) omega = std::max(omega, sim.bodies[sim.contact_nodes[b].body]->largest_frequency());
  return omega;
}

void solve_group(Simulation& sim, Enforcement enforcement, const std::vector<Index>& pairs, double h, bool initial,
                 ContactState& state, ContactOutcome& outcome) {
  const Group group = collect(sim, pairs, initial, state);
  if (group.constraints.empty()) {
    for (const Index p : pairs) std::fill(sim.pairs[p].memory.face.begin(), sim.pairs[p].memory.face.end(), -1);
    return;
  }
  prepare(sim, group, h, state);
  EnforcementResult result;
  switch (enforcement) {
    case Enforcement::impulse:
      result = enforce_impulse(group.constraints, group.guess, h, state.bodies, state.islands[pairs.front()]);
      break;
    case Enforcement::penalty:
      result =
          enforce_penalty(group.constraints, h, largest_frequency(sim, group) * h, state.bodies, sim.pairs[pairs.front()].penalty);
      break;
    case Enforcement::nodal:
      result = enforce_nodal(group.constraints, group.guess, h, state.masses, state.bodies);
      break;
  }
  book(sim, group, result, outcome);
  deliver(sim, group, enforcement == Enforcement::nodal, h, state, outcome);
}

}  // namespace

ContactState start_contact(const Simulation& sim) {
  ContactState state;
  const std::size_t n = sim.contact_nodes.size();
  state.bodies.resize(n), state.masses.resize(n), state.impulses_since_output.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    state.bodies[b].impulses.setZero(static_cast<Index>(sim.contact_nodes[b].nodes.size()), 3);
    state.impulses_since_output[b] = state.bodies[b].impulses;
  }
  for (const ContactPair& pair : sim.pairs) {
    if (pair.enforcement != Enforcement::nodal) continue;
    for (const Index b : {pair.slave.body, pair.master.body}) {
      const ContactNodes& nodes = sim.contact_nodes[b];
      state.masses[b] = sim.bodies[nodes.body]->nodal_masses(nodes.set);
      if (!(state.masses[b].minCoeff() > 0)) {
        throw InputError(
            "contact " + pair.name + ": nodal enforcement: instance '" + sim.bodies[nodes.body]->name() +
            "' has a row sum of its mass that is not positive, so its nodes cannot be weighed: use enforcement: impulse");
      }
    }
  }
  return state;
}

void contact_step(Simulation& sim, const std::vector<Index>& due, double h, bool initial, ContactState& state,
                  ContactOutcome& outcome) {
  outcome.touched.assign(sim.contact_nodes.size(), 0);
  outcome.near.assign(sim.pairs.size(), 0);
  outcome.active.assign(sim.pairs.size(), 0);
  // Penalty knows the start only; impulses see its effect on the end; nodal changes what the others leave.
  for (const Index p : due)
    if (sim.pairs[p].enforcement == Enforcement::penalty) solve_group(sim, Enforcement::penalty, {p}, h, initial, state, outcome);
  for (const Enforcement enforcement : {Enforcement::impulse, Enforcement::nodal})
    for (const auto& pairs : islands(sim, due, enforcement)) solve_group(sim, enforcement, pairs, h, initial, state, outcome);
}

}  // namespace cbr
