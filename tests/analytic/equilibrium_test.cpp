// SPDX-License-Identifier: GPL-3.0-or-later
// Statics against closed forms: a press, bodies that only contact holds, friction, an interference
// fit, a bolt; superelements of every basis against meshes; preload and motion from there;
// restarts, refusals.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "dynamics/output/summary/summary.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::equilibrium_test {
namespace {

using test::at;
using test::last;
using test::Ran;
using test::SceneFolder;

// Bars of nu = 0 along x: E A = 2, each of length 1. They are as stiff as one-dimensional ones.
constexpr double EA = 2;
const std::vector<std::string> kinds{"mesh", "craig-bampton, modes: 6", "massless, modes: 6",
                                     "characteristic, modes: 8"};

struct Bars {
  std::string kind = "mesh";
  std::string instances = {}, boundary = {}, loads = {}, walls = {}, contact = {};
  std::string time = "end: 1, step: 0.5, static: true", extra = {};
  std::string history = "[a.x_max]", nu = "0";
};

std::string instance(const Bars& bars, const std::string& name, double x,
                     const std::string& more = "") {
  const std::string as = bars.kind == "mesh" ? "mesh" : "superelement";
  return "  " + name + ": {component: bar, as: " + as + ", position: [" + test::text(x) +
         ", 0, 0]" + more + "}\n";
}

std::string section(const std::string& name, const std::string& lines) {
  return lines.empty() ? "" : name + ":\n" + lines;
}

// Its faces answer with their statics; what forces on one face and weight do elsewhere is that of
// few shapes. y_max is there to be reduced where the others are kept.
bool is_of_shapes(const std::string& kind) { return kind.starts_with("char"); }

std::string yaml(const Bars& bars) {
  const std::string reduction =
      bars.kind == "mesh" ? ""
                          : ", reduction: {basis: " + bars.kind + ", interface: [x_min, x_max" +
                                (is_of_shapes(bars.kind) ? ", y_max" : "") + "]}";
  return "materials:\n  soft: {youngs_modulus: 2, poissons_ratio: " + bars.nu +
         ", density: 1}\ncomponents:\n  bar: {mesh: bar.exo, material: soft" + reduction +
         "}\ninstances:\n" + bars.instances + section("boundary", bars.boundary) +
         section("loads", bars.loads) + section("walls", bars.walls) +
         section("contact", bars.contact) + "time: {" + bars.time +
         "}\noutput: {history: " + bars.history + bars.extra + "}\n";
}

std::string refusal(const SceneFolder& folder, const std::string& scene) {
  try {
    const Ran ran = folder.run(scene);
    return ran.result.failure.empty() ? "not refused" : ran.result.failure;
  } catch (const InputError& error) {
    return error.what();
  }
}

class Statics : public ::testing::TestWithParam<std::string> {
 protected:
  Statics() { folder.add("bar.exo", test::block_mesh({{4, 2, 2}, {1, 1, 1}})); }
  std::string refusal(const Bars& bars) const {
    return equilibrium_test::refusal(folder, yaml(bars));
  }
  SceneFolder folder;
};

TEST_P(Statics, AHeldBarStretches) {
  Bars bars{.kind = GetParam()};
  bars.instances = instance(bars, "a", 0);
  bars.boundary = "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n";
  bars.loads = "  - {instance: a, surface: x_max, force: [0.3, 0, 0]}\n";
  const Ran ran = folder.run(yaml(bars));
  ASSERT_EQ(ran.result.time.size(), 3U);  // 0, 0.5, 1
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(at(ran.body("a").reaction, i)[0], -0.3 * ran.result.time[i], 1e-12);
    if (is_of_shapes(GetParam())) continue;
    EXPECT_NEAR(at(ran.monitor("a.x_max").mean_position, i)[0], 1 + 0.3 * ran.result.time[i] / EA,
                1e-10);
  }
  EXPECT_LT(test::energy_residual(ran.result), 1e-10);
  if (is_of_shapes(GetParam())) return;
  EXPECT_NEAR(ran.result.total.back(), 0.5 * 0.3 * 0.3 / EA, 1e-10);
}

// A support takes two bars that are tied to another place: nothing is strained, so no energy tells
// when it stands.
TEST_P(Statics, TiedBarsMoveWithoutStrain) {
  Bars bars{.kind = GetParam(), .history = "[b.x_max]"};
  bars.instances = instance(bars, "a", 0) + instance(bars, "b", 1);
  bars.boundary =
      "  - {instance: a, nodes: x_min, fix: [x, y, z], displacement: [0, 0, 0.3], history: {time: "
      "[0, 1], value: [0, 1]}}\n";
  bars.contact = "  - {between: [a.x_max, b.x_min], tied: true}\n";
  const Ran ran = folder.run(yaml(bars));
  const auto& x = ran.monitor("b.x_max").mean_position;
  const auto end = ran.result.time.size() - 1;
  EXPECT_LT((at(x, end) - at(x, 0) - Vector3(0, 0, 0.3)).norm(), 1e-12);
  EXPECT_LT(ran.result.total.back(), 1e-24);
}

