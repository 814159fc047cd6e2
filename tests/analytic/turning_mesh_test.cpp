// SPDX-License-Identifier: GPL-3.0-or-later
// Full meshes that turn by any angle: what they keep, the order of their steps, and superelements
// and linear meshes beside them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/contact_scene.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"

namespace cbr::turning_mesh_test {
namespace {

using Eigen::Quaterniond;
using test::at;
using test::ContactScene;
using test::largest_change;
using test::Ran;
using test::SceneFolder;
using test::text;
using test::total;
using test::tumbling_blocks;

// A block of 0.4 x 0.1 x 0.1 whose waves go at about 22, so a step above 1.6e-3 is unstable.
const Vector3 spin(3, -5, 8);

struct FolderWithBlock : SceneFolder {
  FolderWithBlock() { add("block.exo", test::block_mesh({{4, 2, 2}, Vector3(0.4, 0.1, 0.1)})); }
};

std::string scene(const std::string& time, const std::string& instance = "as: mesh",
                  const std::string& more = "", const std::string& component = "") {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
         "components: {block: {mesh: block.exo, material: m, reduction: {interface: [x_min, "
         "x_max], modes: 8}" +
         component +
         "}}\ninstances: {b: {component: block, velocity: [1, 2, 3], angular_velocity: " +
         text(spin) + ", " + instance + "}}\n" + more + "time: " + time +
         "\noutput: {every: 0.02, history: [b.x_max], fields: [displacement]}\n";
}

std::string steps_of(double h) { return "{end: 1, step: " + text(h) + ", rotations: large}"; }

Quaterniond turn_of(const RunResult::OfBody& body, std::size_t i) {
  const double* q = body.orientation.data() + 4 * i;
  return {q[0], q[1], q[2], q[3]};
}

// The largest angle between the orientations of two runs, rad.
double apart(const RunResult::OfBody& first, const RunResult::OfBody& second) {
  double most = 0;
  for (std::size_t i = 0; 4 * i < first.orientation.size(); ++i)
    most = std::max(most, turn_of(first, i).angularDistance(turn_of(second, i)));
  return most;
}

// From the first output, as a share of what is there.
double drift(const Series3& series) {
  double most = 0;
  for (std::size_t i = 0; 3 * i < series.values.size(); ++i)
    most = std::max(most, (at(series, i) - at(series, 0)).norm());
  return most / at(series, 0).norm();
}

// Of kinetic and strain energy themselves: the balance books what is left of it.
double energy_swing(const RunResult& result) {
  double most = 0;
  for (const double energy : result.total)
    most = std::max(most, std::abs(energy / result.total[0] - 1));
  return most;
}

TEST(TurningMesh, AFreeOneKeepsItsMomentaAndStepsAreOfSecondOrder) {
  for (const std::string component : {"", ", mass: consistent"}) {
    FolderWithBlock folder;
    std::vector<double> steps, swings;
    std::vector<RunResult::OfBody> bodies;
    for (const double h : {4e-4, 2e-4, 1e-4}) {
      const Ran ran = folder.run(scene(steps_of(h), "as: mesh", "", component));
      const RunResult::OfBody& body = ran.body("b");
      const double momentum = drift(body.momentum), angular = drift(body.angular_momentum);
      steps.push_back(h);
      swings.push_back(energy_swing(ran.result));
      bodies.push_back(body);
      std::printf("step %.0e: momentum %.0e, angular %.0e, energy %.2e\n", h, momentum, angular,
                  swings.back());
      EXPECT_LT(momentum, 1e-14);
      EXPECT_LT(angular, 2e-13);
      EXPECT_EQ(ran.result.largest_rotation, 0);  // nothing to warn of
    }
    const double first = apart(bodies[0], bodies[1]), second = apart(bodies[1], bodies[2]);
    std::printf("orientation changes by %.2e and %.2e\n", first, second);
    EXPECT_NEAR(std::log2(first / second), 2, 0.1);
    EXPECT_NEAR(test::observed_order(steps, swings), 2, 0.1);
    EXPECT_LT(swings[2], 8e-7);
  }
}

TEST(TurningMesh, TwoThatHitEachOtherKeepTheirMomenta) {
  for (const std::string options :
       {"", ", friction: 0.3", ", formulation: mortar", ", formulation: mortar, friction: 0.3"}) {
    const Ran ran = run(tumbling_blocks(options, 0.8));
    const RunResult& r = ran.result;
    const double pushed =
        (at(r.bodies[1].momentum, r.time.size() - 1) - at(r.bodies[1].momentum, 0)).norm();
    const double scale = total(r, &RunResult::OfBody::angular_momentum, 0).norm();
    const double momentum = largest_change(r, &RunResult::OfBody::momentum) / pushed;
    const double angular = largest_change(r, &RunResult::OfBody::angular_momentum) / scale;
    double numerical = 0;
    for (const double work : r.work_numerical) numerical = std::max(numerical, std::abs(work));
    std::printf("%-36s momentum %.0e, angular %.0e, numerical work %.1e, left %.3f\n",
                options.c_str(), momentum, angular, numerical / r.total[0],
                r.total.back() / r.total[0]);
    EXPECT_GT(pushed, 0.1) << options;
    EXPECT_LT(momentum, 1e-14) << options;
    EXPECT_LT(angular, 1e-14) << options;
    EXPECT_LT(numerical, 1e-3 * r.total[0]) << options;
  }
}

// Works of contact, friction and loads tell where the energy went, all but the square of the step.
TEST(TurningMesh, NumericalWorkIsOfSecondOrderWithLoadsAndDamping) {
  FolderWithBlock folder;
  const std::string more =
      "loads: [{gravity: [0, 0, -9.81]}, {instance: b, surface: x_max, force: [0.02, 0.01, 0], "
      "follow: true}, {instance: b, surface: x_min, force: [0, 0.02, 0.03], follow: false}]\n";
  for (const bool is_damped : {false, true}) {
    std::vector<double> steps, numerical;
    for (const double h : {4e-4, 2e-4, 1e-4}) {
      std::string yaml = scene(steps_of(h), "as: mesh", is_damped ? "" : more);
      if (is_damped) yaml.replace(yaml.find("density: 2"), 10, "density: 2, damping: {beta: 1e-4}");
      const Ran ran = folder.run(yaml);
      double most = 0;
      for (const double work : ran.result.work_numerical) most = std::max(most, std::abs(work));
      steps.push_back(h);
      numerical.push_back(most / ran.result.total[0]);
      const double damping = ran.result.work_damping.back() / ran.result.total[0];
      std::printf("step %.0e: %.2e, external %.2e, damping %.2e\n", h, numerical.back(),
                  ran.result.work_external.back() / ran.result.total[0], damping);
      if (!is_damped) continue;
      EXPECT_LT(drift(ran.body("b").angular_momentum), 1e-12);  // damping does not brake the spin
      EXPECT_LT(damping, -1e-5);
    }
    EXPECT_NEAR(test::observed_order(steps, numerical), 2, 0.2);
    EXPECT_LT(numerical.back(), 1e-5);
  }
}

TEST(TurningMesh, ARotationOfTheSceneChangesNothing) {
  ContactScene scene = tumbling_blocks(", friction: 0.3", 0.8);
  scene.end = 0.6;
  EXPECT_LT(test::change_of_a_turned_scene(scene), 1.4e-12);
}

TEST(TurningMesh, SmallRotationsAreThoseOfLinearMeshes) {
  EXPECT_GT(test::order_of_small_rotations(
                [](double speed) { return tumbling_blocks(", friction: 0.3", speed); }),
            1.9);
}

struct Apart {
  double orientation, face;  // rad, m
};

// What a superelement of all modes and its mesh are apart at the end, at this share of the spin.
Apart mesh_and_superelement(const FolderWithBlock& folder, double share, double end) {
  std::vector<Quaterniond> ends;
  std::vector<Vector3> places;
  for (const std::string as : {"as: mesh", "as: superelement"}) {
    std::string yaml =
        scene("{end: " + text(end) + ", step: 2e-4, rotations: large}", as, "", ", mass: lumped");
    yaml.replace(yaml.find(text(spin)), text(spin).size(), text(share * spin));
    yaml.replace(yaml.find("modes: 8"), 8, "modes: 81");
    const Ran ran = folder.run(yaml);
    const auto last = ran.result.time.size() - 1;
    ends.push_back(turn_of(ran.body("b"), last));
    places.push_back(at(ran.monitor("b.x_max").mean_position, last));
  }
  const Apart apart{ends[0].angularDistance(ends[1]), (places[0] - places[1]).norm()};
  std::printf("spin %.2f: turned by %.2f, orientation apart %.1e, face %.1e\n", share * spin.norm(),
              share * end * spin.norm(), apart.orientation, apart.face);
  return apart;
}

// The superelement has Coriolis's forces of its lowest modes, and leaves out what the spin does to
// what is deformed: per turn a share of the square of the spin. Both take the same way here.
TEST(TurningMesh, ASuperelementOfAllModesTurnsAlike) {
  FolderWithBlock folder;
  const std::vector<double> spins{0.25, 0.5, 1};
  std::vector<double> apart;
  for (const double share : spins)
    apart.push_back(mesh_and_superelement(folder, share, 0.5 / share).orientation);
  EXPECT_GT(test::observed_order(spins, apart), 1.9);
  EXPECT_LT(apart[0], 6e-6);
}

TEST(TurningMesh, ASuperelementOfAllModesTurnsAlikeTenTimes) {
  FolderWithBlock folder;
  const double share = 0.125, ten_turns = 20 * std::numbers::pi / (share * spin.norm());
  const Apart apart = mesh_and_superelement(folder, share, ten_turns);
  EXPECT_LT(apart.orientation, 1e-6);
  // The face has the phase of its vibration too, of which half the step leaves a third
  EXPECT_LT(apart.face, 1e-5);
}

// Impulses and moments on a body that has turned far, about the scene's origin.
TEST(TurningMesh, ImpulsesTurnItByTheirMoments) {
  FolderWithBlock folder;
  Ran ran = folder.prepare(scene(steps_of(4e-4), "as: mesh, mirror: y, rotation: [30, 40, -20]"));
  Body& body = *ran.built.simulation.bodies[0];
  const Index set = body.track({0, 7, 20});
  double t = 0, most = 0;
  Vector3 L = body.state().angular_momentum, p = body.state().momentum;
  for (int i = 0; i < 1000; ++i) {
    constexpr double h = 4e-4;
    body.predict(t, h);
    if (i % 50 == 7) {
      Points x, impulses(3, 3);
      body.positions(set, x);
      for (Index k = 0; k < 9; ++k)
        impulses.data()[k] = 1e-4 * std::sin(i + 2.5 * static_cast<double>(k));
      const Vector3 moment(1e-5, 2e-5, -1e-5);
      body.add_impulses(set, impulses);
      body.add_moment(moment);
      for (Index k = 0; k < 3; ++k) {
        L += Vector3(x.row(k)).cross(Vector3(impulses.row(k)));
        p += impulses.row(k).transpose();
      }
      L += moment;
    }
    body.accept();
    t += h;
    most = std::max({most, (body.state().angular_momentum - L).norm() / L.norm(),
                     (body.state().momentum - p).norm() / p.norm()});
  }
  const BodyWork work = body.work();
  const BodyState state = body.state();
  const double energy = state.kinetic_energy + state.strain_energy;
  std::printf("momenta off by %.0e, work of contact %.2e, numerical %.1e\n", most,
              work.contact / energy, work.numerical / energy);
  EXPECT_LT(most, 1e-13);
  EXPECT_GT(std::abs(work.contact), 1e-3 * energy);
  EXPECT_LT(std::abs(work.numerical), 2e-5 * energy);
}

// A wall without friction leaves the angular momentum about its normal, however the block spins.
TEST(TurningMesh, AWallLeavesTheSpinAboutItsNormal) {
  FolderWithBlock folder;
  std::string yaml = scene("{end: 0.15, step: 4e-4, rotations: large}",
                           "as: mesh, rotation: [30, 40, -20], position: [0, 0, 0.35]",
                           "walls: {w: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\ncontact: "
                           "[{between: all}]\n");
  yaml.replace(yaml.find("[1, 2, 3]"), 9, "[1, 0.5, -6]");
  const Ran ran = folder.run(yaml);
  const RunResult::OfBody& body = ran.body("b");
  const auto last = ran.result.time.size() - 1;
  const Vector3 spun = at(body.angular_momentum, last) - at(body.angular_momentum, 0);
  const Vector3 pushed = at(body.momentum, last) - at(body.momentum, 0);
  std::printf("pushed %.3f, spun %.3f, about the normal %.1e, turned by %.2f\n", pushed.norm(),
              spun.norm(), spun.z(), turn_of(body, 0).angularDistance(turn_of(body, last)));
  EXPECT_GT(pushed.z(), 0.01);
  EXPECT_GT(spun.head<2>().norm(), 1e-3);
  EXPECT_LT(std::abs(spun.z()), 1e-14);
  EXPECT_LT(pushed.head<2>().norm(), 1e-14);
}

TEST(TurningMesh, ARestartGoesOnBitForBit) {
  FolderWithBlock folder;
  const std::string yaml = scene(
      "{end: 0.2, step: 4e-4, rotations: large}", "as: mesh, position: [0, 0, 0.1]",
      "walls: {w: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\ncontact: [{between: all, "
      "friction: 0.3}]\nloads: [{gravity: [0, 0, -60]}, {instance: b, surface: x_max, force: [0, "
      "0.02, 0], follow: true}]\n");
  test::expect_same_bits(test::restarted(folder, yaml, 0.095));
}

TEST(TurningMesh, WhatDoesNotTurnIsRefusedByName) {
  FolderWithBlock folder;
  const auto expect = [&](const std::string& yaml, const std::string& part) {
    const std::string said = test::refusal_of([&] { (void)folder.prepare(yaml); });
    EXPECT_SAYS(said, part);
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  };
  const std::string wall = "walls: {w: {plane: {point: [-1, 0, 0], normal: [1, 0, 0]}}}\n";
  for (const std::string enforcement : {"penalty", "nodal"})
    expect(scene(steps_of(1e-3), "as: mesh",
                 wall + "contact: [{between: [b.x_min, w], enforcement: " + enforcement + "}]\n"),
           "does not go with enforcement: " + enforcement);
  // A second block that no element joins to the first
  Mesh two = test::block_mesh({{1, 1, 1}, Vector3(0.1, 0.1, 0.1)});
  const Index n = two.coordinates.rows();
  Block& block = two.blocks[0];
  two.coordinates.conservativeResize(2 * n, 3);
  two.coordinates.bottomRows(n) =
      two.coordinates.topRows(n).rowwise() + Eigen::RowVector3d(1, 0, 0);
  for (Index i = 0; i < n; ++i) two.node_ids.push_back(two.node_ids[i] + n);
  block.connectivity.conservativeResize(2, 8);
  block.connectivity.row(1) = block.connectivity.row(0).array() + n;
  block.element_ids.push_back(block.element_ids[0] + 1);
  SceneFolder other;
  other.add("block.exo", two);
  EXPECT_SAYS(test::refusal_of([&] { (void)other.prepare(scene(steps_of(1e-3))); }),
              "(time.rotations: large) does not go with several parts (found 2)");
  std::string damped = scene(steps_of(1e-3));
  damped.replace(damped.find("density: 2"), 10, "density: 2, damping: {alpha: 1, beta: 0}");
  expect(damped, "does not go with mass-proportional damping (alpha)");
}

}  // namespace
}  // namespace cbr::turning_mesh_test
