// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of equal blocks with points, joined by links, with large rotation.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/support/scene_run.hpp"

namespace cbr::test {

// Density 2: the mass is 0.016.
inline const Vector3 block_size(0.4, 0.2, 0.1);

struct LinkedScene {
  std::string instances, links = {}, more = {}, time = {}, output = "every: 0.05";
  std::string component = {};
};

inline std::string yaml(const LinkedScene& scene) {
  return "materials: {m: {youngs_modulus: 1.0e6, poissons_ratio: 0, density: 2}}\n"
         "components:\n  block: {mesh: block.exo, material: m, mass: consistent" +
         scene.component +
         ", points: {base: {surface: x_min}, tip: {surface: x_max}, hub: {surface: x_min, at: "
         "[0.2, 0.1, 0.05]}}}\ninstances:\n" +
         scene.instances + (scene.links.empty() ? "" : "links:\n") + scene.links + scene.more +
         "time: {" + scene.time + ", rotations: large}\noutput: {" + scene.output + "}\n";
}

// LinkedScene::component of superelements.
inline const std::string reduced =
    ", reduction: {basis: craig-bampton, interface: [x_min, x_max], modes: 6}";

class LinkedBlocks : public ::testing::Test {
 protected:
  LinkedBlocks() { folder.add("block.exo", block_mesh({{4, 2, 1}, block_size})); }
  Ran run(const LinkedScene& scene) const { return folder.run(yaml(scene)); }
  SceneFolder folder;
};

// Hinges about z: of a's base on the ground, and of b's base on a's tip.
inline const std::string to_ground = "  - {between: [a.base, ground], fix: [x, y, z, rx, ry]}\n";
inline const std::string in_a_row = "  - {between: [a.tip, b.base], fix: [x, y, z, rx, ry]}\n";
inline const std::string gravity = "loads: [{gravity: [0, -10, 0]}]\n";

}  // namespace cbr::test
