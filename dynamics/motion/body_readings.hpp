// SPDX-License-Identifier: GPL-3.0-or-later
// Outputs of a body between two steps.
#pragma once

#include <optional>

#include "common/base/types.hpp"

namespace cbr {

class StateArchive;

// State of a body, scene axes.
struct BodyState {
  // angular_momentum: about the scene's origin, of the linearised motion (arms of the undeformed
  // body about its centre of mass).
  Vector3 center_of_mass = Vector3::Zero(), momentum = Vector3::Zero(),
          angular_momentum = Vector3::Zero();
  double kinetic_energy = 0, strain_energy = 0;
  // mean rotation since the start, rad: a linear body's must stay small
  double rotation = 0;
  // Of a body with large rotation: unit quaternion w x y z since the start, scene axes.
  std::optional<Eigen::Vector4d> orientation = {};
};

// Work done on a body since the start of the run; kinetic + strain energy changes by their sum, to
// round-off.
struct BodyWork {
  double external = 0, contact = 0;  // contact: with friction
  // of the material's and the modes' damping: never above 0 but for changes of the step
  double damping = 0;
  // of the integrator: HHT-alpha's damping, central differences' changes of step
  double numerical = 0;

  BodyWork& operator+=(const BodyWork& more) {
    external += more.external;
    contact += more.contact;
    damping += more.damping;
    numerical += more.numerical;
    return *this;
  }
};

// Of a set of supports on the body, scene axes.
struct Reaction {
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
};

void keep_state(StateArchive& archive, BodyState& state);
void keep_state(StateArchive& archive, BodyWork& work);

}  // namespace cbr
