// SPDX-License-Identifier: GPL-3.0-or-later
// A free superelement that turns by any angle: a superelement's body in axes that go with it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/modal/free_turn.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

// x = c + R (X + u - c_0), docs/theory.md, "Bodies that turn". The superelement's body gives the centre of mass c and what is
// measured from it without the turn, X + u - c_0; its own rigid rotation stays 0, since nothing turns it. R comes from the angular
// momentum, which stays. Elastic coordinates do not feel the spin.
// Answers no impulses and takes no load but gravity: whoever builds it sees to that.
class TurningBody final : public Body {
 public:
  // As of SuperelementBody. Precondition: form->n_rigid == 6. angular_velocity: rad/s, scene axes, at the start.
  TurningBody(std::string name, std::shared_ptr<const Superelement> superelement, std::shared_ptr<const DiagonalForm> form,
              const Placement& placement, const Vector3& angular_velocity);

  const std::string& name() const override { return inner_.name(); }
  Index n_dofs() const override { return inner_.n_dofs(); }
  double largest_frequency() const override { return inner_.largest_frequency(); }
  Scheme scheme() const override { return inner_.scheme(); }
  const Points& reference_positions() const override { return inner_.reference_positions(); }

  Index track(const std::vector<Index>& nodes) override { return inner_.track(nodes); }
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  MotionBound motion_bound(Index set) const override;
  bool at_rest() const override { return L_.isZero(0) && inner_.at_rest(); }
  Index track_mean(const std::vector<Index>& nodes) override { return inner_.track_mean(nodes); }
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override;

  void predict(double t, double h) override;
  void accept() override;
  using Body::add_impulses;
  void add_impulses(Index set, const Points& impulses, ImpulseKind kind) override;
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  NodeResponse response(Index set, double h) const override;
  Points nodal_masses(Index set) const override;
  void add_force(const Points& forces, const LoadHistory& history) override;
  void add_gravity(const Vector3& acceleration, const LoadHistory& history) override { inner_.add_gravity(acceleration, history); }

  BodyState state() const override;
  BodyWork work() const override { return inner_.work(); }
  void displacements(Points& u, Points& v) const override;
  // In axes that turn with the body; turn() does the rest.
  void coordinates(Vector& q, Vector& rates) const override { inner_.coordinates(q, rates); }
  void turn(const Points& X, Points& u, Points& v) const override;
  void keep_state(StateArchive& archive) override;

 private:
  void turn_about(const Vector3& centre, const Eigen::Quaterniond& q, Points& x) const;

  SuperelementBody inner_;
  FreeTurn free_;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity(), q_end_ = q_;
  Vector3 L_ = Vector3::Zero();  // about the centre of mass, scene axes
};

}  // namespace cbr
