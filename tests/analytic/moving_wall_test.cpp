// SPDX-License-Identifier: GPL-3.0-or-later
// Walls that move: an impact seen from the wall and from the body, a press in motion and in
// statics, restarts, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::moving_wall_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

struct Way {
  std::string kind = "mesh", time = "integrator: exact", enforcement = "impulse";
};

class MovingWall : public ::testing::Test {
 protected:
  MovingWall() { folder.add("bar.exo", test::block_mesh({{6, 2, 2}, {1, 0.5, 0.5}})); }
  SceneFolder folder;
};

std::string scene(const Way& way, const std::string& wall, const std::string& velocity,
                  const std::string& more = "", const std::string& friction = "0.3",
                  const std::string& end = "0.3, ") {
  const std::string reduction =
      way.kind == "mesh" ? "" : ", reduction: {basis: " + way.kind + ", interface: [x_min, x_max]}";
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1, damping: "
         "{alpha: " +
         std::string(more.empty() ? "0" : "20") +
         "}}\ncomponents:\n  bar: {mesh: bar.exo, material: soft" + reduction +
         "}\ninstances:\n  bar: {component: bar, as: " +
         (way.kind == "mesh" ? "mesh" : "superelement") +
         ", position: [0.013, 0, 0], velocity: " + velocity + "}\nwalls:\n  w: {" + wall +
         "}\ncontact:\n  - {between: [bar.x_min, w], " + "enforcement: " + way.enforcement +
         ", friction: " + friction + "}\n" + more + "time: {end: " + end + way.time +
         "}\noutput: {every: 0.01, history: [bar.x_min, bar.x_max]}\n";
}

const std::string plane = "plane: {point: [0, 0, 0], normal: [1, 0, 0]}";

std::vector<Way> all_ways() {
  std::vector<Way> ways;
  for (const std::string kind :
       {"mesh", "craig-bampton, modes: 20", "massless, modes: 40, massless_modes: tapered",
        "characteristic, modes: 20"}) {
    const bool massless = kind.starts_with("massless");
    for (const std::string time : {"integrator: exact", "integrator: central-difference",
                                   "integrator: newmark, step: 0.002"})
      for (const std::string enforcement : {"impulse", "penalty"}) {
        const bool newmark = time.find("newmark") != std::string::npos;
        if ((massless && (newmark || enforcement == "penalty")) ||
            (newmark && enforcement == "penalty"))
          continue;
        if (kind.starts_with("char") && enforcement == "penalty") continue;
        ways.push_back({kind, time, enforcement});
      }
  }
  for (const std::string kind : {"craig-bampton, modes: 20", "characteristic, modes: 20"})
    ways.push_back({kind, "integrator: exact, rotations: large", "impulse"});
  return ways;
}

// Galilei: a bar that flies against a wall at rest, and a wall that comes to a bar at rest. Seen
// from the wall all is the same: forces, and the work of contact and friction. The wall's work is
// its speed times the impulse.
TEST_F(MovingWall, TheFrameDoesNotMatter) {
  const Vector3 V(0.4, 0.1, -0.2);
  for (const Way& way : all_ways()) {
    const std::string name = way.kind + way.time + way.enforcement;
    const Ran flies = folder.run(scene(way, plane, text(-V)));
    const Ran rests = folder.run(scene(way, plane + ", velocity: " + text(V), "[0, 0, 0]"));
    double most = 0;
    Vector3 impulse = Vector3::Zero();
    for (std::size_t i = 0; i < flies.result.time.size(); ++i) {
      const double t = flies.result.time[i];
      for (const char* face : {"bar.x_min", "bar.x_max"}) {
        const Vector3 a = at(flies.monitor(face).mean_position, i),
                      b = at(rests.monitor(face).mean_position, i);
        EXPECT_LT((a + t * V - b).norm(), 1e-11) << name << t;
      }
      const Vector3 force = at(rests.result.pairs[0]["force"], i);
      most = std::max(most, force.norm());
      EXPECT_LT((at(flies.result.pairs[0]["force"], i) - force).norm(), 1e-8) << name << t;
      if (i > 0) impulse += (t - flies.result.time[i - 1]) * force;
      // Of massless bases half of the last impulse is booked with the next step
      const bool is_over = i + 1 == flies.result.time.size();
      if (!is_over && way.kind.starts_with("massless")) continue;
      EXPECT_NEAR(flies.result.work_contact[i], rests.result.work_contact[i], 1e-11) << name;
      EXPECT_NEAR(flies.result.work_friction[i], rests.result.work_friction[i], 1e-11) << name;
      // While forces last, the body has a share of the next impulse
      if (is_over || way.time != "integrator: exact" || way.kind == "mesh")
        EXPECT_NEAR(rests.result.work_external[i], V.dot(impulse), 1e-11) << name;
      EXPECT_EQ(flies.result.work_external[i], 0);
    }
    EXPECT_GT(most, 0.5) << name;
    EXPECT_LT(flies.result.work_friction.back(), -1e-4) << name;
    EXPECT_LT(test::energy_residual(rests.result), 1e-11) << name;
  }
}

