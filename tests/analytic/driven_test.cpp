// SPDX-License-Identifier: GPL-3.0-or-later
// Supports that move: one oscillator on a moving base in closed form in every integrator,
// reactions, the supports' work, a press, restarts, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::driven_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A bar of one element between a base and a face that swings along x: k = E A / L, m = rho A L / 2
// at either end, omega = 20.
constexpr double omega = 20, mass = 0.5;

struct Way {
  std::string motion = {}, as = "superelement", integrator = "exact",
              basis = "craig-bampton, modes: 0", step = "auto";
  std::string mesh = "one.exo", loads = {}, velocity = "0, 0, 0", damping = {}, mass = "lumped",
              more_boundary = {};
  double end = 1, every = 0.01;
};

std::string scene(const Way& way) {
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1" + way.damping +
         "}\ncomponents:\n  bar: {mesh: " + way.mesh + ", material: soft, mass: " + way.mass +
         (way.as == "mesh" ? ""
                           : ", reduction: {basis: " + way.basis + ", interface: [x_min, x_max]}") +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as + ", velocity: [" + way.velocity +
         "]}\nboundary:\n  - {instance: bar, nodes: x_min, fix: [x, y, z], " + way.motion + "}\n" +
         way.more_boundary + way.loads + "time: {end: " + text(way.end) + ", step: " + way.step +
         ", integrator: " + way.integrator + "}\noutput: {every: " + text(way.every) +
         ", history: [bar.x_min, bar.x_max]}\n";
}

class SupportsThatMove : public ::testing::Test {
 protected:
  SupportsThatMove() {
    folder.add("one.exo", test::block_mesh({{1, 1, 1}, {1, 1, 1}}));
    folder.add("many.exo", test::block_mesh({{6, 2, 2}, {1, 0.3, 0.3}}));
  }
  double largest_error(const Ran& ran, const std::function<double(double)>& expected,
                       const std::string& surface = "bar.x_max") const {
    double worst = 0;
    const auto& moved = ran.monitor(surface).mean_position;
    const double start = surface == "bar.x_max" ? 1 : 0;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      worst = std::max(worst, std::abs(at(moved, i)[0] - start - expected(ran.result.time[i])));
    return worst;
  }
  std::string refusal(const std::string& yaml) const {
    return test::refusal_of([&] { folder.prepare(yaml); });
  }
  SceneFolder folder;
};

// Stretch of the spring on a base of constant acceleration a from rest.
double stretch(double a, double t) { return -a / (omega * omega) * (1 - std::cos(omega * t)); }

TEST_F(SupportsThatMove, ConstantAccelerationInClosedForm) {
  const double a = 3;
  const Ran ran = folder.run(scene({.motion = "acceleration: [3, 0, 0]"}));
  EXPECT_LT(largest_error(
                ran, [&](double t) { return 0.5 * a * t * t; }, "bar.x_min"),
            1e-14);
  EXPECT_LT(largest_error(ran, [&](double t) { return 0.5 * a * t * t + stretch(a, t); }), 1e-14);
  EXPECT_LT(test::energy_residual(ran.result), 1e-14);
}

// The base's mass and the spring need the force m a (2 - cos omega t), and it does the work of that
// force.
TEST_F(SupportsThatMove, ReactionsAndTheirWork) {
  const double a = 3;
  const Ran ran = folder.run(scene({.motion = "acceleration: [3, 0, 0]"}));
  const auto& reaction = ran.body("bar").reaction;
  const auto impulse = [&](double t) { return mass * a * (2 * t - std::sin(omega * t) / omega); };
  for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
    const double t = ran.result.time[i], before = ran.result.time[i - 1];
    EXPECT_NEAR(at(reaction, i)[0], (impulse(t) - impulse(before)) / (t - before), 1e-13);
    const double work =
        mass * a * a *
        (t * t - t * std::sin(omega * t) / omega - (std::cos(omega * t) - 1) / (omega * omega));
    EXPECT_NEAR(ran.result.work_external[i], work, 1e-13);
  }
}

