// SPDX-License-Identifier: GPL-3.0-or-later
// Points, links and ties of bodies that turn by any angle: what they keep, loads on points,
// restart, and what is refused. Mechanisms: turning_mechanisms_test.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/files/hdf5_file.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/linked_blocks.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"

namespace cbr::turning_links_test {
namespace {

using test::at;
using test::gravity;
using test::Ran;
using test::reduced;
using test::text;
using test::yaml;

class TurningLinks : public test::LinkedBlocks {};

// Largest change of a sum over all bodies, of the largest of it.
double drift(const Ran& ran, Series3 RunResult::OfBody::*of) {
  double largest = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i)
    largest = std::max(largest, test::total(ran.result, of, i).norm());
  return test::largest_change(ran.result, of) / largest;
}

const std::string askew =
    "  a: {component: block, as: rigid, angular_velocity: [1, 2, 3]}\n"
    "  b: {component: block, as: rigid, position: [0.4, 0, 0], velocity: [0.1, 1, -0.8], "
    "angular_velocity: [-2, 5, 1]}\n";

// Whatever two free bodies have between them, it keeps their momentum and angular momentum. What
// it loses of the energy is what the first step takes, as the bodies start askew.
TEST_F(TurningLinks, EveryLinkKeepsMomentumAndAngularMomentum) {
  for (const char* link :
       {"fix: [x, y, z]", "fix: [x, y, z, rx, ry]", "fix: [x, y, z, rx]",
        "fix: [x, y, z, rx, ry, rz]", "fix: [y, z, rx, ry, rz]", "fix: [x, y, rx, ry]", "fix: [z]",
        "stiffness: [40, 30, 20, 0.1, 0.2, 0.3]",
        "stiffness: [40, 30, 20, 0, 0, 0], damping: [0, 0, 0, 0.001, 0.002, 0.001]",
        "fix: [z, ry], stiffness: [10, 10, 0, 0.1, 0, 0.1]"}) {
    std::array<double, 3> energies{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Ran ran = run({.instances = askew,
                           .links = std::string("  - {between: [a.tip, b.base], ") + link + "}\n",
                           .time = "end: 1, step: " + text(0.004 / (1 << k))});
      EXPECT_LT(drift(ran, &RunResult::OfBody::momentum), 1e-12) << link;
      EXPECT_LT(drift(ran, &RunResult::OfBody::angular_momentum), 1e-12) << link;
      EXPECT_LT(test::energy_residual(ran.result), 1e-11) << link;
      energies[k] = ran.result.total.back();
    }
    // of second order in the step
    EXPECT_NEAR((energies[0] - energies[1]) / (energies[1] - energies[2]), 4, 1) << link;
  }
}

// The same of meshes, whose steps are short. Where a point slides on an elastic body, mesh or
// superelement, the angular momentum is kept to 1e-8 only (measured, not asserted).
TEST_F(TurningLinks, LinksOfMeshesKeepMomentumAndAngularMomentum) {
  std::string meshes = askew;
  for (std::size_t at = 0; (at = meshes.find("rigid", at)) != std::string::npos;)
    meshes.replace(at, 5, "mesh");
  for (const char* link :
       {"fix: [x, y, z]", "fix: [x, y, z, rx, ry]", "fix: [x, y, z, rx, ry, rz]"}) {
    const Ran ran = run({.instances = meshes,
                         .links = std::string("  - {between: [a.tip, b.base], ") + link + "}\n",
                         .time = "end: 0.2"});
    const double momentum = drift(ran, &RunResult::OfBody::momentum),
                 angular = drift(ran, &RunResult::OfBody::angular_momentum);
    std::printf("%s: momentum %.0e, angular %.0e\n", link, momentum, angular);
    EXPECT_LT(momentum, 1e-12) << link;
    EXPECT_LT(angular, 1e-12) << link;
  }
}

// Of what is tied, the pieces turn as one, with and without a gap that the tie keeps.
TEST_F(TurningLinks, TiedBodiesTurnAsOne) {
  for (const auto& [as, gap] : {std::pair<std::string, double>{"superelement", 0.0},
                                {"superelement", 0.002},
                                {"mesh", 0.0},
                                {"mesh", 0.002}}) {
    const double shift = 0.2 + 0.5 * gap;  // of the centres from that of both
    const Ran ran = run({.instances = "  a: {component: block, as: " + as +
                                      ", velocity: " + text(Vector3(0, -2 * shift, 0)) +
                                      ", angular_velocity: [0, 0, 2]}\n"
                                      "  b: {component: block, as: " +
                                      as + ", position: " + text(Vector3(0.4 + gap, 0, 0)) +
                                      ", velocity: " + text(Vector3(0, 2 * shift, 0)) +
                                      ", angular_velocity: [0, 0, 2]}\n",
                         .more = "contact: [{between: [a.x_max, b.x_min], tied: true}]\n",
                         .time = as == "mesh" ? "end: 0.3" : "end: 1",
                         .output = "every: 0.1, history: [b.tip]",
                         .component = reduced});
    const double half = 0.4 + 0.5 * gap;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
      const double angle = 2 * ran.result.time[i];
      const Vector3 tip(half + half * std::cos(angle), 0.1 + half * std::sin(angle), 0.05);
      EXPECT_LT((at(ran.monitor("b.tip").mean_position, i) - tip).norm(), 1e-4) << as << gap;
    }
    EXPECT_LT(drift(ran, &RunResult::OfBody::angular_momentum), 1e-12) << as << gap;
    EXPECT_LT(
        test::total(ran.result, &RunResult::OfBody::momentum, ran.result.time.size() - 1).norm(),
        1e-14);
    EXPECT_LT(test::energy_residual(ran.result), 1e-8);
  }
}

