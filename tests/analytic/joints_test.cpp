// SPDX-License-Identifier: GPL-3.0-or-later
// Springs, dashpots and bushings between points, masses of points, rigid couplings: closed forms in
// every integrator and basis.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::joints_test {
namespace {

using test::at;
using test::last;
using test::Ran;
using test::SceneFolder;
using test::text;

// Bars of length 4 along x, 1 x 1, of mass 4, so stiff that they move as rigid bodies: a bar under
// a force at its end is longer by F length / (3 E A) from its centre on.
constexpr double E = 1e5, length = 4, mass = 4;
const std::vector<std::string> kinds{"mesh", "craig-bampton, modes: 8", "massless, modes: 20",
                                     "characteristic, modes: 20"};

struct Jointed {
  std::string kind = "mesh";
  int bars = 2;
  std::string points = "base: {surface: x_min}, tip: {surface: x_max}",
              velocities[2] = {"[0, 0, 0]", "[0, 0, 0]"};
  std::string more = {}, time = "end: 4", output = "every: 0.1, history: [a.tip, b.base]";
};

std::string yaml(const Jointed& scene) {
  const std::string more = scene.kind.starts_with("char") ? ", y_max" : "";
  const std::string reduction =
      scene.kind == "mesh"
          ? ""
          : ", reduction: {basis: " + scene.kind + ", interface: [x_min, x_max" + more + "]}";
  std::string text = "materials:\n  hard: {youngs_modulus: " + test::text(E) +
                     ", poissons_ratio: 0, density: 1}\ncomponents:\n  bar: {mesh: bar.exo, "
                     "material: hard, points: {" +
                     scene.points + "}" + reduction + "}\ninstances:\n";
  for (int i = 0; i < scene.bars; ++i)
    text += std::string("  ") + "ab"[i] +
            ": {component: bar, as: " + (scene.kind == "mesh" ? "mesh" : "superelement") +
            ", position: [" + test::text(5.0 * i) + ", 0, 0], velocity: " + scene.velocities[i] +
            "}\n";
  return text + scene.more + "time: {" + scene.time + "}\noutput: {" + scene.output + "}\n";
}

class Joints : public ::testing::TestWithParam<std::string> {
 protected:
  Joints() { folder.add("bar.exo", test::block_mesh({{8, 2, 2}, {length, 1, 1}})); }

  // "exact" and so on, as the kind has them.
  static std::vector<std::string> integrators() {
    std::vector<std::string> all{"integrator: exact", "integrator: central-difference"};
    if (!GetParam().starts_with("massless")) all.emplace_back("integrator: newmark, step: 0.005");
    return all;
  }

  SceneFolder folder;
};

// Largest difference of a component of a motion from what is expected, over the outputs.
double worst(const Ran& ran, const std::function<double(std::size_t)>& found,
             const std::function<double(double)>& expected) {
  double error = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i)
    error = std::max(error, std::abs(found(i) - expected(ran.result.time[i])));
  return error;
}

// The motion of a.tip along x since the start.
std::function<double(std::size_t)> moved(const Ran& ran, const std::string& point, int axis) {
  return [&ran, point, axis](std::size_t i) {
    return at(ran.monitor(point).mean_position, i)[axis] -
           at(ran.monitor(point).mean_position, 0)[axis];
  };
}

// k of the spring in series with both bars.
double softened(double k) { return 1 / (1 / k + 2 * length / (3 * E)); }

// Two masses on a spring and a dashpot: r'' + 2 zeta omega r' + omega^2 r = 0.
TEST_P(Joints, TwoMassesOnASpringAndADashpot) {
  for (const std::string& integrator : integrators())
    for (const double c : {0.0, 3.0}) {
      Jointed scene{.kind = GetParam(), .velocities = {"[0.01, 0, 0]", "[-0.01, 0, 0]"}};
      const double k = 8, omega = std::sqrt(softened(k) / (mass / 2)),
                   zeta = c / (2 * omega * mass / 2);
      scene.more = "links:\n  - {between: [a.tip, b.base], stiffness: [8, 0, 0, 0, 0, 0]" +
                   (c > 0 ? ", damping: [" + text(c) + ", 0, 0, 0, 0, 0]" : std::string()) + "}\n";
      scene.time = "end: 4, " + integrator;
      const Ran ran = folder.run(yaml(scene));
      const double damped = omega * std::sqrt(1 - zeta * zeta), amplitude = 0.02 / damped;
      const auto apart = [&](std::size_t i) {
        return moved(ran, "a.tip", 0)(i) - moved(ran, "b.base", 0)(i);
      };
      const auto expected = [&](double t) {
        return amplitude * std::exp(-zeta * omega * t) * std::sin(damped * t);
      };
      EXPECT_LT(worst(ran, apart, expected), 3e-4 * amplitude) << integrator << c;
      EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
      const double energy = ran.result.total.front();
      for (std::size_t i = 0; i < ran.result.time.size(); ++i)
        EXPECT_LT(std::abs(ran.result.work_contact[i]),
                  (GetParam().starts_with("massless") ? 5e-3 : 2e-3) * energy)
            << integrator;
      // but for what swings at twice the frequency
      const double lost = 1 - std::exp(-2 * zeta * omega * 4);
      EXPECT_NEAR(-ran.result.work_damping.back(), lost * energy, c > 0 ? 0.05 * energy : 0)
          << integrator;
      EXPECT_LT((at(ran.body("a").momentum, 20) + at(ran.body("b").momentum, 20)).norm(), 1e-12);
    }
}

