// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/simulation/simulation.hpp"

#include <Eigen/Geometry>

namespace cbr {

Matrix3 axes_along(const Vector3& line) {
  return Eigen::Quaterniond::FromTwoVectors(line, Vector3::UnitX()).toRotationMatrix();
}

PairState& ContactPair::state() {
  if (!state_) {
    state_ = std::make_unique<PairState>();
    for (PairMemory* of : {&state_->memory, &state_->back, &state_->edges}) {
      of->adjust = adjust.value_or(0);
      of->rest = of->rest_before = interference;
    }
    state_->memory.lets_jump = enforcement == Enforcement::penalty;
  }
  return *state_;
}

const PairState& ContactPair::seen() const {
  static const PairState nothing;
  return state_ ? *state_ : nothing;
}

void Simulation::shift_walls(double from, double to) {
  const auto shift = [&](const DrivenMotion& motion) -> RigidWall::Shift {
    const Vector3 start = motion.displacement(from);
    return {start, motion.displacement(to), motion.velocity(to),
            start - motion.displacement(2 * from - to)};
  };
  for (const auto& [wall, motion] : moving_walls) wall->shift(shift(motion));
  for (const auto& link : driven_links) link->shift = shift(link->motion);
}

}  // namespace cbr
