// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/threads.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/blas_threads.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/contact/pair_schedule.hpp"
#include "dynamics/run/equilibrium.hpp"
#include "dynamics/run/recorder.hpp"
#include "dynamics/run/simulation/run_result.hpp"

namespace cbr {
namespace {

class TimeLoop {
 public:
  TimeLoop(Simulation& simulation, const RunOptions& options)
      : sim_(simulation),
        options_(options),
        state_(start_contact(simulation)),
        recorder_(simulation),
        resting_(simulation.bodies.size(), 0),
        schedule_(
            simulation, options.jumps, resting_,
            [this](Index body, Index step) { bring(body, step); }, recorder_.result().work) {
    outcome_.start(sim_);
    at_.assign(sim_.bodies.size(), 0);
    is_moving_.assign(sim_.bodies.size(), 0);
    jump_friction_.assign(sim_.bodies.size(), 0);
    current_.assign(sim_.contact_nodes.size(), 0);
    located_ = current_;
    located_at_.assign(sim_.contact_nodes.size(), -2);
    for (const auto& body : sim_.bodies) alone_.push_back(body->facts().steps_alone);
    contact_of_.assign(sim_.bodies.size(), -1);
    for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c)
      contact_of_[sim_.contact_nodes[c].body] = static_cast<Index>(c);
    if (sim_.preload > 0) preload();
    for (std::size_t b = 0; b < resting_.size(); ++b)
      resting_[b] = options_.jumps && sim_.bodies[b]->at_rest();
  }

  RunResult run() {
    if (options_.restart) {
      keep_state(*options_.restart);
      options_.restart->finish();
    } else if (!recorder_.result().failure.empty()) {
      recorder_.record(0, std::nullopt, resting_, state_, outcome_);  // at rest
      if (options_.on_output) options_.on_output(0, 0);
      return std::move(recorder_.result());
    } else {
      schedule_.start();
      record();
    }
    const auto keep = [this](StateArchive& state) { keep_state(state); };
    while (step_ < plan().n_steps()) {
      go_on();
      const Index taken = ++recorder_.result().steps;
      if (plan().is_output(step_)) record();
      if (taken % looked_ == 0)
        for (const Index b : moving_)
          if (turn_limit(b) < HUGE_VAL) end_if_turned(b, sim_.bodies[b]->state().rotation);
      if (taken % told_ == 0 && options_.on_progress)
        options_.on_progress(plan().time(step_) / plan().end);
      if (step_ < plan().n_steps() &&
          options_.ends_here(step_, plan().time(step_), keep, recorder_.result()))
        break;
      if (recorder_.result().turned) break;
    }
    recorder_.result().reached = step_;
    return std::move(recorder_.result());
  }

 private:
  const TimePlan& plan() const { return sim_.plan; }

  // A restarted run has the state after the preload.
  void preload() {
    Equilibrium equilibrium(sim_, state_, outcome_);
    Index loaded = 0;
    if (options_.on_load_step)
      equilibrium.on_iteration = [&](Index iteration) {
        options_.on_load_step(loaded, sim_.preload, iteration);
      };
    if (!options_.restart &&
        !equilibrium.preload(sim_.preload, recorder_.result(), [&](Index done) {
          loaded = done;
          if (equilibrium.on_iteration) equilibrium.on_iteration(0);
        }))
      return;
    equilibrium.start_motion(plan().h);
    outcome_.next_step();
  }

  // One step, or a jump over several.
  void go_on() {
    schedule_.due(step_, due_);
    if (!due_.empty() || steps_something()) {
      advance(step_);
      ++step_;
      return;
    }
    outcome_.next_step();
    const Index next =
        std::min(plan().next_output(step_), std::max(schedule_.next(step_), step_ + 1));
    recorder_.result().jumps += next > step_ + 1;
    step_ = next;
  }

  double turn_limit(Index body) const {
    const auto b = static_cast<std::size_t>(body);
    return b < options_.turn_limit.size() ? options_.turn_limit[b] : HUGE_VAL;
  }

  void end_if_turned(Index body, double rotation) {
    if (rotation > turn_limit(body))
      recorder_.result().turned = {body, rotation, plan().time(step_)};
  }

  // State between two steps, without updating anything: checkpoints must not change a run.
  void keep_state(StateArchive& archive) {
    archive.expect(plan().n_steps());
    archive.expect(static_cast<Index>(sim_.bodies.size()));
    archive(step_, recorded_, at_, current_, located_at_, resting_);
    for (auto& body : sim_.bodies) body->keep_state(archive);
    state_.keep_state(archive, sim_);
    archive(outcome_, schedule_, recorder_);
  }

