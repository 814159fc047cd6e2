// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn --check-error: a run beside the same with half of the modes.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// What outputs differ by, as shares: of the rms of what moves, and of the largest total energy.
struct HalfDifference {
  struct OfMonitor {
    double position = 0, velocity = 0;  // rms over the outputs
    double length = 0;                  // rms of the positions' difference, in the scene's units
  };
  std::vector<OfMonitor> monitors;
  struct OfBody {
    double center = 0;    // rms, of the rms motion of the centre of mass
    double momentum = 0;  // at the end, of the largest momentum
    double energy = 0;    // largest difference of kinetic + strain energy
  };
  std::vector<OfBody> bodies;
  double position = 0, velocity = 0, energy = 0;  // the largest of all
  double largest() const;                         // of all shares
};

// Of two runs with equal output times.
HalfDifference half_difference(const RunResult& whole, const RunResult& half);

// On the summary, and counts for --timings.
void say_half_difference(const Simulation& simulation, const HalfDifference& difference,
                         Index modes_whole, Index modes_half, Report& report);

}  // namespace cbr
