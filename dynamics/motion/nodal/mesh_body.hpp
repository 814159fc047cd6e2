// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion/nodal: full meshes by central differences.
//
// A full finite element model that moves by central differences.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/motion/nodal/mesh_forces.hpp"

namespace cbr {

class MeshFrame;
struct MeshFit;

// What the instances of a component share; component axes, node i is FiniteElementModel::nodes[i].
// Rows are those of `forces`.
struct MeshModel {
  Points coordinates;  // n x 3
  MeshForces forces;
  std::vector<Index> row_of_node;
  // n, by rows, row sums: the lumped mass, or what a nodal enforcement and the momentum need of a
  // consistent one; rotary inertia of rotations
  Vector mass;
  // Rows of rotations of shells, lumped mass only. Their inertia is the same about all axes, and
  // their displacement is the rotation vector since the start.
  std::vector<Index> rotations;
  Vector inverse_mass;  // n, by rows, lumped mass only
  // n, by rows, lumped mass only: mass times the place from the centre of mass; 0 of rotations
  Field arms;
  SparseMatrix M;  // 3 n x 3 n, consistent mass only; its rows are the nodes
  // 3 n x 6, consistent mass only: M times the rigid motions about the centre of mass
  Matrix MR;
  RigidBody rigid_body;
  double largest_frequency = 0;  // of the free model
  // And of instances that are held, which mostly are held alike
  struct HeldFrequencies {
    std::mutex lock;
    std::vector<std::pair<std::vector<HeldDirection>, double>> known;
  };
  std::shared_ptr<HeldFrequencies> of_held = std::make_shared<HeldFrequencies>();
  // And of those that turn
  struct Turned {
    std::mutex lock;
    std::shared_ptr<const MeshFrame> frame;  // null: not yet made
  };
  std::shared_ptr<Turned> of_turned = std::make_shared<Turned>();
};

// `lumped`: M is diagonal. RunError when the highest frequency is not found or M is not positive
// definite. K assembled.
MeshModel mesh_model(const FiniteElementModel& model, const Points& coordinates, bool lumped);
// `forces` of the same model; of an assembled K when the mass is consistent.
MeshModel mesh_model(const FiniteElementModel& model, const Points& coordinates, bool lumped,
                     MeshForces forces);

struct MeshOptions {
  MaterialDamping damping = {};
  // rad/s, scene axes, at the start, of a body that nothing holds: it turns by any angle. RunError:
  // no inertia about an axis.
  std::optional<Vector3> angular_velocity = {};
  // A body of the same nodes, held alike, that does statics for this one until start_motion().
  std::unique_ptr<Body> statics = {};
};

// `held`: ascending by node, component axes.
class MeshBody final : public Body {
 public:
  MeshBody(std::string name, std::shared_ptr<const MeshModel> model, const Placement& placement,
           const std::vector<HeldDirection>& held, std::shared_ptr<RowThreads> threads,
           MeshOptions options = {});

  double largest_frequency() const override {
    return critical_frequency(largest_frequency_, damping_.beta);
  }

  FloatingForces floating_forces() const override { return still().floating_forces(); }
  void float_by(const Vector& move) override { still().float_by(move); }

  double lasting_share() const override { return 0.5; }

  Points nodal_masses(Index set) const override;

  bool turns() const override { return turning_ != nullptr; }
  Matrix3 turn_of_step() const override;  // at the start of the step
  BodyTurn turn_now() const override;
  BodyTurn turn_at_end() const override;
  Vector3 spin() const override;
  void unturned_displacements(Points& u, Points& v) const override;
  void add_moment(const Vector3& moment) override;
  void add_start_impulse(const Vector& impulse) override;

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  Index own_track_mean(const std::vector<Index>& nodes) override;
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_relax(double t, double share) override { still().relax(t, share); }
  Matrix own_floating_motions(Index set) const override { return still().floating_motions(set); }
  NodeResponse own_static_response(Index set) const override {
    return still().static_response(set);
  }
  void own_add_static_forces(Index set, const Points& forces) override {
    still().add_static_forces(set, forces);
  }
  Settled own_settle() override { return still().settle(); }
  void own_end_load_step() override { still().end_load_step(); }
  void own_start_motion(double h, const std::vector<BodyLoad>& loads) override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_expect_forces(Index set, const Points& forces) override;
  void own_accept() override;
  NodeResponse own_response(Index set, double h) const override;
  Vector3 own_add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  BodyState own_state() const override;
  BodyWork own_work() const override;
  void own_displacements(Points& u, Points& v) const override;
  // Of a body that turns in its own axes: turn() does the rest.
  void own_coordinates(Vector& q, Vector& rates) const override;
  void own_turn(const Points& X, Points& u, Points& v) const override;
  void own_keep_state(StateArchive& archive) override;
  void unturned_positions(Index set, Points& x) const override;
  void unturned_end(Index set, Points& x) const override;
  // The mass is the same along all axes.
  NodeResponse unturned_response(Index set, double h) const override {
    return own_response(set, h);
  }
  void take_plan(const BodyPlan& plan) override;
  void predict_end() override;