  // Whether a body needs a step although no pair is due.
  bool steps_something() const {
    if (!options_.jumps || !schedule_.loose().empty()) return true;
    for (std::size_t b = 0; b < resting_.size(); ++b)
      if (!resting_[b] && !sim_.bodies[b]->is_exact()) return true;
    return false;
  }

  // The same for equal numbers of steps of one length, wherever they start, so that data cached by
  // step length are reused.
  double length(Index from, Index to) const {
    if (to <= plan().n_whole) return static_cast<double>(to - from) * plan().h;
    return to == from + 1 ? plan().step_length(from) : plan().time(to) - plan().time(from);
  }

  // Advances an exact body to `step` in one jump; a resting one is there.
  void bring(Index body, Index step) {
    if (is_behind(body, step)) ++recorder_.result().work.body_steps;
    jump(body, step);
    state_.friction_work += std::exchange(jump_friction_[body], 0);
  }

  bool is_behind(Index body, Index step) const { return at_[body] != step && !resting_[body]; }

  void jump(Index body, Index step) {
    if (is_behind(body, step)) {
      Body& moving = *sim_.bodies[body];
      moving.predict(plan().time(at_[body]), length(at_[body], step), step - at_[body]);
      if (const Index c = contact_of_[body]; c >= 0) {
        current_[c] = 0;
        if (state_.bodies[c].rubs)
          jump_friction_[body] =
              moving.residual_friction(sim_.contact_nodes[c].set, Points(0, 3), false);
      }
      moving.accept();
    }
    at_[body] = step;
  }

  // Start of a step for one body and, if requested, its contact nodes.
  struct Start {
    Index body = 0, contact = -1;
    bool moves = false;
  };

  void move(Index body, Index step, Index contact = -1) {
    const bool moves = !is_moving_[body];
    if (moves) {
      is_moving_[body] = 1;
      moving_.push_back(body);
      if (is_behind(body, step)) ++recorder_.result().work.body_steps;
    }
    if (moves || contact >= 0) starts_.push_back({body, contact, moves});
  }

  void locate(Index c, Index step) {
    if (located_[c]) return;
    located_[c] = 1;
    move(sim_.contact_nodes[c].body, step, c);
  }

  void do_starts(Index step) {
    for_each_body(
        starts_, [](const Start& start) { return start.body; },
        [&](const Start& start) {
          if (start.moves) {
            jump(start.body, step);
            sim_.bodies[start.body]->predict(plan().time(step), plan().step_length(step));
          }
          if (start.contact >= 0) find_nodes(start.contact, step);
        });
    for (const Start& start : starts_)
      state_.friction_work += std::exchange(jump_friction_[start.body], 0);
    starts_.clear();
  }

  // work(item) for items of one body each, by several threads where bodies allow it.
  template <typename Item, typename BodyOf, typename Work>
  void for_each_body(const std::vector<Item>& items, const BodyOf& body_of, const Work& work) {
    shared_.clear();
    for (std::size_t i = 0; i < items.size(); ++i)
      if (alone_[body_of(items[i])]) shared_.push_back(i);
    share_among_threads(static_cast<Index>(shared_.size()), n_threads(),
                        [&](Index i) { work(items[shared_[i]]); });
    for (const Item& item : items)
      if (!alone_[body_of(item)]) work(item);
  }

  // Start and predicted end of a contact body's nodes; the start is the end of the last step.
  void find_nodes(Index c, Index step) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    ContactBody& contact = state_.bodies[c];
    const bool was_located = std::exchange(located_at_[c], step) == step - 1;
    if (contact.rubs) contact.velocity_before = contact.start;
    if (current_[c]) {
      contact.start.swap(contact.end);
    } else {
      sim_.bodies[nodes.body]->positions(nodes.set, contact.start);
    }
    sim_.bodies[nodes.body]->predicted_positions(nodes.set, contact.end);
    // Free motion goes on as in the step before; what forces last in it is not known here
    if (contact.rubs && was_located) {
      contact.velocity_before =
          (contact.start - contact.velocity_before) / plan().step_length(step - 1);
    } else if (contact.rubs && contact.lasting.rows() == 0) {
      contact.velocity_before = (contact.end - contact.start) / plan().step_length(step);
    } else {
      contact.velocity_before.resize(0, 3);
    }
    if (sim_.bodies[nodes.body]->turns()) contact.turn = sim_.bodies[nodes.body]->turn_of_step();
    sweep(contact);
  }

  void locate_due(Index step) {
    for (const Index p : due_) {
      const ContactPair& pair = sim_.pairs[p];
      locate(pair.slave->body, step);
      locate(pair.master->body, step);
      if (pair.joint >= 0) locate(pair.joint, step);
    }
  }