// Loads and contact are not the supports': a bar at rest on them holds its weight and a pull.
TEST_F(SupportsThatMove, ReactionsOfSupportsAtRest) {
  for (const char* as : {"superelement", "mesh"}) {
    Way way{.motion = "acceleration: [0, 0, 0]", .as = as, .damping = ", damping: {beta: 0.02}"};
    way.loads =
        "loads:\n  - {gravity: [0, 0, -2]}\n  - {instance: bar, surface: x_max, force: [5, 0, "
        "0]}\n";
    way.mesh = "many.exo";
    way.integrator = "newmark";
    way.step = "0.01";
    way.every = 0.5;
    way.end = 200;
    const Ran ran = folder.run(scene(way));
    const auto& reaction = ran.body("bar").reaction;
    const Vector3 last = at(reaction, ran.result.time.size() - 1);
    EXPECT_NEAR(last[0], -5, 1e-11) << as;
    EXPECT_NEAR(last[2], 2 * ran.mass("bar"), 1e-11) << as;
  }
}

TEST_F(SupportsThatMove, VelocityRampInClosedForm) {
  const double a = 2 / 0.3;
  const Ran ran = folder.run(
      scene({.motion = "velocity: [2, 0, 0], history: {time: [0, 0.3], value: [0, 1]}"}));
  const auto base = [&](double t) { return t < 0.3 ? 0.5 * a * t * t : 0.3 + 2 * (t - 0.3); };
  const auto free_end = [&](double t) {
    return base(t) + stretch(a, t) - (t > 0.3 ? stretch(a, t - 0.3) : 0);
  };
  EXPECT_LT(largest_error(ran, base, "bar.x_min"), 1e-12);
  EXPECT_LT(largest_error(ran, free_end), 1e-12);
  EXPECT_LT(test::energy_residual(ran.result), 1e-14);
}

// From rest to rest by a cubic: s = D (3 x^2 - 2 x^3), x = t / T. After that nothing moves the
// base.
TEST_F(SupportsThatMove, DisplacementInClosedForm) {
  const double D = 0.5, T = 0.4, a = 6 * D / (T * T), slope = -2 * a / T;
  const Ran ran = folder.run(
      scene({.motion = "displacement: [0.5, 0, 0], history: {time: [0, 0.4], value: [0, 1]}"}));
  const auto base = [&](double t) {
    return t < T ? D * (3 * t * t / (T * T) - 2 * t * t * t / (T * T * T)) : D;
  };
  // w'' + omega^2 w = -(amplitude + rate t)
  const auto swing = [&](double amplitude, double rate, double t) {
    return t < 0 ? 0
                 : (amplitude * std::cos(omega * t) + rate / omega * std::sin(omega * t) -
                    amplitude - rate * t) /
                       (omega * omega);
  };
  const auto free_end = [&](double t) {
    return base(t) + swing(a, slope, t) + swing(a, -slope, t - T);
  };
  EXPECT_LT(largest_error(ran, base, "bar.x_min"), 1e-11);
  EXPECT_LT(largest_error(ran, free_end), 1e-11);
}

// A spline through many points of a smooth curve: the base is off by less than its fourth order.
TEST_F(SupportsThatMove, DisplacementTableOfManyPoints) {
  const auto curve = [](double t) { return 0.1 * (1 - std::cos(6 * t)); };
  std::vector<double> steps, errors;
  for (const int n : {20, 40, 80}) {
    std::string time, value;
    for (int i = 0; i <= n; ++i) {
      time += (i > 0 ? ", " : "") + text(1.0 * i / n);
      value += (i > 0 ? ", " : "") + text(curve(1.0 * i / n));
    }
    const Ran ran = folder.run(scene({.motion = "displacement: [1, 0, 0], history: {time: [" +
                                                time + "], value: [" + value + "]}",
                                      .end = 0.7}));
    steps.push_back(1.0 / n);
    errors.push_back(largest_error(ran, curve, "bar.x_min"));
  }
  EXPECT_LT(errors.back(), 5e-8);
  EXPECT_GT(test::observed_order(steps, errors), 3.5);
}