// Two planes of symmetry go through both cubes: supports hold both sides of the tie across it,
// where its rows are round-off: nodes on both sides of the origin are what makes it other than 0.
// It is no gap either.
TEST(StaticsOfTies, GoWithSupportsOfBothSides) {
  SceneFolder folder;
  folder.add("cube.exo", test::block_mesh({{4, 4, 4}, Vector3(0.1, 0.1, 0.1), [](const Vector3& x) {
                                             return Vector3(x.array() - 0.05);
                                           }}));
  const auto run = [&](const std::string& rest) {
    return folder.run(
        "materials: {m: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}}\n"
        "components: {cube: {mesh: cube.exo, material: m}}\n"
        "instances: {a: {component: cube, as: mesh}, b: {component: cube, as: mesh, position: [0, "
        "0, 0.1]}}\n" +
        rest + "time: {static: true, end: 1, step: 1}\noutput: {every: 1}\n");
  };
  const std::string boundary =
      "boundary:\n"
      "  - {instance: a, nodes: z_min, fix: [z]}\n"
      "  - {instance: a, nodes: x_min, fix: [x]}\n"
      "  - {instance: a, nodes: y_min, fix: [y]}\n"
      "  - {instance: b, nodes: x_min, fix: [x]}\n"
      "  - {instance: b, nodes: y_min, fix: [y]}\n";
  const Ran tied = run(boundary +
                       "contact: [{between: [a.z_max, b.z_min], tied: true}]\n"
                       "loads: [{instance: b, surface: z_max, force: [0, 0, 2.1e5]}]\n");
  const std::size_t end = tied.result.time.size() - 1;
  EXPECT_LT((at(tied.result.pairs[0]["force"], end).cwiseAbs() - Vector3(0, 0, 2.1e5)).norm(),
            1e-3);
  EXPECT_NEAR(tied.result.total.back(), 2.1, 1e-6);  // F^2 L / (2 E A)
  EXPECT_LT(tied.built.simulation.pairs[0].seen().residual, 1e-6);
  // Pulled together by 2e-5 between walls: e = 1e-4
  const Ran bolted = run(boundary +
                         "  - {instance: b, nodes: z_max, fix: [z]}\n"
                         "contact: [{between: [a.z_max, b.z_min], pretension: {shortening: "
                         "2.0e-5}}]\n");
  EXPECT_NEAR(bolted.result.total.back(), 2.1, 1e-6);
}

// Between two forces nothing holds the bars but each other: whatever round-off of the forces is
// left across them must not move them aside. Each force leaves another.
TEST_P(Statics, FreeBarsPressEachOther) {
  for (const std::string formulation : {"node-face", "mortar"}) {
    for (const double force : {0.2, 0.19, 0.13, 0.07}) {
      SCOPED_TRACE(formulation + " " + std::to_string(force));
      Bars bars{.kind = GetParam(), .history = "[a.x_min, b.x_max]"};
      bars.instances = instance(bars, "a", 0) + instance(bars, "b", 1);
      bars.loads = "  - {instance: a, surface: x_min, force: [" + std::to_string(force) +
                   ", 0, 0]}\n  - {instance: b, surface: x_max, force: [" + std::to_string(-force) +
                   ", 0, 0]}\n";
      bars.contact = "  - {between: [a.x_max, b.x_min], formulation: " + formulation + "}\n";
      const Ran ran = folder.run(yaml(bars));
      EXPECT_EQ(ran.result.failure, "");
      const double length =
          last(ran.monitor("b.x_max").mean_position) - last(ran.monitor("a.x_min").mean_position);
      EXPECT_NEAR(length, 2 - 2 * force / EA, 1e-8);
      EXPECT_NEAR(last(ran.result.pairs[0]["force"]), -force, 1e-9);
      EXPECT_NEAR(ran.result.pairs[0]["area"].values.back(), 1, 1e-11);
    }
  }
}

