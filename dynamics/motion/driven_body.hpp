// SPDX-License-Identifier: GPL-3.0-or-later
// A body whose supports move: a body with supports at rest, in axes that move with them.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "dynamics/motion/driven_motion.hpp"
#include "dynamics/motion/wrapped_body.hpp"

namespace cbr {

// x = X + u + s(t), s the translation of the supports; in the moving axes gravity -s'' acts. No
// approximation: a translation strains nothing. docs/theory.md, "Supports that move".
class DrivenBody final : public WrappedBody {
 public:
  // inner: held, in the axes that move, with velocities from there. mass: of the whole body.
  // has_inertia: false in statics, where supports have places and no velocities; `waits`: statics
  // come first, see start_motion(). rotations: nodes that move by a rotation, which the supports'
  // translation leaves alone.
  DrivenBody(std::unique_ptr<Body> inner, DrivenMotion motion, double mass, bool has_inertia = true,
             bool waits = false, std::vector<Index> rotations = {});

  Index track(const std::vector<Index>& nodes) override;
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  MotionBound motion_bound(Index set) const override {
    return moved(inner_->bounds()->motion_bound(set));
  }
  MotionBound quick_motion_bound(Index set) const override {
    return moved(inner_->bounds()->quick_motion_bound(set));
  }
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override;

  void take_impulses(Index set, const Impulses& impulses) override;
  void expect_forces(Index set, const Impulses& forces) override;
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  void accept() override;
  void end_velocities(Index set, Points& v) override;
  void add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) override;

  void relax(double t, double share) override;
  void add_static_forces(Index set, const Points& forces, ImpulseKind kind) override;
  Settled settle() override;
  void end_load_step() override;
  void start_motion(double h, const std::vector<BodyLoad>& loads) override;

  BodyState state() const override;
  // The supports' work is external.
  BodyWork work() const override;
  void displacements(Points& u, Points& v) const override;
  // In axes that move with the supports; turn() does the rest.
  void turn(const Points& X, Points& u, Points& v) const override;
  void keep_state(StateArchive& archive) override;

 private:
  void take_plan(const BodyPlan& plan) override;
  MotionBound moved(MotionBound bound) const;
  void shift(Index set, const Vector3& s, Points& x) const;
  void shift_all(const Vector3& s, Points& x) const;
  Vector3 resultant(Index set, const Points& forces) const;
  void book(const Vector3& impulse, ImpulseKind kind, double t);
  double energy_of_motion() const;
  std::vector<BodyLoad> with_inertia(const std::vector<BodyLoad>& loads) const;
  Vector3 support_velocity(double t) const {
    return has_inertia_ ? motion_.velocity(t) : Vector3::Zero();
  }

  DrivenMotion motion_;
  std::vector<Index> rotations_;
  std::map<Index, std::vector<Index>> rotation_rows_;  // of tracked sets that have any
  double mass_ = 0;
  double now_ = 0;
  double energy_at_start_ = 0;
  bool has_inertia_ = true, waits_ = false;
  // Statics: resultants of contact and of friction, of this iteration and at the end of the last
  // load step, and its time
  Vector3 forces_[2] = {Vector3::Zero(), Vector3::Zero()},
          forces_start_[2] = {Vector3::Zero(), Vector3::Zero()};
  double start_ = 0;
  Vector3 lasting_[2] = {Vector3::Zero(), Vector3::Zero()};  // resultants of forces that last
  double contact_ = 0, friction_ = 0;  // work of impulses on the supports' motion
};

}  // namespace cbr
