// SPDX-License-Identifier: GPL-3.0-or-later
// Loads on bodies that turn by any angle: those that follow the body, and those that stay in the
// scene's axes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::turning_loads_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A bar along x, alone in space.
constexpr double length = 0.4, width = 0.05, height = 0.06, density = 2;
constexpr double mass = density * length * width * height;
constexpr double J_z = mass / 12 * (length * length + width * width);

struct FolderWithBar : SceneFolder {
  FolderWithBar() { add("bar.exo", test::block_mesh({{4, 1, 1}, {length, width, height}})); }
};

struct Model {
  std::string as = "superelement", reduction = "interface: [x_min, x_max], modes: 12";
  double youngs_modulus = 1e5, poissons_ratio = 0.3;
};

std::string scene(const std::string& time, const std::string& instance, const std::string& loads,
                  const Model& model = {}, const std::string& output = "every: 0.05") {
  return "materials: {m: {youngs_modulus: " + text(model.youngs_modulus) +
         ", poissons_ratio: " + text(model.poissons_ratio) + ", density: " + text(density) +
         "}}\ncomponents: {bar: {mesh: bar.exo, material: m, mass: consistent, reduction: {" +
         model.reduction + "}}}\ninstances: {b: {component: bar, as: " + model.as +
         (instance.empty() ? "" : ", ") + instance + "}}\ntime: {" + time +
         ", rotations: large}\nloads: [" + loads + "]\noutput: {" + output +
         ", history: [b.x_min, b.x_max]}\n";
}

Vector3 center(const Ran& ran) {
  const auto& c = ran.body("b").center_of_mass;
  return at(c, ran.result.time.size() - 1) - at(c, 0);
}

// On a fixed axis an angle is the integral of the integral of moment / J: exact in steps of any
// length, with bends of the history inside them.
TEST(TurningLoads, AMomentSpinsUpABody) {
  FolderWithBar folder;
  const double M = 3 * J_z;
  // The history rises to 2 at 0.33 s and falls to 0 at 1 s: its integral is 1, and the angle
  // 0.33^2 / 3 + 0.33 * 0.67 + 2 * 0.67^2 / 3 after 1 s
  const double angle = 3 * (0.33 * 0.33 / 3 + 0.33 * 0.67 + 2 * 0.67 * 0.67 / 3);
  for (const std::string follow : {"false", "true"}) {
    const Ran ran = folder.run(scene("end: 1", "",
                                     "{instance: b, surface: x_max, moment: [0, 0, " + text(M) +
                                         "], follow: " + follow +
                                         ", history: {time: [0, 0.33, 1], value: [0, 2, 0]}}",
                                     {"rigid"}, "every: 0.25"));
    const auto& q = ran.body("b").orientation;
    const double* end = q.data() + q.size() - 4;
    EXPECT_NEAR(2 * std::atan2(end[3], end[0]), angle, 1e-12);
    EXPECT_NEAR(ran.result.work_external.back() / (0.5 * J_z * 9), 1, 1e-12);
    EXPECT_LT(test::energy_residual(ran.result), 1e-13);
    EXPECT_LT(center(ran).norm(), 1e-15);
  }
}

// A thrust through the centre of mass of a body that spins at w: v' = F / m (cos w t, sin w t).
TEST(TurningLoads, AThrustThatFollowsGoesRound) {
  FolderWithBar folder;
  constexpr double w = 5, F = 0.02, end = 0.5, way = F / (mass * w * w);
  const Vector3 expected(way * (1 - std::cos(w * end)), way * (w * end - std::sin(w * end)), 0);
  const Eigen::AngleAxisd placed(std::numbers::pi / 6, Vector3::UnitZ());
  RunOptions every_step;
  every_step.jumps = false;
  std::vector<double> h, error;
  for (const double step : {1e-4, 5e-5, 2.5e-5}) {
    const Ran ran = folder.run(scene("end: " + text(end) + ", step: " + text(step),
                                     "rotation: [0, 0, 30], angular_velocity: [0, 0, 5]",
                                     "{instance: b, surface: x_min, follow: true, force: " +
                                         text(Vector3(placed * Vector3(F, 0, 0))) + "}",
                                     {"rigid"}),
                               every_step);
    h.push_back(step);
    error.push_back((center(ran) - placed * expected).norm() / expected.norm());
    std::printf("step %.1e: off by %.2e of the way\n", step, error.back());
    EXPECT_LT(test::energy_residual(ran.result), 1e-13);
  }
  EXPECT_LT(error.front(), 1e-7);
  EXPECT_NEAR(test::observed_order(h, error), 2, 0.05);
  // Jumps from output to output are cut where the body turns by 0.02 rad
  const Ran jumps = folder.run(
      scene("end: " + text(end), "angular_velocity: [0, 0, 5]",
            "{instance: b, surface: x_min, follow: true, force: [" + text(F) + ", 0, 0]}",
            {"rigid"}, "every: 0.5"));
  EXPECT_LT((center(jumps) - expected).norm() / expected.norm(), 1e-4);
}

