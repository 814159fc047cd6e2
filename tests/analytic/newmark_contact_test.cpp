// SPDX-License-Identifier: GPL-3.0-or-later
// Contact under Newmark's method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/support/bars.hpp"

namespace cbr::newmark_contact_test {
namespace {

using test::at;
using test::Bar;
using test::BarScene;
using test::Ran;
using test::text;

constexpr double v = 1e-3, start = 0.01;

std::string newmark(double alpha) {
  return alpha == 0 ? "newmark" : "newmark, alpha: " + text(alpha);
}

// What contact did to the energy, as shares of the largest: the most that it had given at any
// output, which should be nothing, and the largest gain from one output to the next.
struct Energy {
  double given = 0, gain = 0, balance = 0;
};
Energy energy_of(const RunResult& r) {
  Energy e;
  double most = 0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    most = std::max({most, r.total[i], std::abs(r.work_external[i])});
    e.given = std::max(e.given, r.work_contact[i]);
    if (i > 0) e.gain = std::max(e.gain, r.work_contact[i] - r.work_contact[i - 1]);
  }
  e.given /= most;
  e.gain /= most;
  e.balance = test::energy_residual(r);
  return e;
}

void expect_conserved(const Ran& ran) {
  const RunResult& r = ran.result;
  const Energy e = energy_of(r);
  EXPECT_LT(e.given, 1e-11);  // gaps are closed to 1e-16 of positions of 1, beside motions of 1e-4
  EXPECT_LT(e.gain, 1e-11);
  EXPECT_LT(e.balance, 1e-11);
  if (!ran.built.momentum_is_kept) return;
  Vector3 before = Vector3::Zero();
  double scale = 0, drift = 0;
  for (const auto& body : r.bodies) {
    before += at(body.momentum, 0);
    scale += at(body.momentum, 0).norm();
  }
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    Vector3 now = Vector3::Zero();
    for (const auto& body : r.bodies) now += at(body.momentum, i);
    drift = std::max(drift, (now - before).norm());
  }
  EXPECT_LT(drift, 1e-12 * scale);
}

// Two equal bars swap their velocities.
struct Kind {
  const char* name;
  bool mesh0, mesh1;
};

BarScene strike(const Kind& kind, Index n, const std::string& integrator, const std::string& step) {
  BarScene scene;
  scene.bars = {Bar{}, Bar{}};
  scene.bars[0].velocity = v;
  scene.bars[1].start = 1 + start * v;
  scene.bars[0].mesh = kind.mesh0;
  scene.bars[1].mesh = kind.mesh1;
  for (Bar& bar : scene.bars) bar.n = n;
  scene.integrator = integrator;
  scene.step = step;
  scene.end = 0.3;
  scene.every = 0;
  return scene;
}

struct Errors {
  double speed = 0, ends = 0, centres = 0, force = 0, lost = 0, numerical = 0;
  double steps = 0;  // critical ones to a step
};

Errors errors_of(const Ran& ran) {
  static const auto waves =
      test::waves(strike({"", true, true}, 10, "exact", "auto").bars, 0.001, 0.3);
  const RunResult& r = ran.result;
  const double T = Bar{}.transit(), Z = Bar{}.impedance();
  Errors e;
  e.speed =
      std::max(std::abs(test::speed_of(ran, 0)) / v, std::abs(test::speed_of(ran, 1) / v - 1));
  e.ends = std::max(
      test::error_of(r, ran.monitor("b0.x_max").mean_position, waves.upper[0], 0.001, v * T),
      test::error_of(r, ran.monitor("b1.x_min").mean_position, waves.lower[1], 0.001, v * T));
  e.centres = test::error_of(r, ran.body("b0").center_of_mass, waves.centre[0], 0.001, v * T);
  for (std::size_t i = 0; i < r.time.size(); ++i)
    e.force = std::max(e.force, at(r.pairs[0]["force"], i).norm() / (Z * v / 2));
  e.lost = 1 - r.total.back() / r.total.front();
  e.numerical = r.work_numerical.back() / r.total.front();
  if (ran.built.simulation.plan.critical > 0)
    e.steps = ran.built.simulation.plan.h / ran.built.simulation.plan.critical;
  return e;
}