  struct Turning;
  struct Kick {
    Index row;
    Vector3 impulse, v_before;  // component axes; the velocity half a step before
  };

  bool consistent() const { return model_->M.size() > 0; }
  std::vector<Index> rows(const std::vector<Index>& nodes) const;
  Points by_nodes(const Field& u) const;  // rows put in the order of the nodes
  void add_loads(const std::vector<BodyLoad>& loads);
  void take_still();
  Body& still() const {
    if (!still_) lacks_statics();
    return *still_;
  }
  void hold(Field& v) const;  // takes the held directions out
  void hold_velocity();
  void accelerations(const Field& force, Field& a) const;  // M^-1 f on the free directions
  void load(double t, Field& f) const;
  void stiffness_forces(const Field& u, Field& Ku) const;
  const Field& internal_forces()
      const;                      // K u, formed once for each u; of a body that turns the gradient
  double held_frequency() const;  // the largest one of the free directions
  double find_held_frequency() const;
  double scalar_product_of_forces(const Field& v) const;  // v . K u
  void total_accelerations(Field& a) const;               // M^-1 (f - K u)
  const Field& present_velocities() const;                // at the time of u_, in component axes
  void start(double h);
  void leap(double s, double h);
  bool is_damped() const { return damping_ != MaterialDamping(); }
  // What an impulse leaves in the velocity in the middle of the step h: the rest goes to damping.
  double kick_share(double h) const { return 1 / (1 + 0.5 * h * damping_.alpha); }
  void damped_accelerations(Field& a) const;
  void leap_damped(double s, double h);
  double damping_work() const;
  std::span<const HeldDirection> held_of(Index row) const;
  void gather(const Field& u, const std::vector<Index>& rows, Points& x) const;
  double scalar_product(const Field& v, const Field& w) const;  // v . M w
  // of translation and rotation, component axes
  Eigen::Matrix<double, 6, 1> momenta(const Field& v) const;

  bool is_loaded() const;
  // Of a body that turns
  void turn_freely(const Vector3& angular_velocity);
  void fit_now();
  void forget_end();
  void move_end(Index row, const Vector3& u);
  const MeshFit& fit_at_end() const;
  void form_turned_forces() const;
  const Field& turned_forces() const;
  void leap_turned(double s, double h);
  void turned_damping(const Field& v, Field& f) const;
  void add_turned_load(const VectorForce& force, const LoadHistory& history);
  void add_turned_loads(double t, Field& f) const;
  BodyTurn turn_of(const MeshFit& fit) const;
  void unturned(const MeshFit& fit, const Field& u, Index set, Points& x) const;
  void unturned_fields(Field& u, Field& v) const;
  Field arms_now() const;                       // 0 of rotations
  Field spun(const Vector3& w) const;           // velocities of a rigid rotation about the centre
  void turn_nodes();                            // u_end_ of rotations
  Vector3 spin_of_nodes(const Field& p) const;  // sum over rotations
  Field momenta_of_nodes(const Field& v) const;
  void book_moments();
  BodyState turned_state() const;
  void keep_turning(StateArchive& archive);

  std::unique_ptr<Body> still_;  // does statics; none: there are none, or motion has begun
  std::shared_ptr<const MeshModel> model_;
  Placement placement_;
  std::vector<HeldDirection> held_;  // ascending; the row in place of the node
  double largest_frequency_ = 0;
  std::shared_ptr<RowThreads> threads_;
  SparseMatrix Z_;                          // 3 n x free: consistent mass with held directions
  std::shared_ptr<SparseCholesky> factor_;  // of Z^T M Z
  std::vector<std::vector<Index>> sets_, means_;  // rows
  // of each set, before the step that predict() has begun
  std::vector<Points> v_before_;
  Loads<NodalForces> loads_;  // component axes, by rows
  Field u_, u_end_;           // component axes, by rows
  Field v_;  // half a step behind u_; half a step behind u_end_ from predict() to accept()
  mutable Field load_, Ku_, v_now_;
  mutable MeshForces::Work room_;
  mutable bool Ku_is_current_ = false, v_now_is_current_ = false;
  std::vector<Kick> kicks_;  // of this step
  // What contact does to velocities all the time, component axes; 0 rows: nothing
  Field lasting_;
  double last_h_ = 0;
  MaterialDamping damping_;
  // Damped, from predict() to accept(): v- and K v-
  Field v_old_;
  mutable Field Kv_;
  double Ku_v_before_ = 0;  // K u . v- of a step of another length than the last
  BodyWork work_;
  std::shared_ptr<Turning> turning_;  // none: linear
};

}  // namespace cbr
