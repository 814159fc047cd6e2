// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of one step, between prediction and acceptance of the bodies.
#pragma once

#include <map>
#include <vector>

#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// State of contact between steps.
struct ContactState {
  std::vector<ContactBody> bodies;  // in the order of Simulation::contact_nodes
  // A pair has penalty springs. Their dashpots use the motion of a step without impulses, so that
  // no lasting forces are applied.
  bool has_springs = false;
  // row-sum masses for nodal pairs, else empty
  std::vector<Points> masses;
  std::map<Index, ImpulseMemory> islands;     // by the first pair of the island
  std::map<Index, ImpulseMemory> settled;     // likewise, of settle_velocities()
  std::vector<Points> impulses_since_output;  // per contact body
  double friction_work = 0;                   // on bodies
  // likewise: momentum of lasting forces beyond these impulses; 0 rows: none
  std::vector<Points> ahead_since_output;
  // likewise, without friction and ties, for nodal pressures, else empty
  std::vector<Points> normal_since_output;
  // likewise: normal impulses per area where pressures are unknowns, which the sums above exclude
  std::vector<Points> pressure_since_output;

  // Together with the state of pairs and contact nodes of the simulation. Restores a state of
  // start_contact(); responses are requested again.
  void keep_state(StateArchive& archive, Simulation& simulation);
};

struct ContactOutcome {
  std::vector<char> touched;    // per contact body: has impulses
  std::vector<char> near;       // per pair: has constraints
  std::vector<Index> active;    // per pair: constraints with an impulse
  std::vector<Index> searched;  // pairs of the last step; entries of others are 0
  std::vector<Index> met;       // pairs that have had constraints, in order of time
  std::vector<char> has_met;    // per pair

  void start(const Simulation& simulation);
  void next_step();
  void keep_state(StateArchive& archive);
};

// Finds tie points. InputError: a nodal mass that is not positive; tied surfaces that are out of
// reach of each other.
ContactState start_contact(Simulation& simulation);

// Updates recent_penetration of pairs that may touch: current penetration by all nodes and edges,
// beyond that at the start of the run.
void look_at_depths(Simulation& simulation, const ContactOutcome& outcome);

// Preconditions: the bodies of the `due` pairs are predicted over h, and start and end of their
// contact nodes are filled. Adds impulses to the bodies and updates `end`. Adds to search, response
// and contact of `seconds`.
void contact_step(Simulation& simulation, const std::vector<Index>& due, double h, bool initial,
                  ContactState& state, ContactOutcome& outcome, StepSeconds& seconds);

}  // namespace cbr