// With small rotations a spring along a line is one along a fixed axis.
TEST_P(Joints, ASpringAlongALineIsAlongAnAxis) {
  for (const std::string& integrator : integrators()) {
    const auto moves = [&](const std::string& links, int bars) {
      Jointed scene{
          .kind = GetParam(), .bars = bars, .velocities = {"[0.01, 0.02, 0]", "[0, 0, 0]"}};
      scene.more = "links:\n  - {between: [a.tip, " + links + "}\n";
      scene.time = "end: 1, " + integrator;
      scene.output = "every: 0.1, history: [a.tip]";
      const Ran ran = folder.run(yaml(scene));
      return at(ran.monitor("a.tip").mean_position, 10);
    };
    const std::string spring = "stiffness: [8, 0, 0, 0, 0, 0], ";
    EXPECT_LT((moves("ground], " + spring + "axes: line, ground: [7, 4.5, 0.5]", 1) -
               moves("ground], " + spring + "axes: [[3, 4, 0], [-4, 3, 0]]", 1))
                  .norm(),
              4e-15)
        << integrator;
    EXPECT_LT((moves("b.base], " + spring + "axes: line", 2) -
               moves("b.base], " + spring + "axes: [[1, 0, 0], [0, 1, 0]]", 2))
                  .norm(),
              4e-15)
        << integrator;
  }
}

// However stiff it is, a spring limits no step.
TEST_P(Joints, AStiffBushingIsStable) {
  for (const std::string& integrator : integrators()) {
    Jointed scene{.kind = GetParam(), .velocities = {"[0.01, 0.01, 0]", "[-0.01, 0, 0.02]"}};
    scene.more =
        "links:\n  - {between: [a.tip, b.base], stiffness: [1e9, 1e9, 1e9, 1e9, 1e9, 1e9], "
        "damping: [0, 1e3, 0, 0, 0, 1e3]}\n";
    scene.time = "end: 1, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    EXPECT_LT(test::energy_residual(ran.result), 1e-8) << integrator;
    for (const double total : ran.result.total)
      EXPECT_LT(total, 1.05 * ran.result.total.front()) << integrator;
    // It acts where a.tip is, which lies before b.base by 1
    const double at_tip = moved(ran, "b.base", 1)(10) - at(ran.monitor("b.base").rotation, 10)[2];
    EXPECT_LT(std::abs(moved(ran, "a.tip", 1)(10) - at_tip), 1e-7) << integrator;
  }
}

// A gap of 0.01 to both sides of 0, then k: flights at the speed v and half sines, and all energy
// back.
TEST_P(Joints, AGapBetweenTwoMasses) {
  const double gap = 0.01, v = 0.02, omega = std::sqrt(softened(8) / (mass / 2)),
               pi = std::numbers::pi;
  const auto expected = [&](double t) {
    const double half = 2 * gap / v + pi / omega, in_half = std::fmod(t + gap / v, half),
                 side = std::fmod(t + gap / v, 2 * half) < half ? 1 : -1, s = in_half - 2 * gap / v;
    return side * (s < 0 ? v * in_half - gap : gap + v / omega * std::sin(omega * s));
  };
  for (const std::string& integrator : integrators()) {
    Jointed scene{.kind = GetParam(), .velocities = {"[0.01, 0, 0]", "[-0.01, 0, 0]"}};
    scene.more =
        "links:\n  - {between: [a.tip, b.base], force: {x: [[-0.02, -0.08], [-0.01, 0], [0.01, 0], "
        "[0.02, 0.08]]}}\n";
    scene.time = "end: 6, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    const auto apart = [&](std::size_t i) {
      return moved(ran, "a.tip", 0)(i) - moved(ran, "b.base", 0)(i);
    };
    EXPECT_LT(worst(ran, apart, expected), 2e-3 * gap) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      EXPECT_LT((at(ran.body("a").momentum, i) + at(ran.body("b").momentum, i)).norm(), 1e-12);
    EXPECT_LT(std::abs(ran.result.work_contact.back()), 5e-3 * ran.result.total.front());
  }
}

