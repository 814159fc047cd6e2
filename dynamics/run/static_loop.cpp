// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/run.hpp"

#include <stdexcept>

#include "common/files/state_archive.hpp"
#include "dynamics/run/equilibrium.hpp"
#include "dynamics/run/recorder.hpp"
#include "dynamics/run/simulation/run_result.hpp"

namespace cbr {
namespace {

class StaticLoop {
 public:
  StaticLoop(Simulation& simulation, const RunOptions& options)
      : sim_(simulation),
        options_(options),
        state_(start_contact(simulation)),
        recorder_(simulation),
        moving_(simulation.bodies.size(), 0) {
    outcome_.start(sim_);
    equilibrium_.emplace(sim_, state_, outcome_);
    equilibrium_->on_iteration = [this](Index iteration) { report_load_steps(iteration); };
  }

  RunResult run() {
    RunResult& result = recorder_.result();
    if (options_.restart) {
      keep_state(*options_.restart);
      options_.restart->finish();
      loaded_ = sim_.preload + 1 + step_;
      for (ContactBody& contact : state_.bodies) contact.response_h = 0;
    } else {
      if (sim_.preload > 0 && !equilibrium_->preload(sim_.preload, result, [this](Index done) {
            loaded_ = done;
            report_load_steps();
          })) {
        record();
        return std::move(result);
      }
      equilibrium_->step(0);
      loaded_ = sim_.preload + 1;
      report_load_steps();
      record();
    }
    const TimePlan& plan = sim_.plan;
    const auto keep = [this](StateArchive& state) { keep_state(state); };
    while (step_ < plan.n_steps()) {
      if (!take_step(plan.time(step_ + 1))) break;
      ++step_;
      ++result.steps;
      count();
      if (plan.is_output(step_)) record();
      ++loaded_;
      report_load_steps();
      if (step_ < plan.n_steps() && options_.ends_here(step_, plan.time(step_), keep, result))
        break;
    }
    result.reached = step_;
    return std::move(result);
  }

 private:
  void report_load_steps(Index iteration = 0) const {
    if (options_.on_load_step)
      options_.on_load_step(loaded_, sim_.preload + 1 + sim_.plan.n_steps(), iteration);
  }

  // False: no equilibrium. Earlier load steps are kept.
  bool take_step(double t) {
    RunResult& result = recorder_.result();
    const Stopwatch watch(result.seconds.contact);
    try {
      equilibrium_->step(t);
    } catch (const std::runtime_error& error) {
      result.failure = error.what();
      result.ended_at = sim_.plan.time(step_);
    }
    return result.failure.empty();
  }

  void count() {
    RunResult& result = recorder_.result();
    Index active = 0;
    for (const Index n : outcome_.active) active += n;
    result.contact_rows += static_cast<double>(active);
    result.contact_steps += active > 0;
    result.work.body_steps += static_cast<Index>(sim_.bodies.size());
    result.work.pair_searches += static_cast<Index>(sim_.pairs.size());
  }

  void record() {
    const Stopwatch watch(recorder_.result().seconds.output);
    recorder_.record(sim_.plan.time(step_), std::nullopt, moving_, state_, outcome_);
    if (options_.on_output) options_.on_output(step_, sim_.plan.time(step_));
  }

  void keep_state(StateArchive& archive) {
    archive.expect(sim_.plan.n_steps());
    archive.expect(static_cast<Index>(sim_.bodies.size()));
    archive(step_);
    for (auto& body : sim_.bodies) body->keep_state(archive);
    state_.keep_state(archive, sim_);
    archive(outcome_, recorder_, *equilibrium_);
  }

  Simulation& sim_;
  const RunOptions& options_;
  ContactState state_;
  ContactOutcome outcome_;
  Recorder recorder_;
  std::vector<char> moving_;
  std::optional<Equilibrium> equilibrium_;
  Index step_ = 0, loaded_ = 0;  // loaded_: load steps done, with those before time 0
};

}  // namespace

RunResult run_static(Simulation& simulation, const RunOptions& options) {
  return StaticLoop(simulation, options).run();
}

}  // namespace cbr
