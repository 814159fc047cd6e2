// SPDX-License-Identifier: GPL-3.0-or-later
// What must not change the answer of a scene with contact, and small random scenes cannot show
// (tests/stability/invariance_test.cpp): threads that share the work of one body, and which of two
// equal bodies is named first.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "tests/support/contact_scene.hpp"

namespace cbr::contact_invariance_test {
namespace {

using test::BodyPart;
using test::ContactScene;
using test::Difference;
using test::Ran;

constexpr double allowed = 1e-9;

// The first flies into the second.
ContactScene two_blocks(const Mesh& first, const Mesh& second) {
  ContactScene scene;
  for (const char* name : {"a", "b"}) {
    BodyPart b;
    b.name = name;
    b.mesh = scene.bodies.empty() ? first : second;
    scene.bodies.push_back(b);
  }
  scene.end = 1.2;
  return scene;
}

TEST(Invariance, OfTheNumberOfThreads) {
  // Threads take part from some thousand nodes
  ContactScene scene = two_blocks(test::block_mesh({{12, 13, 13}}), test::block_mesh({{3, 2, 3}}));
  scene.bodies[0].velocity = Vector3(0.3, 0.05, -0.04);
  scene.bodies[1].position = Vector3(1.04, 0.03, -0.02);
  scene.pairs = {"{between: [a.x_max, b.x_min]}"};
  scene.history = {"a.x_max", "b.x_min"};
  scene.step = 0.0015;
  scene.every = 0.015;
  scene.end = 0.6;
  const Ran one = run(scene);
  EXPECT_GT(test::integral(one.result, one.monitor("b.x_min").force).norm(), 0.003);
  scene.threads = 2;
  EXPECT_LT(test::difference(one, run(scene), {}).largest(), allowed);
}

// Two equal blocks, each the other's mirror image: it cannot matter which one's nodes are held by
// the other's faces. But where a spring gives way the bulging faces do not fall together, and which
// one gives the normal does matter, by what they lean.
TEST(Invariance, OfWhichOfTwoEqualBodiesIsNamedFirst) {
  const Mesh block = test::block_mesh({{3, 3, 3}});
  for (const auto& [name, options, tolerance] :
       {std::tuple{"impulse", "", allowed}, std::tuple{"friction", ", friction: 0.3", allowed},
        std::tuple{"mortar", ", formulation: mortar", allowed},
        std::tuple{"penalty", ", enforcement: penalty", 0.05},
        std::tuple{"two-way", ", enforcement: penalty, formulation: two-way", allowed}}) {
    ContactScene scene = two_blocks(block, block);
    scene.bodies[1].rotation = Vector3(-1, -1, 1).asDiagonal();
    scene.bodies[1].position = Vector3(2.01, 1, 0);
    scene.bodies[0].velocity = Vector3(0.1, 0, 0);
    scene.bodies[1].velocity = Vector3(-0.1, 0, 0);
    scene.pairs = {std::string("{between: [a.x_max, b.x_max]") + options + "}"};
    scene.history = {"a.x_max", "b.x_max"};
    scene.step = 0.008;
    scene.every = 0.04;
    const Ran plain = run(scene);
    scene.pairs = {std::string("{between: [b.x_max, a.x_max]") + options + "}"};
    const Difference d = test::difference(plain, run(scene), {});  // nothing turns
    std::printf("named second, %s: positions %.1e momenta %.1e forces %.1e energies %.1e\n", name,
                d.positions, d.momenta, d.forces, d.energies);
    EXPECT_LT(std::max({d.positions, d.momenta, d.forces, d.energies}), tolerance) << name;
  }
}

}  // namespace
}  // namespace cbr::contact_invariance_test