TEST_P(Statics, ABarStandsOnAWallByItsWeight) {
  Bars bars{.kind = GetParam(), .history = "[a.x_max]"};
  bars.instances = instance(bars, "a", 0.1);  // it has to fall first
  bars.loads = "  - {gravity: [-0.1, 0, 0]}\n";
  bars.walls = "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n";
  bars.contact = "  - {between: [a.x_min, floor]}\n";
  // A rigid point on a face that stays plane changes nothing
  for (const std::string point : {"", ", points: {p: {surface: x_max, coupling: rigid}}"}) {
    std::string text = yaml(bars);
    text.insert(text.find("bar.exo") + 7, point);
    const Ran ran = folder.run(text);
    EXPECT_NEAR(last(ran.result.pairs[0]["force"]), 0.1, 1e-9) << point;
    if (is_of_shapes(GetParam())) continue;
    EXPECT_NEAR(last(ran.monitor("a.x_max").mean_position), 1 - 0.5 * 0.1 / EA, 1e-8) << point;
  }
}

// Friction holds what slides without it, up to its limit.
TEST_P(Statics, FrictionHoldsABar) {
  Bars bars{.kind = GetParam(), .history = "[a.x_min]"};
  bars.instances = instance(bars, "a", 0);
  bars.loads = "  - {instance: a, surface: x_max, force: [-0.2, 0.02, 0]}\n";
  bars.walls = "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n";
  bars.contact = "  - {between: [a.x_min, floor], friction: 0.5}\n";
  const Ran ran = folder.run(yaml(bars));
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 0), 0.2, 1e-9);
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 1), -0.02, 1e-9);
  bars.contact = "  - {between: [a.x_min, floor], friction: 0.05}\n";
  EXPECT_SAYS(refusal(bars), "load step to t = 0.5: instance 'a' is not held", ", 1, ",
              "slides in contact a.x_min - floor, where friction is at its limit at every "
              "point and holds 0.5 of");
}

// A support leaves it free along the wall, where at most round-off acts on it: that motion takes no
// gap away, and has no force to balance.
TEST_P(Statics, ABarIsFreeAlongAWall) {
  Bars bars{.kind = GetParam(), .history = "[a.x_max]"};
  bars.instances = instance(bars, "a", 0);
  bars.walls = "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n";
  const std::string fixed = "  - {instance: a, nodes: x_max, fix: [x]";
  bars.boundary = fixed + "}\n";
  bars.loads = "  - {instance: a, surface: x_min, pressure: 0.01}\n";  // away from the wall
  bars.contact = "  - {between: [a.x_min, floor]}\n";
  const Ran lifted = folder.run(yaml(bars));
  EXPECT_LT(last(lifted.result.pairs[0]["force"]), 1e-12);
  EXPECT_NEAR(lifted.result.total.back(), 0.5 * 0.01 * 0.01 / EA, 1e-14);
  bars.boundary =
      fixed + ", displacement: [-0.01, 0, 0], history: {time: [0, 1], value: [0, 1]}}\n";
  bars.loads.clear();
  for (const std::string friction : {"0", "0.1"}) {
    bars.contact = "  - {between: [a.x_min, floor], friction: " + friction + "}\n";
    EXPECT_NEAR(last(folder.run(yaml(bars)).result.pairs[0]["force"]), 0.01 * EA, 1e-11)
        << friction;
  }
}

// What has been found before a load step fails is not lost.
TEST_P(Statics, LoadStepsBeforeAFailureAreKept) {
  Bars bars{.kind = GetParam(), .history = "[a.x_min]"};
  bars.instances = instance(bars, "a", 0);
  bars.loads =
      "  - {instance: a, surface: x_max, force: [-0.2, 0, 0], history: {time: [0, 0.1], value: [1, "
      "1]}}\n  - {instance: a, surface: x_min, force: [0, 0.1, 0]}\n";
  bars.walls = "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n";
  bars.contact = "  - {between: [a.x_min, floor], friction: 0.35}\n";  // up to 0.07
  bars.time = "end: 1, step: 0.25, static: true";
  const Ran ran = folder.run(yaml(bars));
  EXPECT_SAYS(ran.result.failure, "load step to t = 0.75: instance 'a' is not held");
  ASSERT_EQ(ran.result.time.size(), 3U);
  EXPECT_EQ(ran.result.ended_at, 0.5);
  EXPECT_NEAR(last(ran.result.pairs[0]["force"], 1), -0.05, 1e-10);
}

