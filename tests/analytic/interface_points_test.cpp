// SPDX-License-Identifier: GPL-3.0-or-later
// Points as the interface of a superelement: against interfaces of whole faces with the same points
// on them, with all modes, and rigid motions in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::interface_points_test {
namespace {

using test::at;
using test::last;
using test::Ran;
using test::SceneFolder;
using test::text;

// A bar of length 4 along x, 1 x 1. Inside of both ends: 7 x 3 x 3 nodes.
constexpr double length = 4, mass = 4;
constexpr int all_modes = 7 * 27;

// What stands for the ends of the bar.
enum class Ends { faces, points, base_alone };

struct Pointed {
  Ends ends = Ends::points;
  std::string coupling = ", coupling: rigid", modes = std::to_string(all_modes), place = {};
  std::string instances = {}, more = {}, output = "history: [a.tip, a.base]", recovery = {};
  double modulus = 50;
};

std::string yaml(const Pointed& scene) {
  const std::string interface = scene.ends == Ends::faces    ? "interface: [x_min, x_max]"
                                : scene.ends == Ends::points ? "points: [base, tip]"
                                                             : "points: [base], interface: x_max";
  const std::string of_base =
      scene.coupling.empty() && scene.ends != Ends::faces ? ", coupling: rigid" : scene.coupling;
  const std::string instances =
      scene.instances.empty() ? "  a: {component: bar" + scene.place + "}\n" : scene.instances;
  return "materials:\n  m: {youngs_modulus: " + text(scene.modulus) +
         ", poissons_ratio: 0.3, density: 1}\ncomponents:\n  bar: {mesh: bar.exo, material: m, "
         "mass: lumped, points: {base: {surface: x_min" +
         of_base + "}, tip: {surface: x_max" +
         (scene.ends == Ends::base_alone ? "" : scene.coupling) +
         "}}, reduction: {modes: " + scene.modes + ", " + interface + scene.recovery +
         "}}\ninstances:\n" + instances + scene.more + "output: {" + scene.output + "}\n";
}

class InterfacePoints : public ::testing::Test {
 protected:
  InterfacePoints() { folder.add("bar.exo", test::block_mesh({{8, 2, 2}, {length, 1, 1}})); }
  Vector frequencies(const Pointed& scene, Index n) {
    return scene_modes(folder.prepare(yaml(scene)).scene, n, report).instances.at(0).frequency_hz;
  }

  SceneFolder folder;
  Report report{"test", Verbosity::quiet};
};

double difference(const Series3& a, const Series3& b) {
  double worst = 0, scale = 0;
  EXPECT_EQ(a.values.size(), b.values.size());
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    worst = std::max(worst, std::abs(a.values[i] - b.values[i]));
    scale = std::max(scale, std::abs(b.values[i] - b.values[i % 3]));
  }
  EXPECT_GT(scale, 0);
  return worst / scale;
}

void expect_same_motion(const Ran& a, const Ran& b, const std::string& point, double tolerance) {
  EXPECT_LT(difference(a.monitor(point).mean_position, b.monitor(point).mean_position), tolerance)
      << point;
  EXPECT_LT(difference(a.monitor(point).rotation, b.monitor(point).rotation), tolerance) << point;
}

TEST_F(InterfacePoints, FrequenciesAreThoseOfRigidFaces) {
  for (const std::string& more :
       {std::string(), std::string("links:\n  - {between: [a.base, ground]}\n"),
        std::string("links:\n  - {between: [a.base, ground], stiffness: [3, 4, 5, 6, 7, 8]}\n"
                    "  - {between: [a.tip, ground], fix: [y, rz]}\n")}) {
    Pointed points{.more = more + "time: {end: 1}\n"}, faces = points;
    faces.ends = Ends::faces;
    const Vector found = frequencies(points, 20), expected = frequencies(faces, 20);
    const Index n = std::min(found.size(), expected.size());
    ASSERT_GT(n, 10);
    for (Index j = 0; j < n; ++j)
      EXPECT_NEAR(found(j), expected(j), 1e-9 * expected(n - 1)) << more << j;
  }
}

