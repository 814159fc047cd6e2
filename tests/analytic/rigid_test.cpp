// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid bodies, as: rigid: flight, sliding, impact of an elastic bar, springs, supports, restart,
// and what is refused; against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::rigid_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

constexpr double density = 2, g = 10;
const Vector3 size(0.4, 0.2, 0.1);
const double mass = density * size.prod();

std::string scene(const std::string& instances, const std::string& rest, const std::string& time,
                  const std::string& output = "every: 0.01",
                  const std::string& more_of_block = "") {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0, density: 2}}\n"
         "components:\n"
         "  block: {mesh: block.exo, material: m" +
         more_of_block +
         "}\n"
         "  bar: {mesh: bar.exo, material: m, mass: lumped}\n"
         "instances:\n" +
         instances + rest + "time: " + time + "\noutput: {" + output + "}\n";
}

class Rigid : public ::testing::Test {
 protected:
  Rigid() {
    folder.add("block.exo", test::block_mesh({{4, 3, 2}, size}));
    folder.add("bar.exo", test::block_mesh({{80, 1, 1}, {2, 0.1, 0.1}}));
  }

  std::string refusal(const std::string& yaml) const {
    return test::refusal_of([&] { folder.prepare(yaml); });
  }

  SceneFolder folder;
};

// The angular momentum about the centre and the energy are kept, and the axis of the largest
// inertia keeps its direction.
TEST_F(Rigid, FliesAndTurnsByAnyAngle) {
  const Vector3 w(0, 0, 7), v(1, 2, 3);
  const Ran ran =
      folder.run(scene("  b: {component: block, as: rigid, velocity: " + text(v) +
                           ", angular_velocity: " + text(w) + "}\n",
                       "loads: [{gravity: [0, 0, -10]}]\n", "{end: 2, rotations: large}",
                       "every: 0.01, history: [b.x_max]"));
  const RunResult::OfBody& body = ran.body("b");
  const Vector3 c_0 = size / 2;
  for (std::size_t i = 0; i < ran.result.time.size(); i += 10) {
    const double t = ran.result.time[i];
    const Vector3 c = c_0 + v * t + Vector3(0, 0, -g * t * t / 2);
    EXPECT_LT((at(body.center_of_mass, i) - c).norm(), 1e-11);
    const Vector3 arm(0.2 * std::cos(7 * t), 0.2 * std::sin(7 * t), 0);
    EXPECT_LT((at(ran.monitor("b.x_max").mean_position, i) - c - arm).norm(), 1e-10);
    const double rolled = mass / 12 * (0.16 + 0.04) * 49 / 2;
    const Vector3 rate = v - Vector3(0, 0, g * t);
    EXPECT_NEAR(body.kinetic_energy[i], rolled + 0.5 * mass * rate.squaredNorm(), 1e-11);
  }
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
}

// v^2 / (2 mu g), on a wall and on a rigid base that is held; more nodes touch than there are
// coordinates.
TEST_F(Rigid, ABlockSlidesToRest) {
  for (const bool on_wall : {true, false}) {
    const std::string slides = "  b: {component: block, as: rigid, velocity: [1.2, 0, 0]}\n";
    const std::string base =
        "  base: {component: bar, as: rigid, position: [-0.5, 0, -0.1], rotation: [0, 0, 0]}\n";
    const std::string onto =
        on_wall ? "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
                : "boundary: [{instance: base, nodes: z_min, fix: [x, y, z]}]\n";
    const Ran ran =
        folder.run(scene(slides + (on_wall ? "" : base),
                         onto + "loads: [{gravity: [0, 0, -10]}]\ncontact: [{between: [b.z_min, " +
                             (on_wall ? "floor" : "base.z_max") + "], friction: 0.3}]\n",
                         "{end: 0.8, step: 0.001}", "every: 0.02"));
    const RunResult::OfBody& body = ran.body("b");
    const std::size_t last = ran.result.time.size() - 1;
    EXPECT_NEAR(at(body.center_of_mass, last)[0], 0.2 + 1.44 / 6, 0.001);
    EXPECT_LT(at(body.momentum, last).norm(), 1e-4 * mass * g * 0.0005);
    EXPECT_NEAR(at(body.center_of_mass, last)[2], 0.05, 1e-9);
    for (std::size_t i = 2; i < last; ++i)
      EXPECT_NEAR(at(ran.result.pairs[0]["force"], i)[2], mass * g, 1e-6 * mass * g) << i;
    EXPECT_LT(test::energy_residual(ran.result), 1e-10);
  }
}

