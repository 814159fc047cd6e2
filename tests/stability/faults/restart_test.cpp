// SPDX-License-Identifier: GPL-3.0-or-later
// A run that is interrupted after any step and goes on from its checkpoint gives every dataset of
// the results byte for byte.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <map>
#include <random>
#include <set>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/state_archive.hpp"
#include "dynamics/output/results.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::restart_test {
namespace {

using test::Ran;
using test::SceneFolder;

// Of a dataset of float64 or int64 with one or two dimensions.
std::vector<double> numbers(const Hdf5Reader& file, const std::string& name) {
  const bool is_table = file.shape(name).size() == 2;
  const auto listed = [](const auto& values) {
    return std::vector<double>(values.data(), values.data() + values.size());
  };
  try {
    return is_table ? listed(file.read_row_matrix(name)) : listed(file.read_vector(name));
  } catch (const std::exception&) {
    return is_table ? listed(file.read_index_table(name)) : listed(file.read_indices(name));
  }
}

// Names of all datasets, each with its numbers.
void collect(const Hdf5Reader& file, const std::string& group,
             std::map<std::string, std::vector<double>>& found) {
  for (const std::string& child : file.children(group)) {
    const std::string name = (group == "/" ? "" : group) + "/" + child;
    try {
      found[name] = numbers(file, name);
    } catch (const std::exception&) {
      found.erase(name);
      collect(file, name, found);
    }
  }
}

std::map<std::string, std::vector<double>> datasets(const Ran& ran,
                                                    const std::filesystem::path& file) {
  write_results(file, ran.built.simulation, ran.result, Report("test", Verbosity::quiet));
  std::map<std::string, std::vector<double>> found;
  collect(Hdf5Reader(file), "/", found);
  return found;
}

// Names of those that differ in any bit.
std::vector<std::string> differing(const std::map<std::string, std::vector<double>>& a,
                                   const std::map<std::string, std::vector<double>>& b) {
  std::vector<std::string> names;
  for (const auto& [name, values] : a) {
    const auto other = b.find(name);
    const bool same =
        other != b.end() && other->second.size() == values.size() &&
        std::memcmp(values.data(), other->second.data(), values.size() * sizeof(double)) == 0;
    if (!same) names.push_back(name);
  }
  if (a.size() != b.size()) names.push_back("their number");
  return names;
}

struct Saved {
  Index step = 0;
  std::vector<Index> words;
};

class Restart : public testing::Test {
 protected:
  Restart() {
    folder_.add("block.exo", test::block_mesh({{3, 6, 6}, {0.5, 1, 1}}));
    folder_.add("bar.exo", test::block_mesh({{4, 2, 2}, {1, 0.5, 0.5}}));
    folder_.add("plate.exo", test::block_mesh({{5, 5, 1}, {2, 2, 0.3}}));
  }

  // Steps that a run with contact is to be interrupted after: some in contact, some anywhere.
  std::set<Index> pick_steps(const Ran& whole, unsigned seed) const {
    std::mt19937 random(seed);
    const TimePlan& plan = whole.built.simulation.plan;
    std::vector<Index> touching;
    for (std::size_t i = 1; i + 1 < whole.result.time.size(); ++i)
      if (whole.result.active[i] > 0)
        for (Index s = 0; s < plan.steps_per_output; ++s)
          touching.push_back(static_cast<Index>(i) * plan.steps_per_output + s);
    std::set<Index> steps{1 +
                          static_cast<Index>(random() % static_cast<unsigned>(plan.n_steps() - 1))};
    for (int i = 0; i < 3 && !touching.empty(); ++i)
      steps.insert(touching[random() % touching.size()]);
    while (steps.size() < 4)
      steps.insert(1 + static_cast<Index>(random() % static_cast<unsigned>(plan.n_steps() - 1)));
    return steps;
  }

  // Goes on from `from`, ends after the step `until` (0: never) with what is kept there.
  Ran go_on(const std::string& yaml, const Saved& from, Index until, Saved& to) const {
    Ran ran = folder_.prepare(yaml);
    StateArchive state(from.words, "checkpoint");
    RunOptions options;
    options.restart = &state;
    Index taken = 0;
    options.is_checkpoint = [&](Index step, double) {
      taken = step;
      return until > 0 && step >= until;
    };
    options.on_checkpoint = [&](Index step, double, const StateArchive& kept) {
      to = {step, kept.words()};
    };
    options.is_to_end = [&] { return to.step > 0; };
    ran.result = run(ran.built.simulation, options);
    return ran;
  }