// A ramp that ends in a constant ends there, and statics follow the table itself.
TEST_F(SupportsThatMove, ARampEndsWithoutOvershoot) {
  const std::string motion =
      "displacement: [0.5, 0, 0], history: {time: [0, 0.1, 0.2, 0.6, 3], value: [0, 1, 1, -1, -1]}";
  const auto smooth = [](double s) { return s * s * (3 - 2 * s); };
  const auto curve = [&](double t) {
    const double falls = t > 0.2 ? smooth(std::min(1.0, (t - 0.2) / 0.4)) : 0;
    return 0.5 * smooth(std::min(1.0, t / 0.1)) - falls;
  };
  EXPECT_LT(largest_error(folder.run(scene({.motion = motion})), curve, "bar.x_min"), 5e-11);
  std::string statics = scene({.motion = motion, .step = "0.05", .every = 0.05});
  statics.replace(statics.find("integrator: exact"), 17, "static: true");
  const auto table = [](double t) {
    return t < 0.1 ? 5 * t : 0.5 - std::clamp((t - 0.2) / 0.4, 0.0, 1.0);
  };
  const Ran ran = folder.run(statics);
  EXPECT_LT(largest_error(ran, table, "bar.x_min"), 1e-15);
  EXPECT_LT(largest_error(ran, table), 1e-15);
  // Of a table that does not begin with 0 the first load step takes its value there
  statics.replace(statics.find("[0, 0.1, 0.2, 0.6, 3]"), 21, "[0.3, 0.6, 9]");
  statics.replace(statics.find("[0, 1, 1, -1, -1]"), 17, "[1, 2, 2]");
  const auto from_one = [](double t) {
    return t == 0 ? 0 : 0.5 * std::clamp(1 + (t - 0.3) / 0.3, 1.0, 2.0);
  };
  EXPECT_LT(largest_error(folder.run(statics), from_one, "bar.x_min"), 1e-15);
}

// Newmark's forces last through a step, in which the supports go on: a tie does no work.
TEST_F(SupportsThatMove, TiesOnThemDoNoWorkUnderNewmark) {
  for (const std::string as : {"superelement", "mesh"}) {
    std::string yaml = scene({.motion = "velocity: [0.1, 0, 0], history: {sine: {frequency_hz: 1}}",
                              .as = as,
                              .integrator = "newmark",
                              .step = "0.01",
                              .mesh = "many.exo"});
    yaml.insert(yaml.find("boundary:"), "  top: {component: bar, as: " + as +
                                            ", position: [1, 0, 0]}\ncontact: [{between: "
                                            "[bar.x_max, top.x_min], tied: true}]\n");
    const RunResult result = folder.run(yaml).result;
    const double most = *std::max_element(result.total.begin(), result.total.end());
    EXPECT_GT(most, 0);
    EXPECT_LT(std::abs(result.work_contact.back()), 1e-6 * most) << as;
    EXPECT_LT(test::energy_residual(result), 1e-12) << as;
  }
}

// What moves with its supports from the start strains nothing.
TEST_F(SupportsThatMove, BodiesThatBeginToMoveWithTheirSupports) {
  for (const char* motion :
       {"velocity: [2, 0, 1]", "displacement: [2, 0, 1], history: {time: [0, 5], value: [0, 5]}"}) {
    const Ran ran =
        folder.run(scene({.motion = motion, .mesh = "many.exo", .velocity = "2, 0, 1"}));
    const auto& moved = ran.monitor("bar.x_max").mean_velocity;
    const bool is_steady = std::string(motion).find("velocity") == 0;
    EXPECT_NEAR(at(moved, 0)[0], 2, 1e-12) << motion;
    if (!is_steady) continue;
    EXPECT_NEAR(at(moved, ran.result.time.size() - 1)[2], 1, 1e-12);
    EXPECT_NEAR(ran.result.total.back(), 2.5 * ran.mass("bar"), 1e-12);
  }
}

std::vector<Way> all_ways() {
  std::vector<Way> ways = {{.as = "superelement", .integrator = "exact"}};
  for (const char* as : {"superelement", "mesh"})
    for (const char* integrator : {"central-difference", "newmark"})
      ways.push_back({.as = as, .integrator = integrator});
  return ways;
}

TEST_F(SupportsThatMove, OtherIntegratorsConverge) {
  for (Way way : all_ways()) {
    if (way.integrator == "exact") continue;
    way.motion = "acceleration: [1, 0, 0], history: {time: [0, 2], value: [3, 9]}";
    std::vector<double> steps, errors;
    for (const int n : {100, 200, 400}) {
      way.step = text(1.0 / n);
      const Ran ran = folder.run(scene(way));
      const auto free_end = [](double t) {
        return 1.5 * t * t + 0.5 * t * t * t +
               (3 * std::cos(omega * t) + 3 / omega * std::sin(omega * t) - 3 - 3 * t) /
                   (omega * omega);
      };
      steps.push_back(1.0 / n);
      errors.push_back(largest_error(ran, free_end));
      EXPECT_LT(test::energy_residual(ran.result), 1e-13) << way.as << way.integrator;
    }
    EXPECT_NEAR(test::observed_order(steps, errors), 2, 0.1) << way.as << way.integrator;
  }
}