// Dry friction stops a bar after v^2 / 2 a, and it stays there: m v^2 / 2 is gone.
TEST_P(Joints, FrictionStopsASlider) {
  const double v = 0.1, a = 0.2 / mass, way = v * v / (2 * a);
  for (const std::string& integrator : integrators()) {
    Jointed scene{.kind = GetParam(),
                  .bars = 1,
                  .velocities = {"[0.1, 0, 0]", ""},
                  .output = "every: 0.1, history: [a.base]"};
    scene.more =
        "links:\n  - {between: [a.base, ground], fix: [y, z, rx, ry, rz], friction: {x: 0.2}}\n";
    scene.time = "end: 3, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    const auto expected = [&](double t) { return t < v / a ? v * t - a * t * t / 2 : way; };
    EXPECT_LT(worst(ran, moved(ran, "a.base", 0), expected), 2e-3 * way) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
    EXPECT_NEAR(ran.result.work_damping.back(), -0.5 * mass * v * v, 1e-2 * 0.5 * mass * v * v)
        << integrator;
  }
}

// In equilibrium a free bar goes through the gap of 0.5, along 8 and then 80 of a spring; friction
// takes its part.
TEST_P(Joints, ATableHoldsInEquilibrium) {
  const auto moves_by = [&](double force, const std::string& more = "") {
    Jointed scene{.kind = GetParam(),
                  .bars = 1,
                  .time = "end: 1, step: 0.25, static: true",
                  .output = "history: [a.base]"};
    scene.more =
        "loads:\n  - {instance: a, point: base, force: [" + text(force) +
        ", 0, 0]}\nlinks:\n  - {between: [a.base, ground], fix: [y, z, rx, ry, rz], force: "
        "{x: [[-0.5, 0], [0.5, 0], [1.5, 8], [2.5, 88]]}" +
        more + "}\n";
    const Ran ran = folder.run(yaml(scene));
    const double way = moved(ran, "a.base", 0)(ran.result.time.size() - 1);
    if (way > 0.1) EXPECT_LT(test::energy_residual(ran.result), 1e-9);
    return way;
  };
  EXPECT_NEAR(moves_by(4), 1, 1e-6);
  EXPECT_NEAR(moves_by(48), 2, 1e-6);
  EXPECT_NEAR(moves_by(128), 3, 1e-6);
  EXPECT_NEAR(moves_by(6, ", friction: {x: 2}"), 1, 1e-6);
  EXPECT_NEAR(moves_by(1.5, ", friction: {x: 2}"), 0, 1e-9);
}

// A bar lands on a wall with a pressure of 8 per depth, or with that beyond a depth of 0.005: half
// a sine, and back as fast.
TEST_P(Joints, AContactHasItsStiffness) {
  if (GetParam().starts_with("massless")) return;  // see docs/formats.md, "Limits"
  const double v = 0.02, omega = std::sqrt(8 / mass), pi = std::numbers::pi;
  for (const double soft : {0.0, 0.005}) {
    const std::string stiffness =
        soft > 0 ? "[[0, 0], [" + text(soft) + ", 0], [" + text(soft + 1) + ", 8]]" : "8";
    const double gap = 0.01 + soft;
    const auto expected = [&](double t) {
      const double s = t - gap / v;
      return s < 0            ? v * t
             : omega * s < pi ? gap + v / omega * std::sin(omega * s)
                              : gap - v * (s - pi / omega);
    };
    for (const std::string integrator : {"exact", "central-difference"}) {
      Jointed scene{.kind = GetParam(), .bars = 1, .velocities = {"[0.02, 0, 0]", ""}};
      scene.more =
          "walls: {w: {plane: {point: [4.01, 0, 0], normal: [-1, 0, 0]}}}\n"
          "contact:\n  - {between: [a.x_max, w], enforcement: penalty, stiffness: " +
          stiffness + "}\n";
      scene.time = "end: 4, integrator: " + integrator;
      scene.output = "every: 0.1, history: [a.tip]";
      const Ran ran = folder.run(yaml(scene));
      EXPECT_LT(worst(ran, moved(ran, "a.tip", 0), expected), 2e-3 * v / omega)
          << integrator << soft;
      EXPECT_LT(test::energy_residual(ran.result), 1e-9);
    }
  }
  Jointed scene{.kind = GetParam(), .bars = 1, .velocities = {"[0.02, 0, 0]", ""}};
  scene.more =
      "walls: {w: {plane: {point: [4.01, 0, 0], normal: [-1, 0, 0]}}}\n"
      "contact:\n  - {between: [a.x_max, w], enforcement: penalty, stiffness: 1e12}\n";
  scene.output = "every: 0.1";
  EXPECT_SAYS(test::refusal_of<RunError>([&] { folder.run(yaml(scene)); }),
              "found 1e+12, and with the");
}