// A bar of impedance z = rho c A runs onto a free rigid block of mass M: M v' = z (v_0 - v) until
// the wave comes back from its far end.
TEST_F(Rigid, ABarPushesABlockByItsImpedance) {
  const double c = std::sqrt(1000 / density), z = density * c * 0.01, end = 0.9 * 4 / c;
  const Ran ran =
      folder.run(scene("  bar: {component: bar, as: mesh, velocity: [1, 0, 0]}\n"
                       "  b: {component: block, as: rigid, position: [2, -0.05, 0]}\n",
                       "contact: [{between: [bar.x_max, b.x_min]}]\n", "{end: " + text(end) + "}",
                       "every: " + text(end / 40)));
  const RunResult::OfBody& body = ran.body("b");
  double worst = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double v = at(body.momentum, i)[0] / mass;
    worst = std::max(worst, std::abs(v - (1 - std::exp(-z / mass * ran.result.time[i]))));
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT((at(body.momentum, 40) + at(ran.body("bar").momentum, 40)).norm() - density * 0.02,
            1e-12);
}

// A wall with a mass of its own: a plate on rails, which a force pushes along a bar that it
// touches, with the velocity F / z (1 - exp(-z t / M)) until the wave comes back.
TEST_F(Rigid, APlateOnRailsIsAWallWithAMass) {
  const double c = std::sqrt(1000 / density), z = density * c * 0.01, end = 0.9 * 4 / c, F = 3;
  for (const char* integrator : {"exact", "central-difference", "newmark"}) {
    const Ran ran = folder.run(scene(
        "  bar: {component: bar, as: mesh}\n"
        "  plate: {component: block, as: rigid, position: [2, -0.05, 0]}\n",
        "boundary: [{instance: plate, nodes: y_min, fix: [y, z]}]\n"
        "loads: [{instance: plate, surface: x_max, force: [-3, 0, 0]}]\n"
        "contact: [{between: [bar.x_max, plate.x_min]}]\n",
        "{end: " + text(end) + ", step: " + text(end / 400) + ", integrator: " + integrator + "}",
        "every: " + text(end / 40)));
    const RunResult::OfBody& plate = ran.body("plate");
    double worst = 0;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
      const double v = -at(plate.momentum, i)[0] / mass;
      worst = std::max(worst, std::abs(v - F / z * (1 - std::exp(-z / mass * ran.result.time[i]))));
    }
    EXPECT_LT(worst, 0.02 * F / z) << integrator;
    // Its rails take nothing along x, and all that would turn it
    EXPECT_LT(std::abs(at(plate.reaction, 30)[0]), 1e-9 * F) << integrator;
    EXPECT_LT(at(plate.momentum, 30).tail<2>().norm(), 1e-12) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
  }
  EXPECT_SAYS(refusal(scene("  b: {component: block, as: rigid}\n",
                            "walls: {w: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}, mass: 3}}\n",
                            "{end: 1}")),
              "a wall with a mass of its own is an instance with as: rigid");
}

// sqrt(k / m), in --modes and in a run; the other motions are free.
TEST_F(Rigid, SwingsOnASpring) {
  const double k = 50, omega = std::sqrt(k / mass);
  const std::string yaml =
      scene("  b: {component: block, as: rigid, velocity: [0.1, 0, 0]}\n",
            "links: [{between: [b.hub, ground], stiffness: [50, 0, 0, 0, 0, 0]}]\n", "{end: 1}",
            "every: 0.0002, history: [b.hub]",
            ", points: {hub: {surface: x_min, at: [0.2, 0.1, 0.05], coupling: rigid}}");
  Report report("test", Verbosity::quiet);
  const auto modes = scene_modes(folder.prepare(yaml).scene, 6, report).instances;
  const Vector& found = modes.front().frequency_hz;
  ASSERT_EQ(found.size(), 6);
  EXPECT_EQ((found.array() == 0).count(), 5);
  EXPECT_NEAR(2 * std::numbers::pi * found[5], omega, 1e-9 * omega);
  const Ran ran = folder.run(yaml);
  double worst = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double x = at(ran.monitor("b.hub").mean_position, i)[0] - 0.2;
    worst = std::max(worst, std::abs(x - 0.1 / omega * std::sin(omega * ran.result.time[i])));
  }
  EXPECT_LT(worst, 2e-3 * 0.1 / omega);
}