void print(const char* what, double alpha, Index n, const Errors& e) {
  std::printf(
      "%-22s alpha %4.1f n %3ld, %6.3f critical steps: speeds %.1e ends %.1e centres %.1e, largest "
      "force %.2f, energy lost %.1e "
      "(by "
      "damping %.1e)\n",
      what, alpha, long(n), e.steps, e.speed, e.ends, e.centres, e.force, e.lost, -e.numerical);
}

constexpr Kind reduced{"superelement", false, false}, full{"mesh", true, true},
    mixed{"mesh on superelement", true, false};

// With the mesh, at fixed shares of the critical step, towards the waves.
void expect_convergence(const Kind& kind, const std::vector<Index>& elements, double finest) {
  for (const double alpha : {0.0, -0.1})
    for (const double cfl : {1.0, 4.0}) {
      std::vector<double> h, speed, ends, centres;
      Errors e;
      for (const Index n : elements) {
        const Ran ran = run(strike(kind, n, newmark(alpha), "{cfl: " + text(cfl) + "}"));
        expect_conserved(ran);
        e = errors_of(ran);
        h.push_back(1 / double(n));
        speed.push_back(e.speed);
        ends.push_back(e.ends);
        centres.push_back(e.centres);
      }
      print(kind.name, alpha, elements.back(), e);
      const double orders[] = {test::observed_order(h, speed), test::observed_order(h, ends),
                               test::observed_order(h, centres)};
      std::printf("%22s orders %.2f %.2f %.2f\n", "", orders[0], orders[1], orders[2]);
      EXPECT_GT(*std::min_element(orders, orders + 3), 0.5);
      EXPECT_LT(std::max({e.speed, e.ends, e.centres}), cfl * finest);
    }
}

TEST(NewmarkContact, BarsComeToTheWavesWithTheMesh) {
  expect_convergence(reduced, {10, 20, 40}, 0.02);
}

// At a fixed mesh towards what small steps of `exact` do.
TEST(NewmarkContact, BarsComeToExactMotionWithTheStep) {
  BarScene scene = strike(reduced, 20, "exact", "{cfl: 0.02}");
  scene.every = 0.003;
  const Ran exact = run(scene);
  std::vector<double> u;
  for (std::size_t i = 0; i < exact.result.time.size(); ++i)
    u.push_back(at(exact.monitor("b0.x_max").mean_position, i)[0] -
                at(exact.monitor("b0.x_max").mean_position, 0)[0]);
  for (const double alpha : {0.0, -0.1}) {
    std::vector<double> h, e;
    for (const double cfl : {16.0, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25}) {
      BarScene steps = strike(reduced, 20, newmark(alpha), "{cfl: " + text(cfl) + "}");
      const Ran ran = run(steps);
      expect_conserved(ran);
      h.push_back(cfl);
      e.push_back(test::error_of(ran.result, ran.monitor("b0.x_max").mean_position, u, 0.003,
                                 v * Bar{}.transit()));
      print("to exact", alpha, 20, errors_of(ran));
      std::printf("%22s difference %.2e\n", "", e.back());
    }
    std::printf("alpha %.1f: order %.2f\n", alpha, test::observed_order(h, e));
    EXPECT_GT(test::observed_order(h, e), 0.6);
    EXPECT_LT(e.back(), 5e-3);
  }
}

// A bar on a wall flies back as it came, and a stiff mesh is no hindrance to large steps.
TEST(NewmarkContact, WallSendsABarBack) {
  for (const double alpha : {0.0, -0.1})
    for (const double cfl : {1.0, 10.0}) {
      std::vector<double> h, speed;
      for (const Index n : {20, 40, 80}) {
        BarScene scene;
        scene.bars = {Bar{}};
        scene.bars[0].start = start * v;
        scene.bars[0].velocity = -v;
        scene.bars[0].mesh = false;
        scene.bars[0].n = n;
        scene.end = 0.3;
        scene.every = 0;
        scene.integrator = newmark(alpha);
        scene.step = "{cfl: " + text(cfl) + "}";
        scene.extra =
            "walls: {wall: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\ncontact: [{between: "
            "[b0.x_min, wall]}]\n";
        const Ran ran = run(scene);
        expect_conserved(ran);
        h.push_back(1 / double(n));
        speed.push_back(std::abs(test::speed_of(ran, 0) / v - 1));
        std::printf(
            "wall: alpha %4.1f, %4.1f critical steps, n %2ld: rebound %.4f, energy kept %.4f, "
            "damped %.4f\n",
            alpha, cfl, long(n), test::speed_of(ran, 0) / v,
            ran.result.total.back() / ran.result.total[0],
            -ran.result.work_numerical.back() / ran.result.total[0]);
      }
      EXPECT_GT(test::observed_order(h, speed), 0.4);
      EXPECT_LT(speed.back(), cfl > 1 ? 0.15 : 0.03);
    }
}

