// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of one step: between the bodies' prediction and its acceptance.
#pragma once

#include <map>
#include <vector>

#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// What contact keeps from step to step.
struct ContactState {
  std::vector<ContactBody> bodies;  // as Simulation::contact_nodes
  // Some pair has penalty springs, whose dashpots know the motion of a step without impulses: no
  // forces are carried then.
  bool has_springs = false;
  // row-sum masses, where a nodal pair needs them, else empty
  std::vector<Points> masses;
  std::map<Index, ImpulseMemory> islands;     // by the first pair of the island
  std::map<Index, ImpulseMemory> settled;     // likewise, of settle_velocities()
  std::vector<Points> impulses_since_output;  // per contact body
  // likewise: what momentum has of forces that last beyond these impulses, or 0 rows: nothing
  std::vector<Points> ahead_since_output;
  // likewise, without friction and ties, where nodal pressures are wanted, else empty
  std::vector<Points> normal_since_output;
  // likewise: impulses per area along the normal, where contact has pressures as unknowns; the
  // impulses of these are not among those above
  std::vector<Points> pressure_since_output;

  // Together with what the pairs and contact nodes of the simulation keep. Restores a state of
  // start_contact(); the bodies are asked for their responses anew.
  void keep_state(StateArchive& archive, Simulation& simulation);
};

struct ContactOutcome {
  std::vector<char> touched;    // per contact body: got impulses
  std::vector<char> near;       // per pair: had constraints
  std::vector<Index> active;    // per pair: constraints with an impulse
  std::vector<Index> searched;  // the pairs of the last step: only they have entries other than 0
  std::vector<Index> met;       // pairs that have had constraints, in that order
  std::vector<char> has_met;    // per pair

  void start(const Simulation& simulation);
  void next_step();
  void keep_state(StateArchive& archive);
};

// Finds what tied pairs join. InputError: a nodal mass that is not positive; surfaces that are tied
// and nowhere near each other.
ContactState start_contact(Simulation& simulation);

// How deep the surfaces of pairs that may touch are in each other now, by all their nodes and
// edges: into their recent_penetration. Beyond what they were at the start of the run.
void look_at_depths(Simulation& simulation, const ContactOutcome& outcome);

// The bodies of the `due` pairs have been predicted over h and their contact nodes' start and end
// are filled. Adds impulses to the bodies and updates `end`. Adds to search, response and contact
// of `seconds`.
void contact_step(Simulation& simulation, const std::vector<Index>& due, double h, bool initial,
                  ContactState& state, ContactOutcome& outcome, StepSeconds& seconds);

}  // namespace cbr