// Superelements with all modes move as their mesh: other bases, bodies with mass in their interior,
// consistent mass.
TEST_F(SupportsThatMove, EveryBodyMovesAlike) {
  const std::string motion =
      "acceleration: [1, 2, 0], history: {time: [0, 0.2, 0.5], value: [0, 5, 0]}";
  for (const char* kind : {"lumped", "consistent"}) {
    Way way{.motion = motion,
            .as = "mesh",
            .integrator = "newmark",
            .step = "0.001",
            .mesh = "many.exo",
            .mass = kind};
    const Ran mesh = folder.run(scene(way));
    way.as = "superelement";
    for (const char* basis : {"craig-bampton, modes: 135", "massless, modes: 12"}) {
      const bool is_massless = std::string(basis).find("massless") == 0;
      way.basis = basis;
      way.integrator = is_massless ? "exact" : "newmark";
      way.step = is_massless ? "auto" : "0.001";
      const Ran ran = folder.run(scene(way));
      double worst = 0;
      const auto &a = mesh.monitor("bar.x_max").mean_position,
                 &b = ran.monitor("bar.x_max").mean_position;
      for (std::size_t i = 0; i < mesh.result.time.size(); ++i)
        worst = std::max(worst, (at(a, i) - at(b, i)).norm());
      EXPECT_LT(worst, is_massless ? 2e-3 : 1e-11) << basis << kind;
      EXPECT_LT(test::energy_residual(ran.result), 1e-13) << basis << kind;
    }
    folder.diagonal_limit = 0;
    way.basis = "craig-bampton, modes: 60";
    way.integrator = "newmark";
    way.step = "0.001";
    const Ran coupled = folder.run(scene(way));
    folder.diagonal_limit.reset();
    EXPECT_LT(test::energy_residual(coupled.result), 1e-10) << kind;
    EXPECT_NEAR(at(coupled.monitor("bar.x_max").mean_position, 100)[0],
                at(mesh.monitor("bar.x_max").mean_position, 100)[0], 2e-4);
  }
}

// A platen closes on a bar that is clamped at its far end: at the end the force is k d, on the
// platen's supports as on the bar's.
std::string press(const Way& way) {
  const std::string body =
      "many.exo, material: soft, mass: lumped" +
      (way.as == "mesh" ? ""
                        : ", reduction: {basis: " + way.basis + ", interface: [x_min, x_max]}");
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1, damping: "
         "{alpha: 20}}\ncomponents:\n  bar: {mesh: " +
         body + "}\n  platen: {mesh: " + body +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as +
         "}\n  platen: {component: platen, as: " + way.as +
         ", position: [-1.01, 0, 0]}\nboundary:\n  - {instance: bar, nodes: x_max, fix: [x, y, "
         "z]}\n  - {instance: platen, nodes: "
         "x_min, fix: [x, y, z], displacement: [0.03, 0, 0], history: {time: [0, 3], value: [0, "
         "1]}}\ncontact:\n  - {between: "
         "[platen.x_max, bar.x_min]}\ntime: {end: 5, integrator: " +
         way.integrator + ", step: " + way.step + "}\noutput: {every: 0.1, history: [bar.x_min]}\n";
}

TEST_F(SupportsThatMove, APressCloses) {
  for (Way way : all_ways()) {
    for (const char* basis :
         {"craig-bampton, modes: 12", "massless, modes: 12", "characteristic, modes: 12"}) {
      way.basis = basis;
      way.step = way.integrator == "newmark" ? "0.002" : "auto";
      const bool is_plain = std::string(basis).find("craig") == 0;
      if (!is_plain && (way.as == "mesh" || way.integrator != "exact")) continue;
      const Ran ran = folder.run(press(way));
      const std::string name = way.as + " " + way.integrator + " " + basis;
      const std::size_t last = ran.result.time.size() - 1;
      // few shapes and 12 modes of its statics
      const bool is_stiffer = std::string(basis).find("characteristic") == 0;
      // Two bars in a row take 0.02 between them
      const double force = 200 * 0.09 * 0.02 / 2;
      EXPECT_NEAR(at(ran.body("platen").reaction, last)[0], force,
                  (is_stiffer ? 2e-3 : 1e-8) * force)
          << name;
      EXPECT_NEAR(at(ran.body("bar").reaction, last)[0], -force, (is_stiffer ? 2e-3 : 1e-8) * force)
          << name;
      EXPECT_LT(test::energy_residual(ran.result), 1e-12) << name;
    }
  }
}

