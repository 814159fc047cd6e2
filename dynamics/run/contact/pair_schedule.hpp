// SPDX-License-Identifier: GPL-3.0-or-later
// Which pairs a step has to look at: far ones cost nothing.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// A body that no impulse has acted on since its motion bound was formed is free: two free bodies
// cannot meet before a time that their bounds tell, and their pair waits for it in a queue. One
// that is pushed in contact, or does not move exactly, is loose: it is stepped, and where it goes
// in the step is held against the bounds of its partners, one comparison each.
class PairSchedule {
 public:
  // bring(body, step): takes an exact body there. resting, per body: does not move until it is
  // pushed. jumps: false: every pair is due in every step.
  PairSchedule(Simulation& simulation, bool jumps, const std::vector<char>& resting,
               std::function<void(Index, Index)> bring, WorkCounts& counts);

  void start();
  // First step in which a pair is due by what is known now; `step` when a body is loose.
  Index next(Index step) const;
  // The pairs due at the start of the step.
  void due(Index step, std::vector<Index>& pairs);
  const std::vector<Index>& loose() const { return loose_; }  // contact bodies
  // Adds pairs of loose bodies, which are located (start, end and sweep over the step), that come
  // near in it.
  void add_meetings(Index step, const ContactState& state, std::vector<Index>& pairs);
  // Bodies whose swept boxes stay well out of each other's reach in this step need no search.
  bool is_far(Index pair, bool initial, const ContactState& state) const;
  // After the step that ended at `step`.
  void update(Index step, const ContactOutcome& outcome);
  void keep_state(StateArchive& archive);  // in the place of start()

 private:
  enum class Kind : char { timed, always, never };
  struct Known {  // of a contact body
    MotionBound bound;
    Index step = -1;    // of the bound; -1: none
    bool fine = false;  // not the quick one
    bool loose = false, can_settle = false;
    Index busy_at = -1;  // the last step in which it was pushed, or near to be
    Box box;             // where a free body is in the step box_step
    Index box_step = -1;
    void keep_state(StateArchive& archive);
  };
  struct Entry {
    Index step, pair, stamp;
    bool operator<(const Entry& other) const { return step > other.step; }  // the earliest on top
    void keep_state(StateArchive& archive);
  };

  struct Partner {  // of a contact body: the other one, and their pair
    Index body, pair;
    auto operator<=>(const Partner&) const = default;
  };

  const TimePlan& plan() const { return sim_.plan; }
  bool is_free(Index pair) const;
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
  // contact bodies with partners beside walls, ascending
  std::vector<Index> meeting_;
  double face_of_any_ = 0, adjust_of_any_ = 0;  // largest of the pairs of bodies
  std::vector<Kind> kind_;                      // per pair, as the next five
  std::vector<Index> stamp_;                    // of the entry in the queue that counts
  std::vector<Index> taken_at_;
  // a pair that stays close is asked ever more seldom when it can be met
  std::vector<Index> wait_, backoff_;
  std::vector<double> largest_face_;
  std::vector<Entry> queue_;  // a heap
  std::vector<Index> always_, taken_, loose_, settled_;
  std::vector<Box> queries_, targets_;  // of find_near(): the loose bodies, those of meeting_
  std::vector<double> ways_;            // of meeting_
  BroadPhase grid_;
};

}  // namespace cbr
