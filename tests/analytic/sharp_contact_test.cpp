// SPDX-License-Identifier: GPL-3.0-or-later
// Edges and corners that meet faces of finer meshes, and edges: when they touch, by the closed
// form, and that nothing goes into anything else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::sharp_contact_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// Speeds are a thousandth of that of sound.
constexpr double speed = 0.1, gap = 0.005, every = 0.005;

// Moves a block that begins at the origin to be centred there.
std::function<Vector3(const Vector3&)> centred(const Vector3& size) {
  return [size](const Vector3& x) { return Vector3(x - size / 2); };
}

class SharpContact : public ::testing::TestWithParam<std::string> {
 protected:
  SharpContact() {
    const auto add = [&](const std::string& name, Index n, Index layers, const Vector3& size) {
      folder.add(name + ".exo", test::block_mesh({{n, n, layers}, size, centred(size)}));
    };
    add("plate", 6, 1, {1.8, 1.8, 0.3});
    add("cube1", 1, 1, Vector3::Ones());
    add("cube2", 2, 2, Vector3::Ones());
    add("cube3", 3, 3, Vector3::Ones());
    add("cube4", 4, 4, Vector3::Ones());
  }

  static std::string component(const std::string& name) {
    const bool has_interior = name == "cube3" || name == "cube4";
    return "  " + name + ": {mesh: " + name +
           ".exo, material: m, reduction: {interface: [x_min, x_max, y_min, y_max, z_min, z_max], "
           "modes: " +
           (has_interior ? "6" : "0") + "}}\n";
  }

  // An instance of `as: GetParam()` that falls.
  std::string falling(const std::string& of, const Vector3& position,
                      const Vector3& rotation) const {
    return "  up: {component: " + of + ", as: " + GetParam() + ", position: " + text(position) +
           ", rotation: " + text(rotation) + ", velocity: [0, 0, " + text(-speed) + "]}\n";
  }

  std::string scene(const std::string& of, const std::string& below, const std::string& above,
                    const std::string& contact, double end = 0.1) const {
    return "materials: {m: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}\n"
           "components:\n" +
           component(of) + (below == of ? "" : component(below)) + "instances:\n" + above +
           contact + "\ntime: {end: " + text(end) + "}\noutput: {every: " + text(every) + "}\n";
  }

  // A plate, its top at z = 0, held below.
  std::string plate(const std::string& of, const Vector3& position, const Vector3& rotation,
                    const std::string& contact) const {
    const std::string as = GetParam() == "rigid" ? "mesh" : GetParam();
    return scene(of, "plate",
                 "  plate: {component: plate, as: " + as + ", position: [0, 0, -0.15]}\n" +
                     falling(of, position, rotation) +
                     "boundary: [{instance: plate, nodes: z_min, fix: [x, y, z]}]\n",
                 contact);
  }

  // It touches when it has gone `way`, turns back, and leaves at most 1 % of a face of `size`
  // inside.
  static void expect_touch(const Ran& ran, double way, double size, double most_below = 0.01) {
    ASSERT_EQ(ran.result.pairs.size(), 1u);
    const auto& pair = ran.result.pairs.front();
    const double t = way / speed;
    ASSERT_GT(ran.result.time.back(), t + 2 * every);
    // Its centre goes on by what the bodies are pressed together at most
    const auto& up = ran.body("up").center_of_mass;
    const double z0 = at(up, 0)[2];
    double lowest = z0;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      lowest = std::min(lowest, at(up, i)[2]);
    EXPECT_NEAR(lowest, z0 - way, most_below);
    EXPECT_LT(lowest, z0 - way + every * speed);
    const PairState& state = ran.built.simulation.pairs.front().seen();
    EXPECT_TRUE(state.has_touched);
    EXPECT_LT(state.penetration, 0.01 * size);
    EXPECT_NEAR(state.memory.initial_gap, way, 1e-12);
    std::size_t first = 0;
    const auto n = static_cast<std::size_t>(pair["force"].values.size() / 3);
    while (first < n && at(pair["force"], first).norm() == 0) ++first;
    ASSERT_LT(first, n);
    const double since = ran.result.time.back() - every * static_cast<double>(n - 1 - first);
    EXPECT_GE(since, t);
    EXPECT_LE(since, t + every + 1e-9);
  }

  SceneFolder folder;
};

const double turn = 40 * std::numbers::pi / 180;
// Of a unit cube turned by 40 degrees about an edge's direction: from the centre to the lowest edge
const double to_edge = 0.5 * (std::sin(turn) + std::cos(turn));

