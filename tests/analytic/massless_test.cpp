// SPDX-License-Identifier: GPL-3.0-or-later
// Basis massless, from reduction to run: the bouncing bar of Doyen, Ern, Piperno 2011 (see
// bouncing_bar_test.cpp), its order in the step, joints, a block that slides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/pressed_bar.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::massless_test {
namespace {

using test::PressedBar;
using test::Ran;
using test::SceneFolder;
using test::text;

constexpr double period = 16.0 / 3, height = 5, gravity = 10, length = 10;

double end_position(double time) {
  const double t = std::fmod(time, period);
  if (t < 1) return height - 5 * t * t;
  if (t < 5.0 / 3) return 0;
  if (t < 11.0 / 3) {
    const double s = t - 5.0 / 3, z = std::fmod(3 * s, 2.0);
    return height - 5 * (s - 1) * (s - 1) + 10.0 / 9 * z * (z - 2);
  }
  if (t < 13.0 / 3) return 0;
  return height - 5 * (t - period) * (t - period);
}

// Axial modes: the rigid one and those below, f_j = j c / (2 L) = 1.5 j Hz.
std::string reduction(const std::string& basis, Index axial) {
  return "{" + basis + ", interface: [x_min], cutoff_hz: " + text(1.5 * (double(axial) - 0.5)) +
         "}";
}

struct Bounce {
  double two, ten, peak, impulse, energy;
  Index modes;
};

Bounce bounce(const std::string& basis, Index axial, double h, const std::string& integrator,
              Index n, double width, double periods = 10) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{n, 1, 1}, Vector3(length, width, width)}));
  const Ran ran = folder.run(
      "materials: {m: {youngs_modulus: 900, poissons_ratio: 0, density: 1}}\n"
      "components: {bar: {mesh: bar.exo, material: m, mass: consistent, reduction: " +
      reduction(basis, axial) +
      "}}\n"
      "instances: {b: {component: bar, position: [5, 0, 0]}}\n"
      "walls: {floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
      "loads: [{gravity: [-10, 0, 0]}]\n"
      "contact: [{between: [b.x_min, floor]}]\n"
      "time: {end: " +
      text(periods * period) + ", step: " + text(h) + ", integrator: " + integrator +
      "}\n"
      "output: {every: " +
      text(period / 960) + ", history: [b.x_min]}\n");
  EXPECT_LT(test::energy_residual(ran.result), 1e-9);
  Bounce b{};
  b.modes = ran.built.instances[0].n_modal;
  const auto& x = ran.monitor("b.x_min").mean_position;
  double e2 = 0, s2 = 0;
  const double scale = ran.mass("b") * gravity * height;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double t = ran.result.time[i], exact = end_position(t), q = test::at(x, i)[0];
    e2 += (q - exact) * (q - exact);
    s2 += exact * exact;
    if (t <= 2 * period * (1 + 1e-12)) b.two = std::sqrt(e2 / s2);
    if (t > 9 * period) b.peak = std::max(b.peak, q / height);
    b.energy = std::max(b.energy, std::abs(ran.result.work_contact[i]) / scale);
    if (std::abs(t - 8.0 / 3) < 1e-9)
      b.impulse = test::at(ran.body("b").momentum, i)[0] / (width * width) + gravity * length * t;
  }
  b.ten = std::sqrt(e2 / s2);
  b.impulse = std::abs(b.impulse / (800.0 / 3) - 1);
  std::printf(
      "%-40s %2ld axial of %3ld, h %.1e %-18s n %4ld: L2 two periods %.2e, ten %.2e; last peak "
      "%.4f; impulse %.1e; energy %.1e\n",
      basis.c_str(), long(axial), long(b.modes), h, integrator.c_str(), long(n), b.two, b.ten,
      b.peak, b.impulse, b.energy);
  std::fflush(stdout);
  return b;
}

const std::string free_modes = "basis: massless",
                  tapered_modes = "basis: massless, massless_modes: tapered";
const PressedBar bar{.reduction = free_modes + ", modes: 20", .n = {16, 2, 2}};

