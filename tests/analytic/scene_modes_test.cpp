// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn --modes: frequencies and damping ratios of held and free instances, superelements against
// meshes and closed forms.
#include "dynamics/setup/modal/scene_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/setup/modal/modal_scene.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::scene_modes_test {
namespace {

using test::SceneFolder;

class OfScene : public ::testing::Test {
 protected:
  OfScene() {
    folder.add("one.exo", test::block_mesh({{1, 1, 1}, {1, 1, 1}}));
    folder.add("beam.exo", test::block_mesh({{12, 2, 2}, {1, 0.1, 0.1}}));
  }

  std::string scene(const std::string& mesh, const std::string& reduction,
                    const std::string& rest = "", const std::string& instance = "") const {
    return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1, damping: "
           "{alpha: 0.5, beta: 0.001}}\n"
           "components:\n  bar: {mesh: " +
           mesh + ", material: soft, mass: lumped, reduction: {" + reduction +
           "}}\ninstances:\n  reduced: {component: bar, as: superelement" + instance +
           "}\n  full: {component: bar, as: mesh, position: [0, 9, 0]" + instance + "}\n" + rest +
           "time: {end: 0.01}\n";
  }

  std::vector<InstanceModes> modes(const std::string& yaml, Index n) const {
    Report report("test", Verbosity::quiet);
    return std::move(scene_modes(folder.prepare(yaml).scene, n, report).instances);
  }

  SceneFolder folder;
};

const std::string held =
    "boundary:\n  - {instance: reduced, nodes: x_min, fix: [x, y, z]}\n"
    "  - {instance: full, nodes: x_min, fix: [x, y, z]}\n";

// Along x: omega^2 = k / m = E A / L / (rho A L / 2) = 400. Rayleigh's ratio is alpha / (2 omega) +
// beta omega / 2.
TEST_F(OfScene, OneElementIsAnOscillator) {
  for (const InstanceModes& of :
       modes(scene("one.exo", "interface: [x_min, x_max], modes: 0", held), 100)) {
    const Vector omega = 2 * std::numbers::pi * of.frequency_hz;
    EXPECT_EQ(omega.size(), 12) << of.instance;
    EXPECT_LT((omega.array() - 20).abs().minCoeff(), 1e-10) << of.instance;
    for (Index j = 0; j < omega.size(); ++j)
      EXPECT_NEAR(of.damping_ratio[j], 0.25 / omega[j] + 0.0005 * omega[j], 1e-14);
  }
}

// A file has what contact and histories of one surface need; modes, which leave contact out, too.
TEST_F(OfScene, ModesAskForWhatTheRunWasReducedFor) {
  Report report("test", Verbosity::quiet);
  const std::string yaml = scene("beam.exo", "basis: characteristic, interface: [x_max], modes: 8",
                                 "contact: [{between: [reduced.x_max, full.x_min]}]\n") +
                           "output: {history: [reduced.x_max]}\n";
  scene_modes(folder.prepare(yaml).scene, 8, report);
  EXPECT_EQ(join(report.warnings()).find("was not made for"), std::string::npos);
}

// The lowest bending frequencies of a cantilever: 1.875^2 / (2 pi) sqrt(E I / (rho A)) and less, by
// shear.
TEST_F(OfScene, HeldSuperelementsHaveTheFrequenciesOfTheirMesh) {
  for (const char* basis : {"basis: craig-bampton", "basis: massless", "basis: characteristic"}) {
    const auto found = modes(
        scene("beam.exo", std::string(basis) + ", interface: [x_min, x_max], modes: 30", held), 6);
    ASSERT_EQ(found.size(), 2u);
    const Vector &reduced = found[0].frequency_hz, &full = found[1].frequency_hz;
    const double beam = 1.8751 * 1.8751 / (2 * std::numbers::pi) * std::sqrt(200 * 0.01 / 12);
    EXPECT_NEAR(full[0], beam, 0.03 * beam);
    EXPECT_NEAR(full[1], full[0], 1e-8 * beam);  // a square section
    for (Index j = 0; j < 6; ++j)
      EXPECT_NEAR(reduced[j], full[j], 0.01 * full[j]) << basis << " " << j;
  }
}

TEST_F(OfScene, FreeInstancesHaveSixRigidMotions) {
  const auto found = modes(scene("beam.exo", "interface: [x_min, x_max], modes: 297"), 10);
  for (const InstanceModes& of : found) {
    EXPECT_EQ(of.frequency_hz.head(6), Vector::Zero(6)) << of.instance;
    EXPECT_EQ(of.damping_ratio.head(6), Vector::Zero(6));
    EXPECT_GT(of.frequency_hz[6], 0.1);
  }
  for (Index j = 6; j < 10; ++j)
    EXPECT_NEAR(found[0].frequency_hz[j], found[1].frequency_hz[j],
                1e-8 * found[1].frequency_hz[j]);
}

// Six frequencies of a heavy body at the end of a light beam: omega^2 = k / m, with 1e-7 of the
// mass in the beam. They are 1e-11 and less of the beam's own.
TEST_F(OfScene, HeavyPointsHaveLowFrequencies) {
  folder.add("fine.exo", test::block_mesh({{60, 2, 2}, {1, 0.1, 0.1}}));
  const auto found = [&](const std::string& mesh, const std::string& power) {
    const std::string m = "1.0e+" + power;
    return modes(scene(mesh,
                       "interface: [x_min, x_max], modes: 9}, points: {p: {surface: x_max, "
                       "coupling: rigid, mass: " +
                           m + ", inertia: [" + m + ", " + m + ", " + m + "]}",
                       held),
                 8);
  };
  double worst = 0;
  for (const char* mesh : {"beam.exo", "fine.exo"}) {
    const auto light = found(mesh, "5"), heavy = found(mesh, "9");
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_GT(light[i].frequency_hz[6], 1e3 * light[i].frequency_hz[5]);
      for (Index j = 0; j < 6; ++j)
        worst = std::max(worst,
                         std::abs(100 * heavy[i].frequency_hz[j] / light[i].frequency_hz[j] - 1));
    }
  }
  EXPECT_LT(worst, 1e-7);
  std::printf("heavy points: %.1e\n", worst);
}

