// SPDX-License-Identifier: GPL-3.0-or-later
// `rotations: auto`: a run of linear bodies starts again once one of them has turned too far.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <tuple>

#include "common/files/hdf5_file.hpp"
#include "dynamics/program.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::test::starting_again_test {
namespace {

// A free block and a free bar that damping `alpha` keeps from turning; `force` in y on one end of
// the block.
class StartingAgain : public ::testing::Test {
 protected:
  StartingAgain() { folder_.add("block.exo", block_mesh({{3, 2, 2}, Vector3(1, 0.5, 0.5)})); }

  std::string scene(double force, const std::string& time, const std::string& more = "",
                    const std::string& instance = "") const {
    return "materials:\n"
           "  soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}\n"
           "  braked: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1, damping: {alpha: "
           "0.1}}\n"
           "components:\n"
           "  block: {mesh: block.exo, material: soft}\n"
           "  brake: {mesh: block.exo, material: braked}\n"
           "instances:\n"
           "  b: {component: block" +
           instance + "}\n  c: {component: brake, position: [0, 0, 3]}\n" +
           "loads: [{instance: b, surface: x_max, force: [0, " + text(force) +
           ", 0]}]\ntime: {end: 0.5, step: 2.0e-3" + time + "}\noutput: {every: 0.02" + more +
           "}\n";
  }

  std::string file(const std::string& name) const { return (folder_.folder() / name).string(); }

  // What cbr-dyn prints; results in `name`.h5.
  std::string run(const std::string& name, const std::string& yaml,
                  const std::string& restart = "") const {
    std::ofstream(file("scene.yaml")) << yaml;
    testing::internal::CaptureStderr();
    Report report("cbr-dyn", Verbosity::normal);
    try {
      run_scene(file("scene.yaml"), file(name + ".h5"), report, {}, restart);
    } catch (...) {
      testing::internal::GetCapturedStderr();
      throw;
    }
    return testing::internal::GetCapturedStderr();
  }

  Points center(const std::string& name, const std::string& instance) const {
    return Hdf5Reader(file(name + ".h5")).read_points("/instances/" + instance + "/center_of_mass");
  }
  Vector energy(const std::string& name) const {
    return Hdf5Reader(file(name + ".h5")).read_vector("/energy/total");
  }
  bool turns(const std::string& name, const std::string& instance) const {
    return Hdf5Reader(file(name + ".h5")).has("/instances/" + instance + "/orientation");
  }