TEST_P(SharpContact, AnEdgeOnAFinerPlate) {
  const Vector3 position(0.04, 0.03, to_edge + gap);
  for (const std::string contact : {"contact: all", "contact: [{between: [plate.z_max, up.z_min]}]",
                                    "contact: [{between: [up.z_min, plate.z_max], friction: 0.2}]"})
    expect_touch(folder.run(plate("cube1", position, {0, 40, 0}, contact)), gap, 0.3);
}

TEST_P(SharpContact, ACornerOnAFinerPlate) {
  // A diagonal of the cube stands upright
  const Vector3 rotation(45, std::atan(std::sqrt(0.5)) * 180 / std::numbers::pi, 0);
  const Vector3 position(0.04, 0.03, std::sqrt(0.75) + gap);
  expect_touch(folder.run(plate("cube2", position, rotation, "contact: all")), gap, 0.3);
}

TEST_P(SharpContact, ATiltedBlockOnAFinerOne) {
  const std::string as = GetParam() == "rigid" ? "mesh" : GetParam();
  const Vector3 position(0.03, 0.02, 0.5 + to_edge + gap);
  const Ran ran = folder.run(
      scene("cube3", "cube4",
            "  low: {component: cube4, as: " + as + "}\n" + falling("cube3", position, {0, 40, 0}) +
                "boundary: [{instance: low, nodes: z_min, fix: [x, y, z]}]\n",
            "contact: all"));
  expect_touch(ran, gap, 0.25);
}

// No node of either is near the other. They share the momentum: rigid ones stay together, of
// elastic ones nothing is lost but what the elements hold back.
TEST_P(SharpContact, CrossedEdges) {
  const Vector3 position(0, 0, std::sqrt(2.0) + gap);
  for (const std::string contact :
       {"contact: all", "contact: [{between: [low.z_max, up.z_min]}]"}) {
    const Ran ran =
        folder.run(scene("cube1", "cube1",
                         "  low: {component: cube1, as: " + GetParam() +
                             ", rotation: [45, 0, 0]}\n" + falling("cube1", position, {0, 45, 0}),
                         contact));
    const std::size_t last = ran.result.time.size() - 1;
    const Vector3 low = at(ran.body("low").momentum, last), up = at(ran.body("up").momentum, last);
    EXPECT_LT((low + up - Vector3(0, 0, -speed)).norm(), 1e-12);
    EXPECT_LE(low[2], -speed / 2 + 1e-9);
    if (GetParam() == "rigid") {
      EXPECT_NEAR(low[2], -speed / 2, 1e-9);
    } else {
      EXPECT_LT(low[2], -0.6 * speed);
    }
    EXPECT_LT(test::largest_change(ran.result, &RunResult::OfBody::angular_momentum),
              GetParam() == "superelement" ? 1e-3 * speed : 1e-12);
    const PairState& state = ran.built.simulation.pairs.front().seen();
    EXPECT_TRUE(state.has_touched);
    EXPECT_LT(state.penetration, 1e-6);
    EXPECT_NEAR(state.memory.initial_gap, gap, 1e-12);
  }
}

// What edges remember is in a checkpoint: the crossed edges are in contact there.
TEST_P(SharpContact, GoesOnFromACheckpoint) {
  const Vector3 position(0.1, 0.05, std::sqrt(2.0) + gap);
  const std::string yaml =
      scene("cube1", "cube1",
            "  low: {component: cube1, as: " + GetParam() + ", rotation: [45, 0, 0]}\n" +
                falling("cube1", position, {0, 45, 0}),
            "contact: [{between: all, friction: 0.3}]");
  const test::RestartedRun runs = test::restarted(folder, yaml, gap / speed + 0.25 * every);
  EXPECT_TRUE(runs.rest.built.simulation.pairs.front().seen().has_touched);
  for (const char* name : {"low", "up"}) {
    EXPECT_EQ(runs.rest.body(name).momentum.values, runs.whole.body(name).momentum.values);
    EXPECT_EQ(runs.rest.body(name).angular_momentum.values,
              runs.whole.body(name).angular_momentum.values);
  }
}

// Mortar holds means: that it lets edges in is measured, whatever points it has.
TEST_P(SharpContact, WhatMortarLetsInIsMeasured) {
  const Vector3 position(0.04, 0.03, to_edge + gap);
  const Ran ran = folder.run(
      plate("cube1", position, {0, 40, 0}, "contact: [{between: all, formulation: mortar}]"));
  const double fallen = at(ran.body("up").center_of_mass, 0)[2] -
                        at(ran.body("up").center_of_mass, ran.result.time.size() - 1)[2];
  const PairState& state = ran.built.simulation.pairs.front().seen();
  if (!state.has_touched) EXPECT_NEAR(state.penetration, fallen - gap, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Bodies, SharpContact, ::testing::Values("rigid", "mesh", "superelement"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace cbr::sharp_contact_test
