// SPDX-License-Identifier: GPL-3.0-or-later
// Steps above the critical one, of superelements whose highest modes are quasi-static: statics and
// rigid motion stay exact, and what it costs in an impact falls with the step.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/base/error.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::long_steps_test {
namespace {

using test::at;
using test::Ran;

// A block (c = 10, 1 long) at speed 0.5 on one at rest, turned about y and mirrored; their faces do
// not match.
std::string impact(const std::string& time, const std::string& second = "superelement",
                   const std::string& contact = "") {
  return R"(materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}
components:
  one: {mesh: one.exo, material: m, reduction: {interface: [x_max], modes: 30, superelement: one.cbr.h5}}
  two: {mesh: two.exo, material: m, reduction: {interface: [x_max], modes: 30, superelement: two.cbr.h5}}
instances:
  one: {component: one, as: superelement, velocity: [0.5, 0, 0]}
  two: {component: two, as: )" +
         second + R"(, position: [2.001, 0.1, 0], mirror: x}
contact:
  - {between: [one.x_max, two.x_max])" +
         contact + R"(}
time: {end: 0.6, )" +
         time + R"(}
output: {every: 0.6, history: [one.x_max, two.x_max]}
)";
}

struct Blocks : test::SceneFolder {
  Blocks() {
    add("one.exo", test::block_mesh({{6, 4, 4}}));
    add("two.exo", test::block_mesh({{6, 3, 5}, Vector3(1, 0.8, 1)}));
  }
};

double end_speed(const Ran& ran, const std::string& body) {
  return at(ran.body(body).momentum, ran.result.time.size() - 1)[0] / ran.mass(body);
}

Index n_following(const Ran& ran) {
  Index n = 0;
  for (const auto& of : ran.built.instances) n += of.n_following;
  return n;
}

TEST(LongSteps, CostLittleAndLessWithTheStep) {
  const Blocks scenes;
  const Ran plain = scenes.run(impact("step: {cfl: 0.25}"));
  double last = HUGE_VAL;
  for (const double cfl : {4.0, 2.0, 1.25}) {
    const Ran ran = scenes.run(impact("step: {cfl: " + test::text(cfl) + "}"));
    const double error = std::abs(end_speed(ran, "two") - end_speed(plain, "two")) / 0.5;
    std::printf("%4.2f critical steps: %5ld steps, %ld quasi-static modes, speed off by %.2e\n",
                cfl, static_cast<long>(ran.result.steps), static_cast<long>(n_following(ran)),
                error);
    EXPECT_LT(error, last);
    EXPECT_GT(n_following(ran), 0);
    last = error;
    // Exact whatever the modes are
    const std::size_t n = ran.result.time.size() - 1;
    const Vector3 gained = at(ran.body("one").momentum, n) + at(ran.body("two").momentum, n) -
                           at(ran.body("one").momentum, 0);
    EXPECT_LT(gained.norm(), 1e-13);
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
    EXPECT_LT(ran.result.work_contact.back(), 1e-14);
  }
  EXPECT_LT(last, 5e-3);
}

TEST(LongSteps, AreAsLongAsTheyWereAskedFor) {
  const Blocks scenes;
  const auto plan = [&](const std::string& time) {
    std::string scene = impact(time);
    scene.replace(scene.find("every: 0.6"), 10, "every: 0");
    return scenes.prepare(scene).built.simulation.plan;
  };
  const double critical = plan("step: {cfl: 1}").h;  // all divide the end
  for (const double cfl : {1.5, 3.0, 6.0})
    EXPECT_NEAR(plan("step: {cfl: " + test::text(cfl) + "}").h, cfl * critical, 1e-14);
}

// Outputs that make steps short need no quasi-static modes.
TEST(LongSteps, ModesMoveThatOutputsShow) {
  const Blocks scenes;
  std::string scene = impact("step: {cfl: 3}");
  scene.replace(scene.find("every: 0.6"), 10, "every: 0.001");
  EXPECT_EQ(scenes.prepare(scene).built.instances[0].n_following, 0);
}

