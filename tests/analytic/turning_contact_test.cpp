// SPDX-License-Identifier: GPL-3.0-or-later
// Superelements that turn by any angle and touch. Each impulse turns a body by its moment about the
// moving centre of mass, so that two bodies keep their angular momentum to rounding; a plane wall
// without friction leaves that about its normal.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/contact_scene.hpp"
#include "tests/support/restarted_run.hpp"

namespace cbr::turning_contact_test {
namespace {

using Eigen::AngleAxisd;
using test::at;
using test::BodyPart;
using test::ContactScene;
using test::largest_change;
using test::Ran;
using test::total;

// Largest angle of a body since the start, rad.
double largest_turn(const RunResult::OfBody& body) {
  double most = 0;
  for (std::size_t i = 0; 4 * i < body.orientation.size(); ++i)
    most = std::max(most, 2 * std::acos(std::min(1.0, std::abs(body.orientation[4 * i]))));
  return most;
}

const std::vector<std::string> all_faces{"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};

// The same blocks as superelements of a basis.
ContactScene tumbling(const std::string& options, double speed,
                      const std::string& basis = "craig-bampton") {
  ContactScene scene = test::tumbling_blocks(options, speed);
  const bool massless = basis == "massless";  // needs an interior that is softer than its interface
  for (BodyPart& b : scene.bodies) {
    b.full = false;
    b.basis = basis;
    b.modes = massless ? 8 : 3;
    if (!massless) b.interface_sets = all_faces;
  }
  if (massless) {
    scene.bodies[0].mesh = test::block_mesh({{4, 2, 2}});
    scene.step = 0.00125;
    scene.end = 0.6;
  }
  return scene;
}

// They turn by a radian and more, hit each other, and go on.
TEST(TurningContact, TwoBodiesKeepTheirMomenta) {
  for (const std::string basis : {"craig-bampton", "massless"}) {
    for (const std::string options :
         {"", ", friction: 0.3", ", formulation: mortar", ", formulation: mortar, friction: 0.3"}) {
      if (basis == "massless" && options != ", friction: 0.3") continue;
      const Ran ran = run(tumbling(options, 0.8, basis));
      const RunResult& r = ran.result;
      const double pushed =
          (at(r.bodies[1].momentum, r.time.size() - 1) - at(r.bodies[1].momentum, 0)).norm();
      const double scale = total(r, &RunResult::OfBody::angular_momentum, 0).norm();
      const double momentum = largest_change(r, &RunResult::OfBody::momentum) / pushed;
      const double angular = largest_change(r, &RunResult::OfBody::angular_momentum) / scale;
      const double gained = *std::max_element(r.total.begin(), r.total.end()) / r.total[0] - 1;
      std::printf(
          "%-14s%-36s momentum %.0e, angular %.0e, balance %.0e, gained %.1e, left %.3f, turned "
          "%.2f %.2f\n",
          basis.c_str(), options.c_str(), momentum, angular, test::energy_residual(r), gained,
          r.total.back() / r.total[0], largest_turn(r.bodies[0]), largest_turn(r.bodies[1]));
      EXPECT_GT(pushed, 0.1) << options;
      EXPECT_GT(largest_turn(r.bodies[0]), 0.8) << options;
      EXPECT_LT(momentum, 1e-13) << options;
      // massless: of first order in the step
      EXPECT_LT(angular, basis == "massless" ? 3e-3 : 5e-15) << options;
      EXPECT_LT(test::energy_residual(r), 1e-14) << options;
      EXPECT_LT(gained, 1e-9) << options;
    }
  }
}

// Placed anywhere, turned in any way or mirrored, the same happens.
TEST(TurningContact, ARotationOfTheSceneChangesNothing) {
  for (const std::string options : {", friction: 0.3", ", formulation: mortar, friction: 0.3"}) {
    ContactScene scene = tumbling(options, 0.8);
    scene.end = 0.6;
    EXPECT_LT(test::change_of_a_turned_scene(scene), 8e-13) << options;
  }
}

TEST(TurningContact, SmallRotationsAreThoseOfLinearBodies) {
  EXPECT_GT(test::order_of_small_rotations(
                [](double speed) { return tumbling(", friction: 0.3", speed); }),
            1.9);
}

// A block of 1 x 0.8 x 0.6 that touches the plane z = 0 by a corner, falls, slides and spins.
struct Corner {
  Matrix3 R = AngleAxisd(0.7, Vector3(0.6, -0.7, 0.2).normalized()).toRotationMatrix();
  Vector3 size{1, 0.8, 0.6}, at, arm;  // the instance's place; from the centre to the corner

  Corner() {
    const Vector3 centre = R * size / 2;
    for (int i = 0; i < 8; ++i) {
      const Vector3 x = R * Vector3(i & 1 ? size[0] : 0, i & 2 ? size[1] : 0, i & 4 ? size[2] : 0);
      if (i == 0 || x.z() < at.z()) {
        at = x;
        arm = x - centre;
      }
    }
    at = Vector3(0, 0, -at.z());
  }

  std::string scene(double youngs_modulus, const std::string& contact,
                    const std::string& time) const {
    return "materials: {m: {youngs_modulus: " + test::text(youngs_modulus) +
           ", poissons_ratio: 0.3, density: 1}}\ncomponents: {block: {mesh: block.exo, material: "
           "m, reduction: {interface: [x_min, "
           "x_max], modes: 4}}}\nwalls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, "
           "1]}}}\ninstances: {b: {component: block, "
           "rotation: " +
           test::text(test::degrees(R)) + ", position: " + test::text(at) +
           ", velocity: [1.5, 0.5, -0.5], angular_velocity: [0.5, -0.3, 1]}}\ncontact: [{between: "
           "all" +
           contact + "}]\ntime: " + time + "\noutput: {every: 0.001, history: [b.x_min]}\n";
  }
};

Vector3 spin_of(const RunResult::OfBody& body, std::size_t k) {
  return at(body.angular_momentum, k) -
         at(body.center_of_mass, k).cross(Vector3(at(body.momentum, k)));
}

// The limit of a rigid body: one impulse P at the corner, L changes by r x P, and friction is mu
// times what is normal. A stiff block comes closer to it as its contact lasts shorter, with 1 /
// sqrt(E).
TEST(TurningContact, TheFirstBlowOfAStiffBlockIsThatOfARigidOne) {
  const Corner corner;
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{3, 2, 2}, corner.size}));
  for (const double mu : {0.0, 0.3}) {
    std::vector<double> softness, errors;
    for (const double E : {1e4, 1e5, 1e6}) {
      const std::string time = "{end: " + test::text(30 / std::sqrt(E)) + ", rotations: large}";
      const Ran ran = folder.run(corner.scene(E, mu > 0 ? ", friction: 0.3" : "", time));
      const RunResult::OfBody& body = ran.body("b");
      const std::size_t last = ran.result.time.size() - 1;
      const Vector3 P = at(body.momentum, last) - at(body.momentum, 0),
                    moment = corner.arm.cross(P);
      const Vector3 L = spin_of(body, last) - spin_of(body, 0);
      softness.push_back(1 / std::sqrt(E));
      errors.push_back((L - moment).norm() / moment.norm());
      const double tangential = P.head<2>().norm() / P.z();
      std::printf(
          "mu %.1f E %.0e: L off by %.2e, friction %.4f of the normal impulse, energy %.4f\n", mu,
          E, errors.back(), tangential, ran.result.total.back() / ran.result.total[0]);
      EXPECT_GT(P.z(), 0.1);
      EXPECT_NEAR(tangential, mu, 5e-3 * mu + 1e-12);
      EXPECT_LT(test::energy_residual(ran.result), 1e-13);
      EXPECT_EQ(ran.result.active.back(), 0);
    }
    EXPECT_LT(errors.back(), 0.02);
    EXPECT_GT(test::observed_order(softness, errors), 0.8);
  }
}

