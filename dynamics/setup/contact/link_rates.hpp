// SPDX-License-Identifier: GPL-3.0-or-later
// Rates of springs and dashpots on rigid bodies, and of given rotations, which may determine the
// step.
#pragma once

#include <string>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Fastest link: on rigid bodies the larger of omega (springs) and c / m (dashpots), with elastic
// ends held in place; the largest angular velocity of a given rotation.
struct LinkRate {
  double rate = 0;  // 1 / s; 0: no such link
  std::string link;
};
LinkRate fastest_link(const BuiltScene& built);

// Largest h rate / 2, the relative error of velocities at the end of a step, which lack half of the
// next impulse. A given rotation goes by as many rad a step, where links close by linear steps.
constexpr double link_step_share = 0.01;

// Longest step for that error, 0: no limit. Rates that outputs at intervals `every` cannot show do
// not reduce it further, as springs and dashpots are stable at any step.
double link_step(const LinkRate& fastest, double every, double end);

}  // namespace cbr