  void set_out(Index step) {
    moving_.clear();
    std::fill(located_.begin(), located_.end(), 0);
    for (Index b = 0; b < static_cast<Index>(resting_.size()); ++b)
      if (!options_.jumps || (!resting_[b] && !sim_.bodies[b]->is_exact())) move(b, step);
    do_starts(step);  // so that no body has two starts at a time
    for (const Index c : schedule_.loose()) locate(c, step);
    locate_due(step);
    do_starts(step);
    schedule_.add_meetings(step, state_, due_);
    locate_due(step);
    do_starts(step);
  }

  // One step of all bodies in a due pair, with contact, or without exact motion.
  void advance(Index step) {
    const bool initial = step == 0 && sim_.preload == 0;
    StepSeconds& seconds = recorder_.result().seconds;
    sim_.shift_walls(plan().time(step), plan().time(step + 1));
    {
      const Stopwatch watch(seconds.bodies);
      set_out(step);
    }
    // Pairs with points in the last step are searched, so that their state is reset
    std::erase_if(
        due_, [&](Index p) { return !outcome_.near[p] && schedule_.is_far(p, initial, state_); });
    contact_step(sim_, due_, plan().step_length(step), initial, state_, outcome_, seconds);
    {
      const Stopwatch watch(seconds.bodies);
      arrive(step + 1);
    }
    recorder_.result().work.body_steps += static_cast<Index>(moving_.size());
    count_contact();
    schedule_.update(step + 1, outcome_);
  }

  void count_contact() {
    RunResult& result = recorder_.result();
    bool any = false;
    for (const Index p : outcome_.searched) {
      any = any || outcome_.near[p];
      result.contact_rows += static_cast<double>(outcome_.active[p]);
    }
    result.contact_steps += any;
    result.work.pair_searches += static_cast<Index>(outcome_.searched.size());
  }

  void arrive(Index step) {
    const auto accept = [&](Index b) {
      sim_.bodies[b]->accept();
      at_[b] = step;
      is_moving_[b] = 0;
      const Index c = contact_of_[b];
      if (c < 0) return;
      // With large rotation impulses rotate a body, unlike the linear response
      current_[c] = located_[c] && !(outcome_.touched[c] && sim_.bodies[b]->turns());
      if (outcome_.touched[c]) resting_[b] = 0;
    };
    for_each_body(
        moving_, [](Index b) { return b; }, accept);
  }

  void record() {
    const Stopwatch watch(recorder_.result().seconds.output);
    const double t = plan().time(step_), interval = t - plan().time(recorded_);
    for (Index b = 0; b < static_cast<Index>(sim_.bodies.size()); ++b) bring(b, step_);
    sim_.shift_walls(t, t);
    recorder_.record(t, interval, resting_, state_, outcome_);
    recorded_ = step_;
    for (Index b = 0; b < static_cast<Index>(options_.turn_limit.size()); ++b)
      end_if_turned(b, recorder_.result().bodies[b].rotation);
    if (options_.on_output) options_.on_output(step_, t);
  }

  Simulation& sim_;
  const RunOptions& options_;
  // Steps between calls of on_progress: in runs of few steps these are long
  const Index told_ = std::clamp<Index>(sim_.plan.n_steps() / 1000, 1, 16);
  // Steps between checks of rotations: a check costs as much as a few steps
  const Index looked_ = std::max<Index>(50, sim_.plan.n_steps() / 10);
  ContactState state_;
  ContactOutcome outcome_;
  Recorder recorder_;
  std::vector<char> resting_;  // per body: at rest until an impulse acts
  PairSchedule schedule_;
  Index step_ = 0, recorded_ = 0;  // reached by the run, and by the last output
  std::vector<Index> at_;          // per body: the step reached
  std::vector<Index> contact_of_;  // per body: its contact body, or -1
  std::vector<char> current_;      // per contact body: `end` is current
  std::vector<char> located_;      // per contact body: start and end are of this step
  std::vector<Index> located_at_;  // per contact body: the last step with start and end
  std::vector<char> is_moving_;    // per body
  std::vector<Index> moving_, due_;
  std::vector<double> jump_friction_;  // per body: work of friction that a jump books
  std::vector<char> alone_;            // per body: BodyFacts::steps_alone
  std::vector<Start> starts_;          // of this step, not yet done
  std::vector<std::size_t> shared_;    // workspace of for_each_body()
};

}  // namespace

RunResult run(Simulation& simulation, const RunOptions& options) {
  if (simulation.is_static) return run_static(simulation, options);
  return TimeLoop(simulation, options).run();
}

}  // namespace cbr