// While it stays closed contact is a spring, and both schemes are of second order.
TEST(MasslessContact, IsOfSecondOrderInTheStep) {
  for (const char* integrator : {"exact", "central-difference"}) {
    PressedBar p = bar;
    p.integrator = integrator;
    p.end = 0.5;
    p.every = 0.05;
    p.reduction = free_modes + ", modes: 12";
    p.loads = test::ramp(10, 0.2);
    std::vector<double> h, error;
    std::vector<Ran> runs;
    for (const double step : {2.5e-5, 4e-4, 8e-4, 1.6e-3}) {
      p.step = text(step);
      runs.push_back(run(p));
      if (runs.size() == 1) continue;
      double e = 0;
      for (std::size_t i = 0; i < runs[0].result.time.size(); ++i)
        e = std::max(e, std::abs(test::at(runs.back().monitor("b.x_max").mean_position, i)[0] -
                                 test::at(runs[0].monitor("b.x_max").mean_position, i)[0]));
      h.push_back(step);
      error.push_back(e);
    }
    const double order = test::observed_order(h, error);
    std::printf("%-18s closed contact: errors %.1e %.1e %.1e, order %.2f\n", integrator, error[0],
                error[1], error[2], order);
    EXPECT_GT(order, 1.7);
  }
}

// Bars end to end, tied or welded, of which one is held and the other pulled at once: no joint of
// massless bodies with others brings energy.
TEST(MasslessContact, JointsWithOtherKindsKeepTheEnergy) {
  const std::string massless =
      ", reduction: {basis: massless, interface: [x_min, x_max], modes: 40}";
  for (const std::string other :
       {", reduction: {interface: [x_min, x_max], modes: 20}",
        ", reduction: {basis: characteristic, interface: [x_min, x_max, y_max], modes: 20}", "",
        "rigid"})
    for (const bool is_tied : {true, false})
      for (const bool massless_is_held : {true, false}) {
        SceneFolder folder;
        folder.add("bar.exo", test::block_mesh({{10, 2, 2}, {1, 0.2, 0.2}}));
        const bool is_rigid = other == "rigid";
        if (is_rigid && !massless_is_held) continue;
        const auto component = [&](const char* name, bool is_massless) {
          return std::string("  ") + name +
                 ": {mesh: bar.exo, material: m, points: {p: {surface: " +
                 (name == std::string("a") ? "x_max" : "x_min") + "}}" +
                 (is_massless ? massless
                  : is_rigid  ? ""
                              : other) +
                 "}\n";
        };
        const Ran ran = folder.run(
            "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: "
            "1}}\ncomponents:\n" +
            component("a", massless_is_held) + component("b", !massless_is_held) +
            "instances:\n  a: {component: a}\n  b: {component: b, position: [1, 0, 0]" +
            (is_rigid ? ", as: rigid" : "") +
            "}\nboundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n"
            "loads: [{instance: b, surface: x_max, force: [0.01, 0, 0.001]}]\n" +
            (is_tied ? "contact: [{between: [a.x_max, b.x_min], tied: true}]\n"
                     : "links: [{between: [a.p, b.p]}]\n") +
            "time: {end: 20}\noutput: {every: 0.2, history: [b.x_max]}\n");
        const RunResult& result = ran.result;
        const double most =
            *std::max_element(result.work_external.begin(), result.work_external.end());
        const std::string name =
            other + (is_tied ? " tied" : " welded") + (massless_is_held ? " a" : " b");
        for (std::size_t i = 0; i < result.time.size(); ++i)
          ASSERT_LT(std::abs(result.work_contact[i]), 0.03 * most) << name << " " << result.time[i];
      }
}

// A block on a floor under gravity that leans: it slides by s = g (sin a - mu cos a) t^2 / 2, or
// stays.
TEST(MasslessContact, SlidesAndSticks) {
  for (const char* integrator : {"exact", "central-difference"}) {
    for (const double mu : {0.2, 0.6}) {
      PressedBar p = bar;
      p.integrator = integrator;
      p.size = {0.25, 1, 0.5};
      p.n = {4, 4, 3};
      p.reduction = free_modes + ", modes: 30";
      p.contact = "between: [b.x_min, floor], friction: " + text(mu);
      const double lean = 0.4, g = 10;
      p.loads = "{gravity: " + text(Vector3(-g * std::cos(lean), g * std::sin(lean), 0)) +
                ", history: {time: [0, 0.5], value: [0, 1]}}";
      p.end = 1.5;
      p.every = 0.5;
      const Ran ran = run(p);
      const auto moved = [&](std::size_t i) {
        return (test::at(ran.body("b").center_of_mass, i) -
                test::at(ran.body("b").center_of_mass, 0))[1];
      };
      // From the second half on the acceleration is constant
      const double a = g * (std::sin(lean) - mu * std::cos(lean));
      const std::size_t last = ran.result.time.size() - 1;
      if (mu < std::tan(lean)) {
        EXPECT_NEAR(moved(last) - 2 * moved(last - 1) + moved(last - 2), a * 0.25, 5e-3 * a * 0.25)
            << integrator;
        EXPECT_LT(ran.result.work_friction.back(), 0);
        EXPECT_NEAR(ran.result.work_friction.back(),
                    -mu * g * std::cos(lean) * ran.mass("b") * moved(last),
                    0.02 * std::abs(ran.result.work_friction.back()));
      } else {
        EXPECT_LT(std::abs(moved(last)), 5e-3);  // it shears, and stays
        EXPECT_LT(std::abs(test::at(ran.monitor("b.x_min").mean_velocity, last)[1]), 1e-10);
      }
      EXPECT_LT(test::energy_residual(ran.result), 1e-10);
    }
  }
}