  void expect_same_after_restarts(const std::string& yaml, bool touches = true) {
    const Ran whole = folder_.run(yaml);
    ASSERT_EQ(whole.result.contact_steps > 0, touches);
    const auto expected = datasets(whole, folder_.folder() / "whole.h5");
    std::set<Index> steps = pick_steps(whole, seed_++);
    // One run is watched and goes on
    std::vector<Saved> saved;
    RunOptions options;
    options.is_checkpoint = [&](Index step, double) {
      return !steps.empty() && step >= *steps.begin();
    };
    options.on_checkpoint = [&](Index step, double, const StateArchive& state) {
      saved.push_back({step, state.words()});
      while (!steps.empty() && *steps.begin() <= step) steps.erase(steps.begin());
    };
    const auto watched = datasets(folder_.run(yaml, options), folder_.folder() / "watched.h5");
    EXPECT_EQ(differing(expected, watched), std::vector<std::string>()) << "watched";
    ASSERT_FALSE(saved.empty());
    for (const Saved& from : saved) {
      Saved none;
      const Ran ran = go_on(yaml, from, 0, none);
      EXPECT_EQ(differing(expected, datasets(ran, folder_.folder() / "on.h5")),
                std::vector<std::string>())
          << "after step " << from.step << " of " << whole.built.simulation.plan.n_steps();
    }
    // A second interruption of the first
    Saved again;
    const Ran ended = go_on(yaml, saved.front(), saved.back().step, again);
    if (again.step > 0) {
      Saved none;
      EXPECT_EQ(
          differing(expected, datasets(go_on(yaml, again, 0, none), folder_.folder() / "on.h5")),
          std::vector<std::string>())
          << "twice, after step " << again.step;
    }
    std::printf("%3zu datasets, %4d of %4d steps with contact; went on after steps",
                expected.size(), static_cast<int>(whole.result.contact_steps),
                static_cast<int>(whole.built.simulation.plan.n_steps()));
    for (const Saved& from : saved)
      std::printf(" %d (%zu kB)", static_cast<int>(from.step), from.words.size() / 128);
    std::printf("\n");
  }

  // Of `as` superelement or mesh: the left block flies into the right one, and slides on it.
  static std::string impact(const std::string& left, const std::string& right,
                            const std::string& contact, const std::string& time,
                            const std::string& more = "") {
    return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
           "components:\n  block: {mesh: block.exo, material: m, reduction: {interface: [x_min, "
           "x_max], modes: 15}}\n"
           "instances:\n  left: {component: block, as: " +
           left + ", velocity: [0.6, 0.2, 0.05]}\n  right: {component: block, as: " + right +
           ", position: [0.51, 0.03, 0.02], velocity: [-0.3, 0, 0]}\n"
           "contact:\n  - {between: [left.x_max, right.x_min]" +
           contact + "}\ntime: {end: 0.3" + time + "}\n" + more +
           "output: {every: 0.01, history: [left.x_max, right.x_min]}\n";
  }