// Those before the time 0 as well: a shelf takes what presses a bar on a rough floor, so that its
// friction grows no more.
TEST_P(Statics, LoadStepsOfAPreloadBeforeAFailureAreKept) {
  Bars bars{.kind = GetParam()};
  bars.instances = instance(bars, "a", 0);
  bars.loads =
      "  - {instance: a, surface: x_max, force: [-0.175, 0, 0], history: &lasts {time: [0, 1], "
      "value: [1, 1]}}\n"
      "  - {instance: a, surface: x_min, force: [0, 0.06, 0], history: *lasts}\n";
  bars.walls =
      "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n"
      "  shelf: {plane: {point: [0.95, 0, 0], normal: [1, 0, 0]}}\n";
  bars.contact =
      "  - {between: [a.x_min, floor], friction: 0.5}\n  - {between: [a.x_max, shelf]}\n";
  for (const std::string time : {"step: 1, static: true", "integrator: central-difference"}) {
    bars.time = "end: 1, preload: 4, " + time;
    const Ran ran = folder.run(yaml(bars));
    const RunResult& result = ran.result;
    EXPECT_SAYS(result.failure, "load step 4 of 4 before the time 0: instance 'a' is not held");
    EXPECT_EQ(result.ended_at, 0);
    EXPECT_EQ(result.preload_reached, 3);
    ASSERT_EQ(result.time, std::vector<double>{0});
    EXPECT_NEAR(last(ran.monitor("a.x_max").mean_position), 0.95, 1e-9);
    EXPECT_NEAR(last(result.pairs[0]["force"], 1), -0.75 * 0.06, 1e-9);
    if (is_of_shapes(GetParam())) continue;
    EXPECT_NEAR(last(result.pairs[0]["force"]), 0.1, 1e-8);
    EXPECT_NEAR(last(result.pairs[1]["force"]), 0.75 * 0.175 - 0.1, 1e-8);
    EXPECT_NEAR(result.total[0], 0.1 * 0.1 / (2 * EA), 1e-8);
  }
}

// Plates that overlap: the upper one leaves its place before statics end.
TEST(StaticsWithoutEnd, NameTheJointThatSlides) {
  SceneFolder folder;
  folder.add("plate.exo", test::block_mesh({{8, 4, 2}, {40, 20, 5}}));
  for (const char* as : {"mesh", "superelement"}) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 2.1e5, poissons_ratio: 0.3, density: 7.85e-9}}\n"
        "components: {plate: {mesh: plate.exo, material: m, reduction: {interface: [x_min, x_max, "
        "z_min, z_max], modes: 20}}}\ninstances: {low: {component: plate, as: " +
        std::string(as) + "}, up: {component: plate, as: " + as +
        ", position: [10, 0, 5]}}\nboundary: [{instance: low, nodes: z_min, fix: [x, y, z]}]\n"
        "loads: [{instance: up, surface: z_max, force: [0, 0, -1000]}, {instance: up, surface: "
        "x_max, force: [500, 0, 0], history: {time: [0, 0.5, 1], value: [0, 0, 1]}}]\n"
        "contact: [{between: [low.z_max, up.z_min], friction: 0.3}]\n"
        "time: {static: true, end: 1, step: 0.25}\noutput: {every: 0.25}\n");
    // 0.3 x 750 of 250
    for (const std::string part : {"load step to t = 0.75: instance 'up' is not held",
                                   "in contact low.z_max - up.z_min,", "holds 0.9 of the load"})
      EXPECT_SAYS(ran.result.failure, part);
  }
}

// The node at the axis does not slide.
TEST(StaticsWithoutEnd, NameFrictionOfABlockThatTurns) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{2, 4, 4}, {1, 1, 1}}));
  for (const char* as : {"rigid", "mesh", "superelement"}) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 1}}\n"
        "components: {block: {mesh: block.exo, material: m, reduction: {interface: [x_min, x_max], "
        "modes: 10}}}\ninstances: {b: {component: block, as: " +
        std::string(as) +
        "}}\nwalls: {w: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
        "contact: [{between: [b.x_min, w], friction: 0.3}]\n"
        "loads: [{instance: b, surface: x_max, pressure: 1}, {instance: b, surface: x_max, moment: "
        "[1, 0, 0], history: {time: [0, 1], value: [0, 1]}}]\n"
        "time: {static: true, end: 1, step: 0.25}\noutput: {every: 0.25}\n");
    EXPECT_SAYS(ran.result.failure,
                "it turns without end: it slides in contact b.x_min - w, "
                "where friction is at its limit at every point off the axis")
        << as;
  }
}