// Torsion of a free square bar of quadratic hexes, which lumped mass slows by 12 %: half a wave of
// sqrt(G J / (rho I)).
TEST_F(OfScene, QuadraticMeshesHaveConsistentMass) {
  folder.add("hex20.exo", test::box_mesh(ElementType::hex20, {10, 2, 2}, {1, 0.1, 0.1}));
  const auto yaml = [](const std::string& mass) {
    return "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1}}\n"
           "components:\n  bar: {mesh: hex20.exo, material: soft, mass: " +
           mass + "}\ninstances:\n  full: {component: bar, as: mesh}\ntime: {end: 0.01}\n";
  };
  const double torsion = 0.5 * std::sqrt(200 / 2.6 * 0.140577 * 6);
  const auto error = [&](const Vector& found) {
    return (found.array() / torsion - 1).abs().minCoeff();
  };
  EXPECT_LT(error(modes(yaml("auto"), 15)[0].frequency_hz), 0.01);
  EXPECT_GT(error(modes(yaml("lumped"), 15)[0].frequency_hz), 0.1);
}

TEST_F(OfScene, OpenContactIsLeftOut) {
  const std::string reduction = "interface: [x_min, x_max, y_min, y_max], modes: 0";
  const auto with = modes(
      scene("one.exo", reduction, "contact:\n  - {between: [reduced.y_max, full.y_min]}\n"), 3);
  const auto without = modes(scene("one.exo", reduction), 3);
  ASSERT_EQ(with.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(with[i].frequency_hz, without[i].frequency_hz);
}

// Two halves that are tied node by node are the whole: free and held, superelements with all of
// their modes, meshes in all of theirs or, where `fine`, in all of their dofs.
struct Kinds {
  std::string name, a, b;
  bool fine = false;
};

class Halves : public OfScene, public ::testing::WithParamInterface<Kinds> {
 protected:
  static constexpr const char* material =
      "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1, damping: {alpha: "
      "0.5, beta: 0.001}}}\n";
  // a and b, and what follows the instances
  std::string halves(const std::string& rest) const {
    const Kinds& of = GetParam();
    return std::string(material) +
           "components:\n  half: {mesh: half.exo, material: soft, mass: lumped, reduction: "
           "{interface: [x_min, x_max], modes: 135}}\n  whole: {mesh: whole.exo, material: soft, "
           "mass: lumped}\ninstances:\n  a: {component: half, as: " +
           of.a + "}\n  b: {component: half, as: " + of.b + ", position: [0.5, 0, 0]}\n" + rest +
           "time:\n  end: 1\n";
  }
  void SetUp() override {
    const bool fine = GetParam().fine;
    const std::array<Index, 3> half =
        fine ? std::array<Index, 3>{10, 6, 6} : std::array<Index, 3>{6, 2, 2};
    folder.add("half.exo", test::block_mesh({half, {0.5, 0.1, 0.1}}));
    folder.add("whole.exo", test::block_mesh({{2 * half[0], half[1], half[2]}, {1, 0.1, 0.1}}));
  }
};

TEST_P(Halves, TiedTogetherAreTheWhole) {
  for (const std::string& boundary :
       {std::string(), std::string("boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}, "
                                   "{instance: whole, nodes: x_min, fix: [x, y, z]}]\n")}) {
    const auto found = modes(halves("  whole: {component: whole, as: mesh, position: [0, 9, 0]}\n"
                                    "contact: [{between: [a.x_max, b.x_min], tied: true}]\n" +
                                    boundary),
                             12);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].instance, "a+b");
    EXPECT_EQ(found[1].instance, "whole");
    const double scale = found[1].frequency_hz[11], bound = 1e-8;
    double worst = 0;
    for (Index j = 0; j < 12; ++j) {
      worst =
          std::max(worst, std::abs(found[0].frequency_hz[j] - found[1].frequency_hz[j]) / scale);
      EXPECT_NEAR(found[0].frequency_hz[j], found[1].frequency_hz[j], bound * scale) << j;
      EXPECT_NEAR(found[0].damping_ratio[j], found[1].damping_ratio[j], bound) << j;
    }
    std::printf("%s, %s: largest error %.2g of the highest frequency\n", GetParam().name.c_str(),
                boundary.empty() ? "free" : "held", worst);
  }
}