  SceneFolder folder_;
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

const std::string again = "the run starts again with bodies that turn";

TEST_F(StartingAgain, ABodyThatTurnsHasTheResultsOfLarge) {
  const std::string said = run("auto", scene(0.5, ""));
  EXPECT_TRUE(has(said, "instance 'b' has turned by ")) << said;
  EXPECT_TRUE(has(said, again)) << said;
  EXPECT_FALSE(has(said, "warning")) << said;
  EXPECT_TRUE(has(said, "linear as ever: c")) << said;
  EXPECT_TRUE(turns("auto", "b"));
  EXPECT_FALSE(turns("auto", "c"));
  // `large` refuses what `auto` leaves linear
  const std::string refusal =
      test::refusal_of([&] { run("large", scene(0.5, ", rotations: large")); });
  EXPECT_TRUE(has(refusal, "'c': large rotation (time.rotations: large) does not go with mass"))
      << refusal;
  const auto alone = [&](const std::string& time) {
    std::string yaml = scene(0.5, time);
    yaml.erase(yaml.find("  c: {"), yaml.find("loads:") - yaml.find("  c: {"));
    return yaml;
  };
  run("auto", alone(""));
  EXPECT_FALSE(has(run("large", alone(", rotations: large")), again));
  EXPECT_EQ(center("auto", "b"), center("large", "b"));
  EXPECT_EQ(energy("auto"), energy("large"));
  EXPECT_TRUE(has(run("small", alone(", rotations: small")), "its motion is no longer right"));
  EXPECT_FALSE(turns("small", "b"));
}

TEST_F(StartingAgain, ABodyThatHardlyTurnsHasTheResultsOfSmall) {
  EXPECT_FALSE(has(run("auto", scene(1e-3, "")), again));
  run("small", scene(1e-3, ", rotations: small"));
  EXPECT_EQ(center("auto", "b"), center("small", "b"));
  EXPECT_EQ(energy("auto"), energy("small"));
  EXPECT_FALSE(turns("auto", "b"));
}

TEST_F(StartingAgain, WhatCannotTurnGoesOnWithAWarning) {
  std::string yaml = scene(0.5, "");
  yaml.replace(yaml.find("instance: b, surface"), 11, "instance: c");
  const std::string said = run("auto", yaml);
  EXPECT_FALSE(has(said, again)) << said;
  EXPECT_TRUE(has(said, "instance 'c' rotates by ")) << said;
  EXPECT_TRUE(has(said, "does not go with mass-proportional damping")) << said;
}

// One output at the end, when the body has long turned back: it is seen in between.
TEST_F(StartingAgain, ATurnBetweenOutputsIsSeen) {
  std::string yaml = scene(0.5, "");
  yaml.replace(yaml.find("every: 0.02"), 11, "every: 0.5");
  yaml.replace(
      yaml.find("]}]\ntime"), 3,
      "], history: {time: [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4], value: [0, 12, 0, "
      "-12, 0, -12, 0, 12, 0]}}]");
  EXPECT_TRUE(has(run("auto", yaml), again));
  EXPECT_TRUE(turns("auto", "b"));
  // The output alone does not tell
  yaml.replace(yaml.find("time: {end"), 7, "time: {rotations: small, ");
  EXPECT_FALSE(has(run("small", yaml), "rotates by"));
}

// Whatever the scene's text or the component tells of one, the others turn.
TEST_F(StartingAgain, AnInstanceThatCannotTurnKeepsNoOtherFromIt) {
  std::string inert = scene(0.5, "");
  inert.replace(inert.find("brake: {mesh: block.exo, material: braked}"), 42,
                "brake: {mesh: block.exo, material: soft, points: {p: {surface: x_max, inertia: "
                "[1, 1, 1]}}}");
  std::string pressed = scene(0.5, "");
  pressed.insert(pressed.find("loads:"),
                 "walls: {w: {plane: {point: [0, 0, -9], normal: [0, 0, 1]}}}\n"
                 "contact: [{between: [c.z_min, w], enforcement: penalty}]\n");
  for (const std::string& yaml : {inert, pressed}) {
    const std::string said = run("auto", yaml);
    EXPECT_TRUE(has(said, again)) << said;
    EXPECT_TRUE(turns("auto", "b"));
    EXPECT_FALSE(turns("auto", "c"));
  }
}

// The weight of what hangs on a hinge sets it upright at any angle, which no linear body knows.
TEST_F(StartingAgain, APendulumTurnsFromTheStart) {
  const std::string yaml =
      "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n"
      "components: {block: {mesh: block.exo, material: soft, points: {top: {surface: z_max, "
      "coupling: "
      "rigid}}}}\n"
      "instances: {b: {component: block, as: rigid}}\n"
      "links: [{between: [b.top, ground], fix: [x, y, z]}]\n"
      "loads: [{gravity: [0, 0, -10]}]\n"
      "time: {end: 0.1, step: 1.0e-3}\noutput: {every: 0.01}\n";
  EXPECT_FALSE(has(run("auto", yaml), again));
  EXPECT_TRUE(turns("auto", "b"));
}

// A column that stands under gravity may lean by a share of its width over its height.
TEST_F(StartingAgain, ATallBodyThatStandsMayTurnByLess) {
  const auto limit = [&](const std::string& rotation, const std::string& loads,
                         const std::string& reduction = "") {
    const Ran ran = folder_.prepare(
        "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n"
        "components: {block: {mesh: block.exo, material: soft" +
        reduction +
        "}}\n"
        "instances: {b: {component: block, rotation: " +
        rotation +
        "}}\n"
        "walls: {w: {plane: {point: [0, 0, -9], normal: [0, 0, 1]}}}\n"
        "contact: [{between: [b.z_min, w]}]\n" +
        loads + "time: {end: 0.1}\n");
    return ran.built.turn_limit.at(0);
  };
  const std::string weight = "loads: [{gravity: [0, 0, -10]}]\n";
  EXPECT_NEAR(limit("[0, 0, 0]", weight), 0.05, 1e-12);    // 0.5 wide and high
  EXPECT_NEAR(limit("[0, 90, 0]", weight), 0.025, 1e-12);  // upright
  EXPECT_NEAR(limit("[0, 90, 0]", ""), small_rotation, 1e-12);
  // Its nodes are a flat face, the body is not
  const std::string of_foot = ", reduction: {interface: [z_min], modes: 4}";
  EXPECT_NEAR(limit("[0, 0, 0]", weight, of_foot), 0.05, 1e-9);
}

TEST_F(StartingAgain, AForceThatCannotBeMeantIsAnError) {
  std::string yaml = scene(1e30, "");
  yaml.replace(yaml.find("step: 2.0e-3"), 12, "step: auto");
  yaml.replace(yaml.find("material: soft}"), 15,
               "material: soft, reduction: {interface: [x_min, x_max], modes: 6}}");
  const std::string message = test::refusal_of<RunError>([&] {
    folder_.prepare(yaml);
    run("auto", yaml);
  });
  EXPECT_TRUE(has(message, "instance 'b' turns by ")) << message;
  EXPECT_TRUE(has(message, "look at the loads and their units")) << message;
}

TEST_F(StartingAgain, AnAngularVelocityTurnsFromTheStart) {
  const std::string spins = ", angular_velocity: [0, 0, 3]";
  EXPECT_FALSE(has(run("auto", scene(0, "", "", spins)), again));
  EXPECT_TRUE(turns("auto", "b"));
  EXPECT_FALSE(turns("auto", "c"));
}

const std::string begins = "the run begins with bodies that turn";

// A block `rotation` above a floor, and a run until `end`.
std::string dropped(const std::string& rotation, double end, const std::string& time = "",
                    const std::string& position = "[0, 0, 0]", const std::string& floor = "0.05") {
  return "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n"
         "components: {block: {mesh: block.exo, material: soft}}\n"
         "instances: {b: {component: block, rotation: " +
         rotation + ", position: " + position +
         ", velocity: [0, 0, -1]}}\n"
         "walls: {w: {plane: {point: [0, 0, -" +
         floor + "], normal: [0, 0, 1]}}}\ncontact: all\nloads: [{gravity: [0, 0, -10]}]\n" +
         "time: {end: " + text(end) + time + "}\noutput: {every: 0.02}\n";
}

// A corner or an edge beside the centre turns it: that saves the first part of a run.
TEST_F(StartingAgain, ABodyThatMeetsAWallBesideItsCentreTurnsFromTheStart) {
  const std::string tilted = "[0, 20, 0]", floor = "0.5";
  const std::string said = run("auto", dropped(tilted, 0.3, "", "[0, 0, 0]", floor));
  EXPECT_TRUE(has(said, "instance 'b' meets the other in contact b.all - w at t = 0.")) << said;
  EXPECT_TRUE(has(said, begins)) << said;
  EXPECT_FALSE(has(said, again)) << said;
  run("large", dropped(tilted, 0.3, ", rotations: large", "[0, 0, 0]", floor));
  EXPECT_EQ(center("auto", "b"), center("large", "b"));
  EXPECT_EQ(energy("auto"), energy("large"));
}

// Neither the weight's history nor other loads are followed: such bodies begin linear.
TEST_F(StartingAgain, ABodyThatOtherLoadsCarryBeginsLinear) {
  const std::string falls = dropped("[0, 20, 0]", 0.3, "", "[0, 0, 0]", "0.5"),
                    gravity = "{gravity: [0, 0, -10]}";
  for (const std::string& loads :
       {std::string("{gravity: [0, 0, -10], history: {time: [0, 1], value: [1, 1]}}"),
        gravity + ", {instance: b, surface: z_max, pressure: 1.0e-9}"}) {
    std::string scene = falls;
    scene.replace(scene.find(gravity), gravity.size(), loads);
    const std::string said = run("auto", scene);
    EXPECT_FALSE(has(said, begins)) << said;
    EXPECT_TRUE(has(said, again)) << said;
  }
}

// A body that lands flat, or hardly tilted, or too late to turn stays linear.
TEST_F(StartingAgain, ABodyThatLandsFlatStaysLinear) {
  for (const auto& [rotation, end, floor] :
       {std::tuple("[0, 0, 0]", 0.1, "0.05"), std::tuple("[0, 0, 30]", 0.1, "0.05"),
        std::tuple("[0, 3, 0]", 0.08, "0.15"), std::tuple("[0, 20, 0]", 0.09, "0.5")}) {
    const std::string said = run("auto", dropped(rotation, end, "", "[0, 0, 0]", floor));
    EXPECT_FALSE(has(said, begins)) << said << rotation;
    run("small", dropped(rotation, end, ", rotations: small", "[0, 0, 0]", floor));
    EXPECT_EQ(center("auto", "b"), center("small", "b")) << rotation;
    EXPECT_EQ(energy("auto"), energy("small")) << rotation;
  }
}

// Two equal blocks: `beside` is how far the second is from the line of the first.
TEST_F(StartingAgain, BodiesThatMeetBesideTheirCentresTurnFromTheStart) {
  const auto two = [&](double beside) {
    return "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n"
           "components: {block: {mesh: block.exo, material: soft}}\n"
           "instances:\n  b: {component: block, velocity: [1, 0, 0]}\n  c: {component: block, "
           "position: [1.05, " +
           text(beside) +
           ", 0]}\ncontact: [{between: [b.x_max, c.x_min]}]\n"
           "time: {end: 0.4}\noutput: {every: 0.02}\n";
  };
  EXPECT_FALSE(has(run("auto", two(0)), begins));
  EXPECT_FALSE(has(run("auto", two(0.2)), begins));
  EXPECT_TRUE(has(run("auto", two(0.4)), begins));
  EXPECT_TRUE(turns("auto", "b"));
  EXPECT_TRUE(turns("auto", "c"));
  EXPECT_FALSE(has(run("auto", two(0.6)), begins));
}

// The checkpoint of a run that has started again is of bodies that turn.
TEST_F(StartingAgain, ACheckpointGoesOnAsItWas) {
  for (const std::string time : {"0.1", "0.4"}) {
    const std::string yaml = scene(0.5, "", ", checkpoint: {every: " + time + ", file: c.h5}");
    run("whole", yaml);
    const std::string said = run("rest", yaml, file("c.h5"));
    EXPECT_TRUE(has(said, "going on from step ")) << said;
    EXPECT_FALSE(has(said, again)) << said;
    EXPECT_EQ(center("whole", "b"), center("rest", "b")) << time;
    EXPECT_EQ(energy("whole"), energy("rest")) << time;
  }
}

}  // namespace
}  // namespace cbr::test::starting_again_test
