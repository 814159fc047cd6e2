// SPDX-License-Identifier: GPL-3.0-or-later
// How fast springs and dashpots move rigid bodies, which sets the step where nothing else does.
#pragma once

#include <string>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// The fastest of the links on rigid bodies: the larger of omega (springs) and c / m (dashpots), as
// if an end that is elastic stayed where it is.
struct LinkRate {
  double rate = 0;  // 1 / s; 0: there is no such link
  std::string link;
};
LinkRate fastest_link(const BuiltScene& built);

// Velocities at the end of a step lack half of the kick of the next one: h rate / 2 of them.
constexpr double link_step_share = 0.01;

// The longest step for it, 0: no limit. What is faster than outputs that are `every` apart can show
// does not shorten it further: springs and dashpots are stable with any step.
double link_step(const LinkRate& fastest, double every, double end);

}  // namespace cbr
