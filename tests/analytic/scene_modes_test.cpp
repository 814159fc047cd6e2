// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn --modes: frequencies and damping ratios of held and free instances, superelements against meshes and closed forms.
#include "dynamics/setup/scene_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr {
namespace {

using test::SceneFolder;

class OfScene : public ::testing::Test {
 protected:
  OfScene() {
    folder.add("one.exo", test::block_mesh({{1, 1, 1}, {1, 1, 1}}));
    folder.add("beam.exo", test::block_mesh({{12, 2, 2}, {1, 0.1, 0.1}}));
  }

  std::string scene(const std::string& mesh, const std::string& reduction, const std::string& rest = "",
                    const std::string& instance = "") const {
    return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1, damping: {alpha: 0.5, beta: 0.001}}\n"
           "components:\n  bar: {mesh: " +
           mesh + ", material: soft, mass: lumped, reduction: {" + reduction +
           "}}\ninstances:\n  reduced: {component: bar, as: superelement" + instance +
           "}\n  full: {component: bar, as: mesh, position: [0, 9, 0]" + instance + "}\n" + rest + "time: {end: 0.01}\n";
  }

  std::vector<InstanceModes> modes(const std::string& yaml, Index n) const {
    Report report("test", Verbosity::quiet);
    return scene_modes(folder.prepare(yaml).scene, n, report);
  }

  SceneFolder folder;
};

const std::string held =
    "boundary:\n  - {instance: reduced, nodes: x_min, fix: [x, y, z]}\n"
    "  - {instance: full, nodes: x_min, fix: [x, y, z]}\n";

// Along x: omega^2 = k / m = E A / L / (rho A L / 2) = 400. Rayleigh's ratio is alpha / (2 omega) + beta omega / 2.
TEST_F(OfScene, OneElementIsAnOscillator) {
  for (const InstanceModes& of : modes(scene("one.exo", "interface: [x_min, x_max], modes: 0", held), 100)) {
    const Vector omega = 2 * std::numbers::pi * of.frequency_hz;
    EXPECT_EQ(omega.size(), 12) << of.instance;
    EXPECT_LT((omega.array() - 20).abs().minCoeff(), 1e-10) << of.instance;
    for (Index j = 0; j < omega.size(); ++j) EXPECT_NEAR(of.damping_ratio[j], 0.25 / omega[j] + 0.0005 * omega[j], 1e-14);
  }
}

// The lowest bending frequencies of a cantilever: 1.875^2 / (2 pi) sqrt(E I / (rho A)) and less, by shear.
TEST_F(OfScene, HeldSuperelementsHaveTheFrequenciesOfTheirMesh) {
  for (const char* basis : {"basis: craig-bampton", "basis: massless", "basis: characteristic"}) {
    const auto found = modes(scene("beam.exo", std::string(basis) + ", interface: [x_min, x_max], modes: 30", held), 6);
    ASSERT_EQ(found.size(), 2u);
    const Vector &reduced = found[0].frequency_hz, &full = found[1].frequency_hz;
    const double beam = 1.8751 * 1.8751 / (2 * std::numbers::pi) * std::sqrt(200 * 0.01 / 12);
    EXPECT_NEAR(full[0], beam, 0.03 * beam);
    EXPECT_NEAR(full[1], full[0], 1e-8 * beam);  // a square section
    for (Index j = 0; j < 6; ++j) EXPECT_NEAR(reduced[j], full[j], 0.01 * full[j]) << basis << " " << j;
  }
}

TEST_F(OfScene, FreeInstancesHaveSixRigidMotions) {
  const auto found = modes(scene("beam.exo", "interface: [x_min, x_max], modes: 297"), 10);
  for (const InstanceModes& of : found) {
    EXPECT_EQ(of.frequency_hz.head(6), Vector::Zero(6)) << of.instance;
    EXPECT_EQ(of.damping_ratio.head(6), Vector::Zero(6));
    EXPECT_GT(of.frequency_hz[6], 0.1);
  }
  for (Index j = 6; j < 10; ++j) EXPECT_NEAR(found[0].frequency_hz[j], found[1].frequency_hz[j], 1e-8 * found[1].frequency_hz[j]);
}

TEST_F(OfScene, TiedSurfacesAreRefusedByName) {
  const std::string yaml = scene("one.exo", "interface: [x_min, x_max, y_min, y_max], modes: 0",
                                 "contact:\n  - {between: [reduced.y_max, full.y_min], tied: true, adjust: 9}\n");
  try {
    modes(yaml, 3);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("contact: tied: --modes"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace cbr
