// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points and links: forces and moments on points, welds, hinges and sliders between them,
// and to the ground.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::links_test {
namespace {

using test::at;
using test::last;
using test::Ran;
using test::SceneFolder;

// Bars of length 4 along x, 1 x 1: E A = 2, E I = 1/6.
constexpr double EA = 2, EI = 2.0 / 12, length = 4;
const std::vector<std::string> kinds{"mesh", "craig-bampton, modes: 8", "massless, modes: 20",
                                     "characteristic, modes: 20"};

struct Joined {
  std::string kind = "mesh", instances = {}, boundary = {}, loads = {}, links = {};
  std::string time = "end: 1, step: 1, static: true", output = {};
};

std::string section(const std::string& name, const std::string& lines) {
  return lines.empty() ? "" : name + ":\n" + lines;
}

std::string bar(const Joined& scene, const std::string& name, double x,
                const std::string& more = "") {
  return "  " + name +
         ": {component: bar, as: " + (scene.kind == "mesh" ? "mesh" : "superelement") +
         ", position: [" + test::text(x) + ", 0, 0]" + more + "}\n";
}

std::string yaml(const Joined& scene) {
  // The faces of points are kept; one beside them is reduced
  const std::string more = scene.kind.starts_with("char") ? ", y_max" : "";
  const std::string reduction =
      scene.kind == "mesh"
          ? ""
          : ", reduction: {basis: " + scene.kind + ", interface: [x_min, x_max" + more + "]}";
  return "materials:\n  soft: {youngs_modulus: 2, poissons_ratio: 0, density: 1}\ncomponents:\n  "
         "bar: {mesh: bar.exo, material: "
         "soft, points: {base: {surface: x_min}, tip: {surface: x_max}}" +
         reduction + "}\ninstances:\n" + scene.instances + section("boundary", scene.boundary) +
         section("loads", scene.loads) + section("links", scene.links) + "time: {" + scene.time +
         "}\noutput: {" + scene.output + "}\n";
}

class Links : public ::testing::TestWithParam<std::string> {
 protected:
  Links() { folder.add("bar.exo", test::block_mesh({{8, 2, 2}, {length, 1, 1}})); }
  SceneFolder folder;
};

// The work of a moment is that of its point's rotation, which beam theory has but for the ends.
TEST_P(Links, AMomentTurnsItsPoint) {
  Joined scene{.kind = GetParam(), .output = "history: [a.tip]"};
  scene.instances = bar(scene, "a", 0);
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {instance: a, point: tip, moment: [0, 0.01, 0]}\n";
  const Ran ran = folder.run(yaml(scene));
  const double theta = last(ran.monitor("a.tip").rotation, 1);
  EXPECT_NEAR(theta, 0.01 * length / EI, 0.02 * theta);
  EXPECT_NEAR(2 * ran.result.total.back(), 0.01 * theta, 1e-9 * theta);
  // A beam under a moment sags by M L^2 / (2 E I), downwards for +y
  EXPECT_NEAR(last(ran.monitor("a.tip").mean_position, 2), 0.5 - 0.01 * length * length / (2 * EI),
              0.02 * theta);
}

// On the nodes of a face it is the same as on a point that moves with them.
TEST_P(Links, AMomentOnAFaceIsThatOnItsPoint) {
  Joined scene{.kind = GetParam(), .output = "history: [a.tip]"};
  scene.instances = bar(scene, "a", 0, ", rotation: [0, 0, 30]");
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {instance: a, point: tip, moment: [0.002, 0.01, 0.003]}\n";
  const Ran on_point = folder.run(yaml(scene));
  scene.loads = "  - {instance: a, surface: x_max, moment: [0.002, 0.01, 0.003]}\n";
  const Ran on_face = folder.run(yaml(scene));
  for (const auto& [face, point] :
       {std::pair(&on_face.monitor("a.tip").rotation, &on_point.monitor("a.tip").rotation),
        std::pair(&on_face.monitor("a.tip").mean_position,
                  &on_point.monitor("a.tip").mean_position)})
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(last(*face, axis), last(*point, axis), 1e-12) << axis;
  EXPECT_LT(at(on_face.body("a").reaction, on_face.result.time.size() - 1).norm(), 1e-12);
}

// A free bar gets the moment's angular momentum and no momentum, also where it is mirrored.
TEST_P(Links, AMomentOnAFaceTurnsAFreeBar) {
  Joined scene{.kind = GetParam(), .output = "every: 0.5, history: [a.tip]"};
  scene.time = "end: 1, integrator: exact";
  scene.instances = bar(scene, "a", 0, ", mirror: x, rotation: [0, 0, 30]");
  scene.loads =
      "  - {instance: a, surface: x_max, moment: [1.0e-3, 2.0e-3, 3.0e-3], history: {time: [0, 1], "
      "value: [0, 2]}}\n";
  const Ran ran = folder.run(yaml(scene));
  const std::size_t end = ran.result.time.size() - 1;
  const Vector3 expected(1e-3, 2e-3, 3e-3);
  EXPECT_LT(at(ran.body("a").momentum, end).norm(), 1e-12);
  EXPECT_LT((at(ran.body("a").angular_momentum, end) - expected).norm(),
            (GetParam() == "mesh" ? 1e-4 : 1e-10) * expected.norm());
}

TEST_P(Links, AWeldStretchesAsOneBar) {
  Joined scene{.kind = GetParam(), .output = "history: [b.tip]"};
  scene.instances = bar(scene, "a", 0) + bar(scene, "b", length);
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {instance: b, point: tip, force: [0.1, 0, 0]}\n";
  scene.links = "  - {between: [a.tip, b.base]}\n";
  const Ran ran = folder.run(yaml(scene));
  EXPECT_NEAR(last(ran.monitor("b.tip").mean_position, 0), 2 * length * (1 + 0.1 / EA), 1e-8);
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 0), 0.1, 1e-9);
}

