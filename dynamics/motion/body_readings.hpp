// SPDX-License-Identifier: GPL-3.0-or-later
// What outputs read of a body between two steps.
#pragma once

#include <optional>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

class StateArchive;

// What a body answers about itself, all in the scene's axes.
struct BodyState {
  // angular_momentum: about the scene's origin, of the linearised motion (arms of the undeformed
  // body about its centre of mass).
  Vector3 center_of_mass = Vector3::Zero(), momentum = Vector3::Zero(),
          angular_momentum = Vector3::Zero();
  double kinetic_energy = 0, strain_energy = 0;
  // mean rotation since the start, rad: a linear body's must stay small
  double rotation = 0;
  // Of a body that turns by any angle: unit quaternion w x y z since the start, scene axes.
  std::optional<Eigen::Vector4d> orientation = {};
  // kinetic + strain, of what moves with scaled modal mass: what that costs in accuracy at most
  double scaled_energy = 0;
};

// Work done on a body since the start of the run; kinetic + strain energy changes by their sum, to
// round-off.
struct BodyWork {
  double external = 0, contact = 0, friction = 0;
  // of the material's and the modes' damping: never above 0 but for changes of the step
  double damping = 0;
  // what the integrator takes or gives by itself: HHT-alpha's damping, central differences' changes
  // of step
  double numerical = 0;
};

class BodyReadings {
 public:
  virtual ~BodyReadings() = default;

  virtual BodyState state() const = 0;
  virtual BodyWork work() const = 0;
  // of all nodes, and their velocities; scene axes, n_nodes x 3
  virtual void displacements(Points& u, Points& v) const = 0;
  // All coordinates and their rates, component axes: modal ones (of the parts one after the other),
  // then x, y, z of the nodes, then rotations of nodes. A recovery of interiors starts from them.
  virtual void coordinates(Vector& q, Vector& rates) const = 0;
  // Of a body that turns: adds the turn, which coordinates() leaves out, to u and v (n x 3, scene
  // axes) of its points X (n x 3, undeformed, scene axes).
  virtual void turn(const Points& /*X*/, Points& /*u*/, Points& /*v*/) const {}
  // Number of a node set for mean_motion(); as Body::track().
  virtual Index track_mean(const std::vector<Index>& nodes) = 0;
  // the plain mean of its nodes
  virtual void mean_motion(Index set, Vector3& position, Vector3& velocity) const = 0;
};

void keep_state(StateArchive& archive, BodyState& state);
void keep_state(StateArchive& archive, BodyWork& work);

}  // namespace cbr