TEST(LongSteps, AreThoseOfWhatAllModesMove) {
  const Blocks scenes;
  const Ran ran = scenes.run(impact("step: {cfl: 2}", "mesh"));
  EXPECT_LE(ran.built.simulation.plan.h,
            1.8 / ran.built.simulation.bodies[1]->largest_frequency() * (1 + 1e-9));
  EXPECT_LT(test::energy_residual(ran.result), 1e-11);
  EXPECT_THROW(scenes.prepare(impact("step: 0.05", "mesh")), InputError);
  const Ran springs =
      scenes.prepare(impact("step: {cfl: 2}", "superelement", ", enforcement: penalty"));
  EXPECT_EQ(n_following(springs), 0);
  EXPECT_LE(springs.built.simulation.plan.h,
            0.5 / springs.built.simulation.bodies[0]->largest_frequency() * (1 + 1e-9));
}

// Pressed on a wall by its weight and at rest: its reaction and its compression are those of all
// modes.
TEST(LongSteps, StaticsAreExact) {
  test::SceneFolder scenes;
  scenes.add("one.exo", test::block_mesh({{3, 3, 3}}));
  const auto compression = [&](const std::string& time) {
    const Ran ran =
        scenes.run(R"(materials: {m: {youngs_modulus: 100, poissons_ratio: 0, density: 1}}
components:
  one: {mesh: one.exo, material: m, reduction: {interface: [x_min, x_max], modes: 12, superelement: one.cbr.h5}}
instances: {one: {component: one, as: superelement}}
walls: {floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}
contact: [{between: [one.x_min, floor]}]
loads: [{gravity: [-1, 0, 0], history: {time: [0, 20, 40], value: [0, 1, 1]}}]
time: {end: 40, )" +
                   time + R"(}
output: {every: 0.5, history: [one.x_min, one.x_max]}
)");
    double mean = 0, force = 0;
    for (std::size_t i = 41; i < ran.result.time.size(); ++i) {
      mean += at(ran.monitor("one.x_max").mean_position, i)[0] -
              at(ran.monitor("one.x_max").mean_position, 0)[0];
      force += at(ran.monitor("one.x_min").force, i)[0];
    }
    const double n = static_cast<double>(ran.result.time.size() - 41);
    EXPECT_NEAR(force / n, 1, 1e-4);
    return -mean / n;
  };
  // rho g L^2 / (2 E) = 0.005; slow loading leaves the swinging at 1e-4 of it
  EXPECT_NEAR(compression("step: {cfl: 0.5}"), 0.005, 3e-6);
  EXPECT_NEAR(compression("step: {cfl: 3}"), 0.005, 3e-6);
}

// Held, pulled along its side until it meets a wall: where forces act or push, statics are those of
// all modes.
TEST(LongSteps, StaticsAreExactWithSupportsAndLoads) {
  test::SceneFolder scenes;
  scenes.add("one.exo", test::block_mesh({{4, 3, 3}}));
  const auto positions = [&](const std::string& time) {
    const Ran ran =
        scenes.run(R"(materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}
components:
  one: {mesh: one.exo, material: m, reduction: {interface: [x_min, x_max, y_max], modes: 12, superelement: one.cbr.h5}}
instances: {one: {component: one, as: superelement, damping: {ratio: 0.1}}}
walls: {wall: {plane: {point: [1.001, 0, 0], normal: [-1, 0, 0]}}}
boundary: [{instance: one, nodes: x_min, fix: [x, y, z]}]
contact: [{between: [one.x_max, wall]}]
loads: [{instance: one, surface: y_max, traction: [3, 1, 0], history: {time: [0, 20], value: [0, 1]}}]
time: {end: 40, )" +
                   time + R"(}
output: {every: 0.5, history: [one.x_max, one.y_max]}
)");
    EXPECT_EQ(n_following(ran) > 0, time.find('3') != std::string::npos);
    const std::size_t last = ran.result.time.size() - 1;
    Eigen::Matrix<double, 9, 1> all;
    all << at(ran.monitor("one.x_max").mean_position, last),
        at(ran.monitor("one.y_max").mean_position, last), at(ran.monitor("one.x_max").force, last);
    return all;
  };
  const auto all = positions("step: {cfl: 0.5}"), few = positions("step: {cfl: 3}");
  EXPECT_GT(all.tail(3).norm(), 0.01);
  EXPECT_LT((few - all).head(6).norm(), 1e-9);
  EXPECT_LT((few - all).tail(3).norm(), 1e-9 * all.tail(3).norm());
}

}  // namespace
}  // namespace cbr::long_steps_test