// v = v_0 exp(-c t / m) by the step that the program chooses, however far apart the outputs are.
TEST_F(Rigid, ADashpotSetsTheStep) {
  const std::string hub = ", points: {hub: {surface: x_min, at: [0.2, 0.1, 0.05]}}",
                    moving = "  b: {component: block, as: rigid, velocity: [1, 0, 0]}\n";
  const auto run = [&](const std::string& instances, const std::string& links, double every) {
    return folder.run(scene(instances, "links:\n" + links, "{end: 2}",
                            "every: " + text(every) + ", history: [b.hub]", hub));
  };
  const double rate = 1, c = rate * mass;
  const std::string dashpot = "damping: [" + text(c) + ", 0, 0, 0, 0, 0]}\n";
  for (const double every : {0.1, 0.5}) {
    const Ran ran = run(moving, "  - {between: [b.hub, ground], " + dashpot, every);
    const std::size_t last = ran.result.time.size() - 1;
    EXPECT_NEAR(at(ran.body("b").momentum, last)[0] / mass, std::exp(-2.0), 0.006 * std::exp(-2.0));
    EXPECT_NEAR(at(ran.monitor("b.hub").mean_position, last)[0] - 0.2, 1 - std::exp(-2.0), 1e-5);
    EXPECT_NEAR(-ran.result.work_damping[last], 0.5 * mass * (1 - std::exp(-4.0)),
                0.006 * 0.5 * mass);
    EXPECT_SAYS(ran.built.simulation.plan.limit, "link 'b.hub - ground' (1 rad/s)");
  }
  // Two bodies approach each other's velocity twice as fast
  const Ran two = run(moving + "  free: {component: block, as: rigid, position: [1, 0, 0]}\n",
                      "  - {between: [b.hub, free.hub], " + dashpot, 0.5);
  EXPECT_NEAR(at(two.body("b").momentum, 4)[0] / mass, 0.5 * (1 + std::exp(-4.0)), 1e-3);
  EXPECT_SAYS(two.built.simulation.plan.limit, "(2 rad/s)");
  // A spring at the end of an arm e along y: k / m, and more by k e^2 / J
  const std::string arm = "  - {between: [b.hub, ground], stiffness: [0, 0, 8, 0, 0, 0]}\n";
  const std::string yaml =
      scene("  b: {component: block, as: rigid}\n", "links:\n" + arm, "{end: 2}", "every: 0.05",
            ", points: {hub: {surface: x_min, at: [0.2, 0.4, 0.05]}}");
  const double omega = std::sqrt(8 / mass * (1 + 0.3 * 0.3 * 12 / (0.2 * 0.2 + 0.1 * 0.1)));
  EXPECT_NEAR(folder.prepare(yaml).built.simulation.plan.h, 0.01 / omega, 1e-3 * 0.01 / omega);
}

// What swings faster than the outputs show takes no more than a thousand steps to an output; a step
// that is given stays.
TEST_F(Rigid, AStiffBushingTakesAThousandStepsToAnOutput) {
  const std::string hub = ", points: {hub: {surface: x_min, at: [0.2, 0.1, 0.05]}}";
  for (const auto& [time, h] :
       {std::pair("{end: 1}", 1e-4), std::pair("{end: 1, step: 0.05}", 0.05)})
    EXPECT_NEAR(folder
                    .prepare(scene("  b: {component: block, as: rigid}\n",
                                   "links: [{between: [b.hub, ground], stiffness: [1e9, 1e9, 1e9, "
                                   "1e9, 1e9, 1e9]}]\n",
                                   time, "every: 0.1", hub))
                    .built.simulation.plan.h,
                h, 1e-9 * h);
}

// A press: all of its motions are prescribed. The bar between it and a wall gets shorter by its
// travel, and carries E A e / L.
TEST_F(Rigid, APressHasNoCoordinatesOfItsOwn) {
  const Ran ran = folder.run(
      scene("  bar: {component: bar, as: mesh}\n"
            "  press: {component: block, as: rigid, position: [2, -0.05, 0]}\n",
            "boundary:\n"
            "  - {instance: press, nodes: x_max, fix: [x, y, z], displacement: [-0.01, 0, 0], "
            "history: {time: [0, 1], value: [0, 1]}}\n"
            "  - {instance: bar, nodes: x_min, fix: [x, y, z]}\n"
            "contact: [{between: [bar.x_max, press.x_min]}]\n",
            "{end: 1, static: true}", "every: 0.25"));
  const double force = 1000 * 0.01 * 0.01 / 2;
  EXPECT_NEAR(at(ran.body("press").reaction, 4)[0], -force, 1e-6 * force);
  EXPECT_NEAR(at(ran.result.pairs[0]["force"], 4)[0], -force, 1e-6 * force);
}