// A stiff block falls on a coarse slab: it rebounds by the pressure on its face, whichever side has
// the nodes, and of whatever mesh.
TEST(ContactStiffness, ActsOnTheAreaThatIsShared) {
  test::SceneFolder folder;
  folder.add("slab.exo", test::block_mesh({{4, 4, 1}, Vector3(1, 1, 0.25)}));
  folder.add("block.exo", test::block_mesh({{2, 2, 1}, Vector3(0.5, 0.5, 0.25)}));
  const double omega = std::sqrt(1e7 * 0.25 / 62.5);
  for (const char* how : {"node-face", "two-way"}) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 1.0e12, poissons_ratio: 0, density: 1000}}\n"
        "components: {slab: {mesh: slab.exo, material: m}, block: {mesh: block.exo, material: "
        "m}}\n"
        "instances:\n"
        "  slab: {component: slab, as: mesh, position: [0, 0, -0.25]}\n"
        "  block: {component: block, as: mesh, position: [0.25, 0.25, 0], velocity: [0, 0, -0.1]}\n"
        "boundary: [{instance: slab, nodes: z_min, fix: [x, y, z]}]\n"
        "contact: [{between: [slab.z_max, block.z_min], enforcement: penalty, stiffness: 1.0e7, "
        "formulation: " +
        std::string(how) + "}]\ntime: {end: 0.015}\noutput: {every: 0.001}\n");
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      EXPECT_NEAR(test::at(ran.body("block").momentum, i)[2],
                  -6.25 * std::cos(omega * ran.result.time[i]), 0.01 * 6.25)
          << how;
  }
}

// A support that moves by a table drags the bar: its end is there, and its work is all of the bar's
// energy.
TEST_P(Joints, TheGroundOfALinkMoves) {
  for (const std::string& integrator : integrators()) {
    Jointed scene{.kind = GetParam(), .bars = 1, .output = "every: 0.1, history: [a.base]"};
    scene.more =
        "links:\n  - {between: [a.base, ground], velocity: [0.1, 0, 0], history: {time: [0, 1], "
        "value: [0, 1]}}\n";
    scene.time = "end: 2, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    const auto expected = [](double t) { return t < 1 ? 0.05 * t * t : 0.05 + 0.1 * (t - 1); };
    EXPECT_LT(worst(ran, moved(ran, "a.base", 0), expected), 1e-8) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
    EXPECT_NEAR(ran.result.work_external.back(), ran.result.total.back(),
                2e-3 * ran.result.total.back())
        << integrator;
  }
  Jointed scene{.kind = GetParam(),
                .bars = 1,
                .time = "end: 1, step: 0.5, static: true",
                .output = "history: [a.base]"};
  scene.more =
      "links:\n  - {between: [a.base, ground], displacement: [0.1, 0, 0], rotation: [0, 0, 2], "
      "history: {time: [0, 1], value: [0, 1]}}\n";
  const Ran ran = folder.run(yaml(scene));
  EXPECT_NEAR(moved(ran, "a.base", 0)(ran.result.time.size() - 1), 0.1, 1e-9);
  EXPECT_NEAR(last(ran.monitor("a.base").rotation, 2), std::numbers::pi / 90, 1e-9);
}

