// SPDX-License-Identifier: GPL-3.0-or-later
// Statics: bodies, contact and pretensions in equilibrium, load step by load step. docs/theory.md,
// "Statics".
#pragma once

#include <compare>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/enforce/enforce_static.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/simulation/run_result.hpp"

namespace cbr {

// Each load step is a number of iterations: points of contact are found where the last forces of
// contact take the bodies, and the forces that hold them there, with the moves of what floats, are
// found for these points (enforce_static.hpp). It ends when nothing changes. Slip of friction is
// that of the load step. Only pairs of enforcement impulse.
class Equilibrium {
 public:
  Equilibrium(Simulation& simulation, ContactState& state, ContactOutcome& outcome);

  // `steps` load steps under the loads of the time 0, which grow with pretensions, and with the
  // overlaps that are resolved. What is pulled together is locked then. on_step: after each. False:
  // one of them has failed, as `result` says. All is as the load step before it has left it. A
  // failure of the first one is thrown.
  bool preload(Index steps, RunResult& result, const std::function<void(Index step)>& on_step);
  // One load step, to the loads of time t.
  void step(double t);
  // What is kept for the steps of a run, whose length is h, that goes on from here.
  void start_motion(double h);
  void keep_state(StateArchive& archive);  // between load steps

 private:
  // A pretension as a body of one node, whose position is that of the pull along the normal. One of
  // a given force floats.
  struct Bolt {
    Index pair = 0, body = 0;  // body: index into ContactState::bodies
    Vector3 normal;            // scene axes, outward from the slave
    double length = 0;
  };
  // What the search of a pair knows at the start of a load step, from which each iteration
  // searches.
  struct Known {
    std::vector<Index> face, known_face, further_faces;
    Vector offset;
    bool has_points = false;
    double depth = 0;
    std::vector<EdgePair> edges;
  };
  struct Solved {
    ContactGroup group;
    EnforcementResult result;
  };
  // What an iteration has changed: energies as Settled has them, the body that changed most, the
  // longest move of a contact node and the longest since the start of the load step, and whether
  // all is in equilibrium.
  struct Change {
    double change = 0, energy = 0, moved = 0, displaced = 0;
    std::size_t body = 0;
    bool balances = true;
  };
  // A point that pushes: the first node of its slave, and its slot in the search that found it.
  struct Closed {
    Index contact_body = 0, node = 0, slot = 0;
    auto operator<=>(const Closed&) const = default;
  };

  void number_floating(const std::vector<FloatingForces>& forces);
  void iterate(double t, double share);
  void start_iteration(double t, double share);
  void locate();
  void solve(Change& change);
  void solve_group(const std::vector<Index>& pairs, const std::vector<Index>& columns,
                   Change& change);
  void move(const std::vector<Index>& columns, const StaticResult& result, Change& change);
  std::vector<Index> columns_of(const std::vector<Index>& pairs) const;
  void give(Index contact_body);
  void look_at_nodes(Change& change);
  void book();
  bool is_done(const Change& change);
  void note_closed();
  StateArchive saved();
  void keep_found(StateArchive& archive);
  [[noreturn]] void refuse_endless(const Change& change) const;
  [[noreturn]] void refuse_unheld(Index body, const Vector& left) const;
  std::string load_step() const;
  double first_way() const;
  void add_bolts();
  void lock_bolts();
  void keep_known();
  void recall();
  void resolve_overlaps(double share);

  Simulation& sim_;
  ContactState& state_;
  ContactOutcome& outcome_;
  std::vector<Index> pairs_;     // all
  std::vector<Points> forces_;   // per contact body, of the last iteration, scene axes
  std::vector<Points> moved_;    // what they do to the nodes
  std::vector<Points> here_;     // per contact body: its nodes, after the last iteration
  std::vector<char> is_pushed_;  // per contact body: it has such forces
  std::vector<Solved> solved_;   // of this iteration
  // per pair: of its slave's nodes, its master's, and its edges
  std::vector<std::vector<Known>> known_;
  std::vector<Bolt> bolts_;
  // What floats: per contact body, with bolts; the columns of each body, first_[b] .. first_[b +
  // 1] - 1, those of bolts last; forces on them without contact, and their moves in this load step
  std::vector<FloatingNodes> floating_;
  std::vector<Index> first_;
  Vector loads_, moves_;
  double largest_load_ = 0;                 // that adds up to one of them
  std::map<Index, StaticMemory> memories_;  // by the first pair of the island
  // Of this load step: what a move may be, per pair the points that are closed, now and by the
  // iteration before
  double most_way_ = 0;
  std::vector<std::vector<Closed>> closed_, closed_before_;
  double reach_ = 0;  // the largest coordinate of a node
  bool initial_ = true;
  double resolved_ = 0;  // share of the overlaps
  double last_t_ = 0;    // of the last load step
  double most_change_ = 0;
  Index iteration_ = 0;
  Index preload_ = 0, n_preload_ = 0;  // of the load steps before the time 0, this one; all
};

}  // namespace cbr