// A block is pressed half a face deep onto the edge of another in one step: points open and close.
// In four steps it has its equilibrium.
TEST(StaticsWithoutEnd, NameInstancePairLoadStepAndPoints) {
  SceneFolder folder;
  folder.add("coarse.exo", test::block_mesh({{2, 2, 2}, {1, 1, 1}}));
  folder.add("fine.exo", test::block_mesh({{3, 3, 3}, {1, 1, 1}}));
  const auto press = [&](const std::string& step) {
    return folder.run(
        "materials: {m: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}\n"
        "components: {coarse: {mesh: coarse.exo, material: m}, fine: {mesh: fine.exo, material: "
        "m}}\n"
        "instances: {below: {component: fine, as: mesh, rotation: [0, 45, 0]}, above: {component: "
        "coarse, as: mesh, position: [0.1, 0.2, 0.75]}}\n"
        "boundary: [{instance: below, nodes: z_min, fix: [x, y, z]}, {instance: above, nodes: "
        "z_max, "
        "fix: [x, y, z], displacement: [0, 0, -0.45], history: {time: [0, 1], value: [0, 1]}}]\n"
        "contact: all\n"
        "time: {static: true, end: 1, step: " +
        step + "}\noutput: {every: " + step + "}\n");
  };
  const Ran ran = press("1");
  for (const std::string part : {"load step to t = 1: no equilibrium in 100 iterations",
                                 "most in instance '", "in contact below.all - above.all ",
                                 " points still open or close, at [", "take smaller load steps"})
    EXPECT_SAYS(ran.result.failure, part);
  EXPECT_EQ(ran.result.time.size(), 1U);
  EXPECT_EQ(ran.result.ended_at, 0);
  EXPECT_EQ(press("0.25").result.failure, "");
}

// A row of cubes bends as one bar of the same elements: a tied scene is linear, whatever is soft in
// it. It is free at both ends in the second half.
TEST(StaticsOfTies, MakeOneBarOfCubes) {
  for (const Index n : {12, 30}) {
    SceneFolder folder;
    const double length = 4.0 * static_cast<double>(n);
    folder.add("cube.exo", test::block_mesh({{2, 2, 2}, {4, 4, 4}}));
    folder.add("bar.exo", test::block_mesh({{2 * n, 2, 2}, {length, 4, 4}}));
    const auto run = [&](const std::string& kind, Index parts, bool is_free) {
      const std::string name = "c" + std::to_string(parts - 1);
      std::string text =
          "materials: {m: {youngs_modulus: 2.1e5, poissons_ratio: 0.3, density: 7.85e-9}}\n"
          "components: {part: {mesh: " +
          std::string(parts > 1 ? "cube" : "bar") + ".exo, material: m" +
          (kind == "mesh" ? "" : ", reduction: {interface: [x_min, x_max], basis: " + kind + "}") +
          "}}\ninstances:\n";
      for (Index i = 0; i < parts; ++i)
        text += "  c" + std::to_string(i) +
                ": {component: part, as: " + (kind == "mesh" ? "mesh" : "superelement") +
                ", position: [" + std::to_string(4 * i) + ", 0, 0]}\n";
      if (is_free) {
        text += "loads: [{instance: c0, surface: x_min, force: [-1, 0, 0]}, {instance: " + name +
                ", surface: x_max, force: [1, 0, 0]}]\n";
      } else {
        text +=
            "boundary: [{instance: c0, nodes: x_min, fix: [x, y, z]}]\nloads: [{instance: " + name +
            ", surface: x_max, force: [0, 0, 1]}]\n";
      }
      if (parts > 1) text += "contact:\n";
      for (Index i = 0; i + 1 < parts; ++i)
        text += "  - {between: [c" + std::to_string(i) + ".x_max, c" + std::to_string(i + 1) +
                ".x_min], tied: true}\n";
      return folder.run(text +
                        "time: {static: true, end: 1, step: 1}\noutput: {history: [c0.x_min, " +
                        name + ".x_max]}\n");
    };
    for (const bool is_free : {false, true}) {
      const auto moved = [&](const Ran& ran, Index parts) {
        const auto of = [&](const std::string& name) {
          const auto& x = ran.monitor(name).mean_position;
          return Vector3(at(x, 1) - at(x, 0));
        };
        return Vector3(of("c" + std::to_string(parts - 1) + ".x_max") - of("c0.x_min"));
      };
      const Vector3 bar = moved(run("mesh", 1, is_free), 1);
      for (const std::string kind : {"mesh", "craig-bampton, modes: 4"}) {
        const Ran ran = run(kind, n, is_free);
        EXPECT_LT((moved(ran, n) - bar).norm(), 1e-8 * bar.norm()) << kind << " " << n << is_free;
        for (const RunResult::OfPair& pair : ran.result.pairs)
          EXPECT_NEAR(last(pair["force"], is_free ? 0 : 2), 1, 1e-9) << kind;
      }
    }
  }
}

