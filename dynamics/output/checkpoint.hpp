// SPDX-License-Identifier: GPL-3.0-or-later
// Checkpoints: files to restart an interrupted run with bitwise equal results (format
// "cbr-checkpoint", docs/formats.md).
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

// Hash of all inputs that determine a run: the scene except paths and checkpoints, the bytes of its
// meshes and superelements, --diagonal-limit. InputError if a file cannot be read.
std::string run_hash(const Scene& scene, const BuildOptions& options);

struct Checkpoint {
  Index step = 0;
  double time = 0;
  std::vector<double> field_times;  // of the fields written so far
  Index fields_digest = 0;          // ComparedChecksums::digest of these fields
  // at the start of the run: another number changes the order of sums in BLAS
  int threads = 0;
  std::vector<std::string> warnings;  // reported so far
};

// Writes the whole file or nothing. RunError for disk errors.
void write_checkpoint(const std::filesystem::path& file, const std::string& hash,
                      const Checkpoint& checkpoint, const StateArchive& state);
// Also reads the state. InputError: no checkpoint, damaged, of another version of cbr-dyn, or of a
// run with another hash.
std::pair<Checkpoint, StateArchive> read_checkpoint(const std::filesystem::path& file,
                                                    const std::string& hash);
// Whether a run with this run_hash() wrote it. InputError: no checkpoint.
bool is_checkpoint_of(const std::filesystem::path& file, const std::string& hash);
// Number of threads in the checkpoint, for set_threads() before any computation. InputError: no
// checkpoint.
int threads_of_checkpoint(const std::filesystem::path& file);
// File of the fields beside the checkpoint: impact.checkpoint.fields.h5.
std::filesystem::path fields_of_checkpoint(const std::filesystem::path& checkpoint);

// File of the scene's checkpoints, by default beside the results. InputError if another file has
// that name, except `restart` (may be empty), the checkpoint of a restart.
std::filesystem::path checkpoint_file(const CheckpointOptions& options,
                                      const std::filesystem::path& results,
                                      const std::filesystem::path& restart = {});

// Decides when the next checkpoint is due. Times and steps count from the start of the run, minutes
// from the last checkpoint.
class CheckpointClock {
 public:
  explicit CheckpointClock(const CheckpointOptions& options) : options_(options) {}
  void start_at(Index step, double t);
  bool is_due(Index step, double t);  // true once per checkpoint

 private:
  using Clock = std::chrono::steady_clock;
  double passed(double t) const;
  CheckpointOptions options_;
  Index steps_passed_ = 0;
  double times_passed_ = 0;
  Clock::time_point last_ = Clock::now();
};

}  // namespace cbr
