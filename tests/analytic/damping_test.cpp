// SPDX-License-Identifier: GPL-3.0-or-later
// Damping of materials and of modes: one oscillator in closed form in every integrator, stability
// at the limit, accounts of energy, contact, restarts, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::damping_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A bar of one element between a wall and a face that swings along x: k = E A / L, m = rho A L / 2,
// omega = 20.
constexpr double omega = 20, speed = 0.1;

struct Way {
  std::string as = "superelement", integrator = "exact", material = {}, instance = {},
              basis = "craig-bampton, modes: 0", step = "auto";
  double end = 1, every = 0.01, alpha = 0;
  std::string mesh = "one.exo", loads = {}, mass = "lumped";
};

std::string scene(const Way& way) {
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1" +
         (way.material.empty() ? "" : ", damping: {" + way.material + "}") +
         "}\ncomponents:\n  bar: {mesh: " + way.mesh + ", material: soft, mass: " + way.mass +
         (way.as == "mesh" ? ""
                           : ", reduction: {basis: " + way.basis + ", interface: [x_min, x_max]}") +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as + ", velocity: [" + text(speed) +
         ", 0, 0]" + (way.instance.empty() ? "" : ", damping: {" + way.instance + "}") +
         "}\nboundary:\n  - {instance: bar, nodes: x_min, fix: [x, y, z]}\n" + way.loads +
         "time: {end: " + text(way.end) + ", step: " + way.step +
         ", integrator: " + way.integrator + (way.alpha != 0 ? ", alpha: " + text(way.alpha) : "") +
         "}\noutput: {every: " + text(way.every) + ", history: [bar.x_max]}\n";
}

class OfDamping : public ::testing::Test {
 protected:
  OfDamping() {
    folder.add("one.exo", test::block_mesh({{1, 1, 1}, {1, 1, 1}}));
    folder.add("many.exo", test::block_mesh({{6, 2, 2}, {1, 0.3, 0.3}}));
  }
  SceneFolder folder;
};

double swing(double zeta, double t) {
  const double damped = omega * std::sqrt(1 - zeta * zeta);
  return speed / damped * std::exp(-zeta * omega * t) * std::sin(damped * t);
}

double largest_error(const Ran& ran, double zeta) {
  double worst = 0;
  const auto& moved = ran.monitor("bar.x_max").mean_position;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i)
    worst = std::max(worst, std::abs(at(moved, i)[0] - 1 - swing(zeta, ran.result.time[i])));
  return worst / (speed / omega);
}

struct Given {
  std::string material, instance;
  double zeta;
};
const std::vector<Given> all_kinds = {
    {"alpha: 2", "", 0.05},
    {"beta: 0.004", "", 0.04},
    {"alpha: 1, beta: 0.001", "", 0.035},
    {"loss_factor: 0.06", "", 0.03},
    {"", "ratio: 0.02", 0.02},
    {"", "frequency_hz: [0, 10], ratio: [0, 0.1]", 0.1 * omega / (20 * std::numbers::pi)},
    {"alpha: 0.4", "ratio: 0.02", 0.03}};

TEST_F(OfDamping, ExactMotionIsTheClosedForm) {
  for (const Given& given : all_kinds) {
    const Ran ran = folder.run(scene({.material = given.material, .instance = given.instance}));
    EXPECT_LT(largest_error(ran, given.zeta), 1e-11) << given.material << given.instance;
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
    // What is left of the energy is what damping has not taken
    EXPECT_LT(ran.result.work_damping.back(), -0.5 * ran.result.total.front());
  }
}

// Outputs a period apart: ln of their ratio is 2 pi zeta / sqrt(1 - zeta^2).
TEST_F(OfDamping, LogarithmicDecrement) {
  const double zeta = 0.02, damped = omega * std::sqrt(1 - zeta * zeta),
               period = 2 * std::numbers::pi / damped;
  const auto decrement = [&](Way way) {
    way.every = period / 4;
    way.end = 20.001 * way.every;
    const Ran ran = folder.run(scene(way));
    const auto& moved = ran.monitor("bar.x_max").mean_position;
    EXPECT_LT(test::energy_residual(ran.result), 1e-11);
    return std::log((at(moved, 1)[0] - 1) / (at(moved, 17)[0] - 1)) / 4;
  };
  const double expected = 2 * std::numbers::pi * zeta / std::sqrt(1 - zeta * zeta);
  const std::string fine = text(period / 8000);
  EXPECT_NEAR(decrement({.instance = "ratio: 0.02"}), expected, 1e-11);
  EXPECT_NEAR(
      decrement({.integrator = "central-difference", .instance = "ratio: 0.02", .step = fine}),
      expected, 1e-6);
  EXPECT_NEAR(decrement({.integrator = "newmark", .instance = "ratio: 0.02", .step = fine}),
              expected, 1e-6);
  EXPECT_NEAR(decrement({.as = "mesh",
                         .integrator = "newmark",
                         .material = "alpha: 0.4, beta: 0.001",
                         .step = fine}),
              expected, 1e-6);
  EXPECT_NEAR(decrement({.as = "mesh",
                         .integrator = "central-difference",
                         .material = "alpha: 0.8",
                         .step = fine}),
              expected, 1e-6);
}

