// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes whose loads act on faces inside a superelement: nothing but the load is said, cbr-reduce
// takes it in.
#include <gtest/gtest.h>

#include <string>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::load_inside_test {
namespace {

struct Case {
  std::string instance = "{component: part, as: superelement}", load = "force: [0, 0.2, -0.3]",
              integrator = "exact";
  std::string more = {}, reduction = "modes: 6";
  std::optional<Index> diagonal_limit = {};
};

test::Ran run(const Case& c) {
  test::SceneFolder folder;
  folder.diagonal_limit = c.diagonal_limit;
  folder.add("part.exo", test::block_mesh({{6, 2, 2}, Vector3(3, 0.8, 1)}));
  return folder.run(
      "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  part: {mesh: part.exo, material: m, reduction: {interface: [x_min], " +
      c.reduction + "}}\ninstances:\n  a: " + c.instance +
      "\nboundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n" +
      "loads: [{instance: a, surface: x_max, " + c.load +
      ", history: {time: [0, 0.2, 3], value: [0, 1, 0.7]}}]\n" + c.more +
      "time: {end: 3, step: 2.0e-3, integrator: " + c.integrator + "}\noutput: {every: 0.1}\n");
}

Points center(const test::Ran& ran) {
  const auto& values = ran.body("a").center_of_mass.values;
  return Eigen::Map<const Points>(values.data(), static_cast<Index>(values.size() / 3), 3);
}
double difference(const Points& a, const Points& b) {
  return (a - b).norm() / (b.rowwise() - b.row(0)).norm();
}

TEST(LoadInside, MovesASuperelementAsTheMesh) {
  const Points mesh =
      center(run({.instance = "{component: part, as: mesh}", .integrator = "newmark"}));
  const test::Ran reduced = run({.integrator = "newmark"});
  EXPECT_EQ(reduced.built.instances.at(0).n_modal, 6 + 3);
  EXPECT_LT(difference(center(reduced), mesh), 2e-3);
}

TEST(LoadInside, WorkIsEnergy) {
  const test::Ran ran = run({});
  const auto& body = ran.body("a");
  double largest = 0, wrong = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double energy = body.kinetic_energy[i] + body.strain_energy[i];
    largest = std::max(largest, energy);
    wrong = std::max(wrong, std::abs(energy - ran.result.work_external[i]));
  }
  EXPECT_GT(largest, 0);
  EXPECT_LT(wrong, 1e-10 * largest);
}

TEST(LoadInside, TurnsWithTheInstanceAndActsInTheScenesAxes) {
  const Points upright = center(run({}));
  const test::Ran turned =
      run({.instance = "{component: part, as: superelement, rotation: [0, 0, 90], mirror: y}",
           .load = "force: [0.2, 0, -0.3]"});
  // x -> y; y -> -y -> x
  const Points back = center(turned)(Eigen::all, std::vector<int>{1, 0, 2});
  const Points moved = back.rowwise() - back.row(0), expected = upright.rowwise() - upright.row(0);
  EXPECT_LT((moved - expected).norm(), 1e-10 * expected.norm());
}

TEST(LoadInside, TractionIsForceOverTheArea) {
  // of 0.8
  const Points force = center(run({})),
               traction = center(run({.load = "traction: [0, 0.25, -0.375]"}));
  EXPECT_LT(difference(traction, force), 1e-12);
}

TEST(LoadInside, DenseBlocksMoveAsTheDiagonalForm) {
  const Points modal = center(run({.integrator = "central-difference"}));
  const Points blocks = center(run({.integrator = "central-difference", .diagonal_limit = 0}));
  EXPECT_LT(difference(blocks, modal), 1e-9);
}

TEST(LoadInside, WhatCannotTakeItSaysSo) {
  const auto message = [](const Case& c) -> std::string {
    return test::refusal_of([&] { run(c); });
  };
  EXPECT_SAYS(message({.reduction = "modes: 10, basis: massless"}), "reduction.interface");
  EXPECT_SAYS(message({.reduction = "modes: 3, domains: 2"}), "reduction.interface");
  EXPECT_SAYS(message({.reduction = "modes: 3, domains: 2, loads: [x_max]"}),
              "loads: requires domains: 1");
  EXPECT_SAYS(message({.reduction = "modes: 10, basis: massless, loads: [x_max]"}),
              "is not available");
}

}  // namespace
}  // namespace cbr::load_inside_test