// Faces of rigid bodies have more tied nodes than relative motions. Their ties do what a weld does:
// at the start, which stops what only the middle one has, and over several turns.
TEST_F(TurningLinks, TiedRigidBodiesTurnAsWelded) {
  for (const double gap : {0.0, 0.002}) {
    const Vector3 spin(2, 3, 5), way(0.4 + gap, 0, 0);
    std::string row;
    for (int k = -1; k <= 1; ++k)
      row += "  " + std::string(1, static_cast<char>('b' + k)) +
             ": {component: block, as: rigid, position: " + text(Vector3(k * way)) +
             ", angular_velocity: " + text(k == 0 ? spin : Vector3(0, 0, 0)) + "}\n";
    const auto with = [&](const std::string& links, const std::string& more) {
      return run({.instances = row,
                  .links = links,
                  .more = more,
                  .time = "end: 16, step: 0.02",
                  .output = "every: 0.4, history: [a.base, c.tip, a.x_max, b.x_min]"});
    };
    const std::string fix = ", fix: [x, y, z, rx, ry, rz]}\n";
    const Ran tied = with("",
                          "contact: [{between: [a.x_max, b.x_min], tied: true}, {between: "
                          "[b.x_max, c.x_min], tied: true}]\n"),
              welded = with(
                  "  - {between: [a.tip, b.base]" + fix + "  - {between: [b.tip, c.base]" + fix,
                  "");
    for (std::size_t i = 0; i < tied.result.time.size(); ++i) {
      for (const char* end : {"a.base", "c.tip"})
        EXPECT_LT(
            (at(tied.monitor(end).mean_position, i) - at(welded.monitor(end).mean_position, i))
                .norm(),
            1e-10);
      EXPECT_NEAR((at(tied.monitor("a.x_max").mean_position, i) -
                   at(tied.monitor("b.x_min").mean_position, i))
                      .norm(),
                  gap, 1e-12);
    }
    EXPECT_NEAR(tied.result.total.back(), welded.result.total.back(),
                1e-11 * welded.result.total.back());
    EXPECT_LT(drift(tied, &RunResult::OfBody::angular_momentum), 1e-12);
    EXPECT_LT(test::energy_residual(tied.result), 1e-11);
  }
}

// A force on a point, dead or following, is that on the body at the point; so is a moment.
TEST_F(TurningLinks, LoadsOnPointsTurnOrStay) {
  for (const bool follows : {false, true}) {
    const std::string follow = follows ? ", follow: true}\n" : "}\n";
    const auto with = [&](const std::string& place) {
      return run({.instances = "  a: {component: block, as: rigid}\n",
                  .more = "loads:\n  - {instance: a, " + place + ", force: [0.02, 0.01, 0.03]" +
                          follow + "  - {instance: a, " + place +
                          ", moment: [0.001, -0.002, 0.001]" + follow,
                  .time = "end: 1, step: 0.01",
                  .output = "every: 0.1, history: [a.tip]"});
    };
    const Ran point = with("point: tip"), face = with("surface: x_max");
    EXPECT_GT(at(point.monitor("a.tip").rotation, 10).norm(), 0.5);
    for (std::size_t i = 0; i < 11; ++i)
      EXPECT_LT(
          (at(point.monitor("a.tip").mean_position, i) - at(face.monitor("a.tip").mean_position, i))
              .norm(),
          1e-9)
          << follows;
  }
}

