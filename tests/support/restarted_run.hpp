// SPDX-License-Identifier: GPL-3.0-or-later
// A run, and its continuation from a checkpoint.
#pragma once

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
inline RestartedRun restarted(SceneFolder& folder, const std::string& yaml, double after) {
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

}  // namespace cbr::test
