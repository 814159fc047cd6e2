// SPDX-License-Identifier: GPL-3.0-or-later
// A free superelement that turns by any angle: a superelement's body in a floating frame.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/motion/modal/free_turn.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"
#include "dynamics/motion/modal/turning_load.hpp"

namespace cbr {

// x = c + R (X + u - c_0), docs/theory.md, "Bodies that turn". The inner body gives the centre of
// mass c and what is measured from it without the turn, X + u - c_0. It gets impulses in its own
// axes, and never turns (SuperelementBody::carry). R comes from the angular momentum L about c,
// which impulses and loads change by their moments about c, with the arms of the deformed body.
class TurningBody final : public Body {
 public:
  // inner: free, with Scheme::exact and six rigid modes, before any set is tracked.
  // angular_velocity: rad/s, scene axes, at the start. end: of the run, s, for motion bounds.
  TurningBody(std::unique_ptr<SuperelementBody> inner, const Vector3& angular_velocity, double end);

  double largest_frequency() const override { return inner_->largest_frequency(); }
  // Whether the modes feel the spin: the superelement knows its moments.
  bool feels_spin() const { return feels_; }
  // Whether the superelement knows what couples them with each other and the turn.
  bool has_coupling() const { return coupling_ != nullptr; }
  Vector3 angular_velocity() const { return now_.angular_velocity(q_, L_); }

  void add_moment(const Vector3& moment) override;
  bool turns() const override { return true; }
  Matrix3 turn_of_step() const override { return R_; }
  BodyTurn turn_now() const override { return {modal_.center_of_mass(), q_.toRotationMatrix()}; }
  BodyTurn turn_at_end() const override {
    return {modal_.predicted_center_of_mass(), end().toRotationMatrix()};
  }
  Vector3 spin() const override { return angular_velocity(); }
  void unturned_displacements(Points& u, Points& v) const override { inner_->displacements(u, v); }

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  MotionBound own_motion_bound(Index set, bool quick) const override {
    return in_any_position(inner_->motion_bound(set, quick));
  }
  bool own_at_rest() const override { return L_.isZero(0) && loads_.empty() && inner_->at_rest(); }
  Index own_track_mean(const std::vector<Index>& nodes) override {
    return inner_->track_mean(nodes);
  }
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_accept() override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void unturned_positions(Index set, Points& x) const override { inner_->positions(set, x); }
  void unturned_end(Index set, Points& x) const override { inner_->predicted_positions(set, x); }
  NodeResponse unturned_response(Index set, double h) const override {
    return inner_->response(set, h);
  }
  NodeResponse own_response(Index set, double h) const override;
  double own_residual_friction(Index set, const Points& impulses, bool between) override {
    return inner_->residual_friction(set, impulses * R_, between);
  }
  BodyState own_state() const override;
  BodyWork own_work() const override;
  void own_displacements(Points& u, Points& v) const override;
  // In axes that turn with the body; turn() does the rest.
  void own_coordinates(Vector& q, Vector& rates) const override { inner_->coordinates(q, rates); }
  void own_turn(const Points& X, Points& u, Points& v) const override;
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan& plan) override;
  void predict_end() override;
  void add_fixed_forces(const Points& forces, const LoadHistory& history);
  void add_vector_force(const VectorForce& force, const LoadHistory& history);

  // Positions of a set at the moment at which impulses act, once asked for.
  struct PlacedSet {
    Points x;
    bool known = false;
  };
  // Where a turn is at the end of a step, what moments of loads have done to it, and the factors of
  // the forces that turn with the body (SuperelementBody::turn_forces()).
  struct TurnAtEnd {
    Eigen::Quaterniond q;
    Vector3 L;
    double work = 0;
    Matrix g;
    Vector3 w;  // scene axes
  };
  MotionBound in_any_position(MotionBound bound) const;
  Matrix3 inertia(const Vector& shape) const;
  Vector3 axial(const Vector3& of_component) const;
  Vector3 in_component(const Vector3& axial) const;
  // Whether the modes are coupled: without angular momentum they are not.
  bool is_coupled() const { return coupling_ != nullptr && !L_.isZero(0); }
  TurnInertia present_turn(SpinCoupling::Shape& shape) const;
  TurnInertia predicted_turn() const;
  TurnInertia with(const Matrix3& J, const SpinCoupling::Shape& shape) const;
  void take_drift(const SpinCoupling::Shape& shape);
  double energy_for_modes(double momentum) const;
  double longest_part() const;
  void accept_part();
  TurnAtEnd turn_at_end(Vector3 L, const TurnInertia& last) const;
  void add_moments_of_loads(double from, double to, double share, bool at_end, const FreeTurn& turn,
                            TurnAtEnd& end) const;
  Vector factors(const Eigen::Quaterniond& q, const Vector3& w) const;
  void turn_inner(const TurnInertia& last);
  void move_on();
  void expect_turning();
  double spin_energy(const FreeTurn& of) const;
  void take_axes();
  const Eigen::Quaterniond& end() const;
  void add_moments(Index set, const Points& impulses);
  void book(const Vector3& moment, const Vector3& w, const Vector3& share_of_kick);

  std::unique_ptr<SuperelementBody> inner_;
  SuperelementBody& modal_;  // inner_
  const bool late_;          // impulses of contact act at the end of a step, not at its start
  const bool feels_;
  const SpinCoupling* coupling_;  // of the superelement; null: not known
  const double run_end_;
  std::vector<TurningLoad> loads_;
  Matrix3 J_0_;  // undeformed, placed, scene axes
  double largest_inertia_;
  FreeTurn now_, step_;  // of the body as it is, and as it is in the middle of the step
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  // The end of the step, and with loads the momentum and their work there
  mutable Eigen::Quaterniond q_end_ = q_;
  mutable Vector3 L_end_ = Vector3::Zero();
  mutable double work_end_ = 0;
  // with loads: the modes at the start, and as far as they are known at the end
  Vector eta_start_;
  mutable Vector eta_end_;
  mutable bool ends_there_ = true;   // these are of all moments so far
  Matrix3 R_ = Matrix3::Identity();  // in the middle of the step, without impulses of contact
  Vector3 L_ = Vector3::Zero();      // about the centre of mass, scene axes
  Vector3 kick_ = Vector3::Zero();   // moment of the impulses of the step
  bool is_kicked_ = false;
  Vector3 last_kick_ = Vector3::Zero();  // late: of the last step, which L_ has
  mutable std::vector<PlacedSet> placed_;
  BodyWork work_;  // of the spin
};

}  // namespace cbr
