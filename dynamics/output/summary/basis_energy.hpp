// SPDX-License-Identifier: GPL-3.0-or-later
// The energy that contact has taken because modes, or a mesh, cannot hold the waves that it sets
// off (docs/theory.md, (44)).
#pragma once

#include <optional>
#include <string>

#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

struct OutsideBasis {
  // Units of energy: what normal contact has taken, up to the last output at which nothing touched
  // (the last of all when something always does; then what swings between the ends of steps is in
  // it); what friction took in the whole run.
  double energy = 0, friction = 0;
  // largest energy against the common centre of mass (with supports or loads: energy or work at
  // all)
  double scale = 0;
  // a superelement with mass on its interface has been struck; else meshes alone
  bool has_modes = false;
  bool all_rigid = true;  // nothing but rigid bodies and walls has been struck
  // springs or node-lumped contact have been at work too: theirs is in `energy`
  bool has_others = false;
};

// None where no impulses have acted on a body with mass on its surface.
std::optional<OutsideBasis> energy_outside_basis(const BuiltScene& built, const RunResult& result);

// Its energy over the scale; none as there, without a scale, and of statics.
std::optional<double> share_outside_basis(const BuiltScene& built, const RunResult& result);

// "energy lost to truncated modes: 1.2e+06, 10.8 % of the energy against the common centre of mass
// (good: ...); friction: 0"
std::string text_of(const OutsideBasis& outside, bool momentum_is_kept);

}  // namespace cbr