// It tumbles on until it lies on the floor's side: the floor turns it about no vertical axis
// without friction.
TEST(TurningContact, AFloorWithoutFrictionLeavesTheSpinAboutItsNormal) {
  const Corner corner;
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{3, 2, 2}, corner.size}));
  const Ran ran = folder.run(corner.scene(1e5, "", "{end: 1, rotations: large}") +
                             "loads: [{gravity: [0, 0, -5]}]\n");
  const RunResult& r = ran.result;
  double change = 0, most = 0;
  for (std::size_t k = 0; k < r.time.size(); ++k) {
    change = std::max(change, std::abs((spin_of(r.bodies[0], k) - spin_of(r.bodies[0], 0)).z()));
    // While it touches, energies at the ends of steps have what its impulses bring at the starts of
    // the next ones
    if (r.active[k] == 0) most = std::max(most, (r.total[k] - r.work_external[k]) / r.total[0] - 1);
  }
  std::printf("turned %.2f, spin about the normal off by %.0e, gained %.1e\n",
              largest_turn(r.bodies[0]), change, most);
  EXPECT_GT(largest_turn(r.bodies[0]), 0.8);
  EXPECT_LT(change, 1e-13);
  EXPECT_LT(most, 1e-9);
}

// In contact, half of the way, from a checkpoint: the same bits.
TEST(TurningContact, ARestartGoesOnBitForBit) {
  const Corner corner;
  test::SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{3, 2, 2}, corner.size}));
  const std::string yaml = corner.scene(1e4, ", friction: 0.3", "{end: 0.1, rotations: large}");
  test::expect_same_bits(test::restarted(folder, yaml, 0.012));
}

// What turns hits what does not, a superelement that is held: it stays linear, and that is said. It
// hits a mesh, which turns too.
TEST(TurningContact, MeshesAndHeldSuperelementsAreHit) {
  for (const bool full : {true, false}) {
    ContactScene scene = tumbling(", friction: 0.3", 0.8);
    scene.bodies[1].full = full;
    scene.bodies[1].angular_velocity.setZero();
    test::SceneFolder folder;
    for (const BodyPart& b : scene.bodies) folder.add(b.name + ".exo", b.mesh);
    const std::string held =
        full ? "" : "boundary: [{instance: b, nodes: x_max, fix: [x, y, z]}]\n";
    const Ran ran = folder.run(test::yaml(scene, {}) + held);
    EXPECT_GT(ran.body("a").orientation.size(), 0u);
    EXPECT_GT(
        (at(ran.body("a").momentum, ran.result.time.size() - 1) - at(ran.body("a").momentum, 0))
            .norm(),
        0.1);
    EXPECT_LT(test::energy_residual(ran.result), 1e-13);
    EXPECT_LT(*std::max_element(ran.result.total.begin(), ran.result.total.end()),
              (1 + (full ? 1e-4 : 1e-9)) * ran.result.total[0]);
    if (full) {
      EXPECT_GT(largest_turn(ran.body("b")), 0.05);
      const double angular = largest_change(ran.result, &RunResult::OfBody::angular_momentum) /
                             total(ran.result, &RunResult::OfBody::angular_momentum, 0).norm();
      std::printf("superelement and mesh: angular momentum %.0e\n", angular);
      EXPECT_LT(angular, 1e-13);
      continue;
    }
    EXPECT_EQ(ran.body("b").orientation.size(), 0u);
    const auto& notes = ran.built.notes;
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("linear as ever: b") != std::string::npos;
    }));
  }
}

}  // namespace
}  // namespace cbr::turning_contact_test