// Two bars end to end that are pressed together smoothly, or tied and pulled, by `sign`; or the bar
// in one piece that they make.
BarScene pressed(bool in_one, const std::string& integrator, double h, double sign) {
  BarScene scene;
  scene.bars = {Bar{}};
  scene.bars[0].mesh = false;
  scene.bars[0].n = 8;
  if (in_one) {
    scene.bars[0].length = 2;
    scene.bars[0].n = 16;
  } else {
    scene.bars.push_back(scene.bars[0]);
    scene.bars[1].start = 1;
    if (sign < 0) scene.contact = ", tied: true";
  }
  std::string time, value;
  for (int i = 0; i <= 1000; ++i) {
    const double s = i / 1000.0;
    time += (i ? ", " : "") + text(0.6 * s);
    value += (i ? ", " : "") + text(1e-3 * std::pow(s, 3));
  }
  const std::string history = ", history: {time: [" + time + "], value: [" + value + "]}}\n";
  scene.extra = "loads:\n  - {instance: b0, surface: x_min, traction: [" + text(sign) + ", 0, 0]" +
                history + "  - {instance: " + (in_one ? "b0" : "b1") +
                ", surface: x_max, traction: [" + text(-1.3 * sign) + ", 0, 0]" + history;
  scene.integrator = integrator;
  scene.step = text(h * (1 + 1e-10));
  scene.end = 0.6;
  scene.every = 0.06;
  return scene;
}

struct Ends {
  double position = 0, velocity = 0;
};
// Largest difference of the outer ends, as shares of the largest displacement and velocity.
Ends difference(const Ran& halves, const Ran& bar) {
  Ends d;
  double x_scale = 0, v_scale = 0;
  for (const bool upper : {false, true}) {
    const auto &a = halves.monitor(upper ? "b1.x_max" : "b0.x_min"),
               &b = bar.monitor(upper ? "b0.x_max" : "b0.x_min");
    for (std::size_t i = 0; i < bar.result.time.size(); ++i) {
      d.position = std::max(d.position, (at(a.mean_position, i) - at(b.mean_position, i)).norm());
      d.velocity = std::max(d.velocity, (at(a.mean_velocity, i) - at(b.mean_velocity, i)).norm());
      x_scale = std::max(x_scale, (at(b.mean_position, i) - at(b.mean_position, 0)).norm());
      v_scale = std::max(v_scale, at(b.mean_velocity, i).norm());
    }
  }
  return {d.position / x_scale, d.velocity / v_scale};
}

// What stays in contact, or is tied, moves as the bar in one piece does under the same scheme,
// velocities too; and the order of both is the scheme's.
TEST(NewmarkContact, ClosedContactAndTiesAreTheBarInOnePiece) {
  for (const double sign : {1.0, -1.0}) {
    const Ran exact = run(pressed(true, "exact", 0.01, sign));
    for (const double alpha : {0.0, -0.1}) {
      std::vector<double> h, x, u;
      for (const int steps : {200, 400, 800}) {
        const Ran bar = run(pressed(true, newmark(alpha), 0.6 / steps, sign));
        const Ran halves = run(pressed(false, newmark(alpha), 0.6 / steps, sign));
        const Ends same = difference(halves, bar), error = difference(halves, exact);
        EXPECT_LT(same.position, 1e-9);
        EXPECT_LT(same.velocity, 1e-8);
        EXPECT_LT(std::abs(energy_of(halves.result).given), 1e-10);
        EXPECT_LT(energy_of(halves.result).balance, 1e-11);
        h.push_back(0.6 / steps);
        x.push_back(error.position);
        u.push_back(error.velocity);
        if (steps < 800) continue;
        std::printf(
            "%s, alpha %4.1f: to the bar in one piece %.1e, %.1e; to its exact motion %.1e (order "
            "%.2f), %.1e (%.2f)\n",
            sign > 0 ? "pressed" : "tied", alpha, same.position, same.velocity, error.position,
            test::observed_order(h, x), error.velocity, test::observed_order(h, u));
      }
      EXPECT_GT(test::observed_order(h, x), 1.9);
      EXPECT_GT(test::observed_order(h, u), 1.9);
    }
  }
}

