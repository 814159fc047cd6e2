// SPDX-License-Identifier: GPL-3.0-or-later
// A component cut into domains that keep all their modes is the component in one piece: held,
// loaded, struck, by every integrator.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/scene_run.hpp"

namespace cbr::test::decomposition_test {
namespace {

// Warped, so that no two domains are alike.
Mesh part() {
  return block_mesh({{5, 3, 4}, Vector3(1, 0.6, 0.8), [](const Vector3& x) {
                       return Vector3(x[0], x[1] * (1 + 0.1 * x[0]), x[2] + 0.05 * x[0] * x[1]);
                     }});
}

struct Case {
  Index domains = 1;
  std::string second;  // a second reduction with that many modes
  std::string integrator = "exact", step = "1.0e-3";
  Index diagonal_limit = 6000;
  std::string rest;  // boundary, loads, contact, walls
};

constexpr Index interface_nodes = 2 * 4 * 5, all_nodes = 6 * 4 * 5;

Ran run(const Case& c) {
  SceneFolder folder;
  folder.diagonal_limit = c.diagonal_limit;
  folder.add("part.exo", part());
  // More than any domain has: all of them
  const Index modes = c.domains > 1 ? 100000 : 3 * (all_nodes - interface_nodes);
  return folder.run(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  part: {mesh: part.exo, material: m, reduction: {interface: [x_min, x_max], "
      "modes: " +
      std::to_string(modes) + ", domains: " + std::to_string(c.domains) + c.second + "}}\n" +
      "instances:\n  a: {component: part, rotation: [0, 0, 30]}\n"
      "  b: {component: part, position: [0.9, 0.52, 0.013], rotation: [0, 0, 30], velocity: [-0.3, "
      "-0.2, 0.05]}\n" +
      c.rest + "time: {end: 0.3, step: " + c.step + ", integrator: " + c.integrator +
      "}\noutput: {every: 0.01, history: [a.x_min, a.x_max, b.x_min]}\n");
}

// Largest difference of two series over the largest value of the first.
double difference(const Series3& a, const Series3& b) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    worst = std::max(worst, std::abs(a.values[i] - b.values[i]));
    scale = std::max(scale, std::abs(a.values[i]));
  }
  return scale > 0 ? worst / scale : worst;
}

void expect_same(const Ran& one, const Ran& many, double tolerance) {
  for (std::size_t m = 0; m < one.result.monitors.size(); ++m) {
    const auto &a = one.result.monitors[m], &b = many.result.monitors[m];
    EXPECT_LT(difference(a.mean_position, b.mean_position), tolerance) << m;
    EXPECT_LT(difference(a.mean_velocity, b.mean_velocity), tolerance) << m;
    EXPECT_LT(difference(a.force, b.force), 10 * tolerance) << m;  // impulses over a step
  }
  EXPECT_LT(energy_residual(many.result), 1e-10);
}

const std::string held_and_pulled =
    "boundary: [{instance: a, nodes: x_min, fix: [x, z]}]\n"
    "loads:\n"
    "  - {instance: a, surface: x_max, traction: [2, -1, 3], history: {time: [0, 0.1, 0.2], value: "
    "[0, 1, 0.5]}}\n"
    "  - {gravity: [0, 0, -1]}\n";
const std::string struck = "contact: [{between: [a.x_max, b.x_min], friction: 0.3}]\n";

class Decomposition : public testing::TestWithParam<std::string> {
 protected:
  static Case with(Index domains, const std::string& rest) {
    Case c;
    c.domains = domains;
    c.integrator = GetParam();
    c.rest = rest;
    if (domains > 1 && c.integrator != "exact") c.diagonal_limit = 0;  // the domains' dense blocks
    return c;
  }
};

TEST_P(Decomposition, HeldAndLoadedIsThePartInOnePiece) {
  const Ran one = run(with(1, held_and_pulled));
  for (const Index domains : {2, 5}) expect_same(one, run(with(domains, held_and_pulled)), 1e-9);
}

TEST_P(Decomposition, ContactWithFrictionIsThatOfThePartInOnePiece) {
  const Ran one = run(with(1, struck));
  double active = 0;
  for (const double a : one.result.active) active = std::max(active, a);
  ASSERT_GT(active, 5);
  for (const Index domains : {3, 4}) {
    const Ran many = run(with(domains, struck));
    EXPECT_EQ(many.built.instances[0].parts.size(), static_cast<std::size_t>(domains));
    expect_same(one, many, 1e-9);
  }
}

TEST_P(Decomposition, WithoutDiagonalFormOneSuperelementIsTheSame) {
  Case coupled = with(1, held_and_pulled + struck);
  const Ran modal = run(coupled);
  coupled.diagonal_limit = 0;
  expect_same(modal, run(coupled), 1e-9);
}

TEST_P(Decomposition, SecondReductionWithAllModesLosesNothing) {
  const Ran one = run(with(1, held_and_pulled + struck));
  Case c = with(4, held_and_pulled + struck);
  c.second =
      ", second_reduction: {modes: " + std::to_string(3 * (all_nodes - interface_nodes)) + "}";
  c.diagonal_limit = 6000;
  const Ran twice = run(c);
  EXPECT_EQ(twice.built.instances[0].parts.size(), 1u);
  expect_same(one, twice, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Integrators, Decomposition,
                         testing::Values("exact", "central-difference", "newmark"),
                         [](const auto& parameter) {
                           std::string name = parameter.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace cbr::test::decomposition_test
