// SPDX-License-Identifier: GPL-3.0-or-later
// Points, links and ties of bodies that turn by any angle: pendulums, a bead on a rod, springs,
// universal joints, loops, loads on points, restart, and what is refused; against closed forms and
// the equations of motion.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "common/files/hdf5_file.hpp"
#include "dynamics/output/linear_results.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::turning_links_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// Blocks of 0.4 x 0.2 x 0.1, density 2.
const Vector3 size(0.4, 0.2, 0.1);
constexpr double mass = 0.016, J = mass / 12 * (0.16 + 0.04), arm = 0.2, g = 10;

struct Joined {
  std::string instances, links = {}, more = {}, time = {}, output = "every: 0.05";
  std::string component = {};
};

std::string yaml(const Joined& scene) {
  return "materials: {m: {youngs_modulus: 1.0e6, poissons_ratio: 0, density: 2}}\n"
         "components:\n  block: {mesh: block.exo, material: m, mass: consistent" +
         scene.component +
         ", points: {base: {surface: x_min}, tip: {surface: x_max}, hub: {surface: x_min, at: "
         "[0.2, 0.1, 0.05]}}}\ninstances:\n" +
         scene.instances + (scene.links.empty() ? "" : "links:\n") + scene.links + scene.more +
         "time: {" + scene.time + ", rotations: large}\noutput: {" + scene.output + "}\n";
}

const std::string reduced =
    ", reduction: {basis: craig-bampton, interface: [x_min, x_max], modes: 6}";

class TurningLinks : public ::testing::Test {
 protected:
  TurningLinks() { folder.add("block.exo", test::block_mesh({{4, 2, 1}, size})); }
  Ran run(const Joined& scene) const { return folder.run(yaml(scene)); }
  SceneFolder folder;
};

Vector3 sum(const Ran& ran, Series3 RunResult::OfBody::*of, std::size_t i) {
  Vector3 all = Vector3::Zero();
  for (const RunResult::OfBody& body : ran.result.bodies)
    if (!(body.*of).values.empty()) all += at(body.*of, i);
  return all;
}

// Largest change of a sum over all bodies, of the largest of it.
double drift(const Ran& ran, Series3 RunResult::OfBody::*of) {
  const Vector3 start = sum(ran, of, 0);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    worst = std::max(worst, (sum(ran, of, i) - start).norm());
    largest = std::max(largest, sum(ran, of, i).norm());
  }
  return worst / largest;
}

// y' = f(y) from y over t, by Runge and Kutta's rule in steps of 1e-5.
std::vector<double> integrated(
    const std::function<std::vector<double>(const std::vector<double>&)>& f, std::vector<double> y,
    double t) {
  const int n = static_cast<int>(std::ceil(t / 1e-5));
  const double h = t / n;
  const auto moved = [&](const std::vector<double>& by, double share) {
    std::vector<double> to = y;
    for (std::size_t i = 0; i < y.size(); ++i) to[i] += share * h * by[i];
    return to;
  };
  for (int step = 0; step < n; ++step) {
    const auto a = f(y), b = f(moved(a, 0.5)), c = f(moved(b, 0.5)), d = f(moved(c, 1));
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return y;
}

const std::string to_ground = "  - {between: [a.base, ground], fix: [x, y, z, rx, ry]}\n";
const std::string gravity = "loads: [{gravity: [0, -10, 0]}]\n";

// K(k), by the arithmetic-geometric mean.
double elliptic_k(double k) {
  double a = 1, b = std::sqrt(1 - k * k);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi / (2 * a);
}

// From 90 degrees at rest: 4 K(sin 45) / omega later it is there again, a quarter of that later it
// hangs down.
TEST_F(TurningLinks, APendulumHasItsEllipticPeriod) {
  const double omega = std::sqrt(mass * g * arm / (J + mass * arm * arm));
  const double period = 4 * elliptic_k(std::sqrt(0.5)) / omega;
  std::array<double, 3> errors{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double step = period / (100 << k);
    const Ran ran = run({.instances = "  a: {component: block, as: rigid}\n",
                         .links = to_ground,
                         .more = gravity,
                         .time = "end: " + text(period) + ", step: " + text(step),
                         .output = "every: " + text(period / 4) + ", history: [a.tip, a.base]"});
    const auto tip = [&](std::size_t i) { return at(ran.monitor("a.tip").mean_position, i); };
    errors[k] = std::max((tip(4) - Vector3(0.4, 0.1, 0.05)).norm(),
                         (tip(1) - Vector3(0, -0.3, 0.05)).norm());
    EXPECT_LT((at(ran.monitor("a.base").mean_position, 3) - Vector3(0, 0.1, 0.05)).norm(), 1e-12);
    EXPECT_NEAR(at(ran.monitor("a.tip").rotation, 1)[2], -std::numbers::pi / 2, errors[k] / 0.2);
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  }
  EXPECT_LT(errors[2], 1e-3 * 0.4);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.1) << errors[k];
}

