// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/checkpoint.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

constexpr const char* format_name = "cbr-checkpoint";
// Increase when the contents of a keep_state() change: older files cannot be read then.
constexpr const char* format_version = "1.19";

// Hash of all data that a restarted run reads from the file.
std::string hash_of(const Checkpoint& checkpoint, const std::vector<Index>& words) {
  const auto text = [](const auto* values, std::size_t n) {
    return bytes_hash({reinterpret_cast<const char*>(values), n * sizeof *values});
  };
  const Index whole[] = {checkpoint.step, checkpoint.threads, checkpoint.fields_digest};
  return bytes_hash(text(words.data(), words.size()) +
                    text(checkpoint.field_times.data(), checkpoint.field_times.size()) +
                    join(checkpoint.warnings, "\n") + text(&checkpoint.time, 1) + text(whole, 3));
}

void require_checkpoint(const Hdf5Reader& file) {
  if (!file.has_attribute("/", "format") || file.read_string("/", "format") != format_name)
    throw InputError(file.file().string() + ": is not a checkpoint of cbr-dyn");
}

bool is_checkpoint(const fs::path& file) {
  try {
    require_checkpoint(Hdf5Reader(file));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

// Calls `read` and adds the cure to errors.
template <typename Read>
auto from_checkpoint(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    const std::string what = error.what();
    throw InputError(what.find("--restart") != std::string::npos
                         ? what
                         : what +
                               ": give --restart a checkpoint of this run that is whole, or start "
                               "the run again without --restart");
  }
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string generator() { return std::string("cbr-dyn ") + version(); }

}  // namespace

std::string run_hash(const Scene& scene, const BuildOptions& options) {
  Scene plain = scene;
  plain.output.checkpoint.reset();
  if (plain.skin) plain.skin->mesh = "/";  // part of cbr-skin
  std::set<std::string> meshed, reduced;
  for (const Instance& instance : scene.instances)
    (instance.as == InstanceKind::superelement ? reduced : meshed).insert(instance.component);
  for (auto& [name, component] : plain.components) {
    component.mesh = "/" + (meshed.count(name) ? mesh_hash(component.mesh) : "");
    if (!component.reduction) continue;
    fs::path& superelement = component.reduction->superelement;
    superelement = "/" + (reduced.count(name) ? file_hash(superelement) : "");
  }
  std::ostringstream text;
  text << "diagonal limit "
       << (options.diagonal_limit ? std::to_string(*options.diagonal_limit) : "") << "\n";
  write_scene(plain, text);
  return bytes_hash(text.str());
}

void write_checkpoint(const fs::path& file, const std::string& hash, const Checkpoint& checkpoint,
                      const StateArchive& state) {
  Hdf5Writer out(file);
  out.start(format_name, format_version, "cbr-dyn");
  out.attribute("/", "run_hash", hash);
  out.attribute("/", "state_hash", hash_of(checkpoint, state.words()));
  out.attribute("/", "fields_digest", checkpoint.fields_digest);
  out.attribute("/", "warnings", join(checkpoint.warnings, "\n"));
  out.attribute("/", "threads", Index{checkpoint.threads});
  out.attribute("/", "step", checkpoint.step);
  out.write("/time", checkpoint.time);
  out.write("/state", state.words());
  out.write("/field_times", checkpoint.field_times);
  out.commit();
}

bool is_checkpoint_of(const fs::path& file, const std::string& hash) {
  return from_checkpoint([&] {
    const Hdf5Reader in(file);
    require_checkpoint(in);
    return in.read_string("/", "run_hash") == hash;
  });
}

int threads_of_checkpoint(const fs::path& file) {
  return from_checkpoint([&] {
    const Hdf5Reader in(file);
    require_checkpoint(in);
    return static_cast<int>(std::clamp<Index>(in.read_index("/", "threads"), 1, 1024));
  });
}

static std::pair<Checkpoint, StateArchive> read_whole(const fs::path& file,
                                                      const std::string& hash) {
  const Hdf5Reader in(file);
  require_checkpoint(in);
  const std::string by = in.read_string("/", "generator"),
                    version_of_file = in.read_string("/", "format_version");
  if (by != generator() || version_of_file != format_version)
    throw InputError(
        file.string() + ": was written by " + by + " (format " + version_of_file + "), this is " +
        generator() + " (format " + format_version +
        "), which may not go on with the same digits: start the run again, without --restart");
  if (in.read_string("/", "run_hash") != hash)
    throw InputError(
        file.string() +
        ": is of another scene, or the scene, its meshes, its superelements or --diagonal-limit "
        "have " +
        "changed since: give the checkpoint of this run, or start it again without --restart");
  Checkpoint checkpoint;
  checkpoint.step = in.read_index("/", "step");
  checkpoint.threads = static_cast<int>(in.read_index("/", "threads"));
  checkpoint.time = in.read_scalar("/time");
  checkpoint.fields_digest = in.read_index("/", "fields_digest");
  checkpoint.warnings = lines_of(in.read_string("/", "warnings"));
  std::vector<Index> state = in.read_indices("/state");
  const Vector times = in.read_vector("/field_times");
  checkpoint.field_times.assign(times.begin(), times.end());
  if (hash_of(checkpoint, state) != in.read_string("/", "state_hash"))
    throw InputError(file.string() +
                     ": is damaged: the hash of its state is not the one that it names");
  return {std::move(checkpoint), StateArchive(std::move(state), file.string())};
}

std::pair<Checkpoint, StateArchive> read_checkpoint(const fs::path& file, const std::string& hash) {
  return from_checkpoint([&] { return read_whole(file, hash); });
}

fs::path fields_of_checkpoint(const fs::path& checkpoint) {
  fs::path file = checkpoint;
  return file.replace_extension(".fields.h5");
}

fs::path checkpoint_file(const CheckpointOptions& options, const fs::path& results,
                         const fs::path& restart) {
  fs::path file = options.file;
  if (file.empty()) file = fs::path(results).replace_extension(".checkpoint.h5");
  std::error_code error;
  const bool same = is_same_file(file, results);
  // read_checkpoint() reports its defects
  if (!same && !restart.empty() && is_same_file(file, restart)) return file;
  if (same || (fs::exists(file, error) && !is_checkpoint(file)))
    throw InputError(options.source.text() + ": output.checkpoint: " + file.string() +
                     (same ? " is the results file" : " exists and is not a checkpoint") +
                     ": give output.checkpoint.file another name" +
                     (same ? "" : ", or remove it if it is a damaged one"));
  return file;
}

// Number of whole intervals up to t; an interval missed by round-off counts.
double CheckpointClock::passed(double t) const {
  return options_.every ? std::floor(t / *options_.every * (1 + 1e-12)) : 0;
}

void CheckpointClock::start_at(Index step, double t) {
  if (options_.every_steps) steps_passed_ = step / *options_.every_steps;
  times_passed_ = passed(t);
}

bool CheckpointClock::is_due(Index step, double t) {
  bool due = passed(t) > times_passed_;
  if (options_.every_steps) due |= step / *options_.every_steps > steps_passed_;
  if (options_.every_minutes)
    due |= Clock::now() - last_ >= std::chrono::duration<double>(60 * *options_.every_minutes);
  if (!due) return false;
  start_at(step, t);
  last_ = Clock::now();
  return true;
}

}  // namespace cbr