// Pressed together they are the whole as long as friction holds them. Without it one slides on the
// other: they bend more softly, and move along the axis as the whole.
TEST_P(Halves, PressedTogetherAreTheWhole) {
  const auto pressed = [&](const std::string& law) {
    std::string boundary;
    for (const char* held :
         {"a, nodes: x_min, fix: [x, y, z]", "b, nodes: x_max, fix: [y, z]",
          "whole, nodes: x_min, fix: [x, y, z]", "whole, nodes: x_max, fix: [y, z]"})
      boundary += std::string("  - {instance: ") + held + "}\n";
    return modes(halves("  whole: {component: whole, as: mesh, position: [0, 9, 0]}\n"
                        "contact: [{between: [a.x_max, b.x_min]" +
                        law +
                        "}]\nloads: [{instance: b, surface: x_max, force: [-1.0e-3, 0, 0]}]\n"
                        "boundary:\n" +
                        boundary) +
                     "  preload: 1\n",
                 15);
  };
  const auto sticks = pressed(", friction: 0.3"), slides = pressed("");
  ASSERT_EQ(sticks.size(), 2u);
  EXPECT_EQ(sticks[0].instance, "a+b");
  const Vector &stuck = sticks[0].frequency_hz, &whole = sticks[1].frequency_hz,
               &loose = slides[0].frequency_hz;
  EXPECT_LT((stuck - whole).cwiseAbs().maxCoeff(), 1e-8 * whole[14]);
  EXPECT_LT(loose[0], 0.9 * whole[0]);
  EXPECT_GT(loose[0], 0);
  const double along = 0.25 * std::sqrt(200.0);
  const auto error = [&](const Vector& hz) { return (hz.array() / along - 1).abs().minCoeff(); };
  EXPECT_LT(error(whole), 0.02);
  EXPECT_NEAR(error(loose), error(whole), 2e-3);
}