std::vector<Way> other_ways() {
  std::vector<Way> ways;
  for (const char* as : {"superelement", "mesh"})
    for (const char* integrator : {"central-difference", "newmark"})
      for (const char* mass : {"lumped", "consistent"})
        ways.push_back({.as = as,
                        .integrator = integrator,
                        .material = "alpha: 0.8, beta: 0.002",
                        .mass = mass});
  return ways;
}

// Late damping of a mesh's stiffness under central differences is of first order, all else of
// second.
TEST_F(OfDamping, OtherIntegratorsConverge) {
  for (Way way : other_ways()) {
    if (way.mass == "consistent") continue;
    std::vector<double> steps, errors;
    const bool late = way.as == "mesh" && way.integrator == "central-difference";
    for (const int n : {100, 200, 400}) {
      const double h = late ? 0.125 / n : 1.0 / n;
      way.step = text(h);
      const Ran ran = folder.run(scene(way));
      steps.push_back(h);
      errors.push_back(largest_error(ran, 0.04));
      EXPECT_LT(test::energy_residual(ran.result), 1e-12) << way.as << way.integrator;
    }
    EXPECT_NEAR(test::observed_order(steps, errors), late ? 1 : 2, 0.1)
        << way.as << " " << way.integrator;
    EXPECT_LT(errors.back(), late ? 5e-3 : omega * omega * omega / (12 * 400 * 400));
  }
}

// Superelements that are not diagonalised move as those that are.
TEST_F(OfDamping, CoupledSuperelementsMoveAsModalOnes) {
  for (const char* integrator : {"central-difference", "newmark"}) {
    const Way way{.integrator = integrator,
                  .material = "alpha: 0.8, beta: 1e-4",
                  .step = "0.0005",
                  .mesh = "many.exo"};
    const Ran modal = folder.run(scene(way));
    folder.diagonal_limit = 0;
    const Ran coupled = folder.run(scene(way));
    folder.diagonal_limit.reset();
    const auto &a = modal.monitor("bar.x_max").mean_position,
               &b = coupled.monitor("bar.x_max").mean_position;
    double worst = 0;
    for (std::size_t i = 0; i < modal.result.time.size(); ++i)
      worst = std::max(worst, (at(a, i) - at(b, i)).norm());
    // Newmark has the same equations, central differences another damping of the stiffness
    EXPECT_LT(worst, std::string(integrator) == "newmark" ? 1e-12 : 1e-4) << integrator;
    EXPECT_LT(test::energy_residual(coupled.result), 1e-11) << integrator;
    EXPECT_LT(coupled.result.work_damping.back(), 0);
  }
}

TEST_F(OfDamping, EnergyIsAccountedForInBodiesOfManyModes) {
  const std::string pull =
      "loads:\n  - {instance: bar, surface: x_max, traction: [0.1, 0.2, 0], history: {time: [0, "
      "0.3, 0.5], "
      "value: [0, 1, 0]}}\n";
  for (Way way : other_ways()) {
    way.mesh = "many.exo";
    way.loads = pull;
    for (const double alpha : {0.0, -0.1}) {
      if (alpha != 0 && way.integrator != "newmark") continue;
      way.alpha = alpha;
      way.step = way.integrator == "newmark" ? "0.002" : "auto";
      const Ran ran = folder.run(scene(way));
      EXPECT_LT(test::energy_residual(ran.result), 1e-10)
          << way.as << " " << way.integrator << " " << way.mass;
      for (std::size_t i = 1; i < ran.result.time.size(); ++i)
        EXPECT_LE(ran.result.work_damping[i], ran.result.work_damping[i - 1] + 1e-12);
      EXPECT_LT(ran.result.work_damping.back(), -1e-3 * ran.result.total.front());
    }
  }
  for (const char* basis : {"massless, modes: 8", "characteristic, modes: 8"}) {
    const Ran ran = folder.run(
        scene({.instance = "ratio: 0.03", .basis = basis, .mesh = "many.exo", .loads = pull}));
    EXPECT_LT(test::energy_residual(ran.result), 1e-10) << basis;
    EXPECT_LT(ran.result.work_damping.back(), 0);
  }
}

// 2 / largest_frequency() is the limit: the mesh is stable there, and not at steps a little above.
TEST_F(OfDamping, StableUpToTheLimitOfTheStep) {
  for (const char* damping : {"beta: 0.002", "alpha: 1, beta: 0.0003", "alpha: 50"})
    for (const char* mass : {"lumped", "consistent"}) {
      Way way{.as = "mesh",
              .integrator = "central-difference",
              .material = damping,
              .end = 4,
              .every = 0};
      way.mesh = "many.exo";
      way.mass = mass;
      const double limit =
          2 / folder.prepare(scene(way)).built.simulation.bodies[0]->largest_frequency();
      way.step = text(limit * (1 - 1e-9));
      const Ran at_limit = folder.run(scene(way));
      EXPECT_LE(at_limit.result.total.back(), 1.001 * at_limit.result.total.front())
          << damping << mass;
      way.step = text(1.03 * limit) + ", force: true";
      double grown = HUGE_VAL;
      try {
        const Ran above = folder.run(scene(way));
        grown = std::abs(above.result.total.back());
      } catch (const RunError&) {
      }
      EXPECT_GT(grown, 1e3 * at_limit.result.total.front()) << damping << mass;
    }
}

