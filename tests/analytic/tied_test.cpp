// SPDX-License-Identifier: GPL-3.0-or-later
// Tied surfaces: two halves of a bar move as the bar in one piece.
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "dynamics/output/results.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::tied_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;

// A bar of length 2, pulled at its free end by a ramp, with Poisson's ratio; `instances` and
// `contact` of the scene.
std::string scene(const std::string& reduction, const std::string& instances,
                  const std::string& contact, const std::string& tip) {
  return "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}\n"
         "components:\n"
         "  half: {mesh: half.exo, material: soft" +
         reduction +
         "}\n"
         "  fine: {mesh: fine.exo, material: soft}\n"
         "  bar: {mesh: bar.exo, material: soft}\n"
         "instances:\n" +
         instances + "loads:\n  - {instance: " + tip +
         ", surface: x_max, traction: [0.5, 0.1, 0.02], history: {time: [0, 0.05, 0.1], value: [0, "
         "1, 0.3]}}\n" +
         contact +
         "time: {end: 1.0, step: 1.0e-3, integrator: central-difference}\n"
         "output: {every: 0.05, history: [" +
         tip + ".x_max]}\n";
}

void add_meshes(SceneFolder& folder, Index level = 1) {
  folder.add("half.exo", test::block_mesh({{8 * level, 2 * level, 2 * level}, {1, 0.25, 0.25}}));
  folder.add("fine.exo", test::block_mesh({{12 * level, 3 * level, 3 * level}, {1, 0.25, 0.25}}));
  folder.add("bar.exo", test::block_mesh({{16 * level, 2 * level, 2 * level}, {2, 0.25, 0.25}}));
}

double difference(const Ran& a, const std::string& surface_a, const Ran& b,
                  const std::string& surface_b) {
  double worst = 0, scale = 0;
  const Series3 &x = a.monitor(surface_a).mean_velocity, &y = b.monitor(surface_b).mean_velocity;
  for (std::size_t i = 0; i < a.result.time.size(); ++i) {
    worst = std::max(worst, (at(x, i) - at(y, i)).norm());
    scale = std::max(scale, at(y, i).norm());
  }
  return worst / scale;
}

const std::string whole = "  bar: {component: bar, as: mesh}\n";
std::string halves(const std::string& kind, const std::string& right) {
  return "  left: {component: half, as: " + kind + "}\n  right: {component: " + right +
         ", as: " + kind + ", position: [1, 0, 0]}\n";
}

TEST(Tied, MatchingHalvesAreTheBar) {
  SceneFolder folder;
  add_meshes(folder);
  const Ran bar = folder.run(scene("", whole, "", "bar"));
  for (const std::string formulation : {"node-face", "mortar"}) {
    const std::string contact =
        "contact:\n  - {between: [left.x_max, right.x_min], tied: true, formulation: " +
        formulation + "}\n";
    const Ran meshes = folder.run(scene("", halves("mesh", "half"), contact, "right"));
    EXPECT_LT(difference(meshes, "right.x_max", bar, "bar.x_max"), 1e-9) << formulation;
    EXPECT_LT(test::energy_residual(meshes.result), 1e-10);
  }
}

// Every mode kept: the superelements are the meshes.
TEST(Tied, SuperelementsWithAllModesAreTheBar) {
  SceneFolder folder;
  add_meshes(folder);
  const Ran bar = folder.run(scene("", whole, "", "bar"));
  const std::string all = ", reduction: {interface: [x_min, x_max], modes: 189}";
  const Ran tied = folder.run(
      scene(all, halves("superelement", "half"),
            "contact:\n  - {between: [left.x_max, right.x_min], tied: true}\n", "right"));
  EXPECT_LT(difference(tied, "right.x_max", bar, "bar.x_max"), 1e-9);
}

