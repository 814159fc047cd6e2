// SPDX-License-Identifier: GPL-3.0-or-later
// What cbr-dyn says before, during and after a run, and of scenes that can hardly be meant.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "common/base/error.hpp"
#include "dynamics/output/summary/summary.hpp"
#include "dynamics/program.hpp"
#include "reducer/command.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/support/shelled_scene.hpp"

namespace cbr::test::summary_test {
namespace {

class Summary : public ::testing::Test {
 protected:
  Summary() { folder_.add("block.exo", block_mesh({{3, 2, 2}, Vector3(1, 0.5, 0.5)})); }

  // All that cbr-dyn prints.
  std::string said(const std::string& scene, Verbosity verbosity = Verbosity::normal) {
    const auto file = folder_.folder() / "scene.yaml";
    std::ofstream(file)
        << "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n"
           "components: {block: {"
        << component_ << "}}\n"
        << scene;
    ReduceCommand command;
    command.input = file.string();
    Report quiet("cbr-reduce", Verbosity::quiet);
    testing::internal::CaptureStderr();
    run_reduce(command, nullptr, quiet);
    testing::internal::GetCapturedStderr();
    testing::internal::CaptureStderr();
    Report report("cbr-dyn", verbosity);
    try {
      run_scene(file.string(), folder_.folder() / "r.h5", report);
    } catch (const RunError& error) {
      return testing::internal::GetCapturedStderr() + error.what();
    }
    return testing::internal::GetCapturedStderr();
  }

  static std::string instances(const std::string& as, const std::string& right) {
    return "instances:\n  left: {component: block, as: " + as +
           "}\n  right: {component: block, as: " + as + ", " + right + "}\n";
  }