// In equilibrium the point of a free body goes by K^-1 times the force and the moment on it: K
// full, and in axes of the link.
TEST_P(Joints, ABushingHoldsByItsMatrix) {
  Jointed scene{.kind = GetParam(),
                .bars = 1,
                .time = "end: 1, step: 1, static: true",
                .output = "history: [a.tip]"};
  const std::string rows =
      "[[9, 1, 0, 0, 0, 2], [1, 8, 0, 0, 1, 0], [0, 0, 7, -2, 0, 0], [0, 0, -2, 12, 0, 0], [0, 1, "
      "0, 0, 11, 0], [2, 0, 0, 0, 0, 10]]";
  scene.more =
      "loads:\n  - {instance: a, point: tip, force: [0.01, 0.02, -0.03]}\n"
      "  - {instance: a, point: tip, moment: [0.02, 0.01, 0.03]}\n"
      "links:\n  - {between: [a.tip, ground], stiffness: " +
      rows + ", axes: [[0, 1, 0], [0, 0, 1]]}\n";
  const Ran ran = folder.run(yaml(scene));
  Matrix6 K;
  K << 9, 1, 0, 0, 0, 2, 1, 8, 0, 0, 1, 0, 0, 0, 7, -2, 0, 0, 0, 0, -2, 12, 0, 0, 0, 1, 0, 0, 11, 0,
      2, 0, 0, 0, 0, 10;
  const std::size_t n = ran.result.time.size() - 1;
  const Vector3 d = at(ran.monitor("a.tip").mean_position, n) - Vector3(length, 0.5, 0.5),
                theta = at(ran.monitor("a.tip").rotation, n);
  Eigen::Matrix<double, 6, 1> r;
  r << d[1], d[2], d[0], theta[1], theta[2], theta[0];  // along the link's axes y, z, x
  Eigen::Matrix<double, 6, 1> expected;
  expected << 0.02, -0.03, 0.01, 0.01, 0.03, 0.02;
  EXPECT_LT((K * r - expected).norm(), 1e-7 * expected.norm());
  EXPECT_NEAR(ran.result.total.back(), 0.5 * r.dot(K * r), 1e-6 * ran.result.total.back());
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 2), 0.03, 1e-8);  // on a
}

// Statics first, then motion from there: what is in equilibrium stays.
TEST_P(Joints, EquilibriumStays) {
  Jointed scene{.kind = GetParam(), .bars = 1, .output = "every: 0.05, history: [a.tip]"};
  scene.points = "base: {surface: x_min}, tip: {surface: x_max, mass: 3, inertia: [0.1, 0.2, 0.3]}";
  scene.more =
      "loads:\n  - {gravity: [0, 0, -0.01]}\nlinks:\n  - {between: [a.base, ground], fix: [x, y, "
      "rx, rz], stiffness: [0, 0, 20, 0, 300, 0]}\n";
  for (const std::string& integrator : integrators()) {
    scene.time = "end: 0.5, preload: 3, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    // of the base; the moment about it is that of the bar and of the mass at its end
    const double sag = -0.07 / 20;
    const double turn = 0.01 * (mass * length / 2 + 3 * length) / 300;
    const double bent = 0.01 * std::pow(length, 3) * (3.0 / 3 + mass / 8) / (E / 12);
    EXPECT_NEAR(at(ran.monitor("a.tip").mean_position, 0)[2] - 0.5, sag - length * turn - bent,
                0.1 * bent)
        << integrator;
    EXPECT_LT(worst(ran, moved(ran, "a.tip", 2), [](double) { return 0; }), 1e-7) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
  }
}

// A bar and a mass on it on a spring to the ground: omega^2 = k / (m + M).
TEST_P(Joints, APointCarriesItsMass) {
  Jointed scene{.kind = GetParam(),
                .bars = 1,
                .velocities = {"[0.01, 0, 0]", ""},
                .output = "every: 0.1, history: [a.base]"};
  scene.points = "base: {surface: x_min}, tip: {surface: x_max, mass: 6}";
  scene.more = "links:\n  - {between: [a.base, ground], stiffness: [10, 0, 0, 0, 0, 0]}\n";
  for (const std::string& integrator : integrators()) {
    scene.time = "end: 5, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    EXPECT_LT(worst(ran, moved(ran, "a.base", 0), [](double t) { return 0.01 * std::sin(t); }),
              1e-5)
        << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator;
    EXPECT_NEAR(ran.result.total.front(), 0.5 * (mass + 6) * 1e-4, 1e-12);
  }
}

