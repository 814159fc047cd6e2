// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies at rest in contact: they have no velocity, and nothing works on them, with damping and
// without (docs/theory.md, "Forces that last").
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::lasting_force_test {
namespace {

using test::Ran;
using test::SceneFolder;

struct Kind {
  std::string name, component, instance = "", time = "";
};

const std::vector<Kind> kinds{
    {"CraigBampton", ", reduction: {interface: [z_min, z_max], modes: 12}"},
    {"Characteristic",
     ", reduction: {basis: characteristic, interface: [z_min, z_max, y_max], modes: 12, "
     "characteristic: "
     "{shear: true}}"},
    {"Massless", ", reduction: {basis: massless, interface: [z_min, z_max], modes: 12}"},
    {"Mesh", "", ", as: mesh"},
    {"CentralDifferences", ", reduction: {interface: [z_min, z_max], modes: 12}", "",
     ", integrator: central-difference"},
    {"MasslessCentralDifferences",
     ", reduction: {basis: massless, interface: [z_min, z_max], modes: 12}", "",
     ", integrator: central-difference"},
    {"Turned", ", reduction: {interface: [z_min, z_max], modes: 12}", ", rotation: [0, 0, 30]"},
    {"Mirrored", ", reduction: {interface: [z_min, z_max], modes: 12}", ", mirror: x"},
};

double largest(const std::vector<double>& series) {
  double most = 0;
  for (const double value : series) most = std::max(most, std::abs(value));
  return most;
}

// Velocity against that of the kinetic energy `energy` of a mass.
void expect_rest(const Ran& ran, double energy) {
  constexpr double share = 1e-9;  // of the energy, what works may be
  const RunResult& result = ran.result;
  const double scale = energy > 0 ? energy : result.total.front();
  for (const auto* work : {&result.work_contact, &result.work_friction, &result.work_damping,
                           &result.work_numerical, &result.work_external})
    EXPECT_LT(largest(*work), share * scale);
  double kinetic = 0, momentum = 0, mass = 0;
  for (const auto& body : result.bodies) {
    kinetic = std::max(kinetic, largest(body.kinetic_energy));
    momentum = std::max(momentum, largest(body.momentum.values));
  }
  for (const auto& instance : ran.scene.instances) mass += ran.mass(instance.name);
  EXPECT_LT(kinetic, share * scale);
  EXPECT_LT(momentum * momentum / (2 * mass), share * share * scale);
  for (const auto& monitor : result.monitors)
    EXPECT_LT(0.5 * mass * std::pow(largest(monitor.mean_velocity.values), 2),
              share * share * scale);
  EXPECT_LT(std::abs(result.total.back() - result.total.front()), share * scale);
}

class Rest : public ::testing::TestWithParam<Kind> {
 protected:
  Rest() { folder.add("block.exo", test::block_mesh({{3, 3, 2}, {2, 2, 1}})); }
  std::string component(const std::string& beta) const {
    return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1, damping: "
           "{beta: " +
           beta + "}}}\ncomponents: {block: {mesh: block.exo, material: m" + GetParam().component +
           "}}\n";
  }
  std::string instance(const std::string& name, const std::string& z) const {
    return "  " + name + ": {component: block, position: [0, 0, " + z + "]" + GetParam().instance +
           "}\n";
  }
  std::string time() const { return "time: {end: 1, preload: 2" + GetParam().time + "}\n"; }
  // of the block under the pressure 1, about
  static constexpr double energy = 2 * 2 * 0.5 / 100;
  SceneFolder folder;
};

// A pressed block between a wall and its load, with friction that holds the Poisson expansion.
TEST_P(Rest, OfAPressedBlock) {
  for (const std::string beta : {"0", "1.0e-3", "0.1"}) {
    SCOPED_TRACE(beta);
    const Ran ran = folder.run(component(beta) + "instances:\n" + instance("a", "0") +
                               "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
                               "loads: [{instance: a, surface: z_max, pressure: 1}]\n"
                               "contact: [{between: [a.z_min, floor], friction: 0.2}]\n" +
                               time() + "output: {every: 0.1, history: [a.z_max]}\n");
    expect_rest(ran, energy);
  }
}

// Two blocks, tied, on a wall.
TEST_P(Rest, OfTiedBlocks) {
  for (const std::string beta : {"0", "1.0e-3"}) {
    SCOPED_TRACE(beta);
    const Ran ran =
        folder.run(component(beta) + "instances:\n" + instance("a", "0") + instance("b", "1") +
                   "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
                   "loads: [{instance: b, surface: z_max, pressure: 1}]\n"
                   "contact:\n  - {between: [a.z_max, b.z_min], tied: true}\n"
                   "  - {between: [a.z_min, floor], friction: 0.2}\n" +
                   time() + "output: {every: 0.1, history: [a.z_max, b.z_max]}\n");
    expect_rest(ran, energy);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, Rest, ::testing::ValuesIn(kinds),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace cbr::lasting_force_test
