// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/support/refusal.hpp"
#include "tests/unit/common/scene_samples.hpp"

namespace cbr::content_hash_test {
namespace {

using test::replaced;
using test::TemporaryFolder;

const std::string scene_text = R"(materials:
  steel: {youngs_modulus: 2e11, poissons_ratio: 0.3, density: 7836}
  other: {youngs_modulus: 1e9, poissons_ratio: 0.3, density: 1000}
components:
  block:
    mesh: block.msh
    material: steel
    blocks: {core: {element: hex8}}
    reduction: {interface: [a, b], modes: 10, superelement: block.h5}
)";

std::string hash_of(const std::string& text, const std::string& mesh_bytes = "mesh") {
  const TemporaryFolder folder;
  test::write_bytes(folder / "block.msh", mesh_bytes);
  test::write_bytes(folder / "renamed.msh", mesh_bytes);
  const Scene scene = test::read_text(folder, text);
  return content_hash(scene, scene.components.begin()->second);
}

TEST(ContentHash, isTheSameForWhatDoesNotMatter) {
  const std::string hash = hash_of(scene_text);
  EXPECT_EQ(hash.size(), 32u);
  EXPECT_EQ(hash_of(scene_text), hash);
  const std::vector<std::pair<std::string, std::string>> same = {
      {"block.msh", "renamed.msh"},
      {"block.h5", "elsewhere.h5"},
      {"[a, b]", "[b, a]"},
      {"youngs_modulus: 1e9", "youngs_modulus: 2e9"},            // a material that is not used
      {"youngs_modulus: 2e11", "youngs_modulus: 200000000000"},  // the same number
      {"    reduction",
       "    element: hex8-incompatible\n    mass: lumped\n    reduction"},  // the defaults
      {"modes: 10",
       "modes: 10, pick: frequency, domains: 1, recovery: false, basis: craig-bampton, "
       "condense_rotations: false, exact_modes: false"},
      {"  block:\n", "  brick:\n"}};
  for (const auto& [old, with] : same)
    EXPECT_EQ(hash_of(replaced(scene_text, old, with)), hash) << with;
  std::string renamed = replaced(scene_text, "  steel:", "  iron:");
  EXPECT_EQ(hash_of(replaced(renamed, "material: steel", "material: iron")), hash);
}

TEST(ContentHash, differsForWhatMatters) {
  std::set<std::string> hashes = {hash_of(scene_text), hash_of(scene_text, "mesh!"),
                                  hash_of(scene_text, "")};
  const std::vector<std::pair<std::string, std::string>> different = {
      {"youngs_modulus: 2e11", "youngs_modulus: 200000000000.00003"},
      {"poissons_ratio: 0.3", "poissons_ratio: 0.29"},
      {"density: 7836", "density: 7835"},
      {"material: steel", "material: other"},
      {"core: {element: hex8}", "core: {element: hex8-hourglass}"},
      {"core: {element: hex8}", "hull: {element: hex8}"},
      {"core: {element: hex8}", "core: {element: hex8, material: other}"},
      {"core: {element: hex8}", "core: {element: hex8, thickness: 0.1}"},
      {"core: {element: hex8}", "core: {element: hex8, thickness: 0.2}"},
      {"modes: 10", "modes: 10, condense_rotations: true"},
      {"modes: 10", "modes: 10, exact_modes: true"},
      {"modes: 10", "modes: 10, fixed: [{nodes: a, fix: [x]}]"},
      {"modes: 10", "modes: 10, fixed: [{nodes: a, fix: [x, y]}]"},
      {"    reduction", "    element: hex8-hourglass\n    reduction"},
      {"    reduction", "    mass: consistent\n    reduction"},
      {"[a, b]", "[a]"},
      {"[a, b]", "[ab]"},
      {"[a, b]", "[a, b, c]"},
      {"modes: 10", "modes: 11"},
      {"modes: 10", "cutoff_hz: 10"},
      {"modes: 10", "modes: 10, pick: participation"},
      {"modes: 10", "modes: 10, domains: 2"},
      {"modes: 10", "modes: 10, recovery: true"}};
  for (const auto& [old, with] : different) {
    EXPECT_TRUE(hashes.insert(hash_of(replaced(scene_text, old, with))).second) << with;
  }
  EXPECT_EQ(hashes.size(), 3 + different.size());
}

// Letters of a deck choose the element where the scene does not.
TEST(ContentHash, ofADeckHasNoDefaultElement) {
  const std::string given = replaced(scene_text, "    reduction",
                                     "    element: reduced\n    reduction"),
                    usual = replaced(scene_text, "    reduction",
                                     "    element: hex8-incompatible\n    reduction");
  EXPECT_EQ(hash_of(scene_text, "mesh"), hash_of(usual, "mesh"));
  EXPECT_NE(hash_of(scene_text, "*NODE"), hash_of(usual, "*NODE"));
  EXPECT_NE(hash_of(scene_text, "*NODE"), hash_of(given, "*NODE"));
}

TEST(ContentHash, needsTheMesh) {
  const TemporaryFolder folder;
  const Scene scene = test::read_text(folder, scene_text);
  EXPECT_THROW(content_hash(scene, scene.components.begin()->second), InputError);
  std::filesystem::create_directory(folder / "block.msh");
  EXPECT_THROW(content_hash(scene, scene.components.begin()->second), InputError);
  std::filesystem::remove(folder / "block.msh");
  std::filesystem::create_symlink("/dev/zero", folder / "block.msh");  // would be read for ever
  EXPECT_THROW(content_hash(scene, scene.components.begin()->second), InputError);
}

// The basis alone is enough, and means the same as its default written out.
TEST(ContentHash, CharacteristicAloneKeepsEightyModes) {
  const std::string alone = replaced(scene_text, "modes: 10, ", "basis: characteristic, ");
  EXPECT_EQ(hash_of(alone),
            hash_of(replaced(scene_text, "modes: 10, ", "basis: characteristic, modes: 80, ")));
}

// A scene that is passed on means the same material to the last bit, whatever its axes were given
// as.
TEST(ContentHash, OrthotropicMaterialsSurviveTheWayThroughAPipe) {
  const std::string ply = replaced(
      scene_text, "youngs_modulus: 2e11, poissons_ratio: 0.3,",
      "youngs_modulus: [14e10, 1e10, 9e9], poissons_ratio: [0.3, 0.4, 0.25], shear_modulus: [5e9, "
      "3.5e9, 4.5e9], axes: [[1, 2, 0.3], [0.2, 1, 5]],");
  const TemporaryFolder folder;
  test::write_bytes(folder / "block.msh", "mesh");
  const Scene scene = test::read_text(folder, ply);
  std::ostringstream out;
  write_scene(scene, out);
  const Scene again = test::read_text(folder, out.str());
  EXPECT_EQ(content_hash(scene, scene.components.at("block")),
            content_hash(again, again.components.at("block")));
  EXPECT_NE(hash_of(ply), hash_of(scene_text));
  EXPECT_NE(hash_of(ply), hash_of(replaced(ply, "4.5e9]", "4.4e9]")));
  EXPECT_NE(hash_of(ply), hash_of(replaced(ply, "[0.2, 1, 5]", "[0.2, 1, 4]")));
  const Orthotropy& of = *again.materials.at("steel").orthotropy;
  EXPECT_LT((of.axes * of.axes.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(of.shear_moduli, Vector3(5e9, 3.5e9, 4.5e9));
}

TEST(ContentHash, FixedSetsSurviveTheWayThroughAPipe) {
  const TemporaryFolder folder;
  test::write_bytes(folder / "block.msh", "mesh");
  const Scene scene = test::read_text(
      folder, replaced(scene_text, "modes: 10",
                       "modes: 10, fixed: [{nodes: cut, fix: y}, {nodes: a set, fix: [x, z]}]"));
  std::ostringstream out;
  write_scene(scene, out);
  const Scene again = test::read_text(folder, out.str());
  EXPECT_EQ(content_hash(scene, scene.components.at("block")),
            content_hash(again, again.components.at("block")));
  const std::vector<FixedSet>& fixed = again.components.at("block").reduction->fixed;
  ASSERT_EQ(fixed.size(), 2u);
  EXPECT_EQ(fixed[1].nodes, "a set");
  EXPECT_EQ(fixed[1].fix, (std::array<bool, 3>{true, false, true}));
}

TEST(ContentHash, OrthotropicConstantsThatCannotBeAreRefused) {
  const auto refusal = [](const std::string& constants) {
    return test::refusal_of([&] {
      hash_of(replaced(scene_text, "youngs_modulus: 2e11, poissons_ratio: 0.3,", constants));
    });
  };
  const std::string rest = ", shear_modulus: [5, 4, 5]";
  EXPECT_SAYS(refusal("youngs_modulus: [9, 10, 140], poissons_ratio: [0.3, 0.4, 1.2]" + rest + ","),
              "would give energy");
  EXPECT_SAYS(refusal("youngs_modulus: [9, 10, -1], poissons_ratio: [0.3, 0.4, 0.2]" + rest + ","),
              "not positive");
  const std::string good = "youngs_modulus: [9, 10, 14], poissons_ratio: [0.3, 0.4, 0.2]";
  EXPECT_SAYS(refusal(good + rest + ", axes: [[1, 0, 0], [2, 0, 0]],"), "zero or parallel");
  EXPECT_SAYS(refusal(good + ", axes: [[1, 0, 0], [2, 0, 0]],"), "needs shear_modulus");
  EXPECT_SAYS(refusal(good + rest + ","), "no error");
  EXPECT_SAYS(refusal(good + ","), "need shear_modulus");
}

}  // namespace
}  // namespace cbr::content_hash_test
