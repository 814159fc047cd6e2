// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/program.hpp"

#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>
#include <ostream>
#include <sstream>

#include "common/app/program.hpp"
#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/process.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/output/fields.hpp"
#include "dynamics/output/output_names.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/output/summary/progress.hpp"
#include "dynamics/output/summary/summary.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/build.hpp"
#include "dynamics/setup/components/component_model.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"

namespace cbr {
namespace {

void count_work(const Simulation& simulation, const RunResult& result, Report& report) {
  Index n_dofs = 0;
  for (const auto& body : simulation.bodies) n_dofs += body->n_dofs();
  report.count("dofs", static_cast<double>(n_dofs));
  report.count("steps_planned", static_cast<double>(simulation.plan.n_steps()));
  report.count("steps", static_cast<double>(result.steps));
  report.count("jumps", static_cast<double>(result.jumps));
  report.count("contact_steps", static_cast<double>(result.contact_steps));
  report.count("contact_rows", result.contact_rows);
  report.count("body_steps", static_cast<double>(result.work.body_steps));
  report.count("pair_looks", static_cast<double>(result.work.pair_looks));
  report.count("pair_searches", static_cast<double>(result.work.pair_searches));
  report.count("motion_bounds", static_cast<double>(result.work.bounds));
  report.part("steps", "bodies", result.seconds.bodies);
  report.part("steps", "search", result.seconds.search);
  report.part("steps", "response", result.seconds.response);
  report.part("steps", "contact", result.seconds.contact);
  report.part("steps", "output", result.seconds.output);
  report.count("outputs", static_cast<double>(result.time.size()));
}

UnchangedFiles files_of(const Scene& scene) {
  UnchangedFiles inputs;
  for (const Instance& instance : scene.instances) {
    const Component& component = component_of(scene, instance);
    if (component.has_mesh)
      for (const auto& file : mesh_files(component.mesh)) inputs.add(file);
    if (instance.as == InstanceKind::superelement && component.reduction)
      inputs.add(component.reduction->superelement);
  }
  return inputs;
}

// One run, from a built scene to its files.
class Run {
 public:
  // signals: noted from here on, also for a second run.
  Run(const Scene& scene, BuiltScene& built, const RunInputs& inputs,
      const std::filesystem::path& results, std::optional<NotedSignals>& signals, Report& report)
      : scene_(scene),
        built_(built),
        results_(results),
        report_(report),
        inputs_(inputs),
        signals_(signals ? *signals : signals.emplace()) {}

  // Checkpoints to write, one to restart from, or both.
  void use_checkpoints(const std::filesystem::path& restart) {
    if (scene_.output.checkpoint) {
      file_ = checkpoint_file(*scene_.output.checkpoint, results_, restart);
      clock_.emplace(*scene_.output.checkpoint);
    }
    if (restart.empty()) return;
    auto [from, state] = read_checkpoint(restart, inputs_.hash);
    std::ostringstream line;
    line << "going on from step " << from.step << ", t = " << from.time << " s ("
         << restart.string() << ")";
    report_.line(line.str());
    if (from.threads != n_threads()) {
      report_.warning(restart.string() + ": the run was begun with " +
                      std::to_string(from.threads) + " threads and goes on with " +
                      std::to_string(n_threads()) +
                      ": last digits will differ; without --threads it takes as many as it had");
    }
    report_.recall(from.warnings);
    if (clock_) clock_->start_at(from.step, from.time);
    saved_fields_ = {fields_of_checkpoint(restart), std::move(from.field_times),
                     from.fields_digest};
    state_ = std::move(state);
    begun_at_ = from.time;
    has_told_overlaps_ = true;
  }

  bool is_restarted() const { return state_.has_value(); }

  RunResult run() {
    RunOptions options;
    RunProgress progress(report_, "stepping", built_.simulation.plan.end,
                         begun_at_ / built_.simulation.plan.end);
    options.on_progress = [&](double fraction) { progress.at(fraction); };
    RunProgress statics(report_, "statics", built_.simulation.plan.end);
    options.on_load_step = [&](Index done, Index all, Index iteration) {
      statics.at(static_cast<double>(done) / static_cast<double>(all),
                 "load step " + std::to_string(done + (iteration > 0)) + " of " +
                     std::to_string(all) +
                     (iteration > 0 ? ", iteration " + std::to_string(iteration) : ""));
    };
    if (!scene_.output.fields.empty()) {
      fields_ = std::make_unique<FieldWriter>(scene_, built_, results_, report_, inputs_.hash,
                                              saved_fields_);
    }
    options.on_output = [this](Index, double t) {
      if (fields_) fields_->add(t);  // counted with the steps
      built_.gaps.look(built_.simulation);
      built_.strains.look(built_.simulation, t);
    };
    options.is_to_end = [this] {
      tell_overlaps();
      return signals_.any();
    };
    if (clock_) {
      // A run ended by a signal can be continued from there
      options.is_checkpoint = [this](Index step, double t) {
        return clock_->is_due(step, t) || signals_.any();
      };
      options.on_checkpoint = [this](Index step, double t, const StateArchive& state) {
        save(step, t, state);
      };
    }
    options.turn_limit = built_.turn_limit;
    if (state_) options.restart = &*state_;
    const auto phase = report_.phase("steps");
    rest_blas_threads();
    RunResult result = cbr::run(built_.simulation, options);
    report_.end_progress();
    tell_overlaps();
    return result;
  }

