// SPDX-License-Identifier: GPL-3.0-or-later
// Selection of the pairs for each step; distant pairs cost nothing.
#pragma once

#include <functional>
#include <vector>

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// A body is free if no impulse has acted on it since its motion bound was formed. Two free bodies
// cannot meet before a time given by their bounds, and their pair waits for it in a queue. A body
// with contact impulses, or without exact motion, is loose. It is stepped, and its swept box is
// compared with the bounds of its partners.
class PairSchedule {
 public:
  // bring(body, step): advances an exact body. resting, per body: at rest until an impulse acts.
  // jumps: false: every pair is due in every step.
  PairSchedule(Simulation& simulation, bool jumps, const std::vector<char>& resting,
               std::function<void(Index, Index)> bring, WorkCounts& counts);

  void start();
  // First step in which a pair is due by current bounds; `step` if a body is loose.
  Index next(Index step) const;
  // The pairs due at the start of the step.
  void due(Index step, std::vector<Index>& pairs);
  const std::vector<Index>& loose() const { return loose_; }  // contact bodies
  // Adds pairs of loose bodies that come near in the step. Precondition: these are located (start,
  // end and sweep over the step).
  void add_meetings(Index step, const ContactState& state, std::vector<Index>& pairs);
  // Whether swept boxes are out of each other's reach in this step, so that no search is needed.
  bool is_far(Index pair, bool initial, const ContactState& state) const;
  // Call after the step that ended at `step`.
  void update(Index step, const ContactOutcome& outcome);
  void keep_state(StateArchive& archive);  // instead of start()

 private:
  enum class Kind : char { timed, always, never };
  struct Known {  // of a contact body
    MotionBound bound;
    Index step = -1;    // of the bound; -1: none
    bool fine = false;  // not a quick bound
    bool loose = false, can_settle = false;
    Index busy_at = -1;  // last step with impulses or near contact
    Box box;             // swept box of a free body in the step box_step
    Index box_step = -1;
    void keep_state(StateArchive& archive);
  };
  struct Entry {
    Index step, pair, stamp;
    // heap with the earliest on top
    bool operator<(const Entry& other) const { return step > other.step; }
    void keep_state(StateArchive& archive);
  };

  struct Partner {  // of a contact body: the other body, and their pair
    Index body, pair;
    auto operator<=>(const Partner&) const = default;
  };

  const TimePlan& plan() const { return sim_.plan; }
  bool is_free(Index pair) const;
  bool may_jump_near(Index pair) const;
  Kind kind_of(const ContactPair& pair) const;
  void enqueue(Index pair, Index step);
  void take(Index pair, Index step, std::vector<Index>& pairs);
  void form(Index contact, Index step, bool fine);
  MotionBound bound_at(Index contact, Index step) const;
  MotionBound seen_from_wall(Index pair, MotionBound bound, Index step) const;
  double steps_apart(Index pair, Index step) const;
  void first_look(Index pair);
  void schedule(Index pair, Index step);
  const Box& box_of(Index contact, Index step);
  void loosen(Index contact);
  double longest_way(Index contact, Index step, const ContactState& state) const;
  void find_near(Index step, const ContactState& state);

  Simulation& sim_;
  const bool jumps_;
  const std::vector<char>& resting_;
  std::function<void(Index, Index)> bring_;
  WorkCounts& counts_;
  std::vector<Known> known_;                    // per contact body
  std::vector<std::vector<Partner>> partners_;  // per contact body, ascending: walls first
  // contact bodies with partners other than walls, ascending
  std::vector<Index> meeting_;
  double face_of_any_ = 0, adjust_of_any_ = 0;  // largest over pairs of bodies
  std::vector<Kind> kind_;                      // per pair, like the next five
  std::vector<Index> stamp_;                    // of the valid entry in the queue
  std::vector<Index> taken_at_;
  // checks of a pair that stays close become less frequent
  std::vector<Index> wait_, backoff_;
  std::vector<double> largest_face_;
  std::vector<Entry> queue_;  // a heap
  std::vector<Index> always_, taken_, loose_, settled_;
  std::vector<Box> queries_, targets_;  // of find_near(): loose bodies; those of meeting_
  std::vector<double> ways_;            // of meeting_
  BroadPhase grid_;
};

}  // namespace cbr