  SceneFolder folder_;
  unsigned seed_ = 1;
};

const std::string pulse =
    "loads:\n  - {gravity: [0, 0, -0.3]}\n"
    "  - {instance: right, surface: x_max, force: [-1, 0, 0.2], history: {time: [0, 0.1, 0.21], "
    "value: [0, 1, 0.3]}}\n";

TEST_F(Restart, Superelements) {
  expect_same_after_restarts(impact("superelement", "superelement", "", ""));
  expect_same_after_restarts(impact("superelement", "superelement",
                                    ", friction: {static: 0.3, kinetic: 0.2, decay: 5}", "",
                                    pulse));
  expect_same_after_restarts(impact("superelement", "superelement", ", formulation: mortar", ""));
}

// The interface's forces, and velocities that are told from the step before.
TEST_F(Restart, Massless) {
  const auto massless = [](std::string yaml) {
    const std::string interface = "interface: [x_min, x_max]";
    return yaml.replace(yaml.find(interface), interface.size(), "basis: massless, " + interface);
  };
  expect_same_after_restarts(
      massless(impact("superelement", "superelement", ", friction: 0.3", "", pulse)));
  expect_same_after_restarts(
      massless(impact("superelement", "mesh", ", friction: 0.3", ", integrator: central-difference",
                      "boundary: [{instance: left, nodes: x_min, fix: [y, z]}]\n")));
}

// With another number of threads BLAS adds in another order: a run goes on with as many as it had.
TEST_F(Restart, WithThreads) {
  set_threads(2);
  expect_same_after_restarts(impact("superelement", "mesh", ", friction: 0.3", "", pulse));
  expect_same_after_restarts(
      impact("superelement", "superelement", "", ", integrator: newmark, step: 0.003", pulse));
  set_threads(1);
}

TEST_F(Restart, LongSteps) {
  for (const char* friction : {"", ", friction: 0.3"}) {
    expect_same_after_restarts(
        impact("superelement", "superelement", friction, ", step: {cfl: 3}",
               pulse + "boundary: [{instance: right, nodes: x_max, fix: [x]}]\n"));
  }
}

TEST_F(Restart, Newmark) {
  for (const char* alpha : {"", ", alpha: -0.2"})
    for (const char* right : {"superelement", "mesh"})
      expect_same_after_restarts(impact("superelement", right, ", friction: 0.2",
                                        std::string(", integrator: newmark, step: 0.0013") + alpha,
                                        pulse));
  folder_.diagonal_limit = 0;
  expect_same_after_restarts(impact("superelement", "superelement", "",
                                    ", integrator: newmark, step: 0.0013, alpha: -0.1", pulse));
}

TEST_F(Restart, Meshes) {
  const std::string held = pulse + "boundary: [{instance: right, nodes: x_max, fix: [x, y]}]\n";
  expect_same_after_restarts(impact("mesh", "mesh", "", "", held));
  expect_same_after_restarts(impact(
      "mesh", "mesh",
      ", friction: {static: 0.3, kinetic: 0.2, decay: 5}, enforcement: penalty, damping: 0.1", "",
      held));
  expect_same_after_restarts(
      impact("mesh", "mesh", ", enforcement: nodal", ", integrator: central-difference"));
}

TEST_F(Restart, CentralDifferences) {
  const std::string time = ", integrator: central-difference";
  expect_same_after_restarts(impact(
      "superelement", "mesh", ", friction: {static: 0.3, kinetic: 0.2, decay: 5}", time, pulse));
  expect_same_after_restarts(
      impact("superelement", "superelement", ", formulation: two-way, enforcement: penalty", time));
  const std::string skin =
      "skin: {surfaces: [x_max, x_min], youngs_modulus: 100, poissons_ratio: 0.3, density: 1, "
      "thickness: 0.01}\n";
  expect_same_after_restarts(impact("superelement", "mesh", "", time, skin));
  folder_.diagonal_limit = 0;
  expect_same_after_restarts(impact("superelement", "superelement", "", time, pulse));
}

// All in one: superelements, one of them in domains and held, a mesh, ties, a wall, bodies at rest
// and bodies that fly aside.
TEST_F(Restart, MixedScenes) {
  const std::string scene =
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}, soft: "
      "{youngs_modulus: 20, poissons_ratio: 0.1, "
      "density: 2}}\n"
      "components:\n"
      "  bar: {mesh: bar.exo, material: m, reduction: {interface: [x_min, x_max, z_min], modes: "
      "12}}\n"
      "  cut: {mesh: bar.exo, material: soft, reduction: {interface: [x_min, x_max], modes: 6, "
      "domains: 2, superelement: cut.h5}}\n"
      "  plate: {mesh: plate.exo, material: m}\n"
      "instances:\n"
      "  a: {component: bar, as: superelement, velocity: [0.5, 0, -0.2], position: [0, 0, 0.32]}\n"
      "  b: {component: bar, as: superelement, position: [1.03, 0.02, 0.33]}\n"
      "  c: {component: cut, as: superelement, position: [2.06, 0, 0.33]}\n"
      "  aside: {component: bar, as: superelement, position: [0, 3, 0.4], velocity: [0.4, 0, 0]}\n"
      "  resting: {component: bar, as: superelement, position: [1.2, 3, 0.4]}\n"
      "  plate: {component: plate, as: mesh, position: [-0.4, -0.7, 0]}\n"
      "  on: {component: bar, as: superelement, position: [0.1, 0.03, 0.85]}\n"
      "walls: {floor: {plane: {point: [0, 0, -0.01], normal: [0, 0, 1]}}}\n"
      "boundary: [{instance: c, nodes: x_max, fix: [x, y, z]}]\n"
      "contact:\n  - all\n";
  const std::string rest =
      "contact:\n  - {between: all, friction: 0.1}\n  - {between: [a.z_min, plate.z_max], "
      "friction: 0.2}\n"
      "  - {between: [plate.z_min, floor], enforcement: penalty}\n"
      "time: {end: 1.2}\noutput: {every: 0.02, history: [a.x_max, plate.z_max, c.x_min]}\n";
  const std::string loads = "loads: [{instance: plate, surface: z_max, traction: [0, 0, -0.05]}]\n";
  expect_same_after_restarts(scene.substr(0, scene.find("contact:")) + loads + rest);
}

