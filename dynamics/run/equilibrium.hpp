// SPDX-License-Identifier: GPL-3.0-or-later
// Statics: bodies, contact and pretensions in equilibrium, load step by load step. docs/theory.md,
// "Statics".
#pragma once

#include <map>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// Each load step is a number of iterations: bodies relax under the loads (Body::relax), points of
// contact are found where the last forces of contact take them, and contact is solved with the
// static response in the place of W. It ends when nothing changes. Slip of friction is that of the
// load step. Only pairs of enforcement impulse.
class Equilibrium {
 public:
  Equilibrium(Simulation& simulation, ContactState& state, ContactOutcome& outcome);

  // `steps` load steps under the loads of the time 0, which grow with pretensions, and with the
  // overlaps that are resolved. What is pulled together is locked then.
  void preload(Index steps);
  // One load step, to the loads of time t.
  void step(double t);
  // What is kept for the steps of a run, whose length is h, that goes on from here.
  void start_motion(double h);
  void keep_state(StateArchive& archive);  // between load steps
  Index iterations() const { return n_iterations_; }

 private:
  // A pretension as a body of one node, whose position is that of the pull along the normal.
  struct Bolt {
    Index pair = 0, body = 0;  // body: index into ContactState::bodies
    Vector3 normal;            // scene axes, outward from the slave
    // of a given force: how far an iteration may go for what is missing of it
    double compliance = 0;
    double length = 0, force = 0;
    double length_before = 0;
  };
  // What the search of a pair knows at the start of a load step, from which each iteration
  // searches.
  struct Known {
    std::vector<Index> face, known_face, further_faces;
    Vector offset;
    bool has_points = false;
    double depth = 0;
  };
  struct Solved {
    ContactGroup group;
    EnforcementResult result;
  };

  void iterate(const Rest& loads);
  double relax(const Rest& rest);
  void locate(double hold);
  void predict_bolts(double share);
  void solve(double hold);
  void solve_group(const std::vector<Index>& pairs, double hold);
  void give(Index contact_body);
  void book();
  double change_of_bolts();
  bool is_done(double change, double energy, double way);
  void watch(const std::vector<Settled>& settled, double t);
  [[noreturn]] void refuse_unheld(Index body, double t) const;
  void add_bolts();
  void find_compliance(Bolt& bolt, double hold);
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
  std::vector<char> is_pushed_;  // per contact body: it has such forces
  std::vector<Solved> solved_;   // of this iteration
  // per pair: of its slave's nodes, and its master's (two-way)
  std::vector<std::vector<Known>> known_;
  std::vector<Bolt> bolts_;
  // per body: in this load step, of the last iteration; of its box
  std::vector<double> way_, last_way_, extent_;
  double reach_ = 0;  // the largest coordinate of a node
  bool initial_ = true;
  double resolved_ = 0;   // share of the overlaps
  double last_t_ = 0;     // of the last load step
  double full_hold_ = 1;  // where nothing goes on
  double hold_ = 1, most_change_ = 0;
  double missing_pull_ = 0;  // of the pretensions' forces, the largest share
  Index iteration_ = 0, n_iterations_ = 0;
};

}  // namespace cbr