// Meshes as superelements, where ties do not match node by node, or springs join points, one of
// them rigid with a mass. Dashpots damp both alike.
TEST_P(Halves, JoinedByOtherMeansAreAsSuperelements) {
  const Kinds& of = GetParam();
  folder.add("coarse.exo", test::block_mesh({{6, 1, 1}, {0.5, 0.1, 0.1}}));
  const auto joined = [&](const std::string& a, const std::string& b, const std::string& joint) {
    return modes(
        std::string(material) +
            "components:\n  half: {mesh: half.exo, material: soft, mass: lumped, points: {tip: "
            "{surface: x_max, coupling: rigid, mass: 0.01, inertia: [1.0e-5, 1.0e-5, 1.0e-5]}}, "
            "reduction: {interface: [x_min, x_max], modes: 135}}\n"
            "  coarse: {mesh: coarse.exo, material: soft, mass: lumped, points: {root: {surface: "
            "x_min}}, reduction: {interface: [x_min, x_max], modes: 60}}\ninstances:\n  a: "
            "{component: half, as: " +
            a + "}\n  b: {component: coarse, as: " + b + ", position: [0.5, 0, 0]}\n" + joint +
            "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\ntime: {end: 1}\n",
        8);
  };
  for (const std::string& joint :
       {std::string("contact: [{between: [a.x_max, b.x_min], tied: true}]\n"),
        std::string("links: [{between: [a.tip, b.root]}]\n"),
        std::string("links: [{between: [a.tip, b.root], stiffness: [30, 20, 10, 0.1, 0.2, 0.3], "
                    "damping: [0, 0.01, 0.02, 0, 1.0e-4, 0]}]\n")}) {
    const auto expected = joined("superelement", "superelement", joint),
               found = joined(of.a, of.b, joint);
    ASSERT_EQ(found.size(), 1u);
    const double bound = of.fine ? 1e-5 : 1e-8;  // the superelement has 135 modes of some 1200
    double worst = 0;
    for (Index j = 0; j < 8; ++j) {
      const double hz = expected[0].frequency_hz[j];
      worst = std::max(worst, std::abs(found[0].frequency_hz[j] / hz - 1));
      EXPECT_NEAR(found[0].frequency_hz[j], hz, bound * hz) << joint << j;
      EXPECT_NEAR(found[0].damping_ratio[j], expected[0].damping_ratio[j],
                  10 * bound * expected[0].damping_ratio[j])
          << joint << j;
    }
    std::printf("%s: largest error %.2g; %s", of.name.c_str(), worst, joint.c_str());
  }
}

