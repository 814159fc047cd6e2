// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic, from reduction to run: contact on more nodes than the interface has
// coordinates, so that the response of the gaps is singular, must find the motion that there is to
// find, and the forces' sums.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/error.hpp"
#include "tests/support/pressed_bar.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::characteristic_test {
namespace {

using test::PressedBar;
using test::Ran;
using test::SceneFolder;
using test::text;

// Flat on a wall: what Craig and Bampton's interface of 294 dofs does, within what the modes leave
// open in it.
TEST(CharacteristicContact, ReboundsAsTheFullInterfaceDoes) {
  const auto speed = [](const std::string& reduction) {
    PressedBar p;
    p.reduction = reduction;
    p.nu = 0.3;
    p.instance = ", position: [0.05, 0, 0], velocity: [-1, 0, 0]";
    p.end = 0.25;
    p.every = 0.0125;
    const Ran ran = run(p);
    const std::size_t last = ran.result.time.size() - 1;
    EXPECT_LT(test::worst_residual(ran), 1e-8);
    EXPECT_LT(test::energy_residual(ran.result), 1e-10);
    EXPECT_GT(ran.result.active[last / 2] + ran.result.active[last / 3], 0);
    return test::at(ran.body("b").momentum, last)[0] / ran.mass("b");
  };
  const double full = speed("modes: 60");
  const double reduced = speed("basis: characteristic, characteristic: {modes: 6}, modes: 60");
  const double kept =
      speed("basis: characteristic, characteristic: {modes: 6, keep: [x_min]}, modes: 60");
  std::printf("rebound: full interface %.4f, reduced %.4f, contact kept %.4f\n", full, reduced,
              kept);
  EXPECT_NEAR(reduced, full, 0.02);
  EXPECT_NEAR(kept, full, 0.005);
}

// Few shapes under 49 nodes with friction. It slides over all of the face: what a block loses along
// the wall is mu times what it gets from it; and nothing happens across its plane of symmetry.
TEST(CharacteristicContact, SlidesAsCoulombSays) {
  for (const double along : {2.0, 0.05}) {
    PressedBar p;
    // Modes of a basis keep the symmetry to their residual alone
    p.reduction =
        "basis: characteristic, characteristic: {modes: 10}, modes: 20, exact_modes: true";
    p.contact = "between: [b.x_min, floor], friction: 0.3";
    p.nu = 0.3;
    p.instance = ", position: [0.01, 0, 0], velocity: [-1, " + text(along) + ", 0]";
    p.end = 0.1;
    p.every = 0.002;
    const Ran ran = run(p);
    const std::size_t last = ran.result.time.size() - 1;
    const Vector3 change =
        test::at(ran.body("b").momentum, last) - test::at(ran.body("b").momentum, 0);
    EXPECT_GT(change[0], 1.2 * ran.mass("b"));
    if (along > 1) {
      EXPECT_NEAR(change[1], -0.3 * change[0], 0.003 * change[0]) << along;
    } else {
      EXPECT_LE(std::abs(change[1]), 0.3 * change[0]) << along;
    }
    EXPECT_LT(std::abs(change[2]), 1e-9 * change[0]) << along;
    EXPECT_LT(test::worst_residual(ran), 1e-9) << along;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << along;
    EXPECT_LE(ran.result.total.back(), ran.result.total.front() * (1 + 1e-9));
  }
}

TEST(CharacteristicContact, RefusesWhatItCannotDo) {
  const auto expect = [](const PressedBar& p, const std::string& part) {
    const std::string message = test::refusal_of([&] { run(p); });
    EXPECT_SAYS(message, part, "characteristic");
  };
  const PressedBar few{.reduction =
                           "basis: characteristic, characteristic: {modes: 0, statics: "
                           "[x_min, x_max]}, modes: 20"};
  PressedBar p = few;
  p.contact += ", enforcement: nodal";
  expect(p, "enforcement: nodal");
  p = few;
  p.reduction += ", domains: 2";
  expect(p, "domains above 1");
  p = few;
  p.reduction = "characteristic: {modes: 3}, modes: 20";
  expect(p, "requires basis: characteristic");
  p = few;
  p.reduction = "basis: characteristic, characteristic: {statics: [y_min]}, modes: 20";
  expect(p, "characteristic.statics: the interface keeps no sideset 'y_min'");
  p = few;
  p.more =
      "boundary: [{instance: b, nodes: x_min, fix: [x]}, {instance: b, nodes: x_max, fix: [x]}]\n";
  expect(p,
         "every node of the interface is kept by what the scene holds, ties or makes rigid (x_max, "
         "x_min)");
  p = few;
  p.more =
      "skin: {surfaces: [x_max], youngs_modulus: 10, poissons_ratio: 0.3, density: 1, thickness: "
      "0.01}\n";
  expect(p, "skin");
}

// A block whose top has a patch of 3 x 3 elements in its middle.
Mesh block_with_patch(Index n) {
  Mesh mesh = test::block_mesh({{n, n, 3}, {1, 1, 0.3}});
  Sideset patch = mesh.sidesets[find_sideset(mesh, "z_max")];
  patch.name = "patch";
  patch.id = 99;
  std::erase_if(patch.sides, [&](const auto& side) {
    const std::vector<Index> nodes = nodes_of_side(mesh, side);
    const Vector3 middle = mesh.coordinates(nodes, Eigen::all).colwise().mean().transpose();
    return std::max(std::abs(middle[0] - 0.5), std::abs(middle[1] - 0.5)) >
           1.4 / static_cast<double>(n);
  });
  mesh.sidesets.push_back(std::move(patch));
  return mesh;
}

// Pressed on a wall with friction. acts: loads, and supports of the patch.
Ran press_patch(const SceneFolder& folder, const std::string& as, const std::string& acts) {
  return folder.run(
      "materials: {m: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}\ncomponents: "
      "{block: {mesh: block.exo, material: m, reduction: {basis: characteristic, interface: "
      "[z_min, patch, y_max], modes: 20}}}\ninstances: {b: {component: block, as: " +
      as +
      "}}\nwalls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
      "contact: [{between: [b.z_min, floor], friction: 0.5}]\n" +
      acts + "time: {static: true, end: 1, step: 0.5}\noutput: {history: [b.patch, b.y_max]}\n");
}

// The work of a load is that of the mean displacement that it works on, and what a history reads is
// right without a load, too. 22 elements along an edge are above 1500 dofs of the interface, so
// that the shapes come of sparse solves. Of the strain of the held interior under gravity
// fixed-interface modes have a share.
TEST(CharacteristicStatics, LoadsAndHeldFacesDoTheWorkThatTheyDoOnTheMesh) {
  const std::string history = ", history: {time: [0, 1], value: [0.1, 1]}}";
  const std::string on = "{instance: b, surface: ", held = "{instance: b, nodes: patch, fix: ";
  const std::string patch = "loads: [" + on + "patch, traction: [20, -10, -60]" + history;
  const std::string side = on + "y_max, traction: [1, 2, -3]}]\n";  // has an edge with z_min
  for (const Index n : {5, 22}) {
    SceneFolder folder;
    folder.add("block.exo", block_with_patch(n));
    const auto compare = [&](const std::string& acts, double tolerance = 1e-8) {
      const Ran mesh = press_patch(folder, "mesh", acts);
      const Ran reduced = press_patch(folder, "superelement", acts);
      const double work = mesh.result.work_external.back();
      EXPECT_GT(work, 1e-6) << acts;
      EXPECT_NEAR(reduced.result.work_external.back(), work, tolerance * work) << n << " " << acts;
      for (const char* set : {"b.patch", "b.y_max"}) {
        const auto way = [&](const Ran& ran) {
          const Series3& position = ran.monitor(set).mean_position;
          const std::size_t last = ran.result.time.size() - 1;
          return Vector3(test::at(position, last) - test::at(position, 0));
        };
        EXPECT_LT((way(reduced) - way(mesh)).norm(), tolerance * way(mesh).norm())
            << n << " " << set << " " << acts;
      }
    };
    compare(patch + "]\n");
    compare("boundary: [" + held + "[x, y]}]\n" + patch + ", " + side);
    compare("boundary: [" + held + "[x, y, z], displacement: [0, 0, -0.001]" + history +
            "]\nloads: [" + side);
    if (n > 5) continue;
    for (const std::string load : {"pressure: 50", "force: [0.1, 0, -1]"})
      compare("loads: [" + on + "patch, " + load + history + "]\n");
    compare(patch + ", {gravity: [0, 0, -1]}]\n", 1e-3);
  }
}

TEST(CharacteristicStatics, PointsThatAreLinkedAndLoadedMoveAsThoseOfTheMesh) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{8, 3, 3}, {1, 0.25, 0.25}}));
  const auto run_as = [&](const std::string& as) {
    const std::string load = "{instance: b, point: tip, history: {time: [0, 1], value: [0, 1]}, ";
    return folder.run(
        "materials: {m: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}\n"
        "components: {bar: {mesh: bar.exo, material: m, points: {root: {surface: x_min}, tip: "
        "{surface: x_max}}, reduction: {basis: characteristic, interface: [x_min, x_max], modes: "
        "10}}}\ninstances: {b: {component: bar, as: " +
        as + "}}\nlinks: [{between: [b.root, ground]}]\nloads: [" + load + "force: [1, 2, 3]}, " +
        load +
        "moment: [0.1, 0.2, 0.3]}]\ntime: {static: true, end: 1, step: 1}\n"
        "output: {history: [b.tip]}\n");
  };
  const Ran mesh = run_as("mesh"), reduced = run_as("superelement");
  const Vector3 start(1, 0.125, 0.125);
  const Vector3 expected = test::at(mesh.monitor("b.tip").mean_position, 1) - start,
                found = test::at(reduced.monitor("b.tip").mean_position, 1) - start;
  EXPECT_GT(expected.norm(), 1e-3);
  EXPECT_LT((found - expected).norm(), 1e-8 * expected.norm());
  // All of the interface is in sets of points: 6 rigid motions, 10 fixed modes, 10 shapes, nine
  // loads on each of two points
  EXPECT_LE(reduced.built.simulation.bodies[0]->n_dofs(), 6 + 10 + 10 + 18);
}