// Angles, from hanging down, and rates of two rods, each of whose ends is a hinge.
std::vector<double> double_pendulum(const std::vector<double>& y) {
  const double l = 2 * arm, c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
  Eigen::Matrix2d M;
  M << J + mass * (arm * arm + l * l), mass * l * arm * c, mass * l * arm * c, J + mass * arm * arm;
  const Eigen::Vector2d force(
      -mass * l * arm * s * y[3] * y[3] - mass * g * (arm + l) * std::sin(y[0]),
      mass * l * arm * s * y[2] * y[2] - mass * g * arm * std::sin(y[1]));
  const Eigen::Vector2d rate = M.inverse() * force;
  return {y[2], y[3], rate[0], rate[1]};
}

Vector3 end_of_double_pendulum(double t) {
  const auto y = integrated(double_pendulum, {std::numbers::pi / 2, std::numbers::pi / 2, 0, 0}, t);
  return {0.4 * (std::sin(y[0]) + std::sin(y[1])), 0.1 - 0.4 * (std::cos(y[0]) + std::cos(y[1])),
          0.05};
}

const std::string in_a_row = "  - {between: [a.tip, b.base], fix: [x, y, z, rx, ry]}\n";

TEST_F(TurningLinks, ADoublePendulumOfRigidBodiesMovesByItsEquations) {
  std::array<double, 3> errors{};
  const Vector3 expected = end_of_double_pendulum(1.2);
  for (std::size_t k = 0; k < 3; ++k) {
    const Ran ran = run({.instances = "  a: {component: block, as: rigid}\n"
                                      "  b: {component: block, as: rigid, position: [0.4, 0, 0]}\n",
                         .links = to_ground + in_a_row,
                         .more = gravity,
                         .time = "end: 1.2, step: " + text(0.004 / (1 << k)),
                         .output = "every: 0.1, history: [b.tip]"});
    errors[k] = (at(ran.monitor("b.tip").mean_position, 12) - expected).norm();
    EXPECT_LT(test::energy_residual(ran.result), 1e-11);
  }
  EXPECT_LT(errors[2], 1e-3);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.2) << errors[k];
}

// Stiff ones move alike; what their links hold stays together.
TEST_F(TurningLinks, ADoublePendulumOfElasticBodiesMovesByItsEquations) {
  for (const std::string as : {"superelement", "mesh"}) {
    const Ran ran =
        run({.instances = "  a: {component: block, as: " + as +
                          "}\n  b: {component: block, as: " + as + ", position: [0.4, 0, 0]}\n",
             .links = to_ground + in_a_row,
             .more = gravity,
             .time = "end: 0.6",
             .output = "every: 0.05, history: [a.tip, b.base, b.tip]",
             .component = reduced});
    const auto mean = [&](const char* name, std::size_t i) {
      return at(ran.monitor(name).mean_position, i);
    };
    EXPECT_LT((mean("b.tip", 12) - end_of_double_pendulum(0.6)).norm(), 2e-3) << as;
    for (std::size_t i = 0; i < 13; ++i)
      EXPECT_LT((mean("a.tip", i) - mean("b.base", i)).norm(), 1e-11) << as << i;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9);
    for (const double work : ran.result.work_numerical) EXPECT_LT(std::abs(work), 2e-5) << as;
  }
}