TEST_F(InterfacePoints, SweepsAreThoseOfRigidFaces) {
  Pointed points{.output = "history: [a.tip]"};
  points.more =
      "links:\n  - {between: [a.base, ground], stiffness: [3, 4, 5, 6, 7, 8], damping: [0.1, 0.1, "
      "0.1, 0.1, 0.1, 0.1]}\nloads:\n  - {instance: a, point: tip, force: [1, 2, 3]}\n  - "
      "{instance: a, point: tip, moment: [0.5, 0.2, 0.1]}\n"
      "time: {end: 1}\nsweep: {from_hz: 0.02, to_hz: 2, points: 12}\n";
  Pointed faces = points;
  faces.ends = Ends::faces;
  const HarmonicResponse a = harmonic_response(folder.prepare(yaml(points)).scene, report),
                         b = harmonic_response(folder.prepare(yaml(faces)).scene, report);
  const auto &found = a.sets.at(0).displacement, &expected = b.sets.at(0).displacement;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

// Turned and mirrored: a rotation is a pseudo-vector.
TEST_F(InterfacePoints, StaticsAreThoseOfRigidFaces) {
  for (const std::string& place :
       {std::string(), std::string(", position: [1, 2, 3], rotation: [20, -30, 50]"),
        std::string(", rotation: [20, -30, 50], mirror: x")}) {
    Pointed points{.place = place};
    points.more =
        "links:\n  - {between: [a.base, ground], fix: [x, y, z, rx, ry]}\n"
        "  - {between: [a.tip, ground], fix: [y]}\n"
        "loads:\n  - {instance: a, point: tip, force: [0.01, 0.02, 0.03]}\n  - {instance: a, "
        "point: tip, moment: [0.01, -0.02, 0.005]}\n  - {gravity: [0, 0, -0.01]}\n"
        "time: {end: 1, step: 1, static: true}\n";
    Pointed faces = points;
    faces.ends = Ends::faces;
    const Ran a = folder.run(yaml(points)), b = folder.run(yaml(faces));
    expect_same_motion(a, b, "a.tip", 1e-7);
    EXPECT_LT(difference(a.monitor("a.base").rotation, b.monitor("a.base").rotation), 1e-7);
  }
}

// One point and one face: the same held model as with two faces, moved by the same integrator.
TEST_F(InterfacePoints, AHeldPointIsAHeldFace) {
  for (const std::string& motion :
       {std::string(), std::string(", acceleration: [0, 0.3, 0.2], history: {time: [0, 0.5, 1], "
                                   "value: [0, 1, 0]}")})
    for (const std::string& time :
         {std::string("integrator: exact"), std::string("integrator: central-difference"),
          std::string("integrator: newmark, step: 0.01"), std::string("dense"),
          std::string("step: 0.5, static: true")}) {
      const bool is_dense = time == "dense";
      if (time.ends_with("static: true") && !motion.empty()) continue;
      folder.diagonal_limit = is_dense ? std::optional<Index>(0) : std::nullopt;
      Pointed point{.ends = Ends::base_alone,
                    .coupling = {},
                    .output = "every: 0.25, history: [a.tip, a.base]"};
      point.more =
          "boundary:\n  - {instance: a, nodes: base, fix: [x, y, z]" + motion +
          "}\nloads:\n  - {instance: a, point: tip, force: [0.1, 0.2, 0.3]}\n  - {instance: a, "
          "point: tip, moment: [0.1, -0.2, 0.05]}\n  - {gravity: [0, 0, -0.1]}\ntime: {end: 2, " +
          (is_dense ? "integrator: newmark, step: 0.01" : time) + "}\n";
      Pointed faces = point;
      faces.ends = Ends::faces;
      std::string of_faces = yaml(faces);
      of_faces.replace(of_faces.find("nodes: base"), 11, "nodes: x_min");
      const Ran a = folder.run(yaml(point)), b = folder.run(of_faces);
      expect_same_motion(a, b, "a.tip", 1e-8);
      EXPECT_LT(test::energy_residual(a.result), 1e-2) << time;
      const auto& reaction = a.body("a").reaction;
      EXPECT_LT(difference(reaction, b.body("a").reaction), 1e-7) << time << motion;
      if (motion.empty()) {
        EXPECT_EQ(at(a.monitor("a.base").mean_position, 0),
                  at(a.monitor("a.base").mean_position, 3));
      } else {
        EXPECT_LT(difference(a.monitor("a.base").mean_position, b.monitor("a.base").mean_position),
                  1e-9);
      }
      EXPECT_LT(std::abs(last(a.monitor("a.base").rotation, 1)), 1e-12) << time << motion;
    }
}

TEST_F(InterfacePoints, AShakenPointSweepsAsAShakenFace) {
  Pointed point{.ends = Ends::base_alone, .coupling = {}, .output = "history: [a.tip]"};
  point.more =
      "boundary:\n  - {instance: a, nodes: base, fix: [x, y, z], acceleration: [0, 1, 0.5]}\n"
      "time: {end: 1}\nsweep: {from_hz: 0.02, to_hz: 0.3, points: 7}\n";
  Pointed faces = point;
  faces.ends = Ends::faces;
  std::string of_faces = yaml(faces);
  of_faces.replace(of_faces.find("nodes: base"), 11, "nodes: x_min");
  const HarmonicResponse a = harmonic_response(folder.prepare(yaml(point)).scene, report),
                         b = harmonic_response(folder.prepare(of_faces).scene, report);
  const auto &found = a.sets.at(0).displacement, &expected = b.sets.at(0).displacement;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

// Two welded bars fly and turn: momentum, angular momentum and energy stay.
TEST_F(InterfacePoints, WeldedBarsKeepTheirMomentum) {
  for (const std::string& time :
       {std::string("integrator: exact"), std::string("integrator: central-difference"),
        std::string("integrator: newmark, step: 0.01")}) {
    Pointed scene{.modes = "12", .output = "every: 0.5, history: [a.tip, b.base]"};
    scene.instances =
        "  a: {component: bar, velocity: [0, 1.0e-4, 2.0e-4]}\n"
        "  b: {component: bar, position: [4.5, 0, 0], velocity: [1.0e-4, -1.0e-4, 0]}\n";
    scene.more = "links:\n  - {between: [a.tip, b.base]}\ntime: {end: 5, " + time + "}\n";
    const Ran ran = folder.run(yaml(scene));
    const std::size_t n = ran.result.time.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vector3 P = at(ran.body("a").momentum, i) + at(ran.body("b").momentum, i);
      EXPECT_LT((P - mass * Vector3(1e-4, 0, 2e-4)).norm(), 1e-14) << time;
      const Vector3 L =
          at(ran.body("a").angular_momentum, i) + at(ran.body("b").angular_momentum, i);
      const Vector3 L_0 =
          at(ran.body("a").angular_momentum, 0) + at(ran.body("b").angular_momentum, 0);
      EXPECT_LT((L - L_0).norm(), 1e-3 * L_0.norm()) << time << i;
      // The weld holds, across the gap of 0.5 as a rigid bar would
      const Vector3 theta = at(ran.monitor("a.tip").rotation, i);
      EXPECT_LT((theta - at(ran.monitor("b.base").rotation, i)).norm(), 1e-6) << time;
    }
    EXPECT_LT(test::energy_residual(ran.result), 1e-2) << time;
  }
}

// A stiff free bar under a force and a moment on its base: rigid motion in closed form.
TEST_F(InterfacePoints, AForceAndAMomentMoveAStiffBar) {
  for (const std::string& time :
       {std::string("integrator: exact"), std::string("integrator: newmark, step: 0.01")}) {
    Pointed scene{.modes = "4", .output = "every: 0.5, history: [a.tip, a.base]", .modulus = 1e8};
    scene.more =
        "loads:\n  - {instance: a, point: base, force: [0, 0.04, 0]}\n"
        "  - {instance: a, point: base, moment: [0, 0, 0.1]}\ntime: {end: 1, " +
        time + "}\n";
    const Ran ran = folder.run(yaml(scene));
    const double inertia = folder.prepare(yaml(scene))
                               .built.instances[0]
                               .parts[0]
                               .superelement->rigid_body.inertia(2, 2);
    // About the centre: moment 0.1, and the force's at x = -2
    const double alpha = (0.1 - 2 * 0.04) / inertia, t = 1;
    EXPECT_NEAR(last(ran.monitor("a.base").rotation, 2), alpha * t * t / 2, 1e-4 * alpha) << time;
    EXPECT_NEAR(
        last(ran.monitor("a.tip").mean_position, 1) - at(ran.monitor("a.tip").mean_position, 0)[1],
        (0.04 / mass + 2 * alpha) * t * t / 2, 1e-4 * 0.04 / mass)
        << time;
  }
}

// A mass on the point swings on a beam that is held at its other point.
TEST_F(InterfacePoints, AMassOnAPointLowersTheFrequency) {
  Pointed scene;
  scene.coupling = ", coupling: rigid, mass: 100, inertia: [1, 1, 1]";
  scene.more = "boundary:\n  - {instance: a, nodes: base, fix: [x, y, z]}\ntime: {end: 1}\n";
  Pointed faces = scene;
  faces.ends = Ends::faces;
  faces.more = "links:\n  - {between: [a.base, ground]}\ntime: {end: 1}\n";
  const Vector found = frequencies(scene, 6), expected = frequencies(faces, 6);
  for (Index j = 0; j < 6; ++j) EXPECT_NEAR(found(j), expected(j), 1e-8 * expected(j)) << j;
  // E A / L on 100 and a third of the bar
  const double hz = std::sqrt(50 * 1 / length / (100 + mass / 3)) / (2 * std::numbers::pi);
  EXPECT_LT((found.array() / hz - 1).abs().minCoeff(), 0.02);
}

// A cantilever on one point, by a support or a link: w L^4 / (8 E I) under its own weight.
TEST_F(InterfacePoints, OnePointHoldsACantilever) {
  folder.add("bar.exo", test::block_mesh({{40, 2, 2}, {40, 1, 1}}));
  for (const std::string& held :
       {std::string("boundary:\n  - {instance: a, nodes: base, fix: [x, y, z]}\n"),
        std::string("links:\n  - {between: [a.base, ground]}\n")}) {
    const std::string whole =
        "materials:\n  m: {youngs_modulus: 1.0e8, poissons_ratio: 0, density: 1}\ncomponents:\n  "
        "bar: {mesh: bar.exo, material: m, points: {base: {surface: x_min, coupling: rigid}}, "
        "reduction: {points: base, modes: 40, recovery: [x_max]}}\n"
        "instances:\n  a: {component: bar}\n" +
        held +
        "loads:\n  - {gravity: [0, 0, -1]}\ntime: {end: 1, step: 1, static: true}\n"
        "output: {history: [a.base, a.x_max]}\n";
    const Ran ran = folder.run(whole);
    const Series3& tip = ran.monitor("a.x_max").mean_position;
    const double sag = at(tip, 0)[2] - last(tip, 2), expected = std::pow(40, 4) / (8 * 1e8 / 12);
    EXPECT_NEAR(sag, expected, 0.01 * expected) << held;
  }
}

// Stress of elements and at nodes of a set that a point moves.
TEST_F(InterfacePoints, StressIsThatOfRigidFaces) {
  Pointed points{.recovery = ", recovery: true"};
  points.output =
      "history: [a.tip], stress: [a.x_min, a.y_max, {instance: a, elements: [1, 5, 9]}]";
  points.more =
      "links:\n  - {between: [a.base, ground]}\nloads:\n  - {instance: a, point: tip, force: "
      "[0.01, 0.02, 0.03]}\ntime: {end: 1, step: 1, static: true}\n";
  Pointed faces = points;
  faces.ends = Ends::faces;
  const Ran a = folder.run(yaml(points)), b = folder.run(yaml(faces));
  ASSERT_EQ(a.result.watches.size(), 3u);
  for (std::size_t w = 0; w < 3; ++w) {
    // By id, as nodes on the interface come before those inside
    const auto by_id = [w](const Ran& ran) {
      const std::vector<Index>& ids = ran.built.simulation.watches[w].ids;
      const std::vector<double>& of = ran.result.watches[w];
      std::map<Index, std::vector<double>> values;
      for (std::size_t i = 0; i < ids.size(); ++i)
        for (std::size_t j = 0; j < 6; ++j)
          values[ids[i]].push_back(of[of.size() - 6 * ids.size() + 6 * i + j]);
      return values;
    };
    const auto found = by_id(a), expected = by_id(b);
    ASSERT_EQ(found.size(), expected.size());
    double worst = 0, scale = 0;
    for (const auto& [id, values] : expected)
      for (std::size_t j = 0; j < 6; ++j) {
        worst = std::max(worst, std::abs(found.at(id)[j] - values[j]));
        scale = std::max(scale, std::abs(values[j]));
      }
    EXPECT_GT(scale, 0);
    EXPECT_LT(worst, 1e-6 * scale) << w;
  }
}

// The file alone has its points under their names.
TEST_F(InterfacePoints, AFileAloneHasItsPoints) {
  Pointed scene;
  scene.more =
      "links:\n  - {between: [a.base, ground]}\nloads:\n  - {instance: a, point: tip, force: "
      "[0.01, 0.02, 0.03]}\ntime: {end: 1, step: 1, static: true}\n";
  const Ran a = folder.run(yaml(scene));
  const std::string whole = yaml(scene);
  const Ran b = folder.run("components:\n  bar: {superelement: bar.cbr.h5}\n" +
                           whole.substr(whole.find("instances:")));
  EXPECT_EQ(at(a.monitor("a.tip").mean_position, 1), at(b.monitor("a.tip").mean_position, 1));
}

TEST_F(InterfacePoints, WhatCannotBeIsRefusedByName) {
  const auto refusal = [&](const Pointed& scene, const std::string& old = {},
                           const std::string& by = {}) {
    std::string all = yaml(scene);
    if (!old.empty()) all.replace(all.find(old), old.size(), by);
    return test::refusal_of([&] { folder.run(all); });
  };
  const auto expect = [&](const std::string& message, const std::string& says) {
    EXPECT_SAYS(message, says);
  };
  Pointed scene{.more = "time: {end: 1}\n"};
  expect(refusal(scene, "points: [base, tip]", "points: [base, top]"), "unknown point 'top'");
  expect(refusal(scene, "points: [base, tip]", "points: []"), "is empty");
  expect(refusal(scene, ", coupling: rigid", ""), "whose coupling is average");
  expect(refusal(scene, "points: [base, tip]", "points: [base, tip], domains: 2"), "domains");
  expect(refusal(scene, "points: [base, tip]", "points: [base, tip], basis: massless"), "massless");
  expect(refusal(scene, "points: [base, tip]", "points: [base, tip], interface: [x_min]"),
         "reduction.interface too");
  scene.more = "boundary:\n  - {instance: a, nodes: x_min, fix: [x, y, z]}\ntime: {end: 1}\n";
  expect(refusal(scene), "name the point 'base'");
  scene.more = "loads:\n  - {instance: a, surface: y_max, pressure: 1}\ntime: {end: 1}\n";
  expect(refusal(scene), "lies inside the part");
  scene.more = "time: {end: 1, rotations: large}\n";
  expect(refusal(scene), "points");
}

}  // namespace
}  // namespace cbr::interface_points_test
