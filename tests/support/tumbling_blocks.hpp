// SPDX-License-Identifier: GPL-3.0-or-later
// Two blocks that spin and hit each other, and what such a pair must keep whatever moves it: full
// meshes and superelements have the same tests.
#pragma once

#include <functional>
#include <string>

#include "tests/support/contact_scene.hpp"

namespace cbr::test {

// Two blocks askew as full meshes, with faces that do not match; the first flies with spin into the
// second, which spins too. Waves go at about 10. `options`: more of the contact, ", friction: 0.3".
ContactScene tumbling_blocks(const std::string& options, double speed);

// What changes in a scene that is turned, moved and given a boost, or turned and mirrored, as a
// share of what is there.
double change_of_a_turned_scene(const ContactScene& scene);

// Blocks that hit each other as slowly as they turn little: the order in the speed by which runs
// with large rotations and linear ones differ.
double order_of_small_rotations(const std::function<ContactScene(double speed)>& blocks);

}  // namespace cbr::test