// b slides along a, which turns about its middle: L = (2 J + m r^2) w stays, r'' = w^2 r. The force
// acts on a where b is.
TEST_F(TurningLinks, ABeadSlidesOutOnATurningRod) {
  const double L = (2 * J + mass * 0.09) * 3;
  const auto y = integrated(
      [&](const std::vector<double>& of) -> std::vector<double> {
        const double w = L / (2 * J + mass * of[0] * of[0]);
        return {of[1], of[0] * w * w, w};
      },
      {0.3, 0, 0}, 1);
  const Vector3 expected(0.2 + y[0] * std::cos(y[2]), 0.1 + y[0] * std::sin(y[2]), 0.25);
  std::array<double, 2> errors{};
  for (std::size_t k = 0; k < 2; ++k) {
    const Ran ran =
        run({.instances = "  a: {component: block, as: rigid, angular_velocity: [0, 0, 3]}\n"
                          "  b: {component: block, as: rigid, position: [0.3, 0, 0.2], velocity: "
                          "[0, 0.9, 0], angular_velocity: [0, 0, 3]}\n",
             .links = "  - {between: [a.hub, ground], fix: [x, y, z, rx, ry]}\n"
                      "  - {between: [a.hub, b.base], fix: [y, z, rx, ry, rz]}\n",
             .time = "end: 1, step: " + text(0.004 / (1 << k)),
             .output = "every: 0.1"});
    errors[k] = (at(ran.body("b").center_of_mass, 10) - expected).norm();
    const auto L_at = [&](std::size_t i) {  // about the hinge
      Vector3 of = Vector3::Zero();
      for (const RunResult::OfBody& body : ran.result.bodies)
        of += at(body.angular_momentum, i) -
              Vector3(0.2, 0.1, 0).cross(Vector3(at(body.momentum, i)));
      return of[2];
    };
    EXPECT_NEAR(L_at(10), L, 1e-12 * L);
  }
  EXPECT_LT(errors[1], 1e-5);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.1);
}

// A torsional spring counts whole turns: 10 sin 5 t radians.
TEST_F(TurningLinks, ATorsionalSpringCountsWholeTurns) {
  std::array<double, 2> errors{};
  for (std::size_t k = 0; k < 2; ++k) {
    const Ran ran =
        run({.instances = "  a: {component: block, as: rigid, angular_velocity: [0, 0, 50]}\n",
             .links = "  - {between: [a.hub, ground], fix: [x, y, z, rx, ry], stiffness: [0, 0, 0, "
                      "0, 0, " +
                      text(25 * J) + "]}\n",
             .time = "end: 1, step: " + text(0.002 / (1 << k)),
             .output = "every: 0.05, history: [a.tip]"});
    for (std::size_t i = 0; i < 21; ++i) {
      const double angle = 10 * std::sin(5 * ran.result.time[i]);
      const Vector3 tip(0.2 + 0.2 * std::cos(angle), 0.1 + 0.2 * std::sin(angle), 0.05);
      errors[k] = std::max(errors[k], (at(ran.monitor("a.tip").mean_position, i) - tip).norm());
    }
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  }
  EXPECT_LT(errors[1], 1e-4);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.1);
}

