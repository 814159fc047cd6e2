// SPDX-License-Identifier: GPL-3.0-or-later
// What a link or a point has of its own: springs and dashpots, or mass and inertia. A body of six
// coordinates, tied to points of others.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/motion/body.hpp"

namespace cbr {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Translation and rotation at a place, in axes of the joint. Either mass, or springs and dashpots
// from `at` to the nodes; what has neither does not answer. All three are symmetric and positive
// definite but for rows of zeros.
struct Joint {
  std::string name;
  Vector3 at = Vector3::Zero();        // undeformed, scene axes
  Matrix3 axes = Matrix3::Identity();  // rows: the joint's, scene axes
  Matrix6 mass = Matrix6::Zero(), stiffness = Matrix6::Zero(), damping = Matrix6::Zero();
  Vector6 rates = Vector6::Zero();  // of a mass at the start, axes of the joint
  // springs to bodies without mass at the interface, which take impulses at the ends of steps
  bool is_late = false;
  bool is_mass() const { return !mass.isZero(0); }
};

// Node 0 moves by the translation, node 1 by the rotation, both from `at`; impulses on node 1 are
// those of moments.
//
// Springs are implicit, so that they limit no step. With impulses at the start of steps h (exact,
// central differences), r the motion and v = (r_{n+1} - r_n) / h,
//   p_n = h K (r_n + h (v_n - v_{n-1}) / 4) + h C (v_n + v_{n-1}) / 2:
// the mean force of two steps, which is Newmark's with beta = 1/4. They keep (rbar . K rbar) / 2,
// rbar the middle of a step, to round-off with masses that move so. Late ones act at the end of a
// step: p_n = h K r_{n+1} + h C (3 v_n - v_{n-1}) / 2. Under Newmark impulses last, and p = h K
// (r_n + r_{n+1}) / 2 + C (r_{n+1} - r_n).
class JointBody final : public Body {
 public:
  JointBody(Joint joint, Scheme scheme);

  const Joint& joint() const { return joint_; }
  Matrix6 compliance() const;  // K^-1 over the motions that have springs, else 0; axes of the joint
  Matrix6 in_scene_axes(const Matrix6& A) const;
  // Of a link whose ends turn, before each step: what takes its translation (node 0) or rotation
  // (node 1) to the scene's axes from now on, in the place of joint().axes.
  void follow(Index node, const Matrix3& to_scene);
  // translation and rotation, axes of the joint: now, and at the end of the step
  const Vector6& stretch() const { return r_; }
  const Vector6& stretch_at_end() const { return r_end_; }

  double largest_frequency() const override { return 0; }

  FloatingForces floating_forces() const override;
  void float_by(const Vector& move) override;

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override { fill(r_, set, x); }
  void own_predicted_positions(Index set, Points& x) const override { fill(r_end_, set, x); }
  Index own_track_mean(const std::vector<Index>& nodes) override { return own_track(nodes); }
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_accept() override;
  void own_end_velocities(Index set, Points& v) override;
  NodeResponse own_velocity_response(Index set) const override;
  void own_add_end_impulses(Index set, const Points& impulses) override;
  void own_relax(double t, double share) override;
  Matrix own_floating_motions(Index set) const override;
  NodeResponse own_static_response(Index set) const override;
  void own_add_static_forces(Index set, const Points& forces) override;
  Settled own_settle() override;
  void own_end_load_step() override;
  void own_start_motion(double h, const std::vector<BodyLoad>& loads) override;
  NodeResponse own_response(Index set, double h) const override;
  BodyState own_state() const override;
  BodyWork own_work() const override { return work_; }
  void own_displacements(Points& u, Points& v) const override;
  void own_coordinates(Vector& q, Vector& rates) const override;
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan&) override {}  // what loads a point acts on the body that has it
  void predict_end() override;
  bool is_newmark() const { return scheme() == Scheme::newmark; }
  Matrix6 answer(double h) const;  // of r_end_ to impulses, axes of the joint
  Matrix floating() const;         // R of Body::relax(), 6 x k
  NodeResponse response_of(Index set, const Matrix6& A) const;
  Matrix3 to_scene(Index node) const {
    return follows_ ? maps_[static_cast<std::size_t>(node)] : Matrix3(joint_.axes.transpose());
  }
  void fill(const Vector6& r, Index set, Points& x) const;
  Vector6 gathered(Index set, const Points& impulses) const;  // axes of the joint
  double spring_energy(const Vector6& r) const { return 0.5 * r.dot(joint_.stiffness * r); }

  Joint joint_;
  std::vector<std::vector<Index>> sets_;
  Matrix6 inverse_mass_ = Matrix6::Zero();
  // Motion; rates: of a mass now, of springs over the last step, whose length is last_h_
  bool follows_ = false;
  std::array<Matrix3, 2> maps_;  // once it follows
  Vector6 r_ = Vector6::Zero(), r_end_ = Vector6::Zero(), v_ = Vector6::Zero(),
          v_end_ = Vector6::Zero();
  Vector6 pushed_ = Vector6::Zero();  // statics: forces of this iteration
  double last_h_ = 0, answer_h_ = 0;
  Matrix6 answer_ = Matrix6::Zero();  // answer(answer_h_)
  double energy_ = 0;                 // of the springs, as it is booked
  BodyWork work_;
};

}  // namespace cbr