// Newmark and central differences move it alike.
TEST_F(Rigid, FallsAlikeInEveryIntegrator) {
  for (const char* way : {"exact", "central-difference", "newmark"}) {
    const Ran ran = folder.run(
        scene("  b: {component: block, as: rigid, position: [0, 0, 0.2]}\n",
              "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
              "loads: [{gravity: [0, 0, -10]}]\ncontact: [{between: [b.z_min, floor]}]\n",
              std::string("{end: 0.4, step: 0.001, integrator: ") + way + "}", "every: 0.02"));
    const RunResult::OfBody& body = ran.body("b");
    EXPECT_NEAR(at(body.center_of_mass, 5)[2], 0.25 - 0.5 * g * 0.01, 1e-4) << way;
    EXPECT_NEAR(at(body.center_of_mass, 20)[2], 0.05, 1e-6) << way;  // it stays down
    EXPECT_LT(at(body.momentum, 20).norm(), 1.001 * mass * g * 0.0005) << way;
  }
}

// Contact and friction alone hold it in statics; what they do not hold is named.
TEST_F(Rigid, StandsInStatics) {
  const std::string floor = "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n",
                    b = "  b: {component: block, as: rigid, position: [0, 0, 0.01]}\n",
                    statics = "{end: 1, step: 0.5, static: true}";
  const auto loaded = [&](const std::string& gravity) {
    return floor + "loads: [{gravity: " + gravity +
           "}]\ncontact: [{between: [b.z_min, floor], friction: 0.2}]\n";
  };
  const Ran ran = folder.run(scene(b, loaded("[1, 0, -10]"), statics));
  EXPECT_EQ(ran.result.failure, "");
  const std::size_t end = ran.result.time.size() - 1;
  EXPECT_LT((at(ran.result.pairs[0]["force"], end) - mass * Vector3(-1, 0, 10)).norm(),
            1e-9 * mass);
  EXPECT_NEAR(at(ran.body("b").center_of_mass, end)[2], size[2] / 2, 1e-9);
  const Ran lost = folder.run(scene(b, loaded("[3, 0, -10]"), statics));
  EXPECT_SAYS(lost.result.failure, "'b' is not held: under its loads it moves along [1, ");
}

// Heights e^2, e^4 ... of the first; with e = 1 no energy is lost.
TEST_F(Rigid, ReboundsByItsRestitution) {
  for (const std::string way : {"exact", "exact, rotations: large", "central-difference"})
    for (const double e : {0.8, 1.0}) {
      const Ran ran =
          folder.run(scene("  b: {component: block, as: rigid, position: [0, 0, 0.2]}\n",
                           "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
                           "loads: [{gravity: [0, 0, -10]}]\ncontact: [{between: [b.z_min, floor], "
                           "restitution: " +
                               text(e) + "}]\n",
                           "{end: 1.6, step: 0.001, integrator: " + way + "}", "every: 0.002"));
      double t = 0.2, height = 0.2;  // of the impact, and before it
      for (int k = 1; k <= 3; ++k) {
        height *= e * e;
        t += std::sqrt(2 * height / g);
        const auto top = static_cast<std::size_t>(std::lround(t / 0.002));
        double highest = 0;  // an impact is right to some steps
        for (std::size_t i = top - 10; i <= top + 10; ++i)
          highest = std::max(highest, at(ran.body("b").center_of_mass, i)[2] - 0.05);
        EXPECT_NEAR(highest, height, 2e-4 * 0.2) << way << ", " << e;
        EXPECT_NEAR(ran.result.work_contact[top], mass * g * (height - 0.2), 2e-4 * mass * g * 0.2);
        t += std::sqrt(2 * height / g);
      }
      EXPECT_LT(test::energy_residual(ran.result), 1e-12);
      if (e == 1) {
        EXPECT_NEAR(ran.result.work_contact.back(), 0, 1e-12);
      }
    }
}

