// SPDX-License-Identifier: GPL-3.0-or-later
// How far a linear body may turn.
#pragma once

#include "common/base/types.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// rad: a linear body that has turned by more is wrong. 5 degrees; less of a tall one that stands
// under gravity, whose weight loses 5 % of its moment before that. positions: n x 3, undeformed.
double turn_limit(const SceneIndex& index, const Instance& instance, const Points& positions);

}  // namespace cbr
