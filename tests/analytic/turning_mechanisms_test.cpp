// SPDX-License-Identifier: GPL-3.0-or-later
// Mechanisms that turn by any angle against closed forms and their equations of motion: pendulums,
// a bead on a rod, a torsional spring, a universal joint, a loop of four bars.
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/linked_blocks.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::turning_mechanisms_test {
namespace {

using test::at;
using test::gravity;
using test::in_a_row;
using test::Ran;
using test::reduced;
using test::text;
using test::to_ground;

constexpr double mass = 0.016, J = mass / 12 * (0.16 + 0.04), arm = 0.2, g = 10;

class TurningMechanisms : public test::LinkedBlocks {};

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
TEST_F(TurningMechanisms, APendulumHasItsEllipticPeriod) {
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

TEST_F(TurningMechanisms, ADoublePendulumOfRigidBodiesMovesByItsEquations) {
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
TEST_F(TurningMechanisms, ADoublePendulumOfElasticBodiesMovesByItsEquations) {
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
TEST_F(TurningMechanisms, ABeadSlidesOutOnATurningRod) {
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
TEST_F(TurningMechanisms, ATorsionalSpringCountsWholeTurns) {
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
TEST_F(TurningMechanisms, AUniversalJointTurnsItsShaftsUnevenly) {
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

// A loop of four bars, whose hinges hold more than they need to.
TEST_F(TurningMechanisms, ALoopOfHingesTurns) {
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

// A bar from (x, y) on along an angle: its base is there.
std::string bar_at(const char* name, double x, double y, double angle, const std::string& more) {
  const double c = std::cos(angle), s = std::sin(angle);
  return std::string("  ") + name + ": {component: block, rotation: [0, 0, " +
         text(angle * 180 / std::numbers::pi) +
         "], position: " + text(Vector3(x + 0.1 * s, y - 0.1 * c, 0)) + more + "}\n";
}

const std::string hinge = ", fix: [x, y, z, rx, ry]}\n";

// A crank at 4 rad/s on a connecting rod, whose end slides along x: x = l cos a + sqrt(l^2 - l^2
// sin^2 a), twice l cos a for rods of one length; from 60 degrees to 20.
TEST_F(TurningMechanisms, ASliderCrankHasItsStroke) {
  const double l = 0.4, begin = std::numbers::pi / 3, rate = -4, end = 0.17;
  const Vector3 spin(0, 0, rate);
  for (const std::string as : {"rigid", "superelement", "mesh"}) {
    const Vector3 pin(l * std::cos(begin), l * std::sin(begin), 0);
    const Vector3 a = spin.cross(0.5 * pin),
                  b = spin.cross(pin) +
                      Vector3(0, 0, -rate).cross(Vector3(pin[0] / 2, -pin[1] / 2, 0));
    const Ran ran =
        run({.instances =
                 bar_at("a", 0, 0, begin,
                        ", as: rigid, angular_velocity: " + text(spin) + ", velocity: " + text(a)) +
                 bar_at("b", pin[0], pin[1], -begin,
                        ", as: " + as + ", angular_velocity: " + text(Vector3(-spin)) +
                            ", velocity: " + text(b)),
             .links = "  - {between: [a.base, ground], angular_velocity: " + text(spin) +
                      "}\n  - {between: [a.tip, b.base]" + hinge +
                      "  - {between: [b.tip, ground], fix: [y]}\n",
             .time = "end: " + text(end) + ", step: auto",
             .output = "every: 0.01, history: [a.tip, b.tip]",
             .component = reduced});
    for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
      const double angle = begin + rate * ran.result.time[i];
      const Vector3 tip(l * std::cos(angle), l * std::sin(angle), 0.05),
          slider(2 * l * std::cos(angle), 0, 0.05);
      EXPECT_LT((at(ran.monitor("a.tip").mean_position, i) - tip).norm(), 1e-11) << as << i;
      EXPECT_LT((at(ran.monitor("b.tip").mean_position, i) - slider).norm(),
                as == "rigid" ? 1e-11 : 2e-4)
          << as << i;
    }
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << as;
    // but for the impulses at the first step
    EXPECT_NEAR(ran.result.work_external.back(), ran.result.total.back() - ran.result.total.front(),
                1e-2 * ran.result.total.front())
        << as;
  }
}

TEST_F(TurningMechanisms, ARotationAboutSeveralAxesIsRefused) {
  EXPECT_SAYS(test::refusal_of([&] {
                run({.instances = bar_at("a", 0, 0, 0, ", as: rigid"),
                     .links = "  - {between: [a.base, ground], angular_velocity: [0, 1, 2]}\n",
                     .time = "end: 0.1",
                     .output = "every: 0.05"});
              }),
              "about several axes: give one axis");
}

// A crank through two whole turns in a four-bar linkage (0.4, 0.8, 0.8; ground 1): the coupler's
// end is where the circles meet.
TEST_F(TurningMechanisms, AFourBarLinkageFollowsItsCrank) {
  const double l = 0.4, ground = 1;
  // Coupler of two blocks and rocker of two blocks, welded in rows: each 0.8 long
  const auto meet = [&](const Vector3& pin) -> Vector3 {
    const Vector3 apart = Vector3(ground, 0, 0) - pin;
    const double d = apart.norm(), h = std::sqrt(0.64 - d * d / 4);
    return pin + apart / 2 + h / d * Vector3(-apart[1], apart[0], 0);
  };
  const Vector3 pin(l, 0, 0), joint = meet(pin);
  const double up = std::atan2(joint[1], joint[0] - l),
               down = std::atan2(joint[1], joint[0] - ground);
  const auto row = [&](const char* first, const char* second, const Vector3& at, double angle) {
    const Vector3 along(0.4 * std::cos(angle), 0.4 * std::sin(angle), 0);
    return bar_at(first, at[0], at[1], angle, ", as: rigid") +
           bar_at(second, at[0] + along[0], at[1] + along[1], angle, ", as: rigid");
  };
  const Ran ran = run({.instances = bar_at("a", 0, 0, 0, ", as: rigid") + row("b", "c", pin, up) +
                                    row("d", "e", Vector3(ground, 0, 0), down),
                       .links = "  - {between: [a.base, ground], rotation: [0, 0, 720], history: "
                                "{time: [0, 0.5, 1], value: [0, 0.4, 1]}}\n"
                                "  - {between: [a.tip, b.base]" +
                                hinge +
                                "  - {between: [b.tip, c.base]}\n  - {between: [d.tip, e.base]}\n"
                                "  - {between: [d.base, ground]" +
                                hinge + "  - {between: [c.tip, e.tip]" + hinge,
                       .time = "end: 1",
                       .output = "every: 0.05, history: [a.tip, c.tip]"});
  double most = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const Vector3 tip = at(ran.monitor("a.tip").mean_position, i) - Vector3(0, 0, 0.05);
    EXPECT_NEAR(tip.norm(), l, 1e-11);
    EXPECT_LT((at(ran.monitor("c.tip").mean_position, i) - Vector3(0, 0, 0.05) - meet(tip)).norm(),
              1e-10)
        << i;
    most = std::max(most, tip[1]);
  }
  EXPECT_GT(most, 0.35);
  EXPECT_LT((at(ran.monitor("a.tip").mean_position, 20) - Vector3(l, 0, 0.05)).norm(), 1e-10);
  EXPECT_LT(test::energy_residual(ran.result), 1e-9);
}

// A rod swings against a spring of 20 degrees on: a half sine in the stop, and back.
TEST_F(TurningMechanisms, AHingeHasStopsAndFriction) {
  const double w = 2, stop = std::numbers::pi / 9, inertia = J + mass * arm * arm, omega = 40,
               k = omega * omega * inertia;
  const std::string table = "[[" + text(-stop - 1) + ", " + text(-k) + "], [" + text(-stop) +
                            ", 0], [" + text(stop) + ", 0], [" + text(stop + 1) + ", " + text(k) +
                            "]]";
  const auto swings = [&](const std::string& more, double end, double step) {
    return run({.instances = "  a: {component: block, as: rigid, angular_velocity: [0, 0, " +
                             text(w) + "], velocity: [0, " + text(w * arm) + ", 0]}\n",
                .links = "  - {between: [a.base, ground], fix: [x, y, z, rx, ry], " + more + "}\n",
                .time = "end: " + text(end) + ", step: " + text(step),
                .output = "every: " + text(end / 20) + ", history: [a.base]"});
  };
  std::array<double, 2> errors{};
  const double end = 2 * stop / w + std::numbers::pi / omega;
  for (std::size_t j = 0; j < 2; ++j) {
    const Ran ran = swings("force: {rz: " + table + "}", end, end / (400 << j));
    for (std::size_t i = 0; i < 21; ++i) {
      const double t = ran.result.time[i], s = t - stop / w;
      const double angle = s < 0                          ? w * t
                           : s < std::numbers::pi / omega ? stop + w / omega * std::sin(omega * s)
                                                          : w * (end - t);
      errors[j] = std::max(errors[j], std::abs(at(ran.monitor("a.base").rotation, i)[2] - angle));
    }
    EXPECT_LT(test::energy_residual(ran.result), 1e-11);
  }
  EXPECT_LT(errors[1], 1e-3 * stop);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
  // M / I = 4: it stops after half a second and half a radian
  const Ran rubs = swings("friction: {rz: " + text(4 * inertia) + "}", 1, 1e-3);
  for (std::size_t i = 0; i < 21; ++i) {
    const double t = rubs.result.time[i];
    EXPECT_NEAR(at(rubs.monitor("a.base").rotation, i)[2], t < 0.5 ? w * t - 2 * t * t : 0.5, 1e-3);
  }
  EXPECT_LT(test::energy_residual(rubs.result), 1e-11);
  EXPECT_NEAR(rubs.result.work_damping.back(), -0.5 * inertia * w * w, 2e-3 * inertia * w * w);
}

// A block that hangs by its tip on a spring, or on a cable that takes tension alone, whose other
// end is at (0.8, 0.5): its centre, its angle and their rates.
std::vector<double> hung(const std::vector<double>& y, bool is_cable) {
  const Eigen::Vector2d lever(arm * std::cos(y[2]), arm * std::sin(y[2])),
      line = Eigen::Vector2d(y[0], y[1]) + lever - Eigen::Vector2d(0.8, 0.5);
  const double elongation = line.norm() - std::sqrt(0.32);
  const Eigen::Vector2d force =
      -(is_cable ? std::max(0.0, elongation) : elongation) * line.normalized();
  return {y[3],
          y[4],
          y[5],
          force[0] / mass,
          force[1] / mass - g,
          (lever[0] * force[1] - lever[1] * force[0]) / J};
}

TEST_F(TurningMechanisms, ASpringAlongALineFollowsIt) {
  for (const bool is_cable : {false, true}) {
    SCOPED_TRACE(is_cable ? "cable" : "spring");
    const auto y = integrated([&](const std::vector<double>& of) { return hung(of, is_cable); },
                              {0.2, 0.1, 0, 0, 3, 0}, 1);
    const Vector3 expected(y[0] + arm * std::cos(y[2]), y[1] + arm * std::sin(y[2]), 0.05);
    const auto error = [&](const std::string& as, double step) {
      const Ran ran =
          run({.instances = "  a: {component: block, as: " + as + ", velocity: [0, 3, 0]}\n",
               .links = std::string("  - {between: [a.tip, ground], axes: line, ground: [0.8, 0.5, "
                                    "0.05], ") +
                        (is_cable ? "force: {x: [[-1, 0], [0, 0], [1, 1]]}"
                                  : "stiffness: [1, 0, 0, 0, 0, 0]") +
                        "}\n",
               .more = gravity,
               .time = "end: 1, step: " + (step > 0 ? text(step) : "auto"),
               .output = "every: 0.1, history: [a.tip]",
               .component = as == "rigid" ? "" : reduced});
      EXPECT_LT(test::energy_residual(ran.result), 1e-12) << as;
      return (at(ran.monitor("a.tip").mean_position, 10) - expected).norm();
    };
    const std::array errors{error("rigid", 4e-3), error("rigid", 2e-3), error("rigid", 1e-3)};
    EXPECT_LT(errors[2], 2e-5);
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2, 0.02) << errors[1];
    EXPECT_LT(error("superelement", 0), 2e-5);
  }
}

// Two blocks in free flight on a rod of one length.
TEST_F(TurningMechanisms, ARodKeepsItsLength) {
  for (const std::string as : {"rigid", "superelement", "mesh"}) {
    SCOPED_TRACE(as);
    const Ran ran =
        run({.instances = "  a: {component: block, as: " + as +
                          ", angular_velocity: [1, 2, 3]}\n  b: {component: block, as: " + as +
                          ", position: [0.9, 0.3, 0.2], velocity: [0.3, 1, -0.5]}\n",
             .links = "  - {between: [a.tip, b.base], axes: line}\n",
             .time = std::string("end: 2, step: ") + (as == "rigid" ? "1.0e-3" : "auto"),
             .output = "every: 0.1, history: [a.tip, b.base]",
             .component = as == "superelement" ? reduced : ""});
    const auto apart = [&](std::size_t i) {
      return (at(ran.monitor("a.tip").mean_position, i) -
              at(ran.monitor("b.base").mean_position, i))
          .norm();
    };
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      EXPECT_NEAR(apart(i), apart(0), 5e-13) << i;
    EXPECT_LT(test::energy_residual(ran.result), 2e-13);
    const auto changed = [&](Series3 RunResult::OfBody::*of) {
      return test::largest_change(ran.result, of) / test::total(ran.result, of, 0).norm();
    };
    EXPECT_LT(changed(&RunResult::OfBody::momentum), 1e-13);
    EXPECT_LT(changed(&RunResult::OfBody::angular_momentum), 1e-13);
  }
}

}  // namespace
}  // namespace cbr::turning_mechanisms_test