// Tied shapes as fields: those of the whole.
TEST_P(Halves, ShapesAreThoseOfTheWhole) {
  Report report("test", Verbosity::quiet);
  test::Ran ran = folder.prepare(halves(
      "contact: [{between: [a.x_max, b.x_min], tied: true}]\nboundary: [{instance: a, nodes: "
      "x_min, fix: [x, y, z]}]\noutput: {fields: [displacement]}\n"));
  SceneModes modes = scene_modes(ran.scene, 3, report);
  write_modes(folder.folder() / "modes.h5", modes, report);
  const Hdf5Reader fields(folder.folder() / "modes.fields.h5");
  for (const std::string& step : {"0", "1", "2"}) {
    std::map<std::string, Points> u, X;
    for (const std::string& grid : fields.children("/grids")) {
      const std::string instance = fields.read_string("/grids/" + grid, "instance");
      u[instance] = fields.read_points("/steps/" + step + "/" + grid + "/displacement");
      X[instance] = fields.read_points("/grids/" + grid + "/points");
    }
    Index together = 0;
    double apart = 0, largest = 0;
    for (Index i = 0; i < X["a"].rows(); ++i)
      for (Index j = 0; j < X["b"].rows(); ++j) {
        if ((X["a"].row(i) - X["b"].row(j)).norm() > 1e-9) continue;
        ++together;
        apart = std::max(apart, (u["a"].row(i) - u["b"].row(j)).norm());
      }
    for (const auto& [instance, of] : u)
      largest = std::max(largest, of.rowwise().norm().maxCoeff());
    EXPECT_EQ(together, GetParam().fine ? 49 : 9);
    EXPECT_LT(apart, 1e-9 * largest);
    EXPECT_GT(largest, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Halves,
                         ::testing::Values(Kinds{"superelements", "superelement", "superelement"},
                                           Kinds{"meshes", "mesh", "mesh"},
                                           Kinds{"mixed", "superelement", "mesh"},
                                           Kinds{"fine", "mesh", "mesh", true}),
                         [](const auto& of) { return of.param.name; });

// Shapes as fields: the first bending shape of a cantilever, whose tip moves most, and whose mass
// is 1.
// 20 000 rows of ties are the most of a mesh; here as if it were 20.
TEST_F(OfScene, MoreRowsOfTiesThanMemoryIsMeantForAreRefused) {
  const std::string yaml =
      "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1}\n"
      "components:\n  bar: {mesh: beam.exo, material: soft, mass: lumped}\n"
      "instances:\n  a: {component: bar}\n  b: {component: bar, position: [1, 0, 0]}\n"
      "contact: [{between: [a.x_max, b.x_min], tied: true}]\ntime: {end: 1}\n";
  Report report("test", Verbosity::quiet);
  const Scene scene = folder.prepare(yaml).scene;
  const auto modal = modal_scene(scene, {7, 0, false}, false, report);
  const auto with_at_most = [&](Index rows) {
    return assembled_modes(*modal, {0, 1}, 7, {}, JoinedBy::size, rows).lambda.size();
  };
  EXPECT_EQ(with_at_most(27), 7);
  EXPECT_SAYS(test::refusal_of([&] { with_at_most(20); }),
              "scene.yaml: instance 'a' has 27 conditions of ties and links, and --modes takes at "
              "most 20 of a mesh: use as: superelement");
}

// Four parts around an edge, whose nodes have a redundant row each; bars on ball joints, with more
// free motions than a block of Lanczos has columns; and a spring with a dashpot.
TEST_F(OfScene, LanczosFindsTheModesOfDenseMatrices) {
  folder.add("part.exo", test::block_mesh({{6, 2, 2}, {0.5, 0.1, 0.1}}));
  const auto part = [](const std::string& name, const std::string& x, const std::string& y) {
    return "  " + name + ": {component: part, as: superelement, position: [" + x + ", " + y +
           ", 0]}\n";
  };
  std::string bars = "instances:\n", joints = "links:\n";
  for (int i = 0; i < 8; ++i) {
    bars += part("b" + std::to_string(i), std::to_string(0.5 * i), "0");
    if (i > 0)
      joints += "  - {between: [b" + std::to_string(i - 1) + ".right, b" + std::to_string(i) +
                ".left], fix: [x, y, z]}\n";
  }
  const std::string pair = "instances:\n" + part("a", "0", "0") + part("b", "0.5", "0");
  const std::array<std::string, 3> scenes = {
      pair + part("c", "0", "0.1") + part("d", "0.5", "0.1") +
          "contact:\n  - {between: [a.x_max, b.x_min], tied: true}\n"
          "  - {between: [c.x_max, d.x_min], tied: true}\n"
          "  - {between: [a.y_max, c.y_min], tied: true}\n"
          "  - {between: [b.y_max, d.y_min], tied: true}\n",
      bars + joints,
      pair +
          "links: [{between: [a.right, b.left], stiffness: [30, 20, 10, 0.1, 0.2, 0.3], "
          "damping: [0, 0.01, 0.02, 0, 1.0e-4, 0]}]\n"
          "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n"};
  Report report("test", Verbosity::quiet);
  for (const std::string basis : {"craig-bampton, modes: 20", "massless, modes: 13"}) {
    double worst = 0, worst_c = 0;
    for (const std::string& scene : scenes) {
      const std::string yaml =
          "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1, damping: "
          "{alpha: 0.5, beta: 0.001}}}\ncomponents:\n  part: {mesh: part.exo, material: soft, "
          "points: {left: {surface: x_min}, right: {surface: x_max}}, reduction: {basis: " +
          basis + ", interface: [x_min, x_max, y_min, y_max]}}\n" + scene + "time: {end: 1}\n";
      const auto modal = modal_scene(folder.prepare(yaml).scene, {34, 0, true}, false, report);
      std::vector<Index> bodies(modal->bodies.size());
      std::iota(bodies.begin(), bodies.end(), Index{0});
      Index n = 0;
      for (const BodyModes& body : modal->bodies) n += body.omega().size();
      const Index count = std::min<Index>(34, n / 3);
      const auto found = [&](JoinedBy by) {
        return assembled_modes(*modal, bodies, count, {}, by);
      };
      const AssembledModes dense = found(JoinedBy::dense), sparse = found(JoinedBy::lanczos);
      for (Index j = 0; j < count; ++j) {
        EXPECT_EQ(dense.lambda[j] == 0, sparse.lambda[j] == 0) << basis << " " << j << scene;
        if (dense.lambda[j] == 0) continue;
        worst = std::max(worst, std::abs(sparse.lambda[j] / dense.lambda[j] - 1));
        worst_c = std::max(worst_c, std::abs(sparse.c[j] / dense.c[j] - 1));
      }
    }
    std::printf("%s: lambda %.1e, c %.1e\n", basis.c_str(), worst, worst_c);
    EXPECT_LT(worst, 1e-9) << basis;
    EXPECT_LT(worst_c, 1e-8) << basis;
  }
}

// Open contact is not part of the modes, but of what the superelement was made for.
TEST_F(OfScene, OpenContactOfFewShapesIsLeftOut) {
  const std::string floor =
      "walls: {w: {plane: {point: [9, 0, 0], normal: [-1, 0, 0]}}}\n"
      "contact: [{between: [reduced.x_max, w]";
  const std::string shapes = "basis: characteristic, interface: [x_max], modes: 10";
  const std::vector<InstanceModes> with_friction =
      modes(scene("beam.exo", shapes, floor + ", friction: 0.3}]\n"), 8);
  ASSERT_EQ(with_friction.size(), 2u);
  EXPECT_GT(with_friction[0].frequency_hz[6], 0);
  // A file that keeps statics in all directions serves a scene without friction
  EXPECT_EQ(modes(scene("beam.exo", shapes, floor + "}]\n"), 8)[0].frequency_hz,
            with_friction[0].frequency_hz);
}

TEST_F(OfScene, ShapesAreFieldsOfModalMassOne) {
  Report report("test", Verbosity::quiet);
  std::string yaml =
      scene("beam.exo", "interface: [x_min, x_max], modes: 297, recovery: true", held) +
      "output: {fields: [displacement, stress]}\n";
  test::Ran ran = folder.prepare(yaml);
  SceneModes modes = scene_modes(ran.scene, 2, report);
  write_modes(folder.folder() / "modes.h5", modes, report);
  const Hdf5Reader file(folder.folder() / "modes.h5"), fields(folder.folder() / "modes.fields.h5");
  EXPECT_EQ(file.read_string("/", "format"), "cbr-modes");
  const Vector hz = file.read_vector("/instances/full/frequency_hz");
  EXPECT_EQ(hz, modes.instances[1].frequency_hz);
  const std::vector<Index> step = file.read_indices("/instances/full/field_step");
  ASSERT_EQ(step, (std::vector<Index>{2, 3}));
  for (const std::string& grid : fields.children("/grids")) {
    const std::string instance = fields.read_string("/grids/" + grid, "instance");
    const Points u = fields.read_points("/steps/2/" + grid + "/displacement"),
                 X = fields.read_points("/grids/" + grid + "/points");
    if (instance != "full") {
      EXPECT_EQ(u, Points(Points::Zero(u.rows(), 3)));
      continue;
    }
    // Lumped: a node at an edge of the section has a quarter of the mass of one inside
    double mass = 0, tip = 0;
    for (Index i = 0; i < u.rows(); ++i) {
      const auto half = [](double x, double end) { return x < 1e-9 || x > end - 1e-9 ? 0.5 : 1.0; };
      const double y = X(i, 1) - 9;
      mass +=
          0.01 / 48 * half(X(i, 0), 1) * half(y, 0.1) * half(X(i, 2), 0.1) * u.row(i).squaredNorm();
      if (X(i, 0) > 1 - 1e-9) tip = std::max(tip, u.row(i).norm());
    }
    EXPECT_NEAR(mass, 1, 1e-10);
    EXPECT_NEAR(tip, u.rowwise().norm().maxCoeff(), 1e-12 * tip);
  }
}

}  // namespace
}  // namespace cbr::scene_modes_test
