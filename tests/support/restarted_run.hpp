// SPDX-License-Identifier: GPL-3.0-or-later
// A run, and its continuation from a checkpoint.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/files/state_archive.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::test {

struct RestartedRun {
  Ran whole, rest;  // both with the outputs of the whole run
};

// Restarts from the first checkpoint after this time.
inline RestartedRun restarted(const SceneFolder& folder, const std::string& yaml, double after) {
  std::optional<std::vector<Index>> words;
  RunOptions keeps;
  keeps.is_checkpoint = [&](Index, double t) { return t > after && !words; };
  keeps.on_checkpoint = [&](Index, double, const StateArchive& state) { words = state.words(); };
  Ran whole = folder.run(yaml, keeps);
  if (!words) throw std::runtime_error("no checkpoint was written");
  StateArchive state(*words, "test");
  RunOptions goes_on;
  goes_on.restart = &state;
  return {std::move(whole), folder.run(yaml, goes_on)};
}

// Energies, works, bodies, monitors, reactions and pairs have the same bits at all outputs.
inline void expect_same_bits(const RestartedRun& runs, const std::string& of = "") {
  const RunResult &whole = runs.whole.result, &rest = runs.rest.result;
  const auto same = [&](const std::vector<double>& a, const std::vector<double>& b,
                        const std::string& what) {
    ASSERT_EQ(a.size(), b.size()) << of << " " << what;
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0) << of << " " << what;
  };
  for (const auto series :
       {&RunResult::total, &RunResult::work_external, &RunResult::work_contact,
        &RunResult::work_friction, &RunResult::work_damping, &RunResult::work_numerical})
    same(whole.*series, rest.*series, "energies");
  for (std::size_t i = 0; i < whole.bodies.size(); ++i) {
    const RunResult::OfBody &a = whole.bodies[i], &b = rest.bodies[i];
    for (const auto series : {&RunResult::OfBody::center_of_mass, &RunResult::OfBody::momentum,
                              &RunResult::OfBody::angular_momentum, &RunResult::OfBody::reaction})
      same((a.*series).values, (b.*series).values, "body");
    same(a.orientation, b.orientation, "orientation");
  }
  for (std::size_t i = 0; i < whole.monitors.size(); ++i)
    for (const auto series : {&RunResult::OfMonitor::mean_position, &RunResult::OfMonitor::force,
                              &RunResult::OfMonitor::rotation})
      same((whole.monitors[i].*series).values, (rest.monitors[i].*series).values, "monitor");
  for (std::size_t i = 0; i < whole.reactions.size(); ++i) {
    same(whole.reactions[i].force.values, rest.reactions[i].force.values, "reaction");
    same(whole.reactions[i].moment.values, rest.reactions[i].moment.values, "moment");
  }
  for (std::size_t i = 0; i < whole.pairs.size(); ++i)
    for (std::size_t s = 0; s < whole.pairs[i].series.size(); ++s)
      same(whole.pairs[i].series[s].values, rest.pairs[i].series.at(s).values, "pair");
}

}  // namespace cbr::test