// A block that is laid on a wall while gravity grows: it swings a little about its sag, and its
// foot rests.
TEST(NewmarkContact, BlockRestsOnAWall) {
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{4, 4, 4}}));
  for (const double alpha : {0.0, -0.1})
    for (const double cfl : {0.5, 10.0}) {
      const Ran ran = folder.run(
          "materials: {m: {youngs_modulus: 1.0e6, poissons_ratio: 0.3, density: 1000}}\nwalls: "
          "{floor: {plane: {point: [0, 0, 0], "
          "normal: [0, 0, 1]}}}\ncomponents:\n  b: {mesh: block.exo, material: m, reduction: "
          "{interface: [z_min, z_max], modes: "
          "30, "
          "pick: participation}}\ninstances:\n  b: {component: b, as: superelement}\nloads: "
          "[{gravity: [0, 0, -10], history: "
          "{time: "
          "[0, 2], value: [0, 1]}}]\ncontact: [{between: [b.z_min, floor]}]\ntime: {end: 8, "
          "integrator: " +
          newmark(alpha) + ", step: {cfl: " + text(cfl) +
          "}}\noutput: {every: 0, history: [b.z_min, b.z_max]}\n");
      const RunResult& r = ran.result;
      double mean = 0, unrest = 0, foot = 0, head = 0;
      std::size_t n = 0;
      for (std::size_t i = 0; i < r.time.size(); ++i) {
        if (r.time[i] < 4) continue;
        const double f = at(r.pairs[0]["force"], i)[2] / 1e4;
        mean += f;
        ++n;
        unrest = std::max(unrest, std::abs(f - 1));
        foot = std::max(foot, std::abs(at(ran.monitor("b.z_min").mean_velocity, i)[2]));
        head = std::max(head, std::abs(at(ran.monitor("b.z_max").mean_velocity, i)[2]));
      }
      mean /= double(n);
      std::printf(
          "rest: alpha %4.1f, %4.1f critical steps: reaction %.6f of the weight, unrest %.1e; "
          "speed of the foot %.1e, of the head "
          "%.1e\n",
          alpha, cfl, mean, unrest, foot, head);
      expect_conserved(ran);
      EXPECT_NEAR(mean, 1, 2e-4);
      EXPECT_LT(unrest, 0.03);
      EXPECT_LT(foot, 1e-13);
    }
}

// Down a slope with friction: s = g (sin a - mu cos a) t^2 / 2, and friction takes mu N s; it
// sticks where mu > tan a. Gravity grows at first: R and its integral stand for t and t^2 / 2.
TEST(NewmarkContact, BlockOnASlope) {
  constexpr double g = 10, angle = 20 * std::numbers::pi / 180, T = 0.2, end = 1, R = end - T / 2;
  const Vector3 downhill(std::cos(angle), 0, -std::sin(angle)),
      normal(std::sin(angle), 0, std::cos(angle));
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{4, 2, 1}, {1, 0.5, 0.25}}));
  for (const double alpha : {0.0, -0.1})
    for (const double cfl : {1.0, 10.0})
      for (const double mu : {0.2, 0.5}) {
        const Ran ran = folder.run(
            "materials: {m: {youngs_modulus: 1.0e7, poissons_ratio: 0, density: 1000}}\nwalls: "
            "{slope: {plane: {point: [0, 0, 0], "
            "normal: " +
            text(normal) +
            "}}}\ncomponents:\n  b: {mesh: block.exo, material: m, reduction: {interface: [z_min], "
            "modes: 12, pick: "
            "participation}}\ninstances:\n  b: {component: b, as: superelement, rotation: [0, 20, "
            "0]}\nloads: [{gravity: [0, 0, " +
            text(-g) + "], history: {time: [0, " + text(T) +
            "], value: [0, 1]}}]\ncontact: [{between: [b.z_min, slope], friction: " + text(mu) +
            "}]\ntime: {end: " + text(end) + ", integrator: " + newmark(alpha) +
            ", step: {cfl: " + text(cfl) + "}}\noutput: {every: 0, history: [b.z_min]}\n");
        const RunResult& r = ran.result;
        const double drive = std::max(0.0, std::sin(angle) - mu * std::cos(angle)) * g,
                     fall = end * end / 2 - T * end / 2 + T * T / 6;
        const double expected = drive * fall,
                     heat = mu * ran.mass("b") * g * std::cos(angle) * drive * R * R / 2;
        const auto& x = ran.monitor("b.z_min").mean_position;
        const double way = downhill.dot(at(x, r.time.size() - 1) - at(x, 0));
        std::printf(
            "slope: mu %.1f alpha %4.1f, %4.1f critical steps: way %.6f of %.6f, friction took "
            "%.6f of %.6f, balance %.1e\n",
            mu, alpha, cfl, way, expected, -r.work_friction.back(), heat, test::energy_residual(r));
        EXPECT_LT(test::energy_residual(r), 1e-11);
        EXPECT_LE(r.work_friction.back(), 1e-9);  // of a fall of some 1e4 J
        if (drive > 0) {
          EXPECT_NEAR(way, expected, 2e-3 * expected);
          EXPECT_NEAR(-r.work_friction.back(), heat, 2e-3 * heat);
        } else {
          EXPECT_LT(std::abs(way), 1e-4 * g * fall);
        }
      }
}