// A force that stays in the scene's axes, on the end of an elastic bar that tumbles: its work is
// the force times the way of the nodes that it acts on.
TEST(TurningLoads, AForceThatStaysDoesItsWork) {
  FolderWithBar folder;
  RunOptions every_step;
  every_step.jumps = false;
  const Vector3 F(0.001, -0.002, 0.0015);
  std::vector<double> h, error;
  for (const double step : {1e-4, 5e-5, 2.5e-5}) {
    const Ran ran = folder.run(
        scene("end: 0.4, step: " + text(step), "angular_velocity: [2, 1, 6]",
              "{instance: b, surface: x_max, force: " + text(F) + "}", {.youngs_modulus = 4000}),
        every_step);
    const auto& x = ran.monitor("b.x_max").mean_position;
    const double work = F.dot(at(x, ran.result.time.size() - 1) - at(x, 0));
    h.push_back(step);
    error.push_back(std::abs(ran.result.work_external.back() / work - 1));
    std::printf("step %.1e: work off by %.2e, momentum by %.0e\n", step, error.back(),
                (at(ran.body("b").momentum, ran.result.time.size() - 1) - 0.4 * F).norm());
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
    EXPECT_LT((at(ran.body("b").momentum, ran.result.time.size() - 1) - 0.4 * F).norm(), 1e-15);
  }
  EXPECT_LT(error.front(), 1e-7);
  EXPECT_GT(test::observed_order(h, error), 1.9);
}

// A thrust at one end presses the bar together by F L / (2 E A), once damping has taken the swing,
// wherever the bar points; of every basis, whose statics follow too.
TEST(TurningLoads, AThrustShortensTheBar) {
  FolderWithBar folder;
  constexpr double F = 3, E = 1e5;
  for (const std::string reduction :
       {"interface: [x_min, x_max], modes: 12",
        "basis: characteristic, characteristic: {statics: [x_min, x_max]}, interface: [x_min, "
        "x_max], modes: 12",
        "basis: massless, interface: [x_min, x_max], modes: 12"}) {
    const Ran ran = folder.run(scene("end: 1, step: 0.0005",
                                     "damping: {ratio: 0.2}, angular_velocity: [0, 0, 1]",
                                     "{instance: b, surface: x_min, follow: true, traction: [" +
                                         text(F / (width * height)) + ", 0, 0]}",
                                     {"superelement", reduction, E, 0}));
    const auto last = ran.result.time.size() - 1;
    const double shorter = length - (at(ran.monitor("b.x_max").mean_position, last) -
                                     at(ran.monitor("b.x_min").mean_position, last))
                                        .norm();
    const double expected = F * length / (2 * E * width * height);
    std::printf("%s: shorter by %.5e, off by %.1e\n", reduction.c_str(), shorter,
                shorter / expected - 1);
    EXPECT_NEAR(shorter / expected, 1, 0.01);
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  }
}

// Pressure follows unless told otherwise; on one face it is a traction that follows.
TEST(TurningLoads, PressureFollows) {
  FolderWithBar folder;
  const auto run = [&](const std::string& load) {
    return center(folder.run(scene("end: 0.5, step: 0.001", "angular_velocity: [0, 0, 5]",
                                   "{instance: b, surface: x_min, " + load + "}")));
  };
  const Vector3 pressure = run("pressure: 7"), traction = run("traction: [7, 0, 0], follow: true"),
                stays = run("pressure: 7, follow: false"), dead = run("traction: [7, 0, 0]");
  EXPECT_LT((pressure - traction).norm(), 1e-12 * traction.norm());
  EXPECT_LT((stays - dead).norm(), 1e-12 * dead.norm());
  EXPECT_GT((pressure - stays).norm(), 0.5 * stays.norm());
}

// A load on faces that the superelement knows without keeping them turns the body as on a rigid
// one.
TEST(TurningLoads, ALoadInsideTurnsTheBody) {
  FolderWithBar folder;
  const std::string load = "{instance: b, surface: x_max, follow: true, force: [0, 0.001, 0]}";
  const Model stiff{"superelement", "interface: [x_min], modes: 12", 1e9};
  const auto run = [&](const std::string& as) {
    Model model = stiff;
    model.as = as;
    std::string yaml = scene("end: 0.5, step: 0.001", "angular_velocity: [0, 1, 0]", load, model);
    yaml.replace(yaml.find("b.x_min, b.x_max"), 16, "b.x_min");
    return folder.run(yaml);
  };
  const Ran elastic = run("superelement"), rigid = run("rigid");
  const auto last = rigid.result.time.size() - 1;
  EXPECT_LT((at(elastic.monitor("b.x_min").mean_position, last) -
             at(rigid.monitor("b.x_min").mean_position, last))
                .norm(),
            1e-5 * center(rigid).norm());
  EXPECT_GT(center(rigid).norm(), 0.05);
}

TEST(TurningLoads, ARestartGoesOnBitForBit) {
  FolderWithBar folder;
  test::expect_same_bits(test::restarted(
      folder,
      scene("end: 0.5, step: 0.001", "angular_velocity: [1, 2, 5]",
            "{instance: b, surface: x_min, follow: true, force: [0.01, 0, 0], history: {time: "
            "[0, 0.3], value: [0, 1]}}, {instance: b, surface: x_max, force: [0, 0.01, 0.02]}"),
      0.22));
}

}  // namespace
}  // namespace cbr::turning_loads_test