// A pendulum of a bar on a hinge with a spring that turns, and a flywheel at its end: I = m (L^2 /
// 3 + 1 / 12) + M L^2 + J.
TEST_P(Joints, AFlywheelOnAHinge) {
  Jointed scene{.kind = GetParam(), .bars = 1, .output = "every: 0.1, history: [a.base]"};
  scene.points = "base: {surface: x_min}, tip: {surface: x_max, mass: 2, inertia: [0, 5, 0]}";
  scene.more =
      "loads:\n  - {instance: a, point: base, moment: [0, 0.01, 0]}\n"
      "links:\n  - {between: [a.base, ground], fix: [x, y, z, rx, rz], stiffness: [0, 0, 0, 0, 10, "
      "0]}\n";
  const double inertia = mass * (length * length / 3 + 1.0 / 12) + 2 * length * length + 5,
               omega = std::sqrt(10 / inertia);
  for (const std::string& integrator : integrators()) {
    scene.time = "end: 8, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    const auto turned = [&](std::size_t i) { return at(ran.monitor("a.base").rotation, i)[1]; };
    const auto expected = [&](double t) { return 0.001 * (1 - std::cos(omega * t)); };
    EXPECT_LT(worst(ran, turned, expected), 1e-5) << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-8) << integrator;
  }
}

// A rigid end that is pulled is one whose nodes are all driven: the same displacement takes the
// same work. A bar that contracts is softer where the force is spread instead.
TEST_P(Joints, ARigidCouplingHoldsTheEnd) {
  const auto pulled = [&](const std::string& coupling, const std::string& boundary,
                          const std::string& loads) {
    Jointed scene{.kind = GetParam(),
                  .bars = 1,
                  .time = "end: 1, step: 1, static: true",
                  .output = "history: [a.tip]"};
    scene.points =
        "base: {surface: x_min, coupling: rigid}, tip: {surface: x_max, coupling: " + coupling +
        "}";
    scene.more = boundary + loads + "links:\n  - {between: [a.base, ground]}\n";
    std::string text = yaml(scene);
    return folder.run(text.replace(text.find("poissons_ratio: 0,"), 18, "poissons_ratio: 0.4,"));
  };
  const std::string force = "loads:\n  - {instance: a, point: tip, force: [100, 0, 0]}\n";
  const Ran rigid = pulled("rigid", "", force), average = pulled("average", "", force);
  const double u = last(rigid.monitor("a.tip").mean_position, 0) - length;
  const Ran driven =
      pulled("average",
             "boundary:\n  - {instance: a, nodes: x_max, fix: [x, y, z], displacement: [" +
                 text(u) + ", 0, 0], history: {time: [0, 1], value: [0, 1]}}\n",
             "");
  EXPECT_GT(last(average.monitor("a.tip").mean_position, 0) - length, 1.001 * u);
  EXPECT_NEAR(2 * rigid.result.total.back(), 100 * u, 1e-8 * 100 * u);
  EXPECT_NEAR(2 * driven.result.total.back(), 100 * u, 1e-6 * 100 * u);
  Points moves, rates;
  rigid.built.simulation.bodies[0]->displacements(moves, rates);
  const Points& X = rigid.built.simulation.bodies[0]->reference_positions();
  for (Index i = 0; i < 81 && i < moves.rows(); ++i)
    if (X(i, 0) == length) EXPECT_LT((moves.row(i) - Eigen::RowVector3d(u, 0, 0)).norm(), 1e-9 * u);
}

// In motion too, with a mass on it: the end's nodes keep their distances, momentum and energy
// balance.
TEST_P(Joints, ARigidEndStaysRigidInMotion) {
  Jointed scene{.kind = GetParam(), .velocities = {"[0, 0, 0.01]", "[0.02, 0, 0]"}};
  scene.points =
      "base: {surface: x_min}, tip: {surface: x_max, coupling: rigid, mass: 1, inertia: [1, 2, 3, "
      "0.1, 0, 0]}";
  scene.more = "links:\n  - {between: [a.tip, b.base]}\n";
  for (const std::string& integrator : integrators()) {
    scene.time = "end: 0.5, " + integrator;
    const Ran ran = folder.run(yaml(scene));
    EXPECT_LT(test::energy_residual(ran.result), 1e-8) << integrator;
    Points u, v;
    ran.built.simulation.bodies[0]->displacements(u, v);
    const Points& X = ran.built.simulation.bodies[0]->reference_positions();
    for (Index i = 0; i < u.rows(); ++i)
      for (Index j = 0; j < i; ++j) {
        if (X(i, 0) != length || X(j, 0) != length || X.row(i) == X.row(j)) continue;
        const Vector3 d = (X.row(i) - X.row(j)).transpose().normalized();
        EXPECT_LT(std::abs(d.dot((u.row(i) - u.row(j)).transpose())), 1e-10) << integrator;
      }
    const auto momentum = [&](std::size_t i) {
      Vector3 sum = Vector3::Zero();
      for (const RunResult::OfBody& body : ran.result.bodies) sum += at(body.momentum, i);
      return sum;
    };
    EXPECT_LT((momentum(5) - momentum(0)).norm(), 1e-11) << integrator;
    EXPECT_LT((momentum(0) - Vector3(0.02 * (mass + 1), 0, 0.01 * (mass + 1))).norm(), 1e-12)
        << integrator;
  }
}