// Two free blocks part with e of their approach, and keep their momentum. A block that lands flat
// is slowed by mu (1 + e) of its speed down.
TEST_F(Rigid, RestitutionIsOfTheRelativeVelocityAndFrictionOfAllItsImpulse) {
  const Ran met = folder.run(scene(
      "  b: {component: block, as: rigid, velocity: [2, 0, 0]}\n"
      "  bar: {component: bar, as: rigid, position: [0.43, 0.05, 0], velocity: [-1, 0, 0]}\n",
      "contact: [{between: [b.x_max, bar.x_min], restitution: 0.6}]\n", "{end: 0.1, step: 0.001}"));
  const double other = density * 2 * 0.01, common = (2 * mass - other) / (mass + other);
  EXPECT_NEAR(at(met.body("b").momentum, 10)[0] / mass, common - 1.8 * other / (mass + other),
              1e-12);
  EXPECT_LT(test::largest_change(met.result, &RunResult::OfBody::momentum), 1e-14);
  EXPECT_LT(test::energy_residual(met.result), 1e-12);
  const Ran slid = folder.run(
      scene("  b: {component: block, as: rigid, position: [0, 0, 0.0103], velocity: [3, 0, -1]}\n",
            "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
            "contact: [{between: [b.z_min, floor], friction: 0.3, restitution: 0.6}]\n",
            "{end: 0.05, step: 0.001}"));
  EXPECT_LT((at(slid.body("b").momentum, 5) / mass - Vector3(3 - 0.3 * 1.6, 0, 0.6)).norm(), 1e-9);
  EXPECT_LT(test::energy_residual(slid.result), 1e-12);
}

// With friction Newton's law may add energy to a rod that strikes with its end (Kane 1984).
TEST_F(Rigid, RestitutionAddsNoEnergyWithFriction) {
  for (const double degrees : {20, 35, 50, 65, 80})
    for (const double along : {-3, -1, 0, 1, 3}) {
      const Ran ran = folder.run(
          scene("  bar: {component: bar, as: rigid, position: [0, 0, 0.03], rotation: [0, " +
                    text(-degrees) + ", 0], velocity: [" + text(along) + ", 0, -1]}\n",
                "walls: {floor: {plane: {point: [0, 0, -0.02], normal: [0, 0, 1]}}}\n"
                "contact: [{between: all, friction: 0.8, restitution: 0.95}]\n",
                "{end: 0.3, step: 0.001, rotations: large}", "every: 0.001"));
      for (const double total : ran.result.total)
        EXPECT_LE(total, (1 + 1e-9) * ran.result.total[0]) << degrees << ", " << along;
      EXPECT_LT(ran.result.work_contact.back(), 0) << degrees << ", " << along;
      EXPECT_LT(test::energy_residual(ran.result), 1e-12);
    }
}

TEST_F(Rigid, GoesOnFromACheckpoint) {
  const std::string yaml = scene(
      "  b: {component: block, as: rigid, position: [0, 0, 0.05], angular_velocity: [3, 1, 0]}\n",
      "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
      "loads: [{gravity: [0, 0, -10]}]\ncontact: [{between: [b.z_min, floor], friction: 0.2, "
      "restitution: 0.7}]\n",
      "{end: 0.3, step: 0.001, rotations: large}", "every: 0.01");
  test::expect_same_bits(test::restarted(folder, yaml, 0.12));
}

TEST_F(Rigid, IsRefusedWhatOnlyElasticBodiesHave) {
  const std::string b = "  b: {component: block, as: rigid}\n";
  const auto expect = [&](const std::string& yaml, const std::string& words) {
    EXPECT_SAYS(refusal(yaml), words);
  };
  expect(scene("  b: {component: block, as: rigid, damping: {ratio: 0.1}}\n", "", "{end: 1}"),
         "a rigid body has no elastic modes");
  expect(scene(b, "", "{end: 1}", "every: 0.1, stress: [{instance: b, worst: 3}]"),
         "output.stress does not go with as: rigid");
  expect(scene(b, "", "{end: 1}", "every: 0.1, history: [b.nose]"), "nose");
  const std::string floor = "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n";
  const auto with = [&](const std::string& keys) {
    return floor + "contact: [{between: [b.z_min, floor], " + keys + "}]\n";
  };
  expect(scene("  b: {component: block, as: mesh}\n", with("restitution: 0.5"), "{end: 1}"),
         "restitution does not go with as: superelement or as: mesh");
  expect(scene(b, with("restitution: 0.5"), "{end: 1, integrator: newmark}"),
         "restitution does not go with integrator: newmark");
  expect(scene(b, with("restitution: 1.5"), "{end: 1}"), "found 1.5, expected a share from 0 to 1");
  expect(scene(b, with("restitution: 0.5, enforcement: penalty"), "{end: 1}"),
         "springs of 'penalty' have 'damping'");
}

}  // namespace
}  // namespace cbr::rigid_test
