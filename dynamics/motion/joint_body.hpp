// SPDX-License-Identifier: GPL-3.0-or-later
// What a link or a point has of its own: springs and dashpots, or mass and inertia. A body of six
// coordinates, tied to points of others.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/base/force_table.hpp"
#include "dynamics/motion/body.hpp"

namespace cbr {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Translation and rotation at a place, in axes of the joint. Either mass, or springs, dashpots,
// tables and dry friction from `at` to the nodes; what has neither does not answer. The matrices
// are symmetric and positive definite but for rows of zeros.
struct Joint {
  std::string name;
  Vector3 at = Vector3::Zero();        // undeformed, scene axes
  Matrix3 axes = Matrix3::Identity();  // rows: the joint's, scene axes
  Matrix6 mass = Matrix6::Zero(), stiffness = Matrix6::Zero(), damping = Matrix6::Zero();
  std::array<ForceTable, 6> force;     // over each motion
  Vector6 friction = Vector6::Zero();  // force or moment of dry friction on each motion
  double size = 1;                     // reference length of the joined bodies
  Vector6 rates = Vector6::Zero();     // of a mass at the start, axes of the joint
  // springs to bodies without mass at the interface, which take impulses at the ends of steps
  bool is_late = false;
  bool is_mass() const { return !mass.isZero(0); }
  bool bends(Index m) const { return !force[m].empty() || friction[m] > 0; }
  bool bends() const;
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
//
// A table F gives the mean of F between the middles of the last step and of this one (late: F at
// r_{n+1}; Newmark: the mean over the step), which keeps the integral of F as energy in the same
// way. Friction sticks, r_{n+1} = r_n, or slides with its force against r_{n+1} - r_n. Both are
// linear about the predicted r_{n+1}; the group's links are closed by Newton's method,
// linearise_again().
class JointBody final : public Body {
 public:
  JointBody(Joint joint, Scheme scheme);

  const Joint& joint() const { return joint_; }
  // Of small motions from here, axes of the joint: tables by their slopes; and the inverse over the
  // motions that have springs, else 0, as friction sticks.
  Matrix6 stiffness() const;
  Matrix6 compliance() const;
  Matrix6 largest_stiffness() const;  // tables by their steepest slopes
  Matrix6 in_scene_axes(const Matrix6& A) const;
  // Of a link whose ends turn, before each step: what takes its translation (node 0) or rotation
  // (node 1) to the scene's axes from now on, in the place of joint().axes.
  void follow(Index node, const Matrix3& to_scene);
  // translation and rotation, axes of the joint: now, and at the end of the step
  const Vector6& stretch() const { return r_; }
  const Vector6& stretch_at_end() const { return r_end_; }

  // Of a law that bends: whether the response of this step differs from that of the last one; and
  // the law and its response about the end of the step as it is known now.
  bool has_new_response() const { return is_new_; }
  void linearise_again();

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
  // Of springs and dashpots: the impulse on the nodes in a step, or the static force, that ends at
  // r, its derivative, and r_end_ with pushed_ if it is linear about `at`; axes of the joint.
  Vector6 impulse(const Vector6& r, double h) const;
  Matrix6 slope(const Vector6& r, double h) const;
  void linearise(Vector6 at, double h);
  std::array<double, 2> range(Index m, const Vector6& r) const;  // of a table, for a step to r
  bool change_slides(Vector6& at, double h);
  Matrix6 answer(double h) const;  // of r_end_ to impulses, axes of the joint
  Matrix floating() const;         // R of Body::relax(), 6 x k
  NodeResponse response_of(Index set, const Matrix6& A) const;
  Matrix3 to_scene(Index node) const {
    return follows_ ? maps_[node] : Matrix3(joint_.axes.transpose());
  }
  void fill(const Vector6& r, Index set, Points& x) const;
  Vector6 gathered(Index set, const Points& impulses) const;  // axes of the joint
  double spring_energy(const Vector6& r) const;
  template <typename Of>
  Matrix6 with_tables(const Of& of) const;  // K, with of(table, motion) on its diagonal

  Joint joint_;
  std::vector<std::vector<Index>> sets_;
  Matrix6 inverse_mass_ = Matrix6::Zero();
  // Motion; rates: of a mass now, of springs over the last step, whose length is last_h_
  bool follows_ = false;
  std::array<Matrix3, 2> maps_;  // once it follows
  Vector6 r_ = Vector6::Zero(), r_end_ = Vector6::Zero(), v_ = Vector6::Zero(),
          v_end_ = Vector6::Zero();
  Vector6 pushed_ = Vector6::Zero();  // impulses of this step; statics: forces of this iteration
  // Of friction: 0 sticks, else the sign of the slip; where statics began to slip
  Vector6 slides_ = Vector6::Zero(), begin_ = Vector6::Zero();
  bool is_static_ = false, is_new_ = false;
  double last_h_ = 0, answer_h_ = 0;
  Matrix6 answer_ = Matrix6::Zero();        // answer(answer_h_), or of linearise()
  Matrix6 first_answer_ = Matrix6::Zero();  // of a law that bends: at the start of this step
  double energy_ = 0;                       // of the springs, as it is booked
  BodyWork work_;
};

}  // namespace cbr