std::string message_of(const PressedBar& p) {
  return test::refusal_of([&] { run(p); });
}

TEST(MasslessContact, RefusesWhatItCannotDo) {
  const auto expect = [](const PressedBar& p, const std::string& part) {
    EXPECT_SAYS(message_of(p), part, "massless");
  };
  PressedBar p = bar;
  p.integrator = "newmark";
  expect(p, "take exact or central-difference");
  p = bar;
  p.contact += ", enforcement: penalty";
  expect(p, "take enforcement: impulse");
  p = bar;
  p.reduction += ", domains: 2";
  expect(p, "domains above 1");
  p = bar;
  p.reduction += ", recovery: true";
  expect(p, "recovery");
  p = bar;
  p.reduction += ", pick: participation";
  expect(p, "pick: frequency");
  p = bar;
  p.reduction = "massless_modes: tapered, modes: 20";
  EXPECT_SAYS(message_of(p), "requires basis: massless");
  p = bar;
  p.more =
      "skin: {surfaces: [x_max], youngs_modulus: 10, poissons_ratio: 0.3, density: 1, thickness: "
      "0.01}\n";
  expect(p, "skin");
  p = bar;
  p.step = "1";
  EXPECT_SAYS(message_of(p), "above the critical step");
}

// The published figures after ten periods, the rigid mode counted: 2.30e-2 with 15 modes
// (here 2.33e-2) and 5.4e-3 with 30 (here 5.0e-3), where an interface with mass has lost most of
// the bounce. Those numbers of modes suit this motion, as docs/decisions/massless.md tells, and
// elements must be fine enough for the last mode's frequency.
TEST(BouncingBar, MasslessKeepsBouncing) {
  const Bounce leapfrog = bounce(free_modes, 15, 5e-4, "central-difference", 1000, 0.25);
  EXPECT_LT(leapfrog.two, 2.0e-2);
  EXPECT_LT(leapfrog.ten, 2.4e-2);
  EXPECT_LT(leapfrog.impulse, 2e-3);
  EXPECT_LT(leapfrog.energy, 1e-3);
  EXPECT_GT(leapfrog.peak, 0.98);
  const Bounce more = bounce(free_modes, 30, 5e-4, "central-difference", 1000, 0.25);
  EXPECT_LT(more.two, 5.4e-3);
  EXPECT_LT(more.ten, 5.4e-3);
  EXPECT_LT(more.energy, 1e-3);
  EXPECT_GT(more.peak, 0.99);
  const Bounce trigonometric = bounce(free_modes, 15, 2e-3, "exact", 200, 0.25, 2);
  EXPECT_LT(trigonometric.two, 1.5e-2);
  EXPECT_LT(trigonometric.energy, 5e-3);
  const Bounce with_mass = bounce("basis: craig-bampton", 15, 2e-3, "exact", 200, 0.25);
  EXPECT_GT(with_mass.energy, 0.5);
  EXPECT_GT(with_mass.ten, 0.3);
}

// With numbers of modes that do not suit the motion rows that end at once lose the next landing;
// here the mesh's own frequencies, 1.2 % off at the 17th, are part of the errors.
TEST(BouncingBar, TaperedModesDoNotAskForALuckyNumber) {
  // 16 and 18: a bending mode follows, which takes no part in an axial impact and must not end the
  // fall (0.044 and 0.037 where it did)
  for (const Index axial : {16, 18})
    EXPECT_LT(bounce(tapered_modes, axial, 2e-3, "exact", 1000, 0.25, 2).two, 0.01);
  double at_17 = 0;
  for (const Index axial : {15, 17, 18}) {
    const Bounce tapered = bounce(tapered_modes, axial, 2e-3, "exact", 100, 0.5, 2);
    EXPECT_LT(tapered.two, 0.06);  // 0.025, 0.043, 0.052
    EXPECT_LT(tapered.energy, 3e-3);
    EXPECT_LT(tapered.impulse, 5e-3);
    if (axial == 17) at_17 = tapered.two;
  }
  EXPECT_LT(at_17, 0.75 * bounce(free_modes, 17, 2e-3, "exact", 100, 0.5, 2).two);
}

}  // namespace
}  // namespace cbr::massless_test