  void write(const RunResult& result) {
    const auto phase = report_.phase("write");
    try {
      // The results last, so that new results have their fields beside them
      if (fields_) fields_->commit();
      write_results(results_, built_.simulation, result, report_, inputs_,
                    share_outside_basis(built_, result));
    } catch (const std::runtime_error& error) {
      // Also for InputError: a folder of the inputs may have been removed
      throw RunError(error.what() + (result.ended_at ? "; " + end_text(result) : "") +
                     restart_text());
    }
  }

  void finish(const RunResult& result) {
    const std::string fields = fields_ ? ", fields: " + fields_->file().string() : "";
    report_.line("results: " + results_.string() + fields);
    report_.timings();
    if (!result.ended_at) return;
    if (result.preload_reached)
      throw RunError(result.failure + "; " + results_.string() + ": holds load step " +
                     std::to_string(*result.preload_reached) + " of " +
                     std::to_string(built_.simulation.preload) +
                     " before the time 0 as the output of t = 0");
    if (!result.failure.empty())
      throw RunError(result.failure + "; " + results_.string() +
                     format_text(": holds the outputs up to t = %.4g s", *result.ended_at));
    throw RunError(results_.string() + ": " + end_text(result) + ": holds the outputs up to there" +
                   restart_text());
  }

 private:
  // Reports overlaps right after contact has found them, as the run may not be worth its time.
  void tell_overlaps() {
    if (has_told_overlaps_) return;
    has_told_overlaps_ = true;
    warn_of_initial_overlaps(built_, report_);
  }

  std::string end_text(const RunResult& result) const {
    if (!result.failure.empty()) return result.failure;
    std::ostringstream text;
    text << "stopped by " << signals_.name() << " at t = " << *result.ended_at << " s of "
         << built_.simulation.plan.end << " s, after "
         << steps_done(built_.simulation, result.reached);
    return text.str();
  }

  std::string restart_text() const {
    if (!saved_at_) return "";
    std::ostringstream text;
    text << ", --restart " << file_.string() << " goes on from t = " << *saved_at_ << " s";
    return text.str();
  }

  void save(Index step, double t, const StateArchive& state) {
    std::ostringstream place;
    place << "checkpoint at t = " << t << " s: ";
    try {
      // Fields first: extra ones beside the old checkpoint do no harm, missing ones beside the new
      // one would
      if (fields_) fields_->save(fields_of_checkpoint(file_));
      Checkpoint checkpoint{step, t, {}, 0, n_threads(), report_.warnings()};
      if (fields_) {
        checkpoint.field_times = fields_->times();
        checkpoint.fields_digest = fields_->digest();
      }
      write_checkpoint(file_, inputs_.hash, checkpoint, state);
      report_.detail(place.str() + file_.string());
      has_failed_ = false;
      saved_at_ = t;
    } catch (const std::runtime_error& error) {  // InputError: its folder has been removed
      // A failed checkpoint must not end a long run
      if (!has_failed_)
        report_.warning(place.str() + error.what() +
                        "; the run goes on, the checkpoint of before stays");
      has_failed_ = true;
    }
  }