// The paper's block (Table 1), coarser, on a wall in place of its twin: the rebound is that of
// exact motion at the mesh's steps; with a dozen steps to the impact, which takes 30 critical ones,
// it loses some.
TEST(NewmarkContact, BlockReboundsAtAnyStep) {
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{10, 5, 8}, {0.0508, 0.0254, 0.0381}}));
  const auto rebound = [&](const std::string& integrator, double cfl) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}\nwalls: "
        "{wall: {plane: {point: [0, 0, 0], "
        "normal: [1, 0, 0]}}}\ncomponents:\n  b: {mesh: block.exo, material: m, reduction: "
        "{interface: [x_min], modes: 40, pick: "
        "participation}}\ninstances:\n  b: {component: b, as: superelement, position: [0.0001, 0, "
        "0], velocity: [-1905, 0, "
        "0]}\ncontact: [{between: [b.x_min, wall]}]\ntime: {end: 1.2e-5, integrator: " +
        integrator + ", step: {cfl: " + text(cfl) + "}}\noutput: {every: 0, history: [b.x_min]}\n");
    const RunResult& r = ran.result;
    if (integrator != "exact") expect_conserved(ran);
    double force = 0;
    for (std::size_t i = 0; i < r.time.size(); ++i)
      force = std::max(force, at(r.pairs[0]["force"], i).norm());
    const double speed = at(ran.body("b").momentum, r.time.size() - 1)[0] / ran.mass("b") / 1905;
    std::printf(
        "block: %-14s %5.2f critical steps (%3ld): rebound %.4f, energy kept %.4f, damped %.4f, "
        "largest force %.2e\n",
        integrator.substr(0, 14).c_str(), cfl, long(r.steps), speed, r.total.back() / r.total[0],
        -r.work_numerical.back() / r.total[0], force);
    return speed;
  };
  const double exact = rebound("exact", 0.25);
  for (const double alpha : {0.0, -0.1}) {
    for (const double cfl : {0.25, 0.5, 1.0})
      EXPECT_NEAR(rebound(newmark(alpha), cfl), exact, 0.006);
    EXPECT_NEAR(rebound(newmark(alpha), 2), exact, 0.06);
  }
}

// Bodies of different kinds, with every mode kept: one model.
TEST(NewmarkContact, MeshesComeToTheWavesAsSuperelementsDo) {
  expect_convergence(full, {20, 40, 80}, 0.02);
  expect_convergence(mixed, {10, 20, 40}, 0.02);
  for (const double alpha : {0.0, -0.1}) {
    const Errors a = errors_of(run(strike(full, 10, newmark(alpha), "{cfl: 2}"))),
                 b = errors_of(run(strike(reduced, 10, newmark(alpha), "{cfl: 2}")));
    EXPECT_NEAR(a.speed, b.speed, 1e-7);
    EXPECT_NEAR(a.ends, b.ends, 1e-7);
  }
}

}  // namespace
}  // namespace cbr::newmark_contact_test