// Supports that have a velocity from the start, of bodies whose highest modes are quasi-static.
TEST_F(SupportsThatMove, TruncatedModesMoveWithTheirSupports) {
  const std::string bar =
      "{mesh: many.exo, material: soft, reduction: {interface: [x_min, x_max], modes: 60}}";
  const Ran ran = folder.run(
      "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1}}\n"
      "components: {bar: " +
      bar +
      "}\n"
      "instances:\n"
      "  bar: {component: bar, as: superelement}\n"
      "  ram: {component: bar, as: superelement, position: [-1.01, 0, 0], velocity: [0.5, 0, 0]}\n"
      "boundary:\n"
      "  - {instance: bar, nodes: x_max, fix: [x, y, z]}\n"
      "  - {instance: ram, nodes: x_min, fix: [x, y, z], velocity: [0.5, 0, 0]}\n"
      "contact: [{between: [ram.x_max, bar.x_min]}]\n"
      "time: {end: 0.2, step: {cfl: 4}}\n"
      "output: {every: 0.1, history: [ram.x_min, bar.x_min]}\n");
  const std::size_t last = ran.result.time.size() - 1;
  for (const auto& of : ran.built.instances) EXPECT_GT(of.n_following, 0);
  EXPECT_NEAR(at(ran.monitor("ram.x_min").mean_position, last)[0], -1.01 + 0.5 * 0.2, 1e-12);
  EXPECT_GT(at(ran.monitor("bar.x_min").mean_position, last)[0], 0.005);  // it was pushed
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
}

// From a state in the middle a run goes on bit for bit.
TEST_F(SupportsThatMove, RestartsGoOnBitForBit) {
  for (Way way : all_ways()) {
    way.step = way.integrator == "newmark" ? "0.002" : "auto";
    way.end = 5;
    test::expect_same_bits(test::restarted(folder, press(way), 2.6), way.as + way.integrator);
  }
}

TEST_F(SupportsThatMove, WhatCannotBeIsRefusedByName) {
  const auto expect = [&](const std::string& motion, const std::string& what,
                          const std::string& more = {}) {
    EXPECT_SAYS(refusal(scene({.motion = motion, .more_boundary = more})), what) << motion;
  };
  expect("displacement: [1, 0, 0]", "needs a history");
  expect("displacement: [1, 0, 0], velocity: [1, 0, 0]", "remove the other");
  expect("history: {time: [0], value: [1]}", "needs one of displacement, velocity, acceleration");
  expect("displacement: [1, 0, 0], history: {sine: {frequency_hz: 2}}", "begins with a jump");
  expect("velocity: [1, 0, 0], history: {sine: {frequency_hz: 2, phase: 90, cycles: 0.5}}",
         "jumps at the time");
  expect("velocity: [1, 0, 0], history: {time: [-1, 1], value: [0, 1]}", "times from 0 on");
  expect("displacement: [1, 0, 0], history: {time: [0, 1], value: [1, 2]}", "begins with 1");
  expect("acceleration: [1, 0, 0]", "no error", "  - {instance: bar, nodes: x_max, fix: [x]}\n");
  expect("acceleration: [1, 0, 0]", "no error", "  - {instance: bar, nodes: x_max, fix: [y]}\n");
  EXPECT_SAYS(refusal("materials:\n  m: {youngs_modulus: 1, poissons_ratio: 0, density: "
                      "1}\ncomponents:\n  bar: "
                      "{mesh: one.exo, material: "
                      "m}\ninstances:\n  bar: {component: bar, as: mesh}\nboundary:\n  - "
                      "{instance: bar, nodes: "
                      "x_min, fix: z, velocity: [1, 0, "
                      "0]}\ntime: {end: 1}\n"),
              "which 'fix' leaves free");
}

}  // namespace
}  // namespace cbr::driven_test
