// SPDX-License-Identifier: GPL-3.0-or-later
// Full meshes that turn by any angle: what they keep, the order of their steps, and superelements
// and linear meshes beside them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/contact_scene.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"

namespace cbr::turning_mesh_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using test::at;
using test::BodyPart;
using test::Change;
using test::ContactScene;
using test::Ran;
using test::SceneFolder;
using test::text;

// A block of 0.4 x 0.1 x 0.1 whose waves go at about 22, so a step above 1.6e-3 is unstable.
const Vector3 spin(3, -5, 8);

struct FolderWithBlock : SceneFolder {
  FolderWithBlock() { add("block.exo", test::block_mesh({{4, 2, 2}, Vector3(0.4, 0.1, 0.1)})); }
};

std::string scene(const std::string& time, const std::string& instance = "as: mesh",
                  const std::string& more = "", const std::string& component = "") {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
         "components: {block: {mesh: block.exo, material: m, reduction: {interface: [x_min, "
         "x_max], "
         "modes: 8}" +
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
    std::vector<Quaterniond> ends;
    for (const double h : {4e-4, 2e-4, 1e-4}) {
      const Ran ran = folder.run(scene(steps_of(h), "as: mesh", "", component));
      const RunResult::OfBody& body = ran.body("b");
      const double momentum = drift(body.momentum), angular = drift(body.angular_momentum);
      steps.push_back(h), swings.push_back(energy_swing(ran.result));
      ends.push_back(turn_of(body, ran.result.time.size() - 1));
      std::printf("step %.0e: momentum %.0e, angular %.0e, energy %.2e\n", h, momentum, angular,
                  swings.back());
      EXPECT_LT(momentum, 2e-14);
      EXPECT_LT(angular, 2e-12);
      EXPECT_EQ(ran.result.largest_rotation, 0);  // nothing to warn of
    }
    const double first = ends[0].angularDistance(ends[1]),
                 second = ends[1].angularDistance(ends[2]);
    std::printf("orientation changes by %.2e and %.2e\n", first, second);
    EXPECT_NEAR(std::log2(first / second), 2, 0.1);
    EXPECT_NEAR(test::observed_order(steps, swings), 2, 0.1);
    EXPECT_LT(swings[2], 1e-5);
  }
}

}  // namespace
}  // namespace cbr::turning_mesh_test
