// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "dynamics/integrators/contact_step.hpp"
#include "dynamics/integrators/recorder.hpp"
#include "dynamics/integrators/simulation.hpp"

namespace cbr {
namespace {

// First time at which g + w t - b t - a t^2 / 2 reaches 0, for g > 0.
double first_root(double gap, double speed, double growth, double acceleration) {
  if (gap <= 0) return 0;
  const double closing = growth - speed;  // gap - closing t - acceleration t^2 / 2
  if (acceleration <= 0) return closing > 0 ? gap / closing : HUGE_VAL;
  return 2 * gap / (closing + std::sqrt(closing * closing + 2 * acceleration * gap));
}

// No contact before this time: on some axis one surface is still wholly on one side of the other.
double time_apart(const MotionBound& a, const MotionBound& b, double margin) {
  double apart = 0;
  for (int c = 0; c < 3; ++c) {
    const double growth = a.growth[c] + b.growth[c], acceleration = a.acceleration[c] + b.acceleration[c];
    apart =
        std::max(apart, first_root(b.lower[c] - a.upper[c] - margin, b.lower_speed[c] - a.upper_speed[c], growth, acceleration));
    apart =
        std::max(apart, first_root(a.lower[c] - b.upper[c] - margin, a.lower_speed[c] - b.upper_speed[c], growth, acceleration));
  }
  return apart;
}

class TimeLoop {
 public:
  TimeLoop(Simulation& simulation, const RunOptions& options)
      : sim_(simulation), options_(options), state_(start_contact(simulation)), recorder_(simulation) {
    at_.assign(sim_.bodies.size(), 0);
    due_at_.assign(sim_.pairs.size(), 0);
    wait_.assign(sim_.pairs.size(), 1);
    backoff_ = wait_;
    current_.assign(sim_.contact_nodes.size(), 0);
    outcome_.active.assign(sim_.pairs.size(), 0);
    outcome_.near.assign(sim_.pairs.size(), 0);
    bounds_.resize(current_.size());
    bound_at_.assign(current_.size(), -1);
    for (const ContactPair& pair : sim_.pairs)
      largest_face_.push_back(pair.wall ? 0 : std::max(pair.slave.sizes.maxCoeff(), pair.master.sizes.maxCoeff()));
    all_exact_ = std::all_of(sim_.bodies.begin(), sim_.bodies.end(), [](const auto& b) { return b->is_exact(); });
  }

  RunResult run() {
    record(0, 0);
    for (Index p = 0; p < n_pairs(); ++p) schedule(p, 0);
    Index step = 0, recorded = 0;
    while (step < plan().n_steps()) {
      const Index next_output = plan().next_output(step);
      Index next = next_output;
      due_.clear();
      for (Index p = 0; p < n_pairs(); ++p) {
        if (due_at_[p] <= step) due_.push_back(p);
        next = std::min(next, std::max(due_at_[p], step + 1));
      }
      if (due_.empty()) outcome_.active.assign(sim_.pairs.size(), 0);
      if (!due_.empty() || !all_exact_ || !options_.jumps) {
        advance(step);
        next = step + 1;
      } else {
        recorder_.result().jumps += next > step + 1;
      }
      step = next;
      const Index taken = ++recorder_.result().steps;
      if (plan().is_output(step)) {
        record(step, recorded);
        recorded = step;
      }
      if (taken % 16 == 0) look_up(step);
    }
    return std::move(recorder_.result());
  }

 private:
  const TimePlan& plan() const { return sim_.plan; }
  Index n_pairs() const { return static_cast<Index>(sim_.pairs.size()); }
  Body& body_of(Index contact_body) { return *sim_.bodies[sim_.contact_nodes[contact_body].body]; }

  void look_up(Index step) {
    if (options_.on_progress) options_.on_progress(plan().time(step) / plan().end);
  }

  // Brings an exact body that has been left behind to `step` in one jump.
  void bring(Index body, Index step) {
    if (at_[body] == step) return;
    const double t = plan().time(at_[body]);
    sim_.bodies[body]->predict(t, step == at_[body] + 1 ? plan().step_length(at_[body]) : plan().time(step) - t);
    sim_.bodies[body]->accept();
    at_[body] = step;
    for (std::size_t c = 0; c < current_.size(); ++c)
      if (sim_.contact_nodes[c].body == body) current_[c] = 0;
  }

  // One step of all bodies that take part in a due pair or are not exact.
  void advance(Index step) {
    const double h = plan().step_length(step), t = plan().time(step);
    moving_.assign(sim_.bodies.size(), 0);
    for (std::size_t b = 0; b < sim_.bodies.size(); ++b) moving_[b] = !sim_.bodies[b]->is_exact() || !options_.jumps;
    for (const Index p : due_)
      for (const Index c : {sim_.pairs[p].slave.body, sim_.pairs[p].master.body}) moving_[sim_.contact_nodes[c].body] = 1;
    for (Index b = 0; b < static_cast<Index>(moving_.size()); ++b) {
      if (!moving_[b]) continue;
      bring(b, step);
      sim_.bodies[b]->predict(t, h);
    }
    locate();
    const bool any_due = !due_.empty();
    if (options_.jumps) drop_far_pairs(step == 0);
    if (any_due) {
      contact_step(sim_, due_, h, step == 0, state_, outcome_);
      count_contact();
    }
    for (Index b = 0; b < static_cast<Index>(moving_.size()); ++b) {
      if (!moving_[b]) continue;
      sim_.bodies[b]->accept();
      at_[b] = step + 1;
    }
    if (any_due) reschedule(step + 1);
  }

