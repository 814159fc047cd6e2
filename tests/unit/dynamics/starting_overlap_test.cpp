// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of bodies that start inside each other, and not of those that only look so from
// behind a face.
#include "dynamics/setup/contact/starting_overlap.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::starting_overlap_test {
namespace {

// A channel, 3 x 1 x 2 with faces of 0.5: a block without the elements of 1 < x < 2, z > 1.
Mesh channel() {
  Mesh mesh = test::block_mesh({{6, 2, 4}, {3, 1, 2}});
  Block& block = mesh.blocks.front();
  std::vector<Index> kept, new_row(block.element_ids.size(), -1);
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    const Vector3 x =
        mesh.coordinates(block.connectivity.row(e), Eigen::all).colwise().mean().transpose();
    if (x[2] > 1 && x[0] > 1 && x[0] < 2) continue;
    new_row[e] = static_cast<Index>(kept.size());
    kept.push_back(e);
  }
  for (Sideset& set : mesh.sidesets) {
    std::erase_if(set.sides, [&](const Side& side) { return new_row[side.element] < 0; });
    for (Side& side : set.sides) side.element = new_row[side.element];
  }
  const IndexTable old = block.connectivity;
  block.connectivity = old(kept, Eigen::all);
  block.element_ids.resize(kept.size());
  // Nodes of no element go, too
  std::vector<Index> used(old.size() ? static_cast<std::size_t>(mesh.coordinates.rows()) : 0, -1),
      nodes;
  for (const Index node : block.connectivity.reshaped()) used[node] = 0;
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (used[i] == 0) {
      used[i] = static_cast<Index>(nodes.size());
      nodes.push_back(i);
    }
  for (Index& node : block.connectivity.reshaped()) node = used[node];
  mesh.coordinates = Points(mesh.coordinates(nodes, Eigen::all));
  mesh.node_ids.resize(nodes.size());
  return mesh;
}

class StartingOverlap : public testing::Test {
 protected:
  StartingOverlap() {
    folder_.add("channel.exo", channel());
    folder_.add("cube.exo", test::block_mesh({{2, 2, 2}, {0.4, 0.4, 0.4}}));
  }

  // What cbr-dyn says of a cube at `position` and the channel's face, turned and mirrored together.
  std::string said(const std::string& kind, const std::string& face, const Vector3& position,
                   const std::string& cube_face) const {
    testing::internal::CaptureStderr();
    folder_.prepare(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components:\n"
        "  channel: {mesh: channel.exo, material: m, reduction: {interface: [x_min, x_max], modes: "
        "2}}\n"
        "  cube: {mesh: cube.exo, material: m}\n"
        "instances:\n"
        "  channel: {component: channel, as: " +
        kind +
        ", mirror: z, rotation: [0, 90, 0], position: [5, -2, 1]}\n  cube: {component: cube, as: "
        "mesh, mirror: z, " +
        "rotation: [0, 90, 0], velocity: [0.1, 0, 0], position: " + test::text(placed(position)) +
        "}\n" + "contact: [{between: [cube." + cube_face + ", channel." + face +
        "]}]\ntime: {end: 0.1, step: 0.001}\n");
    return testing::internal::GetCapturedStderr();
  }
  // z -> -z, then a quarter turn about y: (x, y, z) -> (z, y, -x), then the channel's position.
  static Vector3 placed(const Vector3& x) {
    return Vector3(-x[2], x[1], -x[0]) + Vector3(5, -2, 1);
  }

  test::SceneFolder folder_;
};

// Straight behind the outer face of a flange, and in the air between the flanges.
TEST_F(StartingOverlap, WhatIsInANotchIsNotInsideTheBody) {
  for (const char* kind : {"mesh", "superelement"}) {
    const auto silent = [&](const char* face, double x) {
      const std::string text = said(kind, face, {x, 0.3, 1.4}, face);
      EXPECT_EQ(text.find("behind the faces"), std::string::npos)
          << kind << " " << x << " " << text;
    };
    silent("x_min", 1.3);
    silent("x_max", 1.3);
    silent("x_min", 1.0);  // touches the flange from inside the notch
    silent("x_max", 1.6);
  }
}

TEST_F(StartingOverlap, WhatIsInsideTheBodyIsWarnedOf) {
  for (const char* kind : {"mesh", "superelement"}) {
    const auto warned = [&](const Vector3& at, const std::string& depth) {
      EXPECT_SAYS(said(kind, "x_min", at, "x_min"),
                  "starts " + depth + " behind the faces of channel.x_min")
          << kind;
    };
    warned({0.55, 0.3, 1.4}, "0.55");
    warned({0.9, 0.3, 1.4}, "0.9");  // half in the notch
    warned({1.2, 0.3, 0.3}, "1.2");  // below it
    warned({0.6, 0, 0}, "0.6");      // faces of both in one plane
  }
}

// Their nodes are flat faces, apart from each other; the bodies are not.
TEST_F(StartingOverlap, SuperelementsOfOneFaceEachAreWarnedOf) {
  const auto said_at = [&](double x) {
    testing::internal::CaptureStderr();
    folder_.prepare(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components: {cube: {mesh: cube.exo, material: m, reduction: {interface: [x_max], modes: "
        "2}}}\n"
        "instances:\n  a: {component: cube}\n  b: {component: cube, mirror: x, position: [" +
        test::text(x) +
        ", 0, 0]}\ncontact: [{between: [a.x_max, b.x_max]}]\ntime: {end: 0.1, step: 0.001}\n");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_SAYS(said_at(0.55), "starts 0.25 behind the faces of");
  const std::string apart = said_at(0.85);
  EXPECT_EQ(apart.find("behind the faces"), std::string::npos) << apart;
}

TEST(Solid, HoldsWhatItsElementsHold) {
  const Solid solid(channel());
  EXPECT_EQ(solid.n_triangles(), 2 * (24 + 16 + 8 + 40));
  for (double x = -0.25; x < 3.5; x += 0.25)
    for (double y = -0.25; y < 1.5; y += 0.5)
      for (double z = -0.1; z < 2.4; z += 0.4) {
        const bool in_block =
            x > 0 && x < 3 && y > 0 && y < 1 && z > 0 && z<2, in_notch = x> 1 && x < 2 && z > 1;
        if (x == 0 || x == 3 || (z > 1 && (x == 1 || x == 2))) continue;  // on the boundary
        EXPECT_EQ(solid.holds({x, y, z}), in_block && !in_notch) << x << " " << y << " " << z;
      }
}

}  // namespace
}  // namespace cbr::starting_overlap_test