std::string bouncing(const Way& way) {
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1" +
         (way.material.empty() ? "" : ", damping: {" + way.material + "}") +
         "}\ncomponents:\n  bar: {mesh: many.exo, material: soft, mass: lumped" +
         (way.as == "mesh" ? ""
                           : ", reduction: {basis: " + way.basis + ", interface: [x_min, x_max]}") +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as +
         ", position: [0.02, 0, 0], velocity: [-1, 0.1, 0]" +
         (way.instance.empty() ? "" : ", damping: {" + way.instance + "}") +
         "}\nwalls:\n  wall: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\ncontact:\n  - "
         "{between: [bar.x_min, wall], "
         "friction: 0.2}\ntime: {end: 0.4, integrator: " +
         way.integrator + ", step: " + way.step +
         "}\noutput: {every: 0.02, history: [bar.x_min]}\n";
}

// A damped bar leaves a wall with less than an undamped one, and nothing brings energy.
TEST_F(OfDamping, ContactBringsNoEnergy) {
  std::vector<Way> ways = {
      {.instance = "ratio: 0.1", .basis = "craig-bampton, modes: 30"},
      {.instance = "ratio: 0.1", .basis = "massless, modes: 30"},
      {.instance = "ratio: 0.1", .basis = "characteristic, modes: 30"},
      {.as = "mesh", .integrator = "central-difference", .material = "beta: 0.002"},
      {.as = "mesh", .integrator = "newmark", .material = "beta: 0.002", .step = "0.001"},
      {.integrator = "newmark",
       .material = "beta: 0.002",
       .basis = "craig-bampton, modes: 30",
       .step = "0.001"}};
  for (Way way : ways) {
    const Ran damped = folder.run(bouncing(way));
    way.material = way.instance = "";
    const Ran free = folder.run(bouncing(way));
    const auto &E = damped.result.total, &v = damped.body("bar").momentum.values;
    EXPECT_LT(test::energy_residual(damped.result), 1e-9) << way.as << way.integrator << way.basis;
    EXPECT_LE(E.back(), E.front());
    EXPECT_LE(E.back(), free.result.total.back());
    EXPECT_LE(damped.result.work_damping.back(), -0.02 * E.front())
        << way.as << way.integrator << way.basis;
    EXPECT_GT(v[v.size() - 3], 0.3 * damped.mass("bar")) << way.as << way.integrator << way.basis;
  }
}

// From a state in the middle a run goes on bit for bit.
TEST_F(OfDamping, RestartsGoOnBitForBit) {
  std::vector<Way> ways = other_ways();
  ways.push_back({.instance = "ratio: 0.02"});
  for (Way way : ways) {
    way.mesh = "many.exo";
    way.step = "0.002";
    test::expect_same_bits(test::restarted(folder, scene(way), 0.19),
                           way.as + way.integrator + way.mass);
  }
}

TEST_F(OfDamping, WhatCannotBeIsRefusedByName) {
  const auto refusal = [&](const std::string& yaml) {
    return test::refusal_of([&] { folder.prepare(yaml); });
  };
  EXPECT_SAYS(refusal(scene({.as = "mesh", .instance = "ratio: 0.02"})), "a mesh has no modes");
  EXPECT_SAYS(refusal(scene({.as = "mesh", .material = "loss_factor: 0.02"})), "loss_factor");
  EXPECT_SAYS(refusal(scene({.material = "alpha: -1"})), "expected a number from 0");
  EXPECT_SAYS(refusal(scene({.instance = "frequency_hz: [1, 1], ratio: [0, 0]"})), "must ascend");
  EXPECT_SAYS(refusal(scene({.instance = "frequency_hz: [1, 2], ratio: [0]"})), "as many as");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string yaml = scene({.material = "alpha: 1"});
    const std::size_t at = yaml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return refusal(yaml.replace(at, from.size(), to));
  };
  const std::string touching =
      "walls:\n  wall: {plane: {point: [2, 0, 0], normal: [-1, 0, 0]}}\ncontact:\n  - {between: "
      "[bar.x_max, wall]";
  EXPECT_SAYS(changed("time: {", touching + ", enforcement: nodal}\ntime: {"),
              "enforcement: nodal");
  EXPECT_SAYS(changed("mass: lumped", "mass: lumped, blocks: {block: {material: other}}"),
              "unknown material");
  EXPECT_SAYS(changed("components:\n  bar: {",
                      "  other: {youngs_modulus: 1, poissons_ratio: 0, density: 1}\ncomponents:\n  "
                      "bar: {blocks: "
                      "{block: {material: other}}, "),
              "'other' and 'soft' are damped differently");
}

}  // namespace
}  // namespace cbr::damping_test