// A round wall that passes by a bar at rest touches it at the same time as one at rest that the bar
// passes.
TEST_F(MovingWall, ABallToo) {
  const std::string ball = "sphere: {center: [-0.6, 0.2, 0.3], radius: 0.5}";
  for (const std::string kind : {"mesh", "craig-bampton, modes: 20"}) {
    const Ran flies = folder.run(scene({kind}, ball, "[-1, 0, 0]"));
    const Ran rests = folder.run(
        scene({kind}, ball + ", velocity: [2, 0, 0], history: {time: [0, 9], value: [0.5, 0.5]}",
              "[0, 0, 0]"));
    for (std::size_t i = 0; i < flies.result.time.size(); ++i)
      EXPECT_NEAR(at(flies.monitor("bar.x_max").mean_position, i)[0] + flies.result.time[i],
                  at(rests.monitor("bar.x_max").mean_position, i)[0], 1e-11);
    EXPECT_GT(test::integral(rests.result, rests.result.pairs[0]["force"])[0], 0.05) << kind;
  }
}

const std::string clamp = "boundary:\n  - {instance: bar, nodes: x_max, fix: [x, y, z]}\n";

// A press: in the end the wall has shortened the bar by 0.02, whose stiffness is E A / L = 50.
TEST_F(MovingWall, APressCloses) {
  const double k = 50, d = 0.02;
  for (Way way : all_ways()) {
    const std::string wall =
        plane + ", displacement: [0.033, 0, 0], history: {time: [0, 1], value: [0, 1]}";
    const Ran ran = folder.run(scene(way, wall, "[0, 0, 0]", clamp, "0", "3, "));
    const std::string name = way.kind + way.time + way.enforcement;
    const std::size_t last = ran.result.time.size() - 1;
    const double share = way.enforcement == "penalty"   ? 0.15
                         : way.kind.starts_with("char") ? 2e-3
                                                        : 1e-6;
    EXPECT_NEAR(at(ran.result.pairs[0]["force"], last)[0], k * d, share * k * d) << name;
    EXPECT_NEAR(at(ran.body("bar").reaction, last)[0], -k * d, share * k * d) << name;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << name;
    if (way.kind == "mesh" && way.enforcement == "impulse")
      EXPECT_LT(std::abs(ran.result.work_contact.back()), 0.05 * k * d * d / 2) << name;
  }
}

// From where the bar touches, the wall does all the work, which the bar stores.
TEST_F(MovingWall, APressInStatics) {
  const double k = 50, d = 0.02;
  for (const std::string kind :
       {"mesh", "craig-bampton, modes: 20", "massless, modes: 40", "characteristic, modes: 20"}) {
    const std::string wall =
        plane + ", displacement: [0.02, 0, 0], history: {time: [0, 1], value: [0, 1]}";
    std::string text =
        scene({kind, "static: true, step: 0.25"}, wall, "[0, 0, 0]", clamp, "0", "1, ");
    text.replace(text.find("position: [0.013, 0, 0]"), 23, "position: [0, 0, 0]");
    text.replace(text.find("every: 0.01"), 11, "every: 0.25");
    const Ran ran = folder.run(text);
    const std::size_t last = ran.result.time.size() - 1;
    const double share = kind.starts_with("char") ? 2e-3 : 1e-7;
    EXPECT_NEAR(at(ran.result.pairs[0]["force"], last)[0], k * d, share * k * d) << kind;
    EXPECT_NEAR(at(ran.body("bar").reaction, last)[0], -k * d, share * k * d) << kind;
    EXPECT_NEAR(ran.result.work_external.back(), k * d * d / 2, share * k * d * d) << kind;
    EXPECT_LT(std::abs(ran.result.work_contact.back()), 1e-6 * k * d * d) << kind;
    EXPECT_LT(test::energy_residual(ran.result), 1e-9) << kind;
  }
}

TEST_F(MovingWall, RestartsGoOnBitForBit) {
  for (Way way : all_ways()) {
    const std::string text =
        scene(way, plane + ", velocity: [0.4, 0.1, 0], history: {time: [0, 0.2], value: [1, 0.5]}",
              "[0, 0, 0]");
    test::expect_same_bits(test::restarted(folder, text, 0.08), way.kind + way.time);
  }
}

TEST_F(MovingWall, WhatCannotBeIsRefusedByName) {
  const auto refusal = [&](const std::string& motion) {
    return test::refusal_of([&] { folder.prepare(scene({}, plane + motion, "[0, 0, 0]")); });
  };
  EXPECT_SAYS(refusal(", displacement: [1, 0, 0]"), "needs a history");
  EXPECT_SAYS(refusal(", velocity: [1, 0, 0], acceleration: [1, 0, 0]"), "remove the other");
  EXPECT_SAYS(refusal(", history: {time: [0], value: [1]}"), "walls.w.history: needs one of");
}

}  // namespace
}  // namespace cbr::moving_wall_test
