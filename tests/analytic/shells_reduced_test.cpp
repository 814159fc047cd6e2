// SPDX-License-Identifier: GPL-3.0-or-later
// Superelements of shells with a reduced interface, or one without mass, against their meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/shelled_scene.hpp"

namespace cbr::shells_reduced_test {
namespace {

using namespace test::shelled;
using test::at;
using test::Faces;
using test::Ran;
using test::text;

// A box of shells, open at the top, 0.6 x 0.4 x 0.3, `n` elements along the longest edge.
Mesh open_box(Index n) {
  Mesh box;
  const Index n_y = 2 * n / 3, n_z = n / 2;
  const double x = 0.6, y = 0.4, z = 0.3;
  add_grid(
      Faces::quads, n, n_y, [&](double s, double r) { return Vector3(x * s, y * r, 0); }, "floor",
      box);
  for (const double end : {0.0, 1.0}) {
    const std::string name = end > 0 ? "1" : "0";
    add_grid(
        Faces::quads, n, n_z, [&](double s, double r) { return Vector3(x * s, y * end, z * r); },
        "y" + name, box);
    add_grid(
        Faces::quads, n_y, n_z, [&](double s, double r) { return Vector3(x * end, y * s, z * r); },
        "x" + name, box);
  }
  // One node for all at a place
  std::vector<Index> first(box.node_ids.size()), kept;
  for (Index i = 0; i < box.coordinates.rows(); ++i) {
    Index j = 0;
    while ((box.coordinates.row(j) - box.coordinates.row(i)).norm() > 1e-9) ++j;
    if (j == i) kept.push_back(i);
    first[i] = j == i ? static_cast<Index>(kept.size()) - 1 : first[j];
  }
  for (Block& block : box.blocks) {
    block.id = &block - box.blocks.data() + 1;
    for (Index& node : block.connectivity.reshaped()) node = first[node];
  }
  box.coordinates = Points(box.coordinates(kept, Eigen::all));
  box.node_ids.resize(kept.size());
  box.nodesets.clear();
  return box;
}

Shelled box_scene(const std::string& reduction) {
  Shelled scene{.mesh = "box.exo", .mass = "lumped"};
  for (const std::string name : {"floor", "x0", "x1", "y0", "y1"})
    scene.blocks += (scene.blocks.empty() ? "" : ", ") + name + ": {thickness: 0.004}";
  scene.reduction = reduction;
  return scene;
}

// Frequencies of the free modes that the basis has: reduced interfaces of few and many dofs
// (dense and sparse shapes), and one without mass.
TEST_F(Shells, ReducedInterfacesKeepFrequencies) {
  for (const Index n : {8, 26}) {
    folder.add("plate.exo", plate(Faces::quads, n, n * 3 / 4, 1, 0.7));
    Shelled scene{.more = "time: {end: 1}\n"};
    const Vector expected = frequencies(scene, 16);
    // (an interface of all nodes has nearly all mass: `massless` leaves it no compliance)
    for (const std::string& basis :
         {std::string("plate, basis: characteristic"), std::string("edges, basis: massless")}) {
      scene.reduction = "interface: " + basis + ", modes: 20";
      const Vector found = frequencies(scene, 16);
      EXPECT_EQ((found.array() == 0).count(), 6);
      for (Index j = 6; j < 16; ++j)
        EXPECT_NEAR(found(j) / expected(j), 1, 1e-6) << basis << n << " " << j;
    }
    scene.reduction.clear();
  }
}

// A clamp keeps its rotations, with all others inside: a strip under its tip's force and a plate
// that a ball presses have the static answers of the mesh.
TEST_F(Shells, ReducedInterfacesHaveTheStaticsOfTheMesh) {
  folder.add("plate.exo", plate(Faces::quads, 12, 8, 1, 0.7));
  const auto both = [&](const std::string& more, const std::string& set) {
    Shelled scene{.more = more, .output = "history: [a." + set + "]"};
    const Ran mesh = folder.run(yaml(scene));
    scene.reduction = "interface: plate, basis: characteristic, modes: 10";
    const Ran reduced = folder.run(yaml(scene));
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(moved(reduced, "a." + set, axis), moved(mesh, "a." + set, axis), 1e-9) << more;
    return std::pair(moved(mesh, "a." + set, 2),
                     last(reduced.body("a").reaction, 2) / last(mesh.body("a").reaction, 2));
  };
  const std::string clamped = "boundary:\n" + held("x_0", "[x, y, z]", ""),
                    run = "time: {end: 1, step: 0.5, static: true}\n";
  const auto [tip, of_tip] =
      both(clamped + "loads:\n  - {instance: a, surface: x_1, force: [0, 0, 100]}\n" + run, "x_1");
  EXPECT_GT(tip, 1e-3);
  EXPECT_NEAR(of_tip, 1, 1e-9);
  const auto [sag, of_ball] = both(
      "walls:\n  ball: {sphere: {center: [0.5, 0.35, 0.2], radius: 0.2}, displacement: [0, 0, "
      "-0.002], history: {time: [0, 1], value: [0, 1]}}\ncontact:\n  - {between: [a.plate, "
      "ball]}\n" +
          clamped + held("x_1", "[x, y, z]", "") + run,
      "tip");
  EXPECT_NEAR(of_ball, 1, 1e-6) << sag;
}

// A box strikes a wall with a corner: its rebound, spin and path are those of the mesh, and the
// books close. Recovered fields move the whole box.
TEST_F(Shells, AReducedBoxStrikesAsItsMesh) {
  folder.add("box.exo", open_box(12));
  const auto run = [&](const std::string& reduction) {
    Shelled scene = box_scene(reduction);
    scene.instance = ", position: [0, 0, 0.03], rotation: [3, 2, 0], velocity: [0, 0, -5]";
    scene.output = "every: 5.0e-5, history: [a.floor.back]";
    scene.more =
        "walls:\n  wall: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}\ncontact:\n"
        "  - {between: [a.floor.back, wall]}\ntime: {end: 5.0e-3, rotations: small}\n";
    return folder.run(yaml(scene));
  };
  const Ran mesh = run("");
  const auto n = mesh.result.time.size() - 1;
  const Vector3 p = at(mesh.body("a").momentum, n), L = at(mesh.body("a").angular_momentum, n),
                p_0 = at(mesh.body("a").momentum, 0);
  EXPECT_GT((p - p_0).norm(), 0.1 * p_0.norm());
  for (const auto& [basis, bound] :
       {std::pair("characteristic, modes: 80", 0.12),
        std::pair("massless, massless_modes: tapered, modes: 120", 0.05)}) {
    const Ran reduced = run("interface: floor.back, basis: " + std::string(basis));
    ASSERT_EQ(reduced.result.time.size() - 1, n);
    EXPECT_LT((at(reduced.body("a").momentum, n) - p).norm(), bound * p_0.norm()) << basis;
    EXPECT_LT((at(reduced.body("a").angular_momentum, n) - L).norm(), 2 * bound * L.norm())
        << basis;
    double worst = 0;
    for (std::size_t i = 0; i <= n; ++i)
      worst = std::max(worst, (at(reduced.monitor("a.floor.back").mean_position, i) -
                               at(mesh.monitor("a.floor.back").mean_position, i))
                                  .norm());
    EXPECT_LT(worst, bound * 0.0125) << basis;
    EXPECT_LT(test::energy_residual(reduced.result), 1e-12) << basis;
    EXPECT_LT(reduced.result.total.back(), 1.001 * reduced.result.total.front()) << basis;
  }
}

// A box lands flat. Few pressures on its floor leave it energy more like the mesh than nodes do.
TEST_F(Shells, AFlatLandingHasFewPressures) {
  folder.add("box.exo", open_box(12));
  const auto kept = [&](const std::string& reduction, const std::string& pressures) {
    Shelled scene = box_scene(reduction);
    scene.instance = ", position: [0, 0, 0.001], velocity: [0, 0, -5]";
    scene.more =
        "walls:\n  wall: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}\ncontact:\n"
        "  - {between: [a.floor.back, wall], pressures: " +
        pressures + "}\ntime: {end: 5.0e-3, rotations: small}\n";
    const Ran ran = folder.run(yaml(scene));
    return ran.result.total.back() / ran.result.total.front();
  };
  const double mesh = kept("", "nodes");
  for (const std::string basis :
       {"characteristic, modes: 80", "massless, massless_modes: tapered, modes: 120"}) {
    const std::string reduction = "interface: floor.back, basis: " + basis;
    const double few = kept(reduction, "40");
    EXPECT_LT(few, 1) << basis;
    EXPECT_LT(std::abs(few - mesh), 0.8 * std::abs(kept(reduction, "nodes") - mesh)) << basis;
  }
}

// Free superelements with a reduced interface turn by any angle.
TEST_F(Shells, ReducedInterfacesTurn) {
  folder.add("plate.exo", plate(Faces::quads, 6, 4, 1, 0.7));
  Shelled scene{.reduction = "interface: plate, basis: characteristic, modes: 10",
                .instance = ", angular_velocity: [3, 5, 7]",
                .output = "every: 0.02, history: [a.x_0]"};
  scene.more = "time: {end: 0.1, rotations: large}\n";
  const Ran ran = folder.run(yaml(scene));
  const std::size_t n = ran.result.time.size() - 1;
  const Vector3 L = at(ran.body("a").angular_momentum, 0);
  EXPECT_LT((at(ran.body("a").angular_momentum, n) - L).norm(), 1e-9 * L.norm());
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
}

}  // namespace
}  // namespace cbr::shells_reduced_test
