// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// Of each mode: tan x / x, x = omega h / 2 < pi / 2. A force F that acts as an impulse F h at the
// start of every step h leaves a mode that moves exactly at F / omega^2 times x / tan x at the
// steps' ends, where contact is tested, and not at F / omega^2: bodies would be stiffer in contact
// than they are (by 8 % at omega h = 1, 36 % at 2). Impulses of contact are given to modes with
// this gain, which makes the compression under a lasting force exact, at any step; rigid motions
// have gain 1. It is a modal mass and stiffness smaller by the gain for all that contact sees, so
// that energies are weighed by its inverse (docs/theory.md, "Compliance that lasts").
Vector contact_gain(const Vector& omega, double h);
// The same of damped modes, (P1 (1 - G') + G^2) / G of damped_step(): of no damping tan x / x too.
// The first n_rigid have gain 1.
Vector contact_gain(const Vector& omega, const Vector& damping, Index n_rigid, double h);

}  // namespace cbr
