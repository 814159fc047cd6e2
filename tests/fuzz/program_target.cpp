// SPDX-License-Identifier: GPL-3.0-or-later
// A scene through the three programs, in this process, on the small meshes of its folder and
// nothing else of the file system.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/base/error.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/build.hpp"
#include "reducer/command.hpp"
#include "tests/fuzz/run_scene.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::fuzz {
namespace {

constexpr Index most_steps = 20;

bool finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); });
}

void check_result(const RunResult& result) {
  for (const auto& body : result.bodies) {
    for (const Series3* series : {&body.center_of_mass, &body.momentum, &body.angular_momentum})
      require(finite(series->values), "a body's motion is not finite");
    require(finite(body.kinetic_energy) && finite(body.strain_energy),
            "a body's energy is not finite");
  }
  for (const auto& monitor : result.monitors)
    for (const Series3* series : {&monitor.mean_position, &monitor.mean_velocity, &monitor.force})
      require(finite(series->values), "a surface's motion is not finite");
  for (const auto& pair : result.pairs)
    for (const Series3& series : pair.series)
      require(finite(series.values), "a pair's figures are not finite");
  for (const auto* values :
       {&result.time, &result.total, &result.work_external, &result.work_contact,
        &result.work_friction, &result.work_damping, &result.work_numerical, &result.active})
    require(finite(*values), "an energy is not finite");
}

const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const auto made = scratch().path() / "program";
    std::filesystem::create_directories(made);
    Mesh mesh = test::block_mesh({{2, 2, 1}});
    mesh.nodesets.push_back({"clamp", 1, {0, 3}});
    mesh.nodesets.push_back({"point", 2, {0}});
    write_mesh(mesh, made / "block.exo");
    write_mesh(test::block_mesh({{1, 1, 1}, Vector3(1, 1, 0.5)}), made / "cell.exo");
    return made;
  }();
  return path;
}

// Meshes that are not there become one that is, and nothing is written elsewhere.
void confine(Scene& scene) {
  int n = 0;
  for (auto& [name, component] : scene.components) {
    if (component.mesh != folder() / "cell.exo") component.mesh = folder() / "block.exo";
    if (component.reduction)
      component.reduction->superelement = folder() / (std::to_string(++n) + ".cbr.h5");
  }
  if (scene.skin) scene.skin.reset();  // cbr-skin's part
}

}  // namespace

Scene reduced_scene(const std::string& file) {
  set_threads(1);
  ReduceCommand command;
  command.input = file;
  Report report("cbr-reduce", Verbosity::quiet);
  run_reduce(command, nullptr, report);
  return read_scene(file);
}

void run_briefly(const Scene& scene) {
  try {
    Report report("cbr-dyn", Verbosity::quiet);
    BuiltScene built = build(scene, report);
    TimePlan& plan = built.simulation.plan;
    if (plan.n_steps() > most_steps) {
      plan.n_whole = std::min(plan.n_whole, most_steps);
      plan.n_rest = 0;
      plan.end = static_cast<double>(plan.n_whole) * plan.h;
    }
    check_result(cbr::run(built.simulation));
  } catch (const InputError&) {
  } catch (const RunError&) {
  }
}

void program(Bytes bytes) {
  folder();
  const ScratchFile file(".yaml", bytes), confined(".yaml");
  Scene scene;
  try {
    scene = read_scene(file.path().string());
    confine(scene);
    std::ostringstream text;
    write_scene(scene, text);
    test::write_bytes(confined.path(), text.str());
    scene = reduced_scene(confined.path().string());
  } catch (const InputError&) {
    return;
  } catch (const RunError&) {
    return;
  }
  run_briefly(scene);
}

}  // namespace cbr::fuzz