// Two thin plates, pressed together by two small blocks that pull each other: what is small and
// stiff between what is soft is held by contact and friction alone.
TEST(StaticsOfBolts, ClampAJointOfPlates) {
  SceneFolder folder;
  folder.add("plate.exo", test::block_mesh({{10, 4, 2}, {80, 30, 4}}));
  folder.add("fine.exo", test::block_mesh({{14, 5, 2}, {80, 30, 4}}));
  folder.add("bolt.exo", test::block_mesh({{3, 3, 2}, {10, 10, 5}}));
  const auto reduction = [](const std::string& kind, const std::string& faces) {
    return kind == "mesh" ? "" : ", reduction: {basis: " + kind + ", interface: [" + faces + "]}";
  };
  for (const std::string formulation : {"node-face", "mortar"}) {
    for (const std::string kind : {"mesh", "craig-bampton, modes: 5", "massless, modes: 5"}) {
      for (const std::string other : {"plate", "fine"}) {
        const std::string as = kind == "mesh" ? "mesh" : "superelement",
                          plate = reduction(kind, "z_min, z_max, x_min, x_max");
        const std::string text =
            "materials: {m: {youngs_modulus: 2.1e5, poissons_ratio: 0.3, density: 7.85e-9}}\n"
            "components:\n  plate: {mesh: plate.exo, material: m" +
            plate + "}\n  fine: {mesh: fine.exo, material: m" + plate +
            "}\n  bolt: {mesh: bolt.exo, material: m" + reduction(kind, "z_min, z_max") +
            "}\ninstances:\n  lower: {component: plate, as: " + as +
            "}\n  upper: {component: " + other + ", as: " + as +
            ", position: [50, 0, 4]}\n  head: {component: bolt, as: " + as +
            ", position: [60, 10, 8]}\n  nut: {component: bolt, as: " + as +
            ", position: [60, 10, -5]}\n"
            "boundary: [{instance: lower, nodes: x_min, fix: [x, y, z]}]\n"
            "loads: [{instance: upper, surface: x_max, force: [100, 0, 0]}]\n"
            "contact:\n  - {between: [head.z_min, nut.z_max], adjust: 9, pretension: {force: "
            "5000}}\n"
            "  - {between: [upper.z_min, lower.z_max], friction: 0.2, formulation: " +
            formulation +
            "}\n  - {between: [head.z_min, upper.z_max], friction: 0.2, formulation: " +
            formulation +
            "}\n  - {between: [nut.z_max, lower.z_min], friction: 0.2, formulation: " +
            formulation +
            "}\ntime: {static: true, end: 1, step: 0.5}\noutput: {history: [upper.x_max]}\n";
        const std::string where = formulation + " " + kind + " " + other;
        const Ran ran = folder.run(text);
        EXPECT_EQ(ran.result.failure, "") << where;
        ASSERT_EQ(ran.result.time.size(), 3U) << where;
        const auto force = [&](std::size_t pair, std::size_t i) {
          return at(ran.result.pairs[pair]["force"], i);
        };
        EXPECT_NEAR(-force(0, 0)[2], 5000, 5) << where;
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_LT((force(0, i) + force(2, i)).norm(), 1e-6) << where;
          EXPECT_LT((force(0, i) - force(3, i)).norm(), 1e-6) << where;
          const Vector3 load(50.0 * static_cast<double>(i), 0, 0);
          EXPECT_LT((force(1, i) - force(2, i) + load).norm(), 1e-6) << where;
          EXPECT_LT((at(ran.body("lower").reaction, i) + load).norm(), 1e-6) << where;
        }
        EXPECT_LT(test::energy_residual(ran.result), 1e-8) << where;
      }
    }
  }
}

