// SPDX-License-Identifier: GPL-3.0-or-later
// Checkpoints: files from which an interrupted run goes on, bit for bit (format "cbr-checkpoint",
// docs/formats.md).
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/files/state_archive.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Hash of all that the course of a run depends on: the scene but for paths and checkpoints, the
// bytes of the meshes and superelements that it uses, --diagonal-limit. InputError when a file
// cannot be read.
std::string run_hash(const Scene& scene, const BuildOptions& options);

struct Checkpoint {
  Index step = 0;
  double time = 0;
  std::vector<double> field_times;  // of the fields written so far
  std::string fields_hash;          // of these: FieldHash
  // that the run was begun with: with others BLAS adds in another order
  int threads = 0;
  std::vector<std::string> warnings;  // told so far
};

// Whole or not at all. RunError when the disk refuses.
void write_checkpoint(const std::filesystem::path& file, const std::string& hash,
                      const Checkpoint& checkpoint, const StateArchive& state);
// And its state. InputError: no checkpoint, damaged, of another version of cbr-dyn, of a run with
// another hash.
std::pair<Checkpoint, StateArchive> read_checkpoint(const std::filesystem::path& file,
                                                    const std::string& hash);
// Whether it was written by a run of this run_hash(). InputError: no checkpoint.
bool is_checkpoint_of(const std::filesystem::path& file, const std::string& hash);
// Of the checkpoint, for set_threads(), before anything is computed. InputError: no checkpoint.
int threads_of_checkpoint(const std::filesystem::path& file);
// Of the fields, beside the checkpoint: impact.checkpoint.fields.h5.
std::filesystem::path fields_of_checkpoint(const std::filesystem::path& checkpoint);

// Where the scene's checkpoints go: beside the results unless it says so. InputError when something
// else is there, but for `restart` (or empty), the checkpoint to go on from.
std::filesystem::path checkpoint_file(const CheckpointOptions& options,
                                      const std::filesystem::path& results,
                                      const std::filesystem::path& restart = {});

// When the next one is due: times and steps are counted from the start of the run, minutes from the
// last one.
class CheckpointClock {
 public:
  explicit CheckpointClock(const CheckpointOptions& options) : options_(options) {}
  void start_at(Index step, double t);
  bool is_due(Index step, double t);  // true once for each

 private:
  using Clock = std::chrono::steady_clock;
  double passed(double t) const;
  CheckpointOptions options_;
  Index steps_passed_ = 0;
  double times_passed_ = 0;
  Clock::time_point last_ = Clock::now();
};

}  // namespace cbr