// A hinge hands on no moment: of the weight of b each end carries one half.
TEST_P(Links, AHingeCarriesHalfOfTheWeight) {
  Joined scene{.kind = GetParam(), .output = "history: [b.tip]"};
  scene.instances = bar(scene, "a", 0) + bar(scene, "b", length);
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {gravity: [0, 0, -0.001]}\n";
  scene.links =
      "  - {between: [a.tip, b.base], fix: [x, y, z, rx, rz]}\n  - {between: [b.tip, ground], fix: "
      "[z]}\n";
  const Ran ran = folder.run(yaml(scene));
  const double weight = 0.001 * length;
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 2), -weight / 2, 1e-8 * weight);  // on a
  EXPECT_NEAR(last(ran.result.pairs[2]["force"], 2), weight / 2, 1e-8 * weight);   // on b
  EXPECT_NEAR(last(ran.result.pairs[1]["force"], 1), 0, 1e-8 * weight);            // its moment
}

// The moment of a link is no force on the supports.
TEST_P(Links, ReactionsHoldNoMoments) {
  Joined scene{.kind = GetParam()};
  scene.instances = bar(scene, "a", 0);
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {instance: a, point: tip, force: [0, 0, 0.01]}\n";
  scene.links = "  - {between: [a.tip, ground], fix: [ry]}\n";
  for (const std::string time : {"end: 1, step: 1, static: true", "end: 1, preload: 2"}) {
    scene.time = time;
    scene.output = time.ends_with("true") ? "" : "every: 0.5";
    const Ran ran = folder.run(yaml(scene));
    const double moment = last(ran.result.pairs[0]["force"], 1);
    EXPECT_NEAR(std::abs(moment), 0.01 * length / 2, 0.02 * 0.01 * length / 2);
    EXPECT_LT((at(ran.body("a").reaction, ran.result.time.size() - 1) + Vector3(0, 0, 0.01)).norm(),
              1e-8)
        << time;
  }
}

TEST_P(Links, AMechanismIsRefused) {
  Joined scene{.kind = GetParam()};
  scene.instances = bar(scene, "a", 0) + bar(scene, "b", length);
  scene.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  scene.loads = "  - {instance: b, point: tip, force: [0, 0, 0.01]}\n";
  scene.links = "  - {between: [a.tip, b.base], fix: [x, y, z, rx, rz]}\n";
  EXPECT_SAYS(folder.run(yaml(scene)).result.failure, "instance 'b' is not held");
}

// In motion: points that are welded stay together, the hinged bar folds, nothing is lost.
TEST_P(Links, LinkedBarsKeepMomentumAndEnergy) {
  for (const std::string integrator : {"exact", "central-difference", "newmark"}) {
    if (integrator == "newmark" && GetParam().starts_with("massless")) continue;
    for (const std::string fix : {"", ", fix: [x, y, z, rx, rz]", ", fix: [y, z, rx, ry, rz]"}) {
      Joined scene{.kind = GetParam(), .output = "every: 0.5, history: [a.tip, b.base]"};
      scene.instances = bar(scene, "a", 0, ", velocity: [0, 0, 0.01]") +
                        bar(scene, "b", length, ", velocity: [0.02, 0, 0]");
      scene.links = "  - {between: [a.tip, b.base]" + fix + "}\n";
      scene.time =
          "end: 2, integrator: " + integrator + (integrator == "newmark" ? ", step: 0.05" : "");
      const Ran ran = folder.run(yaml(scene));
      const Vector3 before = at(ran.body("a").momentum, 0) + at(ran.body("b").momentum, 0);
      for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
        const Vector3 apart =
            at(ran.monitor("a.tip").mean_position, i) - at(ran.monitor("b.base").mean_position, i);
        const Vector3 turned =
            at(ran.monitor("a.tip").rotation, i) - at(ran.monitor("b.base").rotation, i);
        const bool slides = fix.find("[y") != std::string::npos, folds = !fix.empty() && !slides;
        EXPECT_LT((slides ? Vector3(0, apart[1], apart[2]) : apart).norm(), 1e-10)
            << integrator << fix;
        EXPECT_LT((folds ? Vector3(turned[0], 0, turned[2]) : turned).norm(), 1e-10)
            << integrator << fix;
        if (slides) {
          EXPECT_GT(-apart[0], 0.009 * ran.result.time[i]) << integrator;
        }
        EXPECT_LT((at(ran.body("a").momentum, i) + at(ran.body("b").momentum, i) - before).norm(),
                  1e-11);
      }
      EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator << fix;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Links, ::testing::ValuesIn(kinds), [](const auto& of) {
  return of.param.substr(0, of.param.find_first_of("-,"));
});

}  // namespace
}  // namespace cbr::links_test