// Eccentric, on meshes that do not match: nothing holds it, or the mean motion of a face is held.
TEST(StaticsOfBolts, ClampAFreeJoint) {
  SceneFolder folder;
  folder.add("low.exo", test::block_mesh({{9, 8, 2}, {34, 32, 4}}));
  folder.add("up.exo", test::block_mesh({{7, 6, 2}, {30, 30, 4}}));
  folder.add("head.exo", test::block_mesh({{4, 4, 2}, {10, 10, 5}}));
  folder.add("shank.exo", test::block_mesh({{3, 3, 6}, {5, 5, 8}}));
  for (const std::string as : {"mesh", "superelement"}) {
    for (const std::string friction : {"0.3", "0.05"}) {
      const auto run = [&](bool is_held) {
        std::string text =
            "materials: {m: {youngs_modulus: 2.1e5, poissons_ratio: 0.3, density: 7.85e-9}}\n"
            "components:\n";
        for (const std::string part : {"low", "up", "head", "shank"})
          text += "  " + part + ": {mesh: " + part +
                  ".exo, material: m, points: {p: {surface: z_max, coupling: average}}, reduction: "
                  "{interface: [z_min, z_max], modes: 5}}\n";
        text += "instances:\n  low: {component: low, as: " + as +
                "}\n  up: {component: up, as: " + as +
                ", position: [2, 1, 4]}\n  head: {component: head, as: " + as +
                ", position: [11, 12, 8]}\n  shank: {component: shank, as: " + as +
                ", position: [14, 14, 0]}\n  nut: {component: head, as: " + as +
                ", position: [12, 11, -5]}\ncontact:\n"
                "  - {between: [shank.z_max, head.z_min], pretension: {force: 20000}}\n"
                "  - {between: [shank.z_min, nut.z_max], tied: true}\n";
        for (const std::string pair :
             {"up.z_min, low.z_max", "head.z_min, up.z_max", "nut.z_max, low.z_min"})
          text += "  - {between: [" + pair + "], friction: " + friction + "}\n";
        if (is_held) text += "links: [{between: [low.p, ground]}]\n";
        return folder.run(text + "time: {static: true, end: 1, step: 1}\noutput: {}\n");
      };
      const Ran held = run(true), free = run(false);
      const std::string where = as + " " + friction;
      EXPECT_EQ(held.result.failure + free.result.failure, "") << where;
      EXPECT_NEAR(free.result.total.back(), held.result.total.back(),
                  1e-6 * held.result.total.back())
          << where;
      for (std::size_t pair = 0; pair < free.result.pairs.size(); ++pair)
        EXPECT_LT(
            (at(free.result.pairs[pair]["force"], 1) - at(held.result.pairs[pair]["force"], 1))
                .norm(),
            1e-5 * 20000)
            << where << " " << pair;
    }
  }
}

// Two bars between fixed ends that are too long by 0.02: as meshed, or by a length in the scene.
TEST_P(Statics, AnInterferenceFitIsPressedTogether) {
  const std::vector<std::pair<double, std::string>> fits{{0.98, "overlap: resolve"},
                                                         {1, "interference: 0.02"},
                                                         {1.003, "interference: 0.02"},
                                                         {1.005, "interference: 0.025, adjust: 0"}};
  for (const std::string formulation : {"node-face", "mortar"}) {
    for (const auto& [place, key] : fits) {
      const std::string where = formulation + " " + key;
      Bars bars{.kind = GetParam(), .history = "[a.x_max]"};
      bars.instances = instance(bars, "a", 0) + instance(bars, "b", place);
      bars.boundary =
          "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n"
          "  - {instance: b, nodes: x_max, fix: [x, y, z]}\n";
      bars.contact =
          "  - {between: [a.x_max, b.x_min], " + key + ", formulation: " + formulation + "}\n";
      const Ran ran = folder.run(yaml(bars));
      EXPECT_NEAR(at(ran.result.pairs[0]["force"], 0)[0], -0.02 * EA / 2, 1e-9) << where;
      EXPECT_NEAR(last(ran.result.pairs[0]["force"]), -0.02 * EA / 2, 1e-9) << where;
      EXPECT_NEAR(last(ran.monitor("a.x_max").mean_position), 0.99, 1e-9) << where;
      Report report("test", Verbosity::quiet);
      warn_of_initial_overlaps(ran.built, report);
      EXPECT_EQ(report.n_warnings(), 0) << where;
    }
  }
}

// A bar is pushed towards another: the first 0.02 of the approach are free.
TEST_P(Statics, AClearanceIsFree) {
  for (const std::string formulation : {"node-face", "mortar"}) {
    Bars bars{.kind = GetParam(), .history = "[a.x_max]"};
    bars.instances = instance(bars, "a", 0) + instance(bars, "b", 1);
    bars.boundary =
        "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n"
        "  - {instance: b, nodes: x_max, fix: [x, y, z]}\n";
    const double load = 0.06 * EA;
    bars.loads = "  - {instance: a, surface: x_max, force: [" + test::text(load) + ", 0, 0]}\n";
    bars.contact =
        "  - {between: [a.x_max, b.x_min], interference: -0.02, formulation: " + formulation +
        "}\n";
    const Ran ran = folder.run(yaml(bars));
    EXPECT_NEAR(last(ran.result.pairs[0]["force"]), -(load - 0.02 * EA) / 2, 1e-9) << formulation;
    EXPECT_NEAR(last(ran.monitor("a.x_max").mean_position), 1.04, 1e-9) << formulation;
  }
}

