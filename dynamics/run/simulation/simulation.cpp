// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

PairState& ContactPair::state() {
  if (!state_) {
    state_ = std::make_unique<PairState>();
    for (PairMemory* of : {&state_->memory, &state_->back, &state_->edges})
      of->adjust = adjust.value_or(0);
    state_->memory.lets_jump = enforcement == Enforcement::penalty;
  }
  return *state_;
}

const PairState& ContactPair::seen() const {
  static const PairState nothing;
  return state_ ? *state_ : nothing;
}

void Simulation::shift_walls(double from, double to) {
  for (const MovingWall& moving : moving_walls)
    moving.wall->shift({moving.motion.displacement(from), moving.motion.displacement(to),
                        moving.motion.velocity(to)});
}

}  // namespace cbr
