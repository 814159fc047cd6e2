// SPDX-License-Identifier: GPL-3.0-or-later
// What bodies that wrap another one share: they do what that one does, and have the abilities that
// it has.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "dynamics/motion/body.hpp"

namespace cbr {

// Forwards each function. A body overrides those of which it makes something else. Not forwarded:
// impulses, which each body takes in its own way; at_rest(), of which each judges by itself;
// impulses at the start and turning, which none passes on.
class WrappedBody : public Body,
                    public BoundAbility,
                    public NodalAbility,
                    public EndImpulseAbility,
                    public StaticsAbility {
 public:
  double largest_frequency() const override { return inner_->largest_frequency(); }
  Index track(const std::vector<Index>& nodes) override { return inner_->track(nodes); }
  void positions(Index set, Points& x) const override { inner_->positions(set, x); }
  void predicted_positions(Index set, Points& x) const override {
    inner_->predicted_positions(set, x);
  }
  Index track_mean(const std::vector<Index>& nodes) override { return inner_->track_mean(nodes); }
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override {
    inner_->mean_motion(set, position, velocity);
  }
  void expect_forces(Index set, const Impulses& forces) override {
    inner_->expect_forces(set, forces);
  }
  double lasting_share() const override { return inner_->lasting_share(); }
  void accept() override { inner_->accept(); }
  NodeResponse response(Index set, double h) const override { return inner_->response(set, h); }

  BodyState state() const override { return inner_->state(); }
  BodyWork work() const override { return inner_->work(); }
  void displacements(Points& u, Points& v) const override { inner_->displacements(u, v); }
  void coordinates(Vector& q, Vector& rates) const override { inner_->coordinates(q, rates); }
  void turn(const Points& X, Points& u, Points& v) const override { inner_->turn(X, u, v); }
  void keep_state(StateArchive& archive) override { inner_->keep_state(archive); }

  const BoundAbility* bounds() const override { return inner_->bounds() ? this : nullptr; }
  MotionBound motion_bound(Index set) const override { return inner_->bounds()->motion_bound(set); }
  MotionBound quick_motion_bound(Index set) const override {
    return inner_->bounds()->quick_motion_bound(set);
  }

  NodalAbility* nodal() override { return inner_->nodal() ? this : nullptr; }
  Points nodal_masses(Index set) const override { return inner_->nodal()->nodal_masses(set); }
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override {
    return inner_->nodal()->add_velocities(set, velocities, momentum);
  }

  EndImpulseAbility* end_impulses() override { return inner_->end_impulses() ? this : nullptr; }
  void end_velocities(Index set, Points& v) override {
    inner_->end_impulses()->end_velocities(set, v);
  }
  NodeResponse velocity_response(Index set) const override {
    return inner_->end_impulses()->velocity_response(set);
  }
  void add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) override {
    inner_->end_impulses()->add_end_impulses(set, impulses, kind);
  }

  StaticsAbility* statics() override { return inner_->statics() ? this : nullptr; }
  void relax(double t, double share) override { inner_->statics()->relax(t, share); }
  Matrix floating_motions(Index set) const override {
    return inner_->statics()->floating_motions(set);
  }
  FloatingForces floating_forces() const override { return inner_->statics()->floating_forces(); }
  void float_by(const Vector& move) override { inner_->statics()->float_by(move); }
  NodeResponse static_response(Index set) const override {
    return inner_->statics()->static_response(set);
  }
  void add_static_forces(Index set, const Points& forces, ImpulseKind kind) override {
    inner_->statics()->add_static_forces(set, forces, kind);
  }
  Settled settle() override { return inner_->statics()->settle(); }
  void end_load_step() override { inner_->statics()->end_load_step(); }
  void start_motion(double h, const std::vector<BodyLoad>& loads) override {
    inner_->statics()->start_motion(h, loads);
  }

 protected:
  explicit WrappedBody(std::unique_ptr<Body> inner)
      : Body(inner->facts()), inner_(std::move(inner)) {
    facts_.steps_alone = false;
  }

  void take_plan(const BodyPlan& plan) override { inner_->prepare(plan); }
  void predict_end() override { inner_->predict(t_, h_); }

  std::unique_ptr<Body> inner_;
};

}  // namespace cbr