// A bar that is cut and pulled together between fixed ends, then loaded at the cut: its length is
// locked.
TEST_P(Statics, ABoltIsPulledTogetherAndLocked) {
  for (const std::string pretension : {"force: 0.1", "shortening: 0.1"}) {
    Bars bars{.kind = GetParam(), .history = "[a.x_max, b.x_min]"};
    bars.instances = instance(bars, "a", 0) + instance(bars, "b", 1);
    bars.boundary =
        "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n  - {instance: b, nodes: x_max, fix: [x, "
        "y, z]}\n";
    bars.loads = "  - {instance: a, surface: x_max, force: [0.04, 0, 0]}\n";
    bars.contact = "  - {between: [a.x_max, b.x_min], pretension: {" + pretension + "}}\n";
    const Ran ran = folder.run(yaml(bars));
    // On a: a pull along +x; of a shortening d the pull is d E A / 2
    EXPECT_NEAR(at(ran.result.pairs[0]["force"], 0)[0], 0.1, 1e-8) << pretension;
    const double apart =
        last(ran.monitor("a.x_max").mean_position) - last(ran.monitor("b.x_min").mean_position);
    EXPECT_NEAR(apart, 0.1 * 2 / EA, 1e-8);  // pulled through each other
    // The load goes half into either bar
    EXPECT_NEAR(last(ran.result.pairs[0]["force"]), 0.1 - 0.02, 1e-8);
    EXPECT_NEAR(last(ran.monitor("a.x_max").mean_position), 1 + (0.1 + 0.02) / EA, 1e-8);
  }
}

// A run that goes on from between two load steps is byte for byte the one that was not stopped.
TEST_P(Statics, RestartsGoOnBitForBit) {
  Bars bars{.kind = GetParam(), .history = "[a.x_max]"};
  bars.instances = instance(bars, "a", 0) + instance(bars, "b", 1);
  bars.boundary =
      "  - {instance: a, nodes: x_min, fix: [x, y, z]}\n  - {instance: b, nodes: x_max, fix: [x, "
      "y, z]}\n";
  bars.loads = "  - {instance: a, surface: x_max, force: [0.04, 0.01, 0]}\n";
  bars.contact = "  - {between: [a.x_max, b.x_min], pretension: {force: 0.1}}\n";
  test::expect_same_bits(test::restarted(folder, yaml(bars), 0));
}

// A bar is pressed against a wall by a force, and stays as it is when time begins.
TEST_P(Statics, MotionBeginsInEquilibrium) {
  for (const std::string integrator : {"exact", "central-difference", "newmark"}) {
    if (integrator == "newmark" && GetParam().starts_with("massless")) continue;
    Bars bars{.kind = GetParam(), .history = "[a.x_min, a.x_max]"};
    bars.instances = instance(bars, "a", 0);
    bars.loads = "  - {instance: a, surface: x_max, force: [-0.1, 0.01, 0]}\n";
    bars.walls = "  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n";
    bars.contact = "  - {between: [a.x_min, floor], friction: 0.9}\n";
    bars.time = "end: 2, preload: 2, integrator: " + integrator +
                (integrator == "newmark" ? ", step: 0.05" : "");
    bars.extra = ", every: 0.25";
    const Ran ran = folder.run(yaml(bars));
    const auto& x = ran.monitor("a.x_max").mean_position;
    if (!is_of_shapes(GetParam())) {
      EXPECT_NEAR(at(x, 0)[0], 1 - 0.1 / EA, 1e-8) << integrator;
    }
    for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
      EXPECT_LT((at(x, i) - at(x, 0)).norm(), 1e-8) << integrator << " " << i;
      EXPECT_NEAR(at(ran.result.pairs[0]["force"], i)[0], 0.1, 1e-7) << integrator;
      EXPECT_NEAR(at(ran.result.pairs[0]["force"], i)[1], -0.01, 1e-7) << integrator;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Statics, ::testing::ValuesIn(kinds), [](const auto& of) {
  return of.param.substr(0, of.param.find_first_of("-,"));
});

// A block of rubber in units of steel: the cause is the load, and not that friction is too weak.
TEST(StaticsOfSoftBlocks, LoadsFarBeyondTheStiffnessAreNamed) {
  SceneFolder soft;
  soft.add("block.exo", test::block_mesh({{2, 2, 2}, {1, 1, 1}}));
  const std::string failure =
      refusal(soft,
              "materials: {m: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}\n"
              "components: {c: {mesh: block.exo, material: m}}\ninstances:\n"
              "  a: {component: c, as: mesh}\n  b: {component: c, as: mesh, position: [0, 0, 1]}\n"
              "boundary: [{instance: a, nodes: z_min, fix: [x, y, z]}]\n"
              "contact: [{between: [b.z_min, a.z_max], friction: 0.5}]\n"
              "loads: [{instance: b, surface: z_max, pressure: 1000}]\n"
              "time: {static: true, end: 1, step: 1}\noutput: {every: 1}\n");
  EXPECT_SAYS(failure, "'b' is not held", "times its size: look at the units");
}

}  // namespace
}  // namespace cbr::equilibrium_test