// Meshes of two sizes carry waves differently, so the tie is judged by how the difference falls
// when both are refined.
TEST(Tied, HalvesThatDoNotMatchTendToTheBar) {
  for (const std::string formulation : {"node-face", "mortar"}) {
    std::vector<double> error;
    for (const Index level : {1, 2}) {
      SceneFolder folder;
      add_meshes(folder, level);
      const Ran bar = folder.run(scene("", whole, "", "bar"));
      const std::string contact =
          "contact:\n  - {between: [left.x_max, right.x_min], tied: true, formulation: " +
          formulation + "}\n";
      const Ran tied = folder.run(scene("", halves("mesh", "fine"), contact, "right"));
      error.push_back(difference(tied, "right.x_max", bar, "bar.x_max"));
      EXPECT_LT(test::energy_residual(tied.result), 1e-10);
    }
    EXPECT_LT(error[1], 0.6 * error[0]) << formulation << ": " << error[0] << ", " << error[1];
  }
}

// The rims of tied surfaces lie on each other: contact of all surfaces must not act there.
TEST(Tied, ContactOfAllSurfacesLeavesTiesAlone) {
  SceneFolder folder;
  add_meshes(folder);
  const std::string tie =
      "contact:\n  - {between: [left.x_max, right.x_min], tied: true, adjust: 0.001}\n";
  for (const char* right : {"half", "fine"})
    for (const char* all : {"  - {between: all}\n", "  - {between: all, formulation: mortar}\n"}) {
      const Ran tied = folder.run(scene("", halves("mesh", right), tie, "right"));
      const Ran beside = folder.run(scene("", halves("mesh", right), tie + all, "right"));
      ASSERT_EQ(beside.built.simulation.pairs.size(), 2u);
      EXPECT_LT(difference(beside, "right.x_max", tied, "right.x_max"), 1e-12) << right << all;
    }
}

// A lid is tied where it lies on a block, and bends until the rest of its lower face meets it.
TEST(Tied, TheRestOfTiedBodiesMeets) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{4, 2, 1}, {4, 1, 1}}));
  folder.add("lid.exo", test::block_mesh({{12, 3, 1}, {4, 1, 0.25}, [](const Vector3& x) {
                                            const double rise = 0.02 * std::max(0.0, x[0] - 1);
                                            return Vector3(x[0], x[1], x[2] + rise);
                                          }}));
  const Ran ran = folder.run(
      "materials: {soft: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  block: {mesh: block.exo, material: soft}\n"
      "  lid: {mesh: lid.exo, material: soft}\n"
      "instances:\n  block: {component: block, as: mesh}\n"
      "  lid: {component: lid, as: mesh, position: [0, 0, 1]}\n"
      "boundary: [{instance: block, nodes: z_min, fix: [x, y, z]}]\n"
      "loads: [{instance: lid, surface: z_max, traction: [0, 0, -0.05]}]\n"
      "contact: [{between: [lid.z_min, block.z_max], tied: true}, {between: all}]\n"
      "time: {static: true, end: 1, step: 0.25}\n");
  ASSERT_EQ(ran.result.pairs.size(), 2u);
  const std::size_t last = ran.result.time.size() - 1;
  EXPECT_GT(at(ran.result.pairs[1]["force"], last).norm(), 0.01);
  EXPECT_LT(ran.result.pairs[1]["penetration"].values.back(), 1e-3);  // with nodes of the block
}

TEST(Tied, WhatLiesBetweenIsKeptAndTooFarIsRefused) {
  SceneFolder folder;
  add_meshes(folder);
  const std::string apart =
      "  left: {component: half, as: mesh}\n  right: {component: half, as: mesh, position: [1.01, "
      "0, 0]}\n";
  const auto run = [&](const std::string& adjust) {
    return folder.run(scene(
        "", apart, "contact:\n  - {between: [left.x_max, right.x_min], tied: true" + adjust + "}\n",
        "right"));
  };
  const Ran bar = folder.run(scene("", whole, "", "bar"));
  EXPECT_LT(difference(run(", adjust: 0.02"), "right.x_max", bar, "bar.x_max"), 1e-9);
  EXPECT_SAYS(test::refusal_of([&] { run(""); }), "adjust");
}

}  // namespace
}  // namespace cbr::tied_test
