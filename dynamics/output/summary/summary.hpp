// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output/summary: terminal output of a run, before, during and after its
// steps.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "common/app/report.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Largest errors of the run's balances.
struct Balance {
  // |E(t) - E(0) - work of loads, contact and friction| / largest energy or work
  double energy = 0;
  double energy_off = 0;        // the same, not relative
  double momentum_off = 0;      // |p(t) - p(0)|
  double momentum = 0;          // momentum_off / sum over bodies of the largest |p|
  double angular_momentum = 0;  // likewise, with a scale of at least momentum x distance
};
Balance balance(const RunResult& result);

// "3 of 100 steps"; in statics of load steps, counted from the first before time 0.
std::string steps_done(const Simulation& simulation, Index reached);

// Before the first step: instances, dofs, steps and their limits. is_again: instances have been
// reported.
void announce(const BuiltScene& built, bool is_again, Report& report);

// Reports balances and contact, each figure with its good range, and warnings. Counters with
// --verbose only.
void summarise(const BuiltScene& built, const RunResult& result, bool is_restarted, Report& report);

// Warns of pairs with an initial overlap above round-off and `adjust`. Call after the first step,
// in which contact detects it.
void warn_of_initial_overlaps(const BuiltScene& built, Report& report);

// A line per pair, and warnings; with many pairs of `all` only those that met. `is_restarted`: gaps
// were watched since the restart.
void contact_lines(const BuiltScene& built, bool is_restarted, Report& report);

// Energy that contact loses because modes, or a mesh, cannot represent the waves that it excites
// (docs/theory.md, (44)).
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