// Nodes that the scene holds or ties have their dofs without being named.
TEST(CharacteristicContact, TiedFacesAndHeldNodesAreKept) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{4, 2, 2}, {1, 0.5, 0.5}}));
  const Ran ran = folder.run(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0, density: 1}}\ncomponents: {bar: "
      "{mesh: bar.exo, "
      "material: m, reduction: {basis: characteristic, characteristic: {modes: 3}, interface: "
      "[x_min, x_max, y_min], modes: "
      "4}}}\ninstances: {a: {component: bar}, b: {component: bar, position: [1, 0, 0]}}\n"
      "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n"
      "loads: [{instance: b, surface: x_max, traction: [1, 0, 0], history: {time: [0, 4], value: "
      "[0, 1]}}]\n"
      "contact: [{between: [a.x_max, b.x_min], tied: true}]\ntime: {end: 4}\noutput: {every: 0.1, "
      "history: [b.x_max]}\n");
  const std::size_t last = ran.result.time.size() - 1;
  EXPECT_NEAR(test::at(ran.monitor("b.x_max").mean_position, last)[0], 2 + 2.0 / 100, 1e-3);
  EXPECT_LT(test::energy_residual(ran.result), 1e-9);
}

}  // namespace
}  // namespace cbr::characteristic_test
