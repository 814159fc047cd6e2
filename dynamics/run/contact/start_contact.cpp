// SPDX-License-Identifier: GPL-3.0-or-later
// Initialisation of contact before the first step: points of ties, and masses of nodes.
#include <sstream>

#include "common/base/error.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {
namespace {

// For messages: "impact.yaml:12: contact a.top - b.bottom: "
std::string where(const ContactPair& pair) {
  return (pair.source ? pair.source->text() + ": " : "") + "contact " + pair.name + ": ";
}

// Positions for ties. Load steps start from the undeformed mesh; a motion starts with the
// quasi-static displacements of its loads.
const Points& start_of(const Simulation& sim, Index contact, ContactState& state) {
  const ContactNodes& nodes = sim.contact_nodes[contact];
  const Body& body = *sim.bodies[nodes.body];
  Points& start = state.bodies[contact].start;
  if (sim.is_static || sim.preload > 0) {
    start = body.reference_positions()(nodes.nodes, Eigen::all);
  } else {
    body.positions(nodes.set, start);
  }
  return start;
}

// Whether it turns by any angle, and its nodes move as a rigid body. Other bodies that turn have
// more dofs.
bool is_rigid(const Simulation& sim, Index contact) {
  const Body& body = *sim.bodies[sim.contact_nodes[contact].body];
  return body.turns() && body.n_dofs() == 6;
}

// Pairs of `all` that are apart are not tied.
void tie_pair(Simulation& sim, ContactPair& pair, ContactState& state) {
  const Points &slave = start_of(sim, pair.slave->body, state),
               &master = start_of(sim, pair.master->body, state);
  ContactList ties;
  Points offset;
  const TieReport report =
      pair.formulation == Formulation::mortar
          ? tie_mortar(*pair.slave, slave, *pair.master, master, sim.detection, pair.adjust, ties,
                       offset)
          : tie_surfaces(*pair.slave, slave, *pair.master, master, pair.adjust, ties, offset);
  if (!ties.empty()) {
    if (is_rigid(sim, pair.slave->body) && is_rigid(sim, pair.master->body))
      keep_independent(pair.slave->body, slave, ties, offset);
    PairState& now = pair.state();
    now.ties = std::move(ties);
    now.tie_offset = std::move(offset);
    now.tie_report = report;
    return;
  }
  if (pair.of_all) return;
  std::ostringstream message;
  message << where(pair) << "tied: no node of " << pair.slave->name << " is within ";
  if (pair.adjust) {
    message << *pair.adjust;
  } else {
    message << "5 % of a face";
  }
  message << " of " << pair.master->name
          << " at the start: give adjust a length that spans what lies between";
  throw InputError(message.str());
}

void tie_pairs(Simulation& sim, ContactState& state) {
  const ContactPair* of_all = nullptr;
  bool any = false;
  for (ContactPair& pair : sim.pairs) {
    if (pair.law.law != ContactLaw::tied || pair.is_link) continue;
    tie_pair(sim, pair, state);
    if (!pair.of_all) continue;
    of_all = &pair;
    any |= !pair.seen().ties.empty();
  }
  if (of_all && !any)
    throw InputError(
        of_all->source->text() +
        ": contact: all, tied: no two instances are close enough to each other at the start: " +
        "give adjust a length that spans what lies between");
}

}  // namespace

ContactState start_contact(Simulation& sim) {
  ContactState state;
  const std::size_t n = sim.contact_nodes.size();
  state.bodies.resize(n);
  state.masses.resize(n);
  state.impulses_since_output.resize(n);
  state.ahead_since_output.assign(n, Points(0, 3));
  state.normal_since_output.resize(n);
  state.pressure_since_output.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    state.bodies[b].impulses.setZero(static_cast<Index>(sim.contact_nodes[b].nodes.size()), 3);
    state.impulses_since_output[b] = state.bodies[b].friction = state.bodies[b].impulses;
    if (sim.contact_nodes[b].areas.size() == 0) continue;
    state.normal_since_output[b] = state.pressure_since_output[b] = state.bodies[b].impulses;
    sim.contact_nodes[b].slip.setZero(sim.contact_nodes[b].areas.size());
  }
  tie_pairs(sim, state);
  for (const ContactPair& pair : sim.pairs) {
    state.has_springs |= pair.enforcement == Enforcement::penalty;
    if (pair.law.law == ContactLaw::coulomb)
      state.bodies[pair.slave->body].rubs = state.bodies[pair.master->body].rubs = true;
    if (pair.enforcement != Enforcement::nodal) continue;
    for (const Index b : {pair.slave->body, pair.master->body}) {
      const ContactNodes& nodes = sim.contact_nodes[b];
      state.masses[b] = sim.bodies[nodes.body]->nodal_masses(nodes.set);
      if (!(state.masses[b].minCoeff() > 0)) {
        throw InputError(where(pair) + "nodal enforcement: instance '" +
                         sim.bodies[nodes.body]->name() +
                         "' has a row sum of its mass that is not positive, so its nodes cannot be "
                         "weighed: use enforcement: impulse");
      }
    }
  }
  return state;
}

}  // namespace cbr