// Shafts at an angle of 30 degrees: tan of the one's rotation is cos 30 times that of the other's.
TEST_F(TurningLinks, AUniversalJointTurnsItsShaftsUnevenly) {
  const double beta = std::numbers::pi / 6, c = std::cos(beta), s = std::sin(beta);
  const std::string along = text(Vector3(c, s, 0));
  const Ran ran =
      run({.instances = "  a: {component: block, as: rigid, angular_velocity: [9, 0, 0]}\n"
                        "  b: {component: block, as: rigid, rotation: [0, 0, 30], position: " +
                        text(Vector3(0.4 + 0.1 * s, 0.1 - 0.1 * c, 0)) + "}\n",
           .links = "  - {between: [a.base, ground], fix: [x, y, z, ry, rz]}\n"
                    "  - {between: [b.tip, ground], fix: [x, y, z, ry, rz], axes: [" +
                    along + ", " + text(Vector3(-s, c, 0)) +
                    "]}\n"
                    "  - {between: [a.tip, b.base], fix: [rx], axes: [" +
                    along + ", [0, 0, 1]]}\n",
           .time = "end: 2, step: 0.004"});
  double most = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double *p = &ran.body("a").orientation[4 * i], *q = &ran.body("b").orientation[4 * i];
    const double first = 2 * std::atan2(p[1], p[0]),
                 second = 2 * std::atan2(c * q[1] + s * q[2], q[0]);
    most = std::max(most, std::abs(first));
    EXPECT_NEAR(std::sin(second) * std::cos(first), c * std::sin(first) * std::cos(second), 1e-11);
  }
  EXPECT_GT(most, 2);
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
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

// A loop of four bars, whose hinges hold more than they need to.
TEST_F(TurningLinks, ALoopOfHingesTurns) {
  const auto bar = [](const char* name, double x, double y, double angle, const char* more) {
    const double c = std::cos(angle), s = std::sin(angle);
    return std::string("  ") + name + ": {component: block, as: rigid, rotation: [0, 0, " +
           text(angle * 180 / std::numbers::pi) +
           "], position: " + text(Vector3(x + 0.1 * s, y - 0.1 * c, 0)) + more + "}\n";
  };
  const double right = std::numbers::pi / 2;
  const Ran ran =
      run({.instances =
               bar("a", 0, 0, right, ", angular_velocity: [0, 0, -2], velocity: [0.4, 0, 0]") +
               bar("b", 0, 0.4, 0, ", velocity: [0.8, 0, 0]") +
               bar("c", 0.4, 0, right, ", angular_velocity: [0, 0, -2], velocity: [0.4, 0, 0]"),
           .links = "  - {between: [a.base, ground], fix: [x, y, z, rx, ry]}\n"
                    "  - {between: [c.base, ground], fix: [x, y, z, rx, ry]}\n"
                    "  - {between: [a.tip, b.base], fix: [x, y, z, rx, ry]}\n"
                    "  - {between: [c.tip, b.tip], fix: [x, y, z, rx, ry]}\n",
           .time = "end: 0.6, step: 0.002",
           .output = "every: 0.1, history: [a.tip, b.tip]"});
  // A parallelogram in the plane without gravity: the rate stays
  for (std::size_t i = 0; i < 7; ++i) {
    const double angle = right - 2 * ran.result.time[i];
    const Vector3 a(0.4 * std::cos(angle), 0.4 * std::sin(angle), 0.05);
    EXPECT_LT((at(ran.monitor("a.tip").mean_position, i) - a).norm(), 1e-5) << i;
    EXPECT_LT((at(ran.monitor("b.tip").mean_position, i) - a - Vector3(0.4, 0, 0)).norm(), 1e-5);
  }
  EXPECT_LT(test::energy_residual(ran.result), 1e-11);
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
    EXPECT_LT(sum(ran, &RunResult::OfBody::momentum, ran.result.time.size() - 1).norm(), 1e-14);
    EXPECT_LT(test::energy_residual(ran.result), 1e-8);
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
  try {
    far();
    FAIL() << "no error";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("take a smaller time.step"), std::string::npos)
        << error.what();
  }
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
  EXPECT_NE(refusal(", inertia: [1, 1, 1]", "rigid").find("does not turn a point with inertia"),
            std::string::npos);
  EXPECT_EQ(refusal(", mass: 1", "rigid"), "no InputError");
}

}  // namespace
}  // namespace cbr::turning_links_test