// A stiff mesh moves as a rigid body does under what its point takes.
TEST_F(TurningLinks, LoadsOnPointsOfAMeshTurnOrStay) {
  for (const std::string follow : {"", ", follow: true"}) {
    const auto with = [&](const std::string& as, const std::string& step) {
      return run({.instances = "  a: {component: block, as: " + as + "}\n",
                  .more = "loads:\n  - {instance: a, point: tip, force: [0.02, 0.01, 0.03]" +
                          follow +
                          "}\n  - {instance: a, point: tip, moment: [0.001, -0.002, 0.001]" +
                          follow + "}\n",
                  .time = "end: 1, step: " + step,
                  .output = "every: 0.1, history: [a.tip]"});
    };
    const Ran rigid = with("rigid", "0.002"), mesh = with("mesh", "auto");
    EXPECT_GT(at(rigid.monitor("a.tip").rotation, 10).norm(), 0.5);
    for (std::size_t i = 0; i < 11; ++i) {
      EXPECT_LT(
          (at(rigid.monitor("a.tip").mean_position, i) - at(mesh.monitor("a.tip").mean_position, i))
              .norm(),
          1e-3);
      EXPECT_LT(
          (at(rigid.monitor("a.tip").rotation, i) - at(mesh.monitor("a.tip").rotation, i)).norm(),
          1e-2);
    }
  }
}

TEST_F(TurningLinks, GoesOnFromACheckpoint) {
  const std::string scene =
      yaml({.instances = "  a: {component: block, as: rigid}\n"
                         "  b: {component: block, as: rigid, position: [0.4, 0, 0]}\n",
            .links = "  - {between: [a.base, ground], stiffness: [90, 90, 90, 0.1, 0.1, 0.01], "
                     "damping: [0.1, 0.1, 0.1, 0, 0, 0.001]}\n"
                     "  - {between: [a.tip, b.base], fix: [y, z, rx, ry], stiffness: [80, 0, 0, 0, "
                     "0, 0.02]}\n",
            .more = gravity,
            .time = "end: 0.6, step: 0.002",
            .output = "every: 0.02, history: [b.tip]"});
  const test::RestartedRun runs = test::restarted(folder, scene, 0.31);
  EXPECT_EQ(runs.whole.monitor("b.tip").mean_position.values,
            runs.rest.monitor("b.tip").mean_position.values);
  EXPECT_EQ(runs.whole.monitor("b.tip").rotation.values,
            runs.rest.monitor("b.tip").rotation.values);
  EXPECT_EQ(runs.whole.result.total, runs.rest.result.total);
}

// Springs and masses are bodies of their own behind the instances, and have no fields.
TEST_F(TurningLinks, ShapesOfLinkedBodiesAreFields) {
  Report report("test", Verbosity::quiet);
  const Ran ran = folder.prepare(
      yaml({.instances = "  a: {component: block, as: rigid}\n"
                         "  b: {component: block, as: rigid, position: [0.4, 0, 0]}\n",
            .links = "  - {between: [a.base, ground], fix: [x, y, z, rx, ry], stiffness: [0, 0, 0, "
                     "0, 0, 1]}\n"
                     "  - {between: [a.tip, b.base], fix: [x, y, z, rx, ry], stiffness: [0, 0, 0, "
                     "0, 0, 1]}\n",
            .time = "end: 1",
            .output = "fields: [displacement]"}));
  SceneModes modes = scene_modes(ran.scene, 2, report);
  write_modes(folder.folder() / "modes.h5", modes, report);
  const Hdf5Reader fields(folder.folder() / "modes.fields.h5");
  EXPECT_EQ(fields.children("/grids").size(), 2);
}

// Too long a step for what turns in it.
TEST_F(TurningLinks, AStepThatIsTooLongIsToldSo) {
  const auto far = [&] {
    run({.instances = "  a: {component: block, as: rigid, angular_velocity: [0, 0, 60]}\n",
         .links = "  - {between: [a.base, ground], fix: [x, y, z]}\n",
         .time = "end: 1, step: 0.05"});
  };
  EXPECT_SAYS(test::refusal_of<std::exception>(far), "take a smaller time.step");
}

TEST_F(TurningLinks, RefusesWhatDoesNotTurn) {
  const auto refusal = [&](const std::string& component, const std::string& as) {
    return test::refusal_of([&] {
      folder.prepare(
          "materials: {m: {youngs_modulus: 1.0e6, poissons_ratio: 0, density: 2}}\n"
          "components:\n  block: {mesh: block.exo, material: m, points: {base: {surface: x_min" +
          component + "}}}\ninstances: {a: {component: block, as: " + as +
          "}}\ntime: {end: 1, rotations: large}\n");
    });
  };
  EXPECT_SAYS(refusal(", inertia: [1, 1, 1]", "rigid"), "a point with inertia (found 'base')");
  EXPECT_EQ(refusal(", mass: 1", "rigid"), "no error");
}

}  // namespace
}  // namespace cbr::turning_links_test
