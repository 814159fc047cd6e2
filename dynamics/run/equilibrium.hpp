// SPDX-License-Identifier: GPL-3.0-or-later
// Statics: equilibrium of bodies, contact and pretensions by load steps. docs/theory.md, "Statics".
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

// Diagonal of the box around a body's nodes; of a single one its distance from the centre of mass.
double extent_of(const Body& body);

// Iterates each load step. Contact points are found at positions under the last contact forces. For
// these points new forces are computed, together with motions of floating bodies
// (enforce_static.hpp). It ends when nothing changes. Slip of friction is that of the load step.
// Only pairs of enforcement impulse.
class Equilibrium {
 public:
  Equilibrium(Simulation& simulation, ContactState& state, ContactOutcome& outcome);

  // `steps` load steps under the loads of time 0, which increase together with pretensions and
  // resolved overlaps. Pretensions are locked at the end. on_step: after each. False: one has
  // failed, see `result`, and the state is that of the previous load step. A failure of the first
  // is thrown.
  bool preload(Index steps, RunResult& result, const std::function<void(Index step)>& on_step);
  // One load step, to the loads of time t.
  void step(double t);
  // Per pair the points that push after the last load step; none of ties. The tangents of their
  // frames are zero without friction.
  std::vector<ContactList> closed_points() const;
  // Initial state of a run with steps of length h that continues from here.
  void start_motion(double h);
  void keep_state(StateArchive& archive);  // between load steps

  std::function<void(Index iteration)> on_iteration;  // after each, within a load step

 private:
  static constexpr Index most_iterations = 100;  // of a load step
  // Iterations in which a body that slides has not yet left its place.
  static constexpr Index first_slides = 3;
  // A pretension as a body of one node, whose position is the pull along the normal. With a given
  // force it floats.
  struct Bolt {
    Index pair = 0, body = 0;  // body: index into ContactState::bodies
    Vector3 normal;            // scene axes, outward from the slave
    double length = 0;
  };
  // Search state of a pair at the start of a load step, from which each iteration searches.
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
  // Changes by an iteration. Energies as in Settled, and the body with the largest change. The
  // longest motion of a contact node, now and since the start of the load step. Whether forces are
  // in equilibrium.
  struct Change {
    double change = 0, energy = 0, moved = 0, displaced = 0, residual = 0;
    std::size_t body = 0;
    bool balances = true;
  };
  // A point with an impulse: the first node of its slave, and its slot in its search.
  struct Closed {
    Index contact_body = 0, node = 0, slot = 0;
    auto operator<=>(const Closed&) const = default;
  };

  // Iterations of a body without balance, one after another; the forces left in the first. The
  // pairs in which it slides; empty: it does not.
  struct Slide {
    Index n = 0;
    Vector left;
    std::string pairs;
  };

  void number_floating(const std::vector<FloatingForces>& forces);
  double iterate(double t, double share);  // returns Change::displaced
  void start_iteration(double t, double share);
  void locate();
  void solve(Change& change);
  bool takes_functions(const ContactGroup& group, std::size_t search) const;
  void solve_group(const std::vector<Index>& pairs, const std::vector<Index>& columns,
                   Change& change);
  void move(const std::vector<Index>& columns, const StaticResult& result, Change& change);
  std::vector<Index> columns_of(const std::vector<Index>& pairs) const;
  Matrix held_motions(const std::vector<Index>& pairs, const std::vector<Index>& columns) const;
  void give(Index contact_body);
  void look_at_nodes(Change& change);
  void book();
  bool is_done(const Change& change);
  void note_closed();
  StateArchive saved();
  void keep_found(StateArchive& archive);
  // equilibrium_messages.cpp
  [[noreturn]] void refuse_endless(const Change& change) const;
  [[noreturn]] void refuse_unheld(Index body, Vector left) const;
  void note_slide(Index body, const Vector& left);
  std::string sliding_pairs(Index body, const Vector& left) const;
  std::string load_step() const;
  // Of this iteration: solved, pair, place in its list.
  using PointTaker = std::function<void(const Solved&, std::size_t, std::size_t)>;
  void at_pushing_points(const PointTaker& take) const;
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
  std::vector<Points> moved_;    // displacements by these forces
  std::vector<Points> here_;     // per contact body: its nodes after the last iteration
  std::vector<char> is_pushed_;  // per contact body: forces are not 0
  std::vector<Solved> solved_;   // of this iteration
  // per pair: of slave nodes, master nodes, and edges
  std::vector<std::vector<Known>> known_;
  std::vector<Bolt> bolts_;
  // Floating bodies: per contact body, with bolts. Columns of body b: first_[b] .. first_[b + 1] -
  // 1, those of bolts last. Forces on them without contact, and their motions in this load step
  std::vector<FloatingNodes> floating_;
  std::vector<Index> first_;
  Vector loads_, moves_, left_;  // left_: forces without balance in this iteration
  std::vector<Slide> slides_;    // per body, in this load step
  double largest_load_ = 0;      // the largest force that adds to one of them
  bool bends(std::size_t contact) const {
    return sim_.bodies[sim_.contact_nodes[contact].body]->facts().bends;
  }
  std::map<Index, StaticMemory> memories_;  // by the first pair of the island
  // For this load step: largest motion allowed; per pair the closed points, now and in the previous
  // iteration
  double most_way_ = 0;
  std::vector<std::vector<Closed>> closed_, closed_before_;
  double reach_ = 0;  // largest coordinate of a node
  bool initial_ = true;
  double resolved_ = 0;  // resolved fraction of the overlaps
  double last_t_ = 0;    // of the last load step
  double most_change_ = 0;
  Index iteration_ = 0;
  Index preload_ = 0, n_preload_ = 0;  // load steps before time 0: the current one; their number
};

}  // namespace cbr
