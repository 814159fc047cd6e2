// SPDX-License-Identifier: GPL-3.0-or-later
// Modal mass scaling in whole scenes: statics and rigid motion stay exact, and what it costs in an
// impact falls with the step.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/base/error.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::mass_scaling_test {
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

TEST(MassScaling, CostsLittleAndLessWithTheStep) {
  const Blocks scenes;
  const Ran plain = scenes.run(impact("step: {cfl: 0.25}"));
  double last = HUGE_VAL, last_share = 1;
  for (const double cfl : {4.0, 2.0, 1.25}) {
    const Ran ran = scenes.run(impact("mass_scaling: true, step: {cfl: " + test::text(cfl) + "}"));
    EXPECT_GT(ran.built.simulation.plan.clip, 0);
    const double error = std::abs(end_speed(ran, "two") - end_speed(plain, "two")) / 0.5;
    std::printf(
        "%4.2f critical steps: %5ld steps, speed off by %.2e of the impact's, %.2e of the energy "
        "in scaled modes\n",
        cfl, static_cast<long>(ran.result.steps), error, ran.result.scaled_energy_share);
    EXPECT_LT(error, last);
    EXPECT_GT(ran.result.scaled_energy_share, 0);
    EXPECT_LT(ran.result.scaled_energy_share, last_share);
    last = error;
    last_share = ran.result.scaled_energy_share;
    // Exact whatever the clip
    const std::size_t n = ran.result.time.size() - 1;
    const Vector3 gained = at(ran.body("one").momentum, n) + at(ran.body("two").momentum, n) -
                           at(ran.body("one").momentum, 0);
    EXPECT_LT(gained.norm(), 1e-13);
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
    EXPECT_LT(ran.result.work_contact.back(), 1e-14);
  }
  EXPECT_LT(last, 5e-3);
}

TEST(MassScaling, NothingIsScaledUpToTheCriticalStep) {
  const Blocks scenes;
  const Ran plain = scenes.run(impact("step: {cfl: 0.8}")),
            scaled = scenes.run(impact("mass_scaling: true, step: {cfl: 0.8}"));
  EXPECT_EQ(scaled.built.simulation.plan.clip, 0);
  EXPECT_EQ(scaled.result.scaled_energy_share, 0);
  EXPECT_NEAR(end_speed(scaled, "two"), end_speed(plain, "two"), 1e-11);
}

TEST(MassScaling, TheStepIsThatOfWhatCannotBeScaled) {
  const Blocks scenes;
  const Ran ran = scenes.run(impact("mass_scaling: true", "mesh"));
  EXPECT_LE(ran.built.simulation.plan.h,
            1.8 / ran.built.simulation.bodies[1]->largest_frequency() * (1 + 1e-9));
  EXPECT_LT(test::energy_residual(ran.result), 1e-11);
  EXPECT_THROW(scenes.prepare(impact("mass_scaling: true, step: 0.05", "mesh")), InputError);
  EXPECT_THROW(
      scenes.prepare(impact("mass_scaling: true", "superelement", ", enforcement: penalty")),
      InputError);
}

// Pressed on a wall by its weight and at rest: its reaction and its compression are those of the
// unscaled body.
TEST(MassScaling, StaticsAreExact) {
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
    EXPECT_NEAR(force / n, 1, 2e-3);
    return -mean / n;
  };
  // rho g L^2 / (2 E) = 0.005; slow loading leaves the swinging at some thousandths of it
  EXPECT_NEAR(compression("step: {cfl: 0.5}"), 0.005, 3e-5);
  EXPECT_NEAR(compression("mass_scaling: true, step: {cfl: 3}"), 0.005, 3e-5);
}

}  // namespace
}  // namespace cbr::mass_scaling_test
