// SPDX-License-Identifier: GPL-3.0-or-later
// Where an instance is placed, and which material a block of its mesh has.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>

#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_placement_test {
namespace {

using test::full_scene;
using test::read_text;
using test::replaced;
using test::TemporaryFolder;

TEST(Transformation, isMirrorThenRotationsAboutTheFixedAxes) {
  Instance instance;
  instance.rotation_degrees = Vector3(31, -47, 112);
  for (const char* mirror : {"", "x", "y", "z"}) {
    instance.mirror = mirror;
    const double degree = std::numbers::pi / 180;
    Vector3 scale = Vector3::Ones();
    if (*mirror) scale(*mirror - 'x') = -1;
    const Matrix3 expected = (Eigen::AngleAxisd(112 * degree, Vector3::UnitZ()) *
                              Eigen::AngleAxisd(-47 * degree, Vector3::UnitY()) *
                              Eigen::AngleAxisd(31 * degree, Vector3::UnitX()))
                                 .toRotationMatrix() *
                             scale.asDiagonal();
    const Matrix3 T = instance.transformation();
    EXPECT_LT((T - expected).norm(), 1e-14);
    EXPECT_NEAR(T.determinant(), *mirror ? -1 : 1, 1e-14);
  }
}

TEST(Transformation, isExactForRightAngles) {
  Instance instance;
  instance.rotation_degrees = Vector3(0, 0, 90);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(-2, 1, 3));
  instance.rotation_degrees = Vector3(90, 0, 0);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(1, -3, 2));
  instance.rotation_degrees = Vector3(0, -270, 360);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(3, 2, -1));
  instance.rotation_degrees = Vector3(180, -180, 540);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(1, 2, 3));
}

TEST(BlockProperties, followTheBlocksOfTheMesh) {
  const TemporaryFolder folder;
  const Scene scene =
      read_text(folder, replaced(full_scene, "      \"true\": {element: hex8-hourglass}\n", ""));
  Mesh mesh;
  mesh.blocks.resize(3);
  mesh.blocks[0].name = "other";
  mesh.blocks[1].name = "core";
  mesh.blocks[2].name = "skin";
  mesh.blocks[2].type = ElementType::quad4;
  const auto properties = block_properties(scene, scene.components.at("block"), mesh);
  ASSERT_EQ(properties.size(), 3u);
  EXPECT_EQ(properties[0].material.density, 7836);
  EXPECT_EQ(properties[0].hex, HexFormulation::hourglass);
  EXPECT_EQ(properties[1].material.density, 0.1);
  EXPECT_EQ(properties[1].hex, HexFormulation::full);
  // 'bare' gives a material to block 'all' only.
  // the mesh has no block 'all'
  EXPECT_THROW(block_properties(scene, scene.components.at("bare"), mesh), InputError);
  mesh.blocks[0].name = "all";
  // 'core' is a volume without a material
  EXPECT_THROW(block_properties(scene, scene.components.at("bare"), mesh), InputError);
  mesh.blocks.erase(mesh.blocks.begin() + 1);
  // 'skin' needs none
  EXPECT_EQ(block_properties(scene, scene.components.at("bare"), mesh).size(), 2u);
}

// As in Exodus meshes without names.
TEST(BlockProperties, knowUnnamedBlocksByTheirNumber) {
  Scene scene;
  scene.materials = {{"light", {1, 0, 1}}, {"dense", {1, 0, 2}}};
  Component component;
  component.material = "light";
  component.blocks["20"].material = "dense";
  Mesh mesh;
  mesh.blocks.resize(2);
  mesh.blocks[0].name = "block_10";
  mesh.blocks[1].name = "block_20";
  const auto properties = block_properties(scene, component, mesh);
  EXPECT_EQ(properties[0].material.density, 1);
  EXPECT_EQ(properties[1].material.density, 2);
  component.blocks["block_20"].material = "light";
  EXPECT_THROW(block_properties(scene, component, mesh), InputError);  // twice
  component.blocks.erase("block_20");
  component.blocks["30"].material = "light";
  EXPECT_THROW(block_properties(scene, component, mesh), InputError);  // there is none
}

}  // namespace
}  // namespace cbr::scene_placement_test
