// SPDX-License-Identifier: GPL-3.0-or-later
// The floating frame of a free superelement with large rotation.
#pragma once

#include <Eigen/Geometry>

#include <vector>

#include "common/base/types.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/modal/forms/spin_coupling.hpp"
#include "dynamics/motion/modal/turning_forces.hpp"

namespace cbr {

// J: 3 x 3, inertia about the centre of mass in body axes, kg m^2, positive definite. inner: what
// moves inside the body has of its angular momentum L, body axes: L = R (J w + inner).
struct TurnInertia {
  Matrix3 J = Matrix3::Identity();
  Vector3 inner = Vector3::Zero();
};

// The rotation of a free rigid body, of any inertia and by any angle.
struct FreeTurn : TurnInertia {
  Matrix3 J_inverse = Matrix3::Identity();
  double rate_per_momentum = 0;  // the largest |J^-1 l| / |l|

  FreeTurn() = default;
  explicit FreeTurn(const Matrix3& inertia) : FreeTurn(TurnInertia{inertia}) {}
  explicit FreeTurn(const TurnInertia& of);
  // (1 - share) from + share to
  static FreeTurn between(const TurnInertia& from, const TurnInertia& to, double share);

  // R J^-1 (R^T L - inner), rad/s, scene axes. q: unit quaternion of R, body axes to scene axes.
  Vector3 angular_velocity(const Eigen::Quaterniond& q, const Vector3& L) const;
  // by which the former changes as L does
  Vector3 change(const Eigen::Quaterniond& q, const Vector3& change_of_L) const;
  double energy(const Eigen::Quaterniond& q, const Vector3& L) const;  // w . J w / 2

  // q a time h later. L: angular momentum about the centre of mass, scene axes, which stays.
  // Taylor series of Euler's equations and of q' = q w / 2, in parts of at most a tenth of a
  // radian: errors are round-off.
  Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vector3& L, double h) const;
};

class ModalBody;

// x = c + R (X + u - c_0), docs/theory.md, "Bodies that turn". The modes of the body give the
// centre of mass c and the place relative to it without the rotation, X + u - c_0. They take
// impulses in the axes of the frame. R follows from the angular momentum L about c, which impulses
// and loads change by their moments about c, with the arms of the deformed body.
class Frame {
 public:
  // modal: free, with Scheme::exact and six rigid modes, before any set is tracked.
  // angular_velocity: rad/s, scene axes, at the start. end: of the run, s, for motion bounds.
  Frame(ModalBody& modal, const Vector3& angular_velocity, double end);

  // Whether the modes have the forces of the spin: the superelement has its moments.
  bool feels_spin() const { return feels_; }
  // Whether the superelement has the coupling of the modes with each other and the rotation.
  bool has_coupling() const { return coupling_ != nullptr; }
  Vector3 angular_velocity() const { return now_.angular_velocity(q_, L_); }
  const Matrix3& R() const { return R_; }  // in the middle of the step, without impulses of contact
  BodyTurn now() const;
  BodyTurn at_end() const;
  bool at_rest() const { return L_.isZero(0) && loads_.empty(); }

  // The public functions of Body, for a body that has this frame.
  void track() { placed_.emplace_back(); }
  void predict(double t, double h);
  void take_impulses(Index set, const Impulses& impulses);
  void add_moment(const Vector3& moment);
  void accept();
  // Takes the loads with moments; returns the plan of the modes.
  BodyPlan take_plan(const BodyPlan& plan);
  void keep_state(StateArchive& archive);

  // Each applies the rotation to a result of the modes.
  void turn_positions(Index set, Points& x) const;
  void turn_predicted_positions(Index set, Points& x) const;
  void turn_mean_motion(Vector3& position, Vector3& velocity) const;
  void turn(const Points& X, Points& u, Points& v) const;
  void turn_state(BodyState& state) const;
  MotionBound in_any_position(MotionBound bound) const;
  const BodyWork& work() const { return work_; }  // beside that of the modes

 private:
  // Positions of a set at the moment at which impulses act, once computed.
  struct PlacedSet {
    Points x;
    bool known = false;
  };
  // The rotation at the end of a step, with the moments of loads, and the factors of TurningForces.
  struct TurnAtEnd {
    Eigen::Quaterniond q;
    Vector3 L;
    double work = 0;
    Matrix g;
    Vector3 w;  // scene axes
  };
  void add_fixed_forces(const Points& forces, const LoadHistory& history);
  void add_vector_force(const VectorForce& force, const LoadHistory& history);
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
  void turn_modes(const TurnInertia& last);
  void move_on();
  void expect_turning();
  double spin_energy(const FreeTurn& of) const;
  void take_axes();
  const Eigen::Quaterniond& end() const;
  void add_moments(Index set, const Points& impulses);
  void book(const Vector3& moment, const Vector3& w, const Vector3& share_of_kick);

  ModalBody& modal_;
  const bool late_;  // impulses of contact act at the end of a step, not at its start
  const bool feels_;
  const SpinCoupling* coupling_;  // of the superelement; null: it has none
  const double run_end_;
  double t_ = 0, h_ = 0;  // of the step
  std::vector<TurningLoad> loads_;
  Matrix3 J_0_;  // undeformed, placed, scene axes
  double largest_inertia_;
  FreeTurn now_, step_;  // of the body as it is, and as it is in the middle of the step
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  // The end of the step, and with loads the momentum and their work there
  mutable Eigen::Quaterniond q_end_ = q_;
  mutable Vector3 L_end_ = Vector3::Zero();
  mutable double work_end_ = 0;
  // with loads: the modes at the start, and as predicted at the end
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
