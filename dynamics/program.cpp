// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/program.hpp"

#include <memory>
#include <optional>

#include "common/error.hpp"
#include "common/output_file.hpp"
#include "common/scene.hpp"
#include "dynamics/output/fields.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/setup/build.hpp"

namespace cbr {
namespace {

// InputError when the results cannot be written where they are to go: found before the run and not after it.
void check_target(const Scene& scene, const std::filesystem::path& results) {
  const auto refuse = [&](const std::filesystem::path& input, const std::string& what) {
    std::error_code missing;
    if (std::filesystem::equivalent(input, results, missing))
      throw InputError(results.string() + ": the results would replace " + what + ": give --output another name");
  };
  if (scene.file != "-") refuse(scene.file, "the scene");
  for (const auto& [name, component] : scene.components) {
    refuse(component.mesh, "the mesh of component '" + name + "'");
    if (component.reduction) refuse(component.reduction->superelement, "the superelement of component '" + name + "'");
  }
  const TemporaryFile probe(results);
}

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
  report.count("outputs", static_cast<double>(result.time.size()));
}

}  // namespace

void run_scene(const std::string& scene_or_dash, const std::filesystem::path& results, Report& report,
               const BuildOptions& build_options) {
  std::optional<Scene> scene;
  {
    const auto phase = report.phase("read");
    scene = read_scene(scene_or_dash);
  }
  check_target(*scene, results);
  BuiltScene built = build(*scene, report, build_options);
  RunOptions options;
  options.on_progress = [&](double fraction) { report.progress("stepping", fraction); };
  std::unique_ptr<FieldWriter> fields;
  if (!scene->output.fields.empty()) {
    fields = std::make_unique<FieldWriter>(*scene, built, results, report);
    options.on_output = [&](Index, double t) { fields->add(t); };  // counted with the steps
  }
  RunResult result;
  {
    const auto phase = report.phase("steps");
    result = run(built.simulation, options);
  }
  report.end_progress();
  {
    const auto phase = report.phase("write");
    write_results(results, built.simulation, result, report);
    if (fields) fields->commit();
  }
  count_work(built.simulation, result, report);
  summarise(built, result, report);
  report.line("results: " + results.string() + (fields ? ", fields: " + fields->file().string() : ""));
  report.timings();
}

}  // namespace cbr
