// SPDX-License-Identifier: GPL-3.0-or-later
// What must not change the answer of a scene with contact: numbering, axes, handedness, units,
// uniform motion, how a body came to its place, threads, and the order of names. Random scenes by
// seed: two or three blocks with curved faces that do not match.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>
#include <random>
#include <tuple>

#include "tests/support/contact_scene.hpp"

namespace cbr::contact_invariance_test {
namespace {

using test::BodyPart;
using test::Change;
using test::ContactScene;
using test::Difference;
using test::Ran;

constexpr double allowed = 1e-9;

struct Way {
  const char* name;
  std::string options;  // of the pairs
  bool full1, full2;    // as: mesh
  bool third;           // another block behind the second
  bool ball;            // a rigid ball beside the second
};

ContactScene random_scene(const Way& way, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double s) {
    return Vector3(s * uniform(random), s * uniform(random), s * uniform(random));
  };
  ContactScene scene;
  const auto block = [&](const std::string& name, std::array<Index, 3> n, bool full, double x) {
    BodyPart b;
    const Vector3 wave = vector(2), phase = vector(3);
    b.name = name;
    b.full = full;
    b.mesh = test::block_mesh(
        {n, Vector3(1, 1, 1), [&](const Vector3& p) {
           return Vector3(p + 0.03 * Vector3(std::sin(wave[0] * p[1] + wave[1] * p[2] + phase[0]),
                                             std::sin(wave[1] * p[2] + 2 * p[0] + phase[1]),
                                             std::sin(wave[2] * p[0] + 2 * p[1] + phase[2])));
         }});
    b.rotation =
        Eigen::AngleAxisd(0.1 * uniform(random), vector(1).normalized()).toRotationMatrix();
    b.position = Vector3(x, 0, 0) + vector(0.05);
    b.density = 1 + 0.3 * uniform(random);
    b.youngs_modulus = 100 * (1 + 0.3 * uniform(random));
    scene.bodies.push_back(b);
  };
  block("a", {3, 3, 4}, way.full1, 0);
  block("b", {3, 2, 3}, way.full2, 1.15);
  scene.bodies[0].velocity = Vector3(0.3, 0.05, -0.04) + vector(0.02);
  scene.pairs = {"{between: [a.x_max, b.x_min]" + way.options + "}"};
  scene.history = {"a.x_max", "b.x_min"};
  if (way.third) {
    block("c", {2, 3, 3}, way.full1, 2.25);
    scene.bodies[2].velocity = Vector3(-0.2, 0.02, 0.03);
    scene.pairs.push_back("{between: [b.x_max, c.x_min]" + way.options + "}");
    scene.history.push_back("c.x_min");
  }
  if (way.ball) {
    scene.walls = {{"ball", Vector3(3.3, 0.5, 0.5), 1}};
    scene.pairs.push_back("{between: [b.x_max, ball]" + way.options + "}");
  }
  scene.step = 0.008;
  scene.every = 0.04;
  scene.end = 1.2;
  return scene;
}

const std::vector<Way>& ways() {
  static const std::vector<Way> list = {
      {"impulse", "", true, true, false, false},
      {"impulse, superelements", "", false, false, true, false},
      {"impulse, friction", ", friction: 0.3", false, true, true, true},
      {"mortar", ", formulation: mortar", true, false, true, false},
      {"mortar, friction", ", formulation: mortar, friction: 0.3", false, false, false, false},
      {"penalty", ", enforcement: penalty, damping: 0.1", true, true, false, true},
      {"two-way penalty, friction", ", enforcement: penalty, formulation: two-way, friction: 0.2",
       false, true, true, false}};
  return list;
}

void expect_same(const char* what, const Way& way, unsigned seed, const Ran& plain,
                 const Ran& other, const Change& change) {
  const Difference d = test::difference(plain, other, change);
  std::printf(
      "%-22s %-26s seed %u: positions %.1e momenta %.1e angular %.1e forces %.1e energies %.1e "
      "pairs %.1e\n",
      what, way.name, seed, d.positions, d.momenta, d.angular, d.forces, d.energies, d.pairs);
  EXPECT_LT(d.largest(), allowed) << what << ", " << way.name << ", seed " << seed;
}

class RandomScenes : public testing::TestWithParam<std::size_t> {};

TEST_P(RandomScenes, DoNotDependOnHowTheyAreToldOf) {
  const Way& way = ways()[GetParam()];
  for (const unsigned seed : {1u, 2u}) {
    const ContactScene scene = random_scene(way, seed);
    const Ran plain = run(scene);
    EXPECT_LT(test::energy_residual(plain.result), 1e-10);
    // they do meet
    EXPECT_GT(test::integral(plain.result, plain.monitor("b.x_min").force).norm(), 0.02)
        << way.name;

    ContactScene numbered = scene;
    for (BodyPart& b : numbered.bodies) b.mesh = test::renumbered(b.mesh, seed + 17);
    expect_same("renumbered", way, seed, plain, run(numbered), {});

    const Matrix3 R =
        Eigen::AngleAxisd(2.1 + seed, Vector3(1, -2, 0.7).normalized()).toRotationMatrix();
    const Change turned{R, Vector3(3, -2, 5)};
    expect_same("turned", way, seed, plain, run(scene, turned), turned);

    const Change mirrored{R * Vector3(1, 1, -1).asDiagonal()};
    expect_same("mirrored", way, seed, plain, run(scene, mirrored), mirrored);

    Change moving;
    moving.boost = Vector3(2, -1, 3);
    if (!way.ball) expect_same("moving", way, seed, plain, run(scene, moving), moving);

    Change tonnes;
    tonnes.length = 1e3;
    tonnes.mass = 1e-3;
    expect_same("millimetres and tonnes", way, seed, plain, run(scene, tonnes), tonnes);
    Change scaled;
    scaled.length = 1e6;
    scaled.mass = 1e6;
    scaled.time = 1e-6;
    expect_same("scaled by 1e6", way, seed, plain, run(scene, scaled), scaled);

    ContactScene in_place = scene;
    in_place.in_place = true;
    expect_same("meshed in place", way, seed, plain, run(in_place), {});
  }
}

INSTANTIATE_TEST_SUITE_P(Invariance, RandomScenes, testing::Range<std::size_t>(0, 7));

TEST(Invariance, OfTheNumberOfThreads) {
  ContactScene scene = random_scene(ways()[0], 3);
  // threads take part from some thousand nodes
  scene.bodies[0].mesh = test::block_mesh({{12, 13, 13}});
  scene.step = 0.0015;
  scene.every = 0.015;
  scene.end = 0.6;
  const Ran one = run(scene);
  EXPECT_GT(test::integral(one.result, one.monitor("b.x_min").force).norm(), 0.003);
  scene.threads = 2;
  expect_same("two threads", ways()[0], 3, one, run(scene), {});
}

TEST(Invariance, OfTheOrderOfInstances) {
  for (const std::size_t i : {1, 4}) {
    const ContactScene scene = random_scene(ways()[i], 4);
    ContactScene reversed = scene;
    std::reverse(reversed.bodies.begin(), reversed.bodies.end());
    expect_same("instances reversed", ways()[i], 4, run(scene), run(reversed), {});
  }
}

TEST(Invariance, OfTheOrderOfTheSurfacesOfTwoWayContact) {
  const Way two_way{
      "two-way penalty", ", enforcement: penalty, formulation: two-way", true, false, false, false};
  ContactScene scene = random_scene(two_way, 5);
  // of equal sizes the first named is the slave
  for (BodyPart& b : scene.bodies) b.mesh = test::block_mesh({{3, 3, 4}});
  const Ran plain = run(scene);
  scene.pairs = {"{between: [b.x_min, a.x_max]" + two_way.options + "}"};
  expect_same("swapped", two_way, 5, plain, run(scene), {});
}

// Two equal blocks, each the other's mirror image: it cannot matter which one's nodes are held by
// the other's faces. But where a spring gives way the bulging faces do not fall together, and which
// one gives the normal does matter, by what they lean.
TEST(Invariance, OfWhichOfTwoEqualBodiesIsNamedFirst) {
  for (const auto& [name, options, tolerance] :
       {std::tuple{"impulse", "", allowed}, std::tuple{"friction", ", friction: 0.3", allowed},
        std::tuple{"mortar", ", formulation: mortar", allowed},
        std::tuple{"penalty", ", enforcement: penalty", 0.05}}) {
    const Way way{name, options, true, true, false, false};
    ContactScene scene = random_scene(way, 6);
    for (BodyPart& b : scene.bodies) {
      b.mesh = test::block_mesh({{3, 3, 3}});
      b.youngs_modulus = 100;
      b.density = 1;
    }
    scene.bodies[0].rotation.setIdentity();
    scene.bodies[0].position.setZero();
    scene.bodies[1].rotation = Vector3(-1, -1, 1).asDiagonal();
    scene.bodies[1].position = Vector3(2.01, 1, 0);
    scene.bodies[0].velocity = Vector3(0.1, 0, 0);
    scene.bodies[1].velocity = Vector3(-0.1, 0, 0);
    scene.pairs = {std::string("{between: [a.x_max, b.x_max]") + options + "}"};
    scene.history = {"a.x_max", "b.x_max"};
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