TEST_P(Joints, RestartsGoOnBitForBit) {
  Jointed scene{.kind = GetParam(), .velocities = {"[0.01, 0, 0]", "[-0.01, 0, 0.01]"}};
  scene.points =
      "base: {surface: x_min}, tip: {surface: x_max, coupling: rigid, mass: 1, inertia: [1, 2, 3]}";
  scene.more =
      "links:\n  - {between: [a.tip, b.base], stiffness: [8, 1e4, 1e4, 1e3, 1e3, 0], damping: [1, "
      "0, 0, 0, 0, 2], friction: {rx: 0.01}}\n  - {between: [a.base, ground], force: {x: [[0, 0], "
      "[0.001, 0], [0.002, 0.4]]}}\n  - {between: [b.tip, ground], fix: [z], velocity: [0, 0, "
      "0.02]}\n";
  for (const std::string& integrator : integrators()) {
    scene.time = "end: 0.5, " + integrator;
    test::expect_same_bits(test::restarted(folder, yaml(scene), 0.22), integrator);
  }
}

// The frequencies and the damping of the assembled scene, and its harmonic response.
TEST_P(Joints, ModesAndSweepsHaveThem) {
  Report report("test", Verbosity::quiet);
  Jointed scene{.kind = GetParam(), .time = "end: 1"};
  scene.more =
      "links:\n  - {between: [a.tip, b.base], stiffness: [8, 0, 0, 0, 0, 0], damping: [0.8, 0, "
      "0.5, 0, 0, 0]}\n"
      "loads:\n  - {instance: a, point: tip, force: [1, 0, 0]}\nsweep: {from_hz: 0.1, to_hz: 1, "
      "points: 5}\n";
  const Scene prepared = folder.prepare(yaml(scene)).scene;
  const InstanceModes modes = std::move(scene_modes(prepared, 14, report).instances.at(0));
  EXPECT_EQ(modes.instance, "a+b");
  const double reduced = mass / 2, omega = std::sqrt(softened(8) / reduced);
  Index j = 0;
  while (modes.frequency_hz[j] == 0) ++j;
  EXPECT_EQ(j, 11);
  EXPECT_NEAR(2 * std::numbers::pi * modes.frequency_hz[j], omega, 1e-6 * omega);
  EXPECT_NEAR(modes.damping_ratio[j], 0.8 / (2 * reduced * omega), 1e-3 * modes.damping_ratio[j]);
  const HarmonicResponse response = harmonic_response(prepared, report);
  for (Index i = 0; i < response.frequency_hz.size(); ++i) {
    const std::complex<double> iw(0, 2 * std::numbers::pi * response.frequency_hz[i]),
        d = 8.0 + 0.8 * iw, m = mass * iw * iw;
    const std::complex<double> expected = (m + d) / (m * (m + 2.0 * d)) + length / (3 * E);
    EXPECT_LT(std::abs(response.sets.at(0).displacement(i, 0) - expected),
              2e-3 * std::abs(expected))
        << i << expected;
  }
}

// A bar that is held at one end and has a mass M at the other: lambda tan lambda = m / M, omega =
// lambda c / L.
TEST_P(Joints, ABarWithAMassAtItsEnd) {
  const bool is_mesh = GetParam() == "mesh";
  if (!is_mesh && !GetParam().starts_with("craig")) return;  // see APointCarriesItsMass
  Report report("test", Verbosity::quiet);
  const double M = 3, c = std::sqrt(E);
  double lambda = 1;
  for (int i = 0; i < 50; ++i)
    lambda -= (lambda * std::tan(lambda) - mass / M) /
              (std::tan(lambda) + lambda / std::pow(std::cos(lambda), 2));
  std::vector<double> errors;
  for (const Index n : {8, 16}) {
    SceneFolder of;
    of.add("bar.exo", test::block_mesh({{n, 1, 1}, {length, 1, 1}}));
    Jointed scene{.kind = is_mesh ? "mesh" : "craig-bampton, modes: " + std::to_string(9 * n),
                  .bars = 1,
                  .time = "end: 1",
                  .output = "history: [a.tip]"};
    scene.points = "tip: {surface: x_max, mass: 3}";
    scene.more =
        "boundary:\n  - {instance: a, nodes: x_min, fix: [x, y, z]}\n  - {instance: a, nodes: "
        "x_max, fix: [y, z]}\n";
    const InstanceModes modes =
        std::move(scene_modes(of.prepare(yaml(scene)).scene, 30, report).instances.at(0));
    const double expected = lambda * c / length;
    errors.push_back(
        (2 * std::numbers::pi * modes.frequency_hz.array() / expected - 1).abs().minCoeff());
  }
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_GT(errors[0] / errors[1], 3.5) << errors[0] << " " << errors[1];
}