  SceneFolder folder_;
  std::string component_ =
      "mesh: block.exo, material: soft, mass: consistent, reduction: {interface: [x_min, x_max], "
      "modes: 6}";
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Summary, SaysBeforeTheStepsWhatIsToBeDone) {
  const std::string text = said(instances("mesh", "position: [1.5, 0, 0]") +
                                "time: {end: 0.01, step: 1.0e-4}\noutput: {every: 0.001}\n");
  EXPECT_TRUE(has(text, "steps: 100 of 0.0001 s to t = 0.01 s, 216 dofs in 2 instances")) << text;
  EXPECT_LT(text.find("steps: 100"), text.find("energy: ")) << text;
  EXPECT_LT(text.find("instances left, right: component block, "), text.find("steps: 100")) << text;
}

TEST_F(Summary, CountsAllLoadStepsOfStatics) {
  const std::string scene = instances("mesh", "position: [1.5, 0, 0]") +
                            "boundary: [{instance: left, nodes: x_min, fix: [x, y, z]}, "
                            "{instance: right, nodes: x_min, fix: [x, y, z]}]\n";
  EXPECT_TRUE(has(said(scene + "time: {static: true, end: 1, step: 0.5}\n"),
                  "\nload steps: 3, from t = 0 every 0.5 s to t = 1 s, 162 dofs in 2 instances\n"));
  EXPECT_TRUE(has(said(scene + "time: {static: true, preload: 4, end: 1, step: 0.5}\n"),
                  "\nload steps: 7 (4 before t = 0), from t = 0 every 0.5 s to t = 1 s, 162"));
}

// Without forces at the end: nothing elastic changes while a body still leaves the other.
TEST_F(Summary, FreeBodiesLeaveTheirOverlapWithoutAWarning) {
  for (const std::string as : {"mesh", "superelement"})
    for (const std::string place : {"0, 0", "0.1, 0.05", "0.2, 0.1"}) {
      const std::string scene =
          instances(as, "position: [0.96, " + place + "]") +
          "contact: [{between: [left.x_max, right.x_min], overlap: resolve}]\n";
      for (const std::string time : {"static: true, end: 1, step: 1", "end: 0.01"}) {
        const std::string text = said(scene + "time: {" + time + "}\n");
        EXPECT_TRUE(has(text, "; initial overlap 0.04")) << text;
        EXPECT_FALSE(has(text, "cbr-dyn: warning: contact")) << text;
        EXPECT_FALSE(has(text, "does not close")) << text;
      }
    }
}

// Shells have one side each. With contact of all, a surface behind the other is no overlap.
TEST_F(Summary, WarnsOfShellsThatFaceAway) {
  folder_.add("plate.exo", shelled::plate(Faces::quads, 4, 4, 1, 1));
  component_ = "mesh: plate.exo, material: soft, blocks: {plate: {thickness: 0.01}}";
  const auto warned = [&](const std::string& height, bool reversed) {
    const std::string down = "rotation: [180, 0, 0]", beside = "position: [0, 1, ",
                      text = said("instances:\n  left: {component: block, as: mesh" +
                                  (reversed ? ", " + down + ", " + beside + "0]" : "") +
                                  "}\n  right: {component: block, as: mesh, " +
                                  (reversed ? "position: [0, 0, " : down + ", " + beside) + height +
                                  "]}\ncontact: all\ntime: {end: 1.0e-3}\n");
    EXPECT_FALSE(has(text, "overlap by")) << text;
    return has(text, ": the surfaces face away from each other");
  };
  for (const std::string height : {"0.1", "1"}) {
    EXPECT_TRUE(warned(height, true)) << height;
    EXPECT_FALSE(warned(height, false)) << height;
  }
}

// Of basis characteristic; nobody reduces such a file again when the scene changes.
TEST_F(Summary, AFileAloneThatWasMadeForLessIsWarnedOf) {
  const auto file = folder_.folder() / "alone.yaml";
  const std::string materials =
      "materials: {soft: {youngs_modulus: 1.0e4, poissons_ratio: 0.25, density: 1}}\n";
  std::string output;
  const auto warned = [&](const std::string& loads, const std::string& components, bool reduces) {
    std::ofstream(file) << materials << "components: {block: {" << components
                        << "}}\ninstances: {b: {component: block}}\nloads: [" << loads
                        << "]\ntime: {end: 1.0e-3}\n"
                        << output;
    Report report("cbr-dyn", Verbosity::quiet);
    ReduceCommand command;
    command.input = file.string();
    if (reduces)
      run_reduce(command, nullptr, report);
    else
      run_scene(file.string(), folder_.folder() / "r.h5", report);
    return join(report.warnings());
  };
  const std::string load = "{instance: b, surface: x_max, traction: [1, 0, 0]}",
                    mesh =
                        "mesh: block.exo, material: soft, reduction: {basis: characteristic, "
                        "interface: [x_min, x_max], modes: 6, superelement: alone.cbr.h5}",
                    alone = "superelement: alone.cbr.h5", words = "was not made for ";
  warned("", mesh, true);
  const std::string text = warned(load, alone, false);
  EXPECT_TRUE(has(text, words + "x_max (forces)")) << text;
  EXPECT_FALSE(has(warned("", alone, false), words));
  warned(load, mesh, true);
  EXPECT_FALSE(has(warned(load, alone, false), words));
  EXPECT_FALSE(has(warned("", mesh, false), "stale"));  // made for more: it is taken
  // A new history does not make a file stale; the cure is named once
  output = "output: {history: [b.x_min]}\n";
  const std::string told = warned(load, mesh, false);
  EXPECT_TRUE(has(told, words + "x_min (history), where it moves too little: run cbr-reduce"));
  EXPECT_EQ(told.find(words), told.rfind(words)) << told;
  warned(load, mesh, true);
  EXPECT_FALSE(has(warned(load, mesh, false), words));
}

TEST_F(Summary, StaticsBeyondSmallStrainsAreWarnedOf) {
  const auto statics = [&](const std::string& as, double traction) {
    return said("instances: {b: {component: block, as: " + as +
                "}}\nboundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\n"
                "loads: [{instance: b, surface: x_max, traction: [" +
                text(traction) +
                ", 0, 0], history: {time: [0, 1], value: [0, 1]}}]\n"
                "time: {static: true, end: 1}\n");
  };
  for (const char* as : {"mesh", "superelement"}) {
    // 1 % of strain, and 1.5 times the length
    const std::string small = statics(as, 100), large = statics(as, 15000);
    EXPECT_FALSE(has(small, "is strained by")) << small;
    EXPECT_FALSE(has(small, "times its size")) << small;
    EXPECT_TRUE(has(large, "instance 'b' is strained by ")) << large;
    EXPECT_TRUE(has(large, "instance 'b' deforms by 1.")) << large;
    EXPECT_TRUE(has(large, "in another unit?")) << large;
  }
}

// Nodes that are held swing between the ends of steps, which is energy on paper until they are let
// go.
TEST_F(Summary, APressedBlockHasNoEnergyFromContact) {
  const std::string text = said(
      "instances: {b: {component: block}}\n"
      "walls: {w: {plane: {point: [1, 0, 0], normal: [-1, 0, 0]}}}\n"
      "contact: [{between: [b.x_max, w]}]\n"
      "loads: [{gravity: [500, 0, 0], history: {time: [0, 0.05], value: [0, 1]}}]\n"
      "time: {end: 0.2}\noutput: {every: 0.002}\n");
  EXPECT_TRUE(has(text, "contact b.x_max - w")) << text;
  EXPECT_FALSE(has(text, "brought energy")) << text;
}

// Its edge slides up a slope in two load steps. In equilibrium normal forces do no work.
TEST_F(Summary, TellsTheErrorOfLoadSteps) {
  const std::string scene =
      "instances:\n  left: {component: block, as: mesh}\n"
      "boundary: [{instance: left, nodes: x_min, fix: [x, y, z]}]\n"
      "walls: {slope: {plane: {point: [1.01, 0, 0], normal: [-1, 0, 0.3]}WHERE}}\n"
      "loads: [{instance: left, surface: x_max, force: [400, 0, 300]}]\n"
      "contact: [{between: [left.x_max, slope]}]\n"
      "time: {static: true, end: 1, step: 0.5}\noutput: {every: 0.5}\n";
  const auto of = [&](const std::string& where) {
    std::string text = scene;
    return said(text.replace(text.find("WHERE"), 5, where));
  };
  const std::string still = of("");
  EXPECT_TRUE(has(still, "% of all, an error of the load steps")) << still;
  const std::string moved =
      of(", displacement: [-0.01, 0, 0], history: {time: [0, 1], value: [0, 1]}");
  EXPECT_FALSE(has(moved, "an error of the load steps")) << moved;
}

TEST_F(Summary, CountersAreDetailsAndFiguresSayWhatIsGood) {
  const std::string scene =
      instances("mesh", "position: [1.01, 0, 0], velocity: [-0.3, 0, 0]") +
      "contact: [{between: [left.x_max, right.x_min]}]\ntime: {end: 0.1}\noutput: {every: 0.01}\n";
  const std::string text = said(scene), all = said(scene, Verbosity::verbose);
  EXPECT_FALSE(has(text, "body steps")) << text;
  EXPECT_TRUE(has(all, "body steps")) << all;
  EXPECT_TRUE(has(text, "the balance closes to ")) << text;
  for (const std::string figure : {"closes to ", "drift ", "largest penetration ", "residual "}) {
    const std::size_t at = text.find(figure);
    ASSERT_NE(at, std::string::npos) << figure;
    EXPECT_LT(text.find("(good: ", at), at + 60) << figure << text;
  }
}

TEST_F(Summary, TellsTheNearestGapOfSurfacesThatNeverTouched) {
  for (const std::string as : {"mesh", "superelement"}) {
    const std::string text =
        said(instances(as, "position: [1.5, 0.1, 0], velocity: [-1, 0, 0]") +
             "walls: {w: {plane: {point: [-0.7, 0, 0], normal: [1, 0, 0]}}}\n"
             "contact: [{between: [left.x_max, right.x_min]}, {between: [left.x_min, w]}]\n"
             "time: {end: 0.3}\noutput: {every: 0.01}\n");
    EXPECT_TRUE(has(text,
                    "contact left.x_max - right.x_min: never touched; the nearest gap at an output "
                    "was 0.2; initial gap 0.5\n"))
        << text;
    EXPECT_TRUE(has(text,
                    "contact left.x_min - w: never touched; the nearest gap at an output was 0.7; "
                    "initial gap 0.7\n"))
        << text;
  }
}

// Mortar sees no faces that look at each other there.
TEST_F(Summary, TellsTheDepthOfAnEdgeInsideAFaceWithMortar) {
  for (const std::string as : {"mesh", "superelement"}) {
    const std::string text = said(
        instances(as, "position: [1.55, 0.1, 0.1], rotation: [0, 0, 80], velocity: [-1, 0, 0]") +
        "contact: [{between: [left.x_max, right.x_min], formulation: mortar}]\n"
        "time: {end: 0.1}\noutput: {every: 0.01}\n");
    EXPECT_TRUE(has(text, "largest penetration 0.0")) << text;
    EXPECT_FALSE(has(text, "never touched")) << text;
  }
}

TEST_F(Summary, TellsTheInitialGapToAWallOfSuperelementsToo) {
  for (const std::string as : {"mesh", "superelement"}) {
    const std::string text =
        said("instances: {left: {component: block, as: " + as + ", velocity: [1, 0, 0]}}\n" +
             "walls: {w: {plane: {point: [1.25, 0, 0], normal: [-1, 0, 0]}}}\n"
             "contact: [{between: [left.x_max, w]}]\ntime: {end: 0.4}\noutput: {every: 0.01}\n");
    EXPECT_TRUE(has(text, "; initial gap 0.25\n")) << text;
    EXPECT_FALSE(has(text, "never touched")) << text;
  }
}

TEST_F(Summary, TellsOverlapBeforeTheRunIsOver) {
  const std::string scene =
      instances("mesh", "position: [0.9, 0, 0]") +
      "contact: [{between: [left.x_max, right.x_min]}]\ntime: {end: 0.1}\noutput: {every: 0.01}\n";
  const std::string text = said(scene);
  EXPECT_TRUE(has(text, "the surfaces overlap by 0.1 at the start")) << text;
  EXPECT_EQ(text.find("overlap by"), text.rfind("overlap by")) << text;
  EXPECT_LT(text.find("overlap by"), text.find("energy: ")) << text;
}

TEST_F(Summary, WarnsOfSurfacesThatFaceAway) {
  const auto warned = [&](const std::string& first, const std::string& second,
                          const std::string& as) {
    const std::string text =
        said(instances(as, "position: [1.2, 0, 0]") + "contact: [{between: [left." + first +
             ", right." + second + "]}]\ntime: {end: 0.01}\noutput: {every: 0.01}\n");
    return has(text, "contact left." + first + " - right." + second +
                         ": the surfaces face away from each other");
  };
  for (const std::string as : {"mesh", "superelement"}) {
    EXPECT_FALSE(warned("x_max", "x_min", as)) << as;
    EXPECT_TRUE(warned("x_min", "x_min", as)) << as;
    EXPECT_TRUE(warned("x_min", "x_max", as)) << as;
  }
  const std::string floor = said(
      "instances: {left: {component: block, as: mesh}}\n"
      "walls: {w: {plane: {point: [-0.1, 0, 0], normal: [1, 0, 0]}}}\n"
      "contact: [{between: [left.x_max, w]}]\ntime: {end: 0.01}\n");
  EXPECT_TRUE(has(floor, "contact left.x_max - w: the surfaces face away from each other"))
      << floor;
}

TEST_F(Summary, WarnsOfPositionsInAnotherUnit) {
  const auto text = [&](const std::string& position, const std::string& velocity,
                        const std::string& as) {
    return said(instances(as, "mirror: x, position: [" + position + ", 0, 0], velocity: [" +
                                  velocity + ", 0, 0]") +
                "contact: [{between: [left.x_max, right.x_max]}]\ntime: {end: 0.01}\noutput: "
                "{every: 0.01}\n");
  };
  const std::string question = "are their positions in the unit of the meshes' coordinates?";
  for (const std::string as : {"mesh", "superelement"}) {
    EXPECT_FALSE(has(text("2.1", "0", as), question)) << as;
    EXPECT_TRUE(has(text("2100", "-3", as), question)) << as;
    EXPECT_FALSE(has(text("2100", "-1.0e5", as), question)) << as;  // fast enough to come near
    // 2.1 mm in metres, mirrored: on one another
    const std::string inside = text("1.0021", "0", as);
    EXPECT_TRUE(has(inside, question)) << inside;
  }
}

TEST_F(Summary, NamesEveryBodyThatTurnsAndWhen) {
  // A force on one end turns a free block, a larger one sooner.
  const std::string text = said(instances("superelement", "position: [3, 0, 0]") +
                                "loads:\n  - {instance: left, surface: x_max, force: [0, 0.5, 0]}\n"
                                "  - {instance: right, surface: x_max, force: [0, 0.1, 0]}\n"
                                "time: {end: 0.5, rotations: small}\noutput: {every: 0.01}\n");
  const auto when = [&](const std::string& name) {
    const std::size_t at = text.find("instance '" + name + "' rotates by ");
    EXPECT_NE(at, std::string::npos) << text;
    const std::string since = "beyond 5 from t = ";
    return at == std::string::npos ? 0.0
                                   : std::stod(text.substr(text.find(since, at) + since.size()));
  };
  // phi = F (L / 2) t^2 / (2 I), I = m (L^2 + b^2) / 12, m = 0.25
  const double inertia = 0.25 * 1.25 / 12;
  const auto expected = [&](double F) {
    return std::sqrt(2 * 5 * 3.14159265 / 180 * inertia / (F / 2));
  };
  EXPECT_NEAR(when("left"), expected(0.5), 0.02);
  EXPECT_NEAR(when("right"), expected(0.1), 0.02);
}

// What stands in the way of large rotations is named, or nothing but they.
TEST_F(Summary, TheCureOfARotationIsOneThatRuns) {
  const auto cure = [&](const std::string& time) {
    return said(instances("superelement", "position: [3, 0, 0]") +
                "loads: [{instance: left, surface: x_max, force: [0, 0.5, 0]}]\n"
                "time: {end: 0.5" +
                time + "}\noutput: {every: 0.01}\n");
  };
  const std::string turns = "time: {rotations: large} turns it by any angle",
                    small = cure(", rotations: small");
  EXPECT_TRUE(has(small, turns + "\n")) << small;
  const std::string newmark = cure(", integrator: newmark, step: 1.0e-3");
  EXPECT_TRUE(has(newmark, "newmark (line 7): take integrator: exact")) << newmark;
}

// Nothing is strained: energies are round-off, and so is what is missing of them.
TEST_F(Summary, RoundOffIsNoEnergyThatIsMissing) {
  for (const std::string as : {"mesh", "superelement"}) {
    Ran ran = folder_.run(
        "materials: {steel: {youngs_modulus: 2.0e11, poissons_ratio: 0.25, density: 7800}}\n"
        "components: {block: {mesh: block.exo, material: steel, reduction: {interface: [x_min, "
        "x_max], modes: 6}}}\n"
        "instances: {b: {component: block, as: " +
        as +
        "}}\n"
        "boundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\n"
        "time: {static: true, end: 1}\n");
    const auto warned = [&](double missing) {
      ran.result.total.back() = missing;
      Report report("cbr-dyn", Verbosity::quiet);
      testing::internal::CaptureStderr();
      summarise(ran.built, ran.result, false, report);
      return has(testing::internal::GetCapturedStderr(), "the energy balance does not close");
    };
    EXPECT_FALSE(warned(1e-26)) << as;
    EXPECT_TRUE(warned(1e-6)) << as;
    ran.result.work_external.back() = 1e-6;
    EXPECT_FALSE(warned(1e-6 * (1 + 1e-9))) << as;
    EXPECT_TRUE(warned(1e-6 * (1 + 1e-7))) << as;
  }
}

}  // namespace
}  // namespace cbr::test::summary_test
