// SPDX-License-Identifier: GPL-3.0-or-later
// Impact of two spinning blocks, and invariants of such a pair for any kind of body: full meshes
// and superelements have the same tests.
#pragma once

#include <functional>
#include <string>

#include "tests/support/contact_scene.hpp"

namespace cbr::test {

// Two oblique blocks as full meshes with nonmatching faces. The first flies with spin into the
// second, which spins too. Wave speeds are about 10. `options`: further contact options, ",
// friction: 0.3".
ContactScene tumbling_blocks(const std::string& options, double speed);

// Change of a scene under rotation, translation and boost, or rotation and reflection, relative to
// its values.
double change_of_a_turned_scene(const ContactScene& scene);

// Blocks with slow impacts and small rotations: the order in the speed of the difference between
// runs with large rotation and linear ones.
double order_of_small_rotations(const std::function<ContactScene(double speed)>& blocks);

}  // namespace cbr::test