TEST_P(Joints, WhatCannotBeIsRefusedByName) {
  const auto refusal = [&](const std::string& points, const std::string& more,
                           const std::string& time = "end: 1") {
    Jointed scene{.kind = GetParam(), .time = time};
    scene.points = "base: {surface: x_min}, tip: {surface: x_max" + points + "}";
    scene.more = more;
    return test::refusal_of([&] { folder.prepare(yaml(scene)); });
  };
  const auto link = [&](const std::string& keys, const std::string& time = "end: 1") {
    return refusal("", "links:\n  - {between: [a.tip, b.base], " + keys + "}\n", time);
  };
  EXPECT_SAYS(link("stiffness: [1, 2]"), "expected six numbers");
  EXPECT_SAYS(link("stiffness: [1, -1, 0, 0, 0, 0]"), "links[0].stiffness");
  EXPECT_SAYS(link("stiffness: [0, 0, 0, 0, 0, 0]"), "leave it out");
  EXPECT_SAYS(link("force: {x: [[0, 0]]}"), "at least two rows");
  EXPECT_SAYS(link("force: {x: [[0, 0], [0, 1]]}"), "an x above 0");
  EXPECT_SAYS(link("force: {rz: [[0, 1], [1, 0]]}"), "falls below");
  EXPECT_SAYS(link("friction: {x: 1}, fix: [x]"), "holds x, which has");
  EXPECT_SAYS(link("fix: [y], velocity: [1, 0, 0]"), "prescribes x, which 'fix' leaves free");
  EXPECT_SAYS(link("stiffness: [1, 0, 0, 0, 0, 0], fix: [x]"), "holds x, which has a spring");
  EXPECT_SAYS(link("damping: [1, 0, 0, 0, 0, 0]", "end: 1, static: true"),
              "damping but no stiffness");
  const std::string singular =
      "[[1, 1, 0, 0, 0, 0], [1, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, "
      "0, 1, 0], [0, 0, 0, 0, 0, 1]]";
  EXPECT_SAYS(link("stiffness: " + singular), "not positive definite");
  EXPECT_SAYS(refusal("",
                      "links:\n  - {between: [a.tip, b.base]}\n  - {between: [a.tip, b.base], "
                      "stiffness: [1, 0, 0, 0, 0, 0]}\n"),
              "put both into one entry");
  EXPECT_SAYS(link("axes: line, fix: [x, y]"), "motion x alone, found y");
  EXPECT_SAYS(link("axes: lines"), "expected line, or");
  EXPECT_SAYS(link("ground: [0, 0, 0]"), "is for `axes: line`");
  const auto on_ground = [&](const std::string& keys) {
    return refusal("", "links:\n  - {between: [a.tip, ground], axes: line" + keys + "}\n");
  };
  EXPECT_SAYS(on_ground(""), "ground: [x, y, z]");
  EXPECT_SAYS(on_ground(", ground: [4, 0.5, 0.5]"), "the ends are at one place");
  EXPECT_SAYS(refusal(", mass: 0", ""), "mass");
  EXPECT_SAYS(refusal(", inertia: [1, 2]", ""), "expected three");
  EXPECT_SAYS(refusal(", coupling: stiff", ""), "average, rigid");
  EXPECT_SAYS(
      refusal(", coupling: rigid", "boundary:\n  - {instance: a, nodes: x_max, fix: [x]}\n"),
      "shares nodes with 'x_max'");
  EXPECT_SAYS(refusal(", coupling: rigid}, z: {surface: x_max, coupling: rigid", ""),
              "the rigid point 'tip'");
}

INSTANTIATE_TEST_SUITE_P(Kinds, Joints, ::testing::ValuesIn(kinds), [](const auto& of) {
  return of.param.substr(0, of.param.find_first_of("-,"));
});

}  // namespace
}  // namespace cbr::joints_test
