// SPDX-License-Identifier: GPL-3.0-or-later
// What bodies of basis massless, and of basis characteristic with chosen shapes and with the
// statics of the faces that touch, have in common in contact, from reduction to run.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/support/pressed_bar.hpp"

namespace cbr::bases_in_contact_test {
namespace {

using test::PressedBar;
using test::Ran;

const std::string massless = "basis: massless, modes: 20",
                  statics = "basis: characteristic, modes: 20";

struct Pressed {
  const char* name;
  PressedBar bar;
  std::vector<const char*> integrators;
  double position, force, wall, energy;  // limits of errors
  Index most_dofs;                       // beside 20 modes and 6 rigid motions
};

class BasesInContact : public ::testing::TestWithParam<Pressed> {};

TEST_P(BasesInContact, APressedBarHasTheForceAndTheCompressionOfStatics) {
  for (const char* integrator : GetParam().integrators) {
    PressedBar p = GetParam().bar;
    p.integrator = integrator;
    if (p.integrator == "newmark" && p.reduction == statics) p.step = "1.0e-3";
    p.loads = test::ramp(10, 2);
    p.end = 3;
    const Ran ran = run(p);
    const std::size_t last = ran.result.time.size() - 1;
    const double force = 10 * p.area();
    // sigma L / E = 0.01, less the swinging that the corner of the ramp leaves: c / L is 32 / s
    EXPECT_NEAR(test::at(ran.monitor("b.x_max").mean_position, last)[0], 1 - 0.01,
                GetParam().position)
        << integrator;
    EXPECT_NEAR(test::at(ran.monitor("b.x_min").force, last)[0], force, GetParam().force * force)
        << integrator;
    EXPECT_LT(std::abs(test::at(ran.monitor("b.x_min").mean_position, last)[0]), GetParam().wall)
        << integrator;
    EXPECT_LT(test::energy_residual(ran.result), GetParam().energy) << integrator;
    EXPECT_LE(ran.built.simulation.bodies[0]->n_dofs(), 20 + 6 + GetParam().most_dofs);
    if (p.reduction == massless) {
      EXPECT_LT(std::abs(test::at(ran.monitor("b.x_min").mean_velocity, last)[0]), 1e-12);
      EXPECT_LT(std::abs(ran.result.work_contact.back()), 1e-3 * ran.result.work_external.back());
    } else {
      EXPECT_LT(test::worst_residual(ran), 1e-9) << integrator;
    }
  }
}

// Held at one end, whose nodes are kept: the static compression at the other, and the support's
// reaction is no contact.
TEST_P(BasesInContact, HeldNodesStayAndCarry) {
  PressedBar p = GetParam().bar;
  if (p.reduction.find("statics: ") != std::string::npos)
    p.reduction = "basis: characteristic, characteristic: {modes: 4, keep: [x_min]}, modes: 20";
  p.contact = "between: [b.x_max, ceiling]";
  p.walls = "ceiling: {plane: {point: [1.005, 0, 0], normal: [-1, 0, 0]}}";
  p.more = "boundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\n";
  p.loads = test::ramp(-20, 2);
  p.end = 3;
  const Ran ran = run(p);
  const std::size_t last = ran.result.time.size() - 1;
  // 20 of traction, of which E 0.005 / L = 5 strains the bar
  const double force = -15 * p.area();
  EXPECT_LT(test::at(ran.monitor("b.x_min").mean_position, last).cwiseAbs()[0], 1e-13);
  EXPECT_NEAR(test::at(ran.monitor("b.x_max").mean_position, last)[0], 1.005,
              p.reduction == massless ? 1e-13 : 1e-12);
  EXPECT_NEAR(test::at(ran.monitor("b.x_max").force, last)[0], force, 0.02 * std::abs(force));
  EXPECT_LT(test::energy_residual(ran.result), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(
    Bases, BasesInContact,
    ::testing::Values(
        // 49 nodes at each end. Uniform pressure on one end or on the other, balanced by inertia,
        // moves the ends alike: one shape. The load's other two directions are two, and equal
        // forces on all nodes three
        Pressed{"Shapes",
                {.reduction = "basis: characteristic, characteristic: {modes: 0, statics: [x_min, "
                              "x_max]}, modes: 20"},
                {"exact", "central-difference", "newmark"},
                2e-4,
                0.05,
                1e-12,
                1e-9,
                1 + 2 + 3},
        Pressed{"Massless",
                {.reduction = massless, .n = {16, 2, 2}},
                {"exact", "central-difference"},
                1e-4,
                0.02,
                1e-14,
                1e-10,
                0},
        // Ten shapes, and whatever the floor does to 25 nodes
        Pressed{"Statics",
                {.reduction = statics, .n = {12, 4, 4}, .size = {1, 0.5, 0.5}},
                {"exact", "central-difference", "newmark"},
                1e-4,
                0.02,
                1e-13,
                1e-10,
                29}),
    [](const auto& info) { return info.param.name; });

struct Strikes {
  std::string name;
  test::Strike strike;
  double speed, balance, energy;  // limits: of the striker's speed, and of the energy
  double gain = HUGE_VAL, residual = HUGE_VAL;
};

// Of every pair of kinds, the modes that each has, with both integrators or formulations.
std::vector<Strikes> strikes() {
  const auto kind = [](const std::string& basis, Index modes) {
    return "reduction: {basis: " + basis +
           ", interface: [x_min, x_max], modes: " + std::to_string(modes) + "}";
  };
  std::vector<Strikes> all;
  const std::string shapes =
      kind("characteristic, characteristic: {modes: 2, statics: [x_min, x_max]}", 40);
  for (const std::string formulation : {"node-face", "mortar"})
    for (const std::string& other : {shapes, kind("craig-bampton", 40), kind("massless", 40), {}})
      all.push_back({formulation + " " + other,
                     {.kind_a = shapes,
                      .kind_b = other,
                      .contact = "[{between: [a.x_max, b.x_min], friction: 0.2, formulation: " +
                                 formulation + "}]",
                      .across_a = 3,
                      .across_b = 4,
                      .nu = 0.2,
                      .every = 0.02},
                     0.08,
                     1e-9,
                     1.01,
                     HUGE_VAL,
                     1e-6});
  // Beside another kind the modes of massless have mass at the interface, and the impact loses
  // their waves
  for (const std::string integrator : {"exact", "central-difference"})
    for (const std::string& other : {kind("massless", 60), kind("craig-bampton", 60), {}})
      all.push_back(
          {integrator + " massless " + other,
           {.kind_a = kind("massless", 60), .kind_b = other, .time = ", integrator: " + integrator},
           other == kind("massless", 60) ? 0.06 : 0.07,
           1e-10,
           other == kind("massless", 60) ? 1.01 : 1});
  for (const std::string integrator : {"exact", "central-difference", "newmark"})
    for (const std::string& other :
         {kind("characteristic", 20), kind("massless", 60), kind("craig-bampton", 60), {}})
      for (const std::string contact :
           {"[{between: [a.x_max, b.x_min]}]",
            "[{between: [a.x_max, b.x_min], formulation: mortar}]", "all"}) {
        const bool newmark = integrator == "newmark", is_massless = other == kind("massless", 60);
        if (newmark && is_massless) continue;
        all.push_back({integrator + " statics " + other + " " + contact,
                       {.kind_a = kind("characteristic", 20),
                        .kind_b = other,
                        .contact = contact,
                        .time = ", integrator: " + integrator + (newmark ? ", step: 1.0e-3" : ""),
                        .n = 10,
                        .across_a = 2,
                        .across_b = 3,
                        .width = 0.4},
                       0.1,
                       1e-9,
                       1.01,
                       is_massless ? 0.01 : 1e-3});
      }
  return all;
}

// Bars that strike each other: momentum is kept, the speeds swap, energy does not rise.
TEST(BasesInContact, StrikeEveryKindOfBody) {
  for (const Strikes& p : strikes()) {
    const auto [ran, left] = run(p.strike, p.name);
    const double energy = ran.result.total.back() / ran.result.total.front();
    std::printf("speed of the striker afterwards %.4f, energy %.4f, residual %.1e: %s\n", left,
                energy, test::worst_residual(ran), p.name.c_str());
    EXPECT_NEAR(left, 0, p.speed) << p.name;
    EXPECT_LT(energy, p.energy) << p.name;
    EXPECT_LT(test::energy_residual(ran.result), p.balance) << p.name;
    EXPECT_LT(test::largest_gain(ran), p.gain) << p.name;
    EXPECT_LT(test::worst_residual(ran), p.residual) << p.name;
  }
}

// As long as round-off has no impacts to grow on.
TEST(BasesInContact, DoNotDependOnAxesAndUnits) {
  test::expect_the_same_in_other_axes_and_units({.reduction = "basis: characteristic, modes: 15"});
  test::expect_the_same_in_other_axes_and_units(
      {.reduction = "basis: massless, modes: 25", .contact = ", friction: 0.3", .end = 0.1});
}

}  // namespace
}  // namespace cbr::bases_in_contact_test