TEST_F(Restart, SkipsOnAsBefore) {
  std::string scene =
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  bar: {mesh: bar.exo, material: m, reduction: {interface: [x_min, x_max], "
      "modes: 12}}\n"
      "instances:\n  a: {component: bar, as: superelement, velocity: [0.3, 0, 0]}\n"
      "  b: {component: bar, as: superelement, position: [1.2, 0.01, 0.02]}\n";
  for (int i = 0; i < 6; ++i)
    scene += "  o" + std::to_string(i) + ": {component: bar, as: superelement, position: [" +
             std::to_string(1.3 * (i % 3)) + ", 2, " + std::to_string(i / 3) + "], velocity: [" +
             std::to_string(0.1 - 0.1 * (i % 3)) + ", -0.4, 0]}\n";
  expect_same_after_restarts(
      scene + "contact: all\ntime: {end: 5}\noutput: {every: 0.25, history: [a.x_max, b.x_min]}\n");
}

// Histories of stress, the worst elements and envelopes, and a sensor inside.
TEST_F(Restart, Stress) {
  for (const char* right : {"superelement", "mesh"}) {
    std::string yaml = impact("superelement", right, "", "", pulse);
    const auto replace = [&](const std::string& old, const std::string& with) {
      yaml.replace(yaml.find(old), old.size(), with);
    };
    replace("modes: 15}", "modes: 15, recovery: true}");
    replace("history: [left.x_max, right.x_min]}",
            "history: [left.x_max, right.x_min, left.y_min], stress: [left.x_max, {instance: left, "
            "elements: [5], worst: 4, envelope: true}, {instance: right, envelope: true}]}");
    expect_same_after_restarts(yaml);
  }
}

TEST_F(Restart, TiedSurfaces) {
  for (const char* formulation : {"node-face", "mortar"})
    for (const char* integrator : {"exact", "newmark, step: 0.004"})
      expect_same_after_restarts(
          "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
          "components:\n  block: {mesh: block.exo, material: m, reduction: {interface: [x_min, "
          "x_max], modes: 8}}\n"
          "  bar: {mesh: bar.exo, material: m, reduction: {interface: [x_min, x_max], modes: 8}}\n"
          "instances:\n  block: {component: block, as: superelement}\n"
          "  bar: {component: bar, as: superelement, position: [0.5, 0.21, 0.22], velocity: [0.2, "
          "0, 0]}\n"
          "contact: [{between: [block.x_max, bar.x_min], tied: true, formulation: " +
          std::string(formulation) + "}]\ntime: {end: 0.5, integrator: " + integrator +
          "}\noutput: {every: 0.05, history: [bar.x_min]}\n");
}

// The words are those of the scene or are refused, whatever they are.
TEST_F(Restart, StatesOfOtherScenesAreRefused) {
  const std::string one = impact("superelement", "superelement", "", ""),
                    other = impact("superelement", "mesh", "", "");
  Saved saved;
  RunOptions options;
  options.is_checkpoint = [](Index step, double) { return step == 7; };
  options.on_checkpoint = [&](Index step, double, const StateArchive& state) {
    saved = {step, state.words()};
  };
  folder_.run(one, options);
  ASSERT_EQ(saved.step, 7);
  Saved none;
  EXPECT_THROW(go_on(other, saved, 0, none), InputError);
  Saved shorter = saved, longer = saved;
  shorter.words.pop_back();
  longer.words.push_back(0);
  EXPECT_THROW(go_on(one, shorter, 0, none), InputError);
  EXPECT_THROW(go_on(one, longer, 0, none), InputError);
  EXPECT_THROW(go_on(one, {}, 0, none), InputError);
}

}  // namespace
}  // namespace cbr::restart_test