  const Scene& scene_;
  BuiltScene& built_;
  const std::filesystem::path results_;
  Report& report_;
  const RunInputs& inputs_;
  const NotedSignals& signals_;
  std::filesystem::path file_;
  double begun_at_ = 0;  // time of the checkpoint of a restart
  bool has_told_overlaps_ = false;
  bool has_failed_ = false;         // to write the last checkpoint
  std::optional<double> saved_at_;  // time of the last one written
  std::optional<CheckpointClock> clock_;
  std::optional<StateArchive> state_;
  std::optional<FieldWriter::Saved> saved_fields_;
  std::unique_ptr<FieldWriter> fields_;
};

// Arguments of run_scene() except the scene.
struct RunCommand {
  std::filesystem::path results, restart;
};

// With `rotations: auto`: whether the run of the checkpoint had large rotation.
bool turns_in_checkpoint(const Scene& scene, BuildOptions options,
                         const std::filesystem::path& restart) {
  if (restart.empty() || !scene.time || scene.time->rotations != Rotations::automatic) return false;
  options.turns = true;
  return is_checkpoint_of(restart, run_hash(with_rotations(scene, options), options));
}

void say_that_it_starts_again(const Simulation& simulation, const RunResult::Turned& turned,
                              Report& report) {
  report.line(format_text(
      "instance '%s' has turned by %.3g degrees at t = %.4g s, too far for a linear body: the run "
      "starts again with bodies that turn (time: {rotations: large} saves the first part)",
      simulation.bodies[turned.body]->name().c_str(), turned.rotation * 180 / std::numbers::pi,
      turned.t));
}

// False: a body has exceeded the rotation limit of linear bodies, or will; writes nothing.
bool run_once(const Scene& scene, const BuildOptions& options, const RunCommand& command,
              const UnchangedFiles& inputs, std::optional<NotedSignals>& signals, Report& report) {
  const bool is_again = signals.has_value();
  BuiltScene built = build(scene, report, options);
  // A checkpoint without large rotation goes on without it
  if (!built.will_turn.empty() && command.restart.empty()) {
    report.line(built.will_turn);
    report.start_again();
    return false;
  }
  refuse_names_that_meet(built.simulation);
  require_memory_for_outputs(scene, built.simulation, machine_memory_bytes());
  RunInputs from;
  {
    const auto phase = report.phase("read");
    from = inputs_of(scene, run_hash(with_rotations(scene, options), options), command.results);
  }
  inputs.check();
  Run run(scene, built, from, command.results, signals, report);
  run.use_checkpoints(command.restart);
  announce(built, is_again, report);
  const RunResult result = run.run();
  if (result.turned && !result.ended_at) {
    say_that_it_starts_again(built.simulation, *result.turned, report);
    report.start_again();
    return false;
  }
  count_work(built.simulation, result, report);
  // before writing, as the results include its warnings
  summarise(built, result, run.is_restarted(), report);
  run.write(result);
  run.finish(result);
  return true;
}

Scene read_timed(const std::string& scene_or_dash, Report& report) {
  const auto phase = report.phase("read");
  Scene scene = read_scene(scene_or_dash);
  place_instances(scene, report);
  return scene;
}

}  // namespace

void run_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
               Report& report, const BuildOptions& build_options,
               const std::filesystem::path& restart, const std::filesystem::path& timings) {
  const Scene scene = read_timed(scene_or_dash, report);
  check_outputs(scene, {results, restart, timings});
  const UnchangedFiles inputs = files_of(scene);
  BuildOptions options = build_options;
  options.turns = turns_in_checkpoint(scene, options, restart);
  RunCommand command{results, restart};
  std::optional<NotedSignals> signals;
  if (run_once(scene, options, command, inputs, signals, report)) return;
  options.turns = true;
  command.restart.clear();
  run_once(scene, options, command, inputs, signals, report);
}

void print_modes(const std::string& scene_or_dash, Index n, const std::filesystem::path& results,
                 Report& report, std::ostream& out) {
  Scene scene = read_timed(scene_or_dash, report);
  scene.output.checkpoint.reset();
  if (results.empty()) scene.output.fields.clear();
  std::erase_if(scene.output.fields,
                [](const std::string& field) { return field.starts_with("contact_"); });
  if (!results.empty() && scene.output.fields.empty()) scene.output.fields = {"displacement"};
  if (!results.empty()) check_outputs(scene, {results, {}, {}, "cbr-modes"});
  SceneModes modes = scene_modes(scene, n, report);
  if (!results.empty()) write_modes(results, modes, report);
  out << "instance,mode,frequency_hz,damping_ratio\n";
  out.precision(10);
  for (const InstanceModes& of : modes.instances)
    for (Index j = 0; j < of.frequency_hz.size(); ++j)
      out << of.instance << "," << j + 1 << "," << of.frequency_hz[j] << "," << of.damping_ratio[j]
          << "\n";
  out.flush();
}

void sweep_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
                 Report& report) {
  Scene scene = read_timed(scene_or_dash, report);
  scene.output.checkpoint.reset();
  scene.output.fields.clear();
  check_outputs(scene, {results, {}, {}, "cbr-sweep", sweep_table(results)});
  const HarmonicResponse response = harmonic_response(scene, report);
  const auto phase = report.phase("write");
  write_sweep(results, response);
  report.line("sweep: " + results.string() + ", " + sweep_table(results).string());
}

void require_output(Index modes, bool sweep, const std::string& output,
                    const std::string& restart) {
  if (modes > 0 && sweep) throw InputError("--modes and --sweep are two things: give one of them");
  if ((modes > 0 || sweep) && !restart.empty())
    throw InputError((sweep ? std::string("--sweep") : std::string("--modes")) +
                     " runs nothing: leave out --restart");
  if (modes == 0 && output.empty())
    throw InputError("--output is required: give -o RESULTS.h5" +
                     std::string(sweep ? "" : ", or --modes N"));
}

}  // namespace cbr