  void count_contact() {
    RunResult& result = recorder_.result();
    result.contact_steps += std::find(outcome_.near.begin(), outcome_.near.end(), 1) != outcome_.near.end();
    for (const Index active : outcome_.active) result.contact_rows += static_cast<double>(active);
  }

  // Of the due pairs, those whose bodies stay well out of each other's reach in this step need no search. A pair that had points in
  // the last step is searched all the same, so that it forgets them.
  void drop_far_pairs(bool initial) {
    const auto is_far = [&](Index p) {
      const ContactPair& pair = sim_.pairs[p];
      if (pair.wall || pair.law.law == ContactLaw::tied || outcome_.near[p]) return false;
      const ContactBody &a = state_.bodies[pair.slave.body], &b = state_.bodies[pair.master.body];
      // Above every reach of a search: contact_reach() of either side's faces, with motions relative to either
      const double size = largest_face_[p];
      const Vector3 reach =
          Vector3::Constant((initial ? 1.5 : 0.5) * size + 2 * (a.longest_way + b.longest_way) + pair.adjust.value_or(0));
      return !Box{a.swept.lower - reach, a.swept.upper + reach}.meets(b.swept);
    };
    std::erase_if(due_, is_far);
  }

  // Start and predicted end of the contact nodes of the due pairs; the last step's end is this step's start.
  void locate() {
    needed_.assign(current_.size(), 0);
    for (const Index p : due_) needed_[sim_.pairs[p].slave.body] = needed_[sim_.pairs[p].master.body] = 1;
    for (std::size_t c = 0; c < needed_.size(); ++c) {
      ContactBody& contact = state_.bodies[c];
      const ContactNodes& nodes = sim_.contact_nodes[c];
      if (!needed_[c]) {
        current_[c] = 0;
        continue;
      }
      if (current_[c]) {
        contact.start.swap(contact.end);
      } else {
        sim_.bodies[nodes.body]->positions(nodes.set, contact.start);
      }
      sim_.bodies[nodes.body]->predicted_positions(nodes.set, contact.end);
      sweep(contact);
      current_[c] = 1;
    }
  }

  void reschedule(Index step) {
    for (Index p = 0; p < n_pairs(); ++p) {
      const ContactPair& pair = sim_.pairs[p];
      const bool was_due = due_at_[p] < step, near = outcome_.near[p];
      const bool disturbed = outcome_.touched[pair.slave.body] || outcome_.touched[pair.master.body];
      if (was_due ? !near : disturbed) {
        schedule(p, step);
      } else if (was_due) {
        due_at_[p] = step, wait_[p] = backoff_[p] = 1;
      }
    }
  }

  // When pair p has to be looked at again. A bound is dear compared with a step, so a pair that stays close is asked ever more
  // seldom.
  void schedule(Index p, Index step) {
    ContactPair& pair = sim_.pairs[p];
    Body &a = body_of(pair.slave.body), &b = body_of(pair.master.body);
    if (pair.law.law == ContactLaw::tied && pair.ties.empty()) {  // one of all that lies apart
      due_at_[p] = plan().n_steps() + 1;
      return;
    }
    due_at_[p] = step;
    if (!options_.jumps || !a.is_exact() || !b.is_exact() || pair.law.law == ContactLaw::tied) return;
    if (step > 0 && --wait_[p] > 0) return;
    const double margin = 0.1 * pair.master.size + pair.memory.adjust;  // adjusted gaps are closed at a distance
    const MotionBound& bound = bound_of(pair.slave.body, step);
    const double apart =
        pair.wall ? pair.wall->time_apart(bound, margin) : time_apart(bound, bound_of(pair.master.body, step), margin);
    const double steps = std::floor(apart / plan().h);
    due_at_[p] = step + static_cast<Index>(std::min(steps, static_cast<double>(plan().n_steps() + 1)));
    backoff_[p] = steps > 0 ? 1 : std::min<Index>(2 * backoff_[p], 8);
    wait_[p] = backoff_[p];
  }

  // Formed once in a step, however many pairs the body is in.
  const MotionBound& bound_of(Index contact_body, Index step) {
    bring(sim_.contact_nodes[contact_body].body, step);
    if (bound_at_[contact_body] != step) {
      bounds_[contact_body] = body_of(contact_body).motion_bound(sim_.contact_nodes[contact_body].set);
      bound_at_[contact_body] = step;
    }
    return bounds_[contact_body];
  }

  void record(Index step, Index last) {
    const double t = plan().time(step), interval = t - plan().time(last);
    for (Index b = 0; b < static_cast<Index>(sim_.bodies.size()); ++b) bring(b, step);
    recorder_.record(t, interval, state_, outcome_);
    if (options_.on_output) options_.on_output(step, t);
  }

  Simulation& sim_;
  const RunOptions& options_;
  ContactState state_;
  ContactOutcome outcome_;
  Recorder recorder_;
  std::vector<Index> at_;              // per body: the step it has reached
  std::vector<Index> due_at_;          // per pair: no contact in steps that start before this one
  std::vector<Index> wait_, backoff_;  // per pair: steps until its bound is formed again; the next such wait
  std::vector<char> current_;          // per contact body: `end` is where it is now
  std::vector<char> moving_, needed_;
  std::vector<MotionBound> bounds_;  // per contact body, of the step bound_at_
  std::vector<Index> bound_at_;
  std::vector<double> largest_face_;  // per pair, its size
  std::vector<Index> due_;
  bool all_exact_ = false;
};

}  // namespace

RunResult run(Simulation& simulation, const RunOptions& options) { return TimeLoop(simulation, options).run(); }

}  // namespace cbr
