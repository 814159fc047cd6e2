// SPDX-License-Identifier: GPL-3.0-or-later
// Energy that contact loses because modes, or a mesh, cannot represent the waves that it excites
// (docs/theory.md, (44)).
#pragma once

#include <optional>
#include <set>
#include <string>

#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

struct OutsideBasis {
  // Units of energy. energy: lost by normal contact up to the last output without contact, or the
  // last output if there is none. It then includes oscillation within steps. friction: lost in the
  // whole run.
  double energy = 0, friction = 0;
  // largest energy relative to the common centre of mass (with supports or loads: largest energy or
  // work)
  double scale = 0;
  // contact acted on a superelement with mass on its interface; false: on meshes only
  bool has_modes = false;
  bool all_rigid = true;   // contact acted on rigid bodies and walls only
  bool has_rigid = false;  // some pair had no others
  // springs or node-lumped contact acted too: `energy` includes their loss
  bool has_others = false;
  Index n_impacts = 0;  // of the pairs that lose it: times that contact began
  // superelements with mass on their interface, or with meshes alone these
  std::set<std::string> components = {};
  bool of_faces_in_part = false;  // basis characteristic: contact on less than a quarter of a face
  bool may_be_massless = true;    // the scene allows `basis: massless` in place of theirs
  bool modes_help = false;        // the mesh's own face nodes are less than most of the loss
};

// Kinetic energy of rigid bodies by the last contact forces in one step: they have it at rest, as
// their velocities lack half a step of the loads.
double energy_of_a_step(const BuiltScene& built, const RunResult& result);

// None if no impulses acted on a body with mass on its surface.
std::optional<OutsideBasis> energy_outside_basis(const BuiltScene& built, const RunResult& result);

// OutsideBasis::energy / scale. None likewise, with scale 0, and for statics.
std::optional<double> share_outside_basis(const BuiltScene& built, const RunResult& result);

// "energy lost to truncated modes: 1.2e+06, 10.8 % of the energy against the common centre of mass
// (good: ...); friction: 0"
std::string text_of(const OutsideBasis& outside, bool momentum_is_kept);

// Warns of a large share, and names the component and the cure. None: no warning.
std::optional<std::string> warning_of(const OutsideBasis& outside);

}  // namespace cbr
