// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies in contact that lasts: at rest they have no velocity, and nothing works on them, with
// damping and without; in a cycle of shear friction and damping take as much as of the mesh
// (docs/theory.md, "Forces that last").
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/scene_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

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
     "characteristic: {shear: true}}"},
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

// A pressed block on a wall, or two, tied; time and output are to follow.
std::string on_wall(const Kind& kind, const std::string& beta, bool two,
                    const std::string& load = "") {
  const auto instance = [&](const std::string& name, const std::string& z) {
    return "  " + name + ": {component: block, position: [0, 0, " + z + "]" + kind.instance + "}\n";
  };
  return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1, damping: {beta: " +
         beta + "}}}\ncomponents: {block: {mesh: block.exo, material: m" + kind.component +
         "}}\ninstances:\n" + instance("a", "0") + (two ? instance("b", "1") : "") +
         "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
         "contact:\n  - {between: [a.z_min, floor], friction: 0.3}\n" +
         (two ? "  - {between: [a.z_max, b.z_min], tied: true}\n" : "") +
         "loads:\n  - {instance: " + (two ? "b" : "a") + ", surface: z_max, pressure: 1}\n" + load;
}

class Rest : public ::testing::TestWithParam<Kind> {};

// With friction that holds the Poisson expansion.
TEST_P(Rest, OfPressedBlocks) {
  constexpr double energy = 2 * 2 * 0.5 / 100;  // under the pressure 1, about
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{3, 3, 2}, {2, 2, 1}}));
  for (const bool two : {false, true})
    for (const std::string beta : {"0", "1.0e-3", "0.1"}) {
      SCOPED_TRACE((two ? "two, beta " : "beta ") + beta);
      expect_rest(folder.run(on_wall(GetParam(), beta, two) + "time: {end: 1, preload: 2" +
                             GetParam().time + "}\noutput: {every: 0.1, history: [a.z_max" +
                             (two ? ", b.z_max" : "") + "]}\n"),
                  energy);
    }
}

// Load steps end in equilibrium at nodes, or with functions of corners on faces of second order:
// motion goes on with these unknowns, on faces of many nodes and in short steps too.
TEST_P(Rest, OfFacesOfManyNodesAndOfSecondOrder) {
  for (const bool second_order : {false, true}) {
    SCOPED_TRACE(second_order ? "hex20" : "hex8");
    Kind kind = GetParam();
    if (const auto at = kind.component.find(", y_max"); second_order && at < kind.component.size())
      kind.component.erase(at, 7);  // hex20 have z_min and z_max alone
    SceneFolder folder;
    folder.add("block.exo", second_order ? test::box_with_faces(ElementType::hex20, {3, 3, 2},
                                                                {2, 2, 1}, "z_min", "z_max")
                                         : test::block_mesh({{12, 12, 2}, {2, 2, 1}}));
    expect_rest(folder.run(on_wall(kind, "0", false,
                                   "  - {instance: a, surface: z_max, traction: [0.1, 0, 0]}\n") +
                           "time: {end: 0.2, preload: 2, step: {cfl: 0.2}" + kind.time +
                           "}\noutput: {every: 0.02, history: [a.z_max]}\n"),
                0);
  }
}

// With pressure functions in load steps and in motion, beside nodes where cells are partly open.
TEST_P(Rest, OfFacesWithPressureFunctions) {
  struct Face {
    Index elements;
    double height;
    std::string functions, modulus, shear, end;
  };
  std::vector<Face> faces{{12, 1, "20", "100", "0.1", "0.02"}};
  if (GetParam().name == "Characteristic") faces.push_back({28, 2, "4", "1.0e7", "0.2", "1.0e-4"});
  for (const Face& face : faces) {
    SCOPED_TRACE(face.functions + " functions");
    SceneFolder folder;
    folder.add("block.exo",
               test::block_mesh({{face.elements, face.elements, 2}, {2, 2, face.height}}));
    std::string scene =
        on_wall(GetParam(), "0", false,
                "  - {instance: a, surface: z_max, traction: [" + face.shear + ", 0, 0]}\n");
    scene.replace(scene.find("friction: 0.3"), 13, "friction: 0.3, pressures: " + face.functions);
    scene.replace(scene.find("modulus: 100"), 12, "modulus: " + face.modulus);
    const Ran ran =
        folder.run(scene + "time: {end: " + face.end + ", preload: 2, step: {cfl: 0.2}" +
                   GetParam().time + "}\noutput: {every: " + face.end + ", history: [a.z_max]}\n");
    expect_rest(ran, 0);
    EXPECT_EQ(ran.built.simulation.pairs.front().seen().n_function_steps > 0,
              GetParam().name != "Mesh");  // whose face keeps its nodes
  }
}

// On a mesh, sheared until a part of its face slid in the load steps.
TEST_P(Rest, OfABlockThatSlid) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{4, 4, 2}, {2, 2, 1}}));
  const Ran ran = folder.run(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\ncomponents:\n"
      "  block: {mesh: block.exo, material: m" +
      GetParam().component + "}\n  base: {mesh: block.exo, material: m}\ninstances:\n" +
      "  a: {component: block, position: [0, 0, 1]" + GetParam().instance + "}\n" +
      "  base: {component: base, as: mesh" +
      (GetParam().name == "Mesh" ? "" : GetParam().instance) + "}\n" +
      "boundary: [{instance: base, nodes: z_min, fix: [x, y, z]}]\n"
      "contact: [{between: [a.z_min, base.z_max], friction: 0.3}]\n"
      "loads:\n  - {instance: a, surface: z_max, pressure: 1}\n"
      "  - {instance: a, surface: z_max, traction: [0.2, 0, 0]}\n"
      "time: {end: 1, preload: 2" +
      GetParam().time + "}\noutput: {every: 0.1, history: [a.z_max]}\n");
  expect_rest(ran, 0);
}

INSTANTIATE_TEST_SUITE_P(Bodies, Rest, ::testing::ValuesIn(kinds),
                         [](const auto& info) { return info.param.name; });

// A pressed block is sheared to and fro, slowly for its modes: its rim slides. With little damping
// it rings as the shear begins, less so in a longer period.
TEST(Microslip, TakesAsMuchAsOfTheMesh) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{3, 3, 2}, {2, 2, 1}}));
  const auto taken = [&](const Kind& kind, const std::string& beta, double period) {
    const RunResult result =
        folder
            .run(on_wall(kind, beta, false,
                         "  - {instance: a, surface: z_max, traction: [0.2, 0, 0], history: {sine: "
                         "{frequency_hz: " +
                             test::text(1 / period) + ", cycles: 1}}}\n") +
                 "time: {end: " + test::text(period) + ", preload: 2}\noutput: {every: 1}\n")
            .result;
    EXPECT_LT(test::energy_residual(result), 1e-10);
    return std::array{-result.work_friction.back(), -result.work_damping.back()};
  };
  for (const std::string beta : {"0", "0.01", "0.1", "1"}) {
    const double period = beta == "0" || beta == "0.01" ? 120 : 40;
    const auto [friction, damping] = taken(kinds[3], beta, period);
    EXPECT_GT(friction, 1e-4);
    for (const Kind& kind : {kinds[0], kinds[1], kinds[2]}) {
      SCOPED_TRACE(kind.name + " " + beta);
      const auto [rubbed, damped] = taken(kind, beta, period);
      EXPECT_NEAR(rubbed, friction, 0.03 * friction);
      EXPECT_NEAR(damped, damping, 0.03 * damping);
    }
  }
}

}  // namespace
}  // namespace cbr::lasting_force_test
