// SPDX-License-Identifier: GPL-3.0-or-later
// Motion of a body's residual compliance, which follows forces without inertia.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/motion/modal/forms/residual_compliance.hpp"

namespace cbr {

// u_c = B F B^T (f + g), beside the modes of the form. Contact at the end of a step finds the force
// lambda there, given as impulse / h. The compliance follows it: g_end = (1 - theta) g + theta
// lambda, theta = h / ResidualCompliance::following(h); massless without damping: 1. The interface
// moves by theta B F B^T lambda, which is in its response. A step loses theta (1 - theta / 2)
// |lambda - g|_F^2 and never brings energy. Stiffness-proportional damping (beta, s) acts here too,
// other damping on the modes alone. A form without residual compliance is the case s = 0: nothing
// moves, and nothing is kept. Sets have the numbers of the body's.
class ResidualMotion {
 public:
  // rows: of the form's V, for each node and component; T: component axes to scene axes.
  ResidualMotion(std::shared_ptr<const ModalForm> form, std::shared_ptr<const IndexTable> rows,
                 const Matrix3& T, double beta);

  bool is_massless() const { return of_ && of_->is_massless; }
  double critical_frequency() const;  // rad/s, with damping; of a form with residual compliance
  bool at_rest() const { return g_.isZero(0) && loads_.empty(); }
  void track(const NodeRows& nodes);
  void track_mean(const std::vector<Index>& nodes);

  // Loads begin at t = 0.
  void add_load(const NodalForces& forces, const LoadHistory& history);
  // Loads whose factor a floating frame sets: first `factor`, then at the end of the next step a
  // number for each call.
  void add_turning_load(const NodalForces& forces, double factor, const LoadHistory& history);
  void turn_loads(const Vector& factors, const Vector& largest);
  Vector load() const;  // of all loads with a factor of 1, s

  // One jump over h does what n_steps of h / n_steps do.
  void predict(double t, double h, Index n_steps);
  void push(Index set, const Impulses& impulses);
  double friction(Index set, const Points& impulses, bool between);
  const BodyWork& work() const { return work_; }
  // Whether accept() reads eta at the start of the last regular step of a jump.
  bool needs_last_step() const { return n_steps_ > 1 && is_pushed_ && is_massless(); }
  void accept(const Vector& eta);  // eta: modal coordinates at the start of the step

  // Each adds the part of the residual compliance.
  void add_positions(Index set, Points& x) const;
  void add_predicted_positions(Index set, Points& x) const;
  void add_bound(Index set, MotionBound& bound) const;
  void add_strain_energy(double& energy) const;
  // Velocities of an interface without mass in contact are those of the last step, of the modes
  // too. Vt: n x 3, modal rows of the mean.
  void add_mean_motion(Index set, const Matrix& Vt, const Vector& eta, Vector3& position,
                       Vector3& velocity) const;
  void add_coordinates(const Vector& eta, Vector& q, Vector& rates) const;

  // As contact sees the nodes, modes included; weight: of these.
  std::shared_ptr<const ThinResponse> response(Index set, const ResponseOf& of,
                                               const Vector& weight) const;
  Matrix compliance(Index set) const;  // B F B^T   (3 m x 3 m), component axes

  // Equilibrium: the iterations of Body::relax(); push() takes forces then.
  void relax(double t, double share);
  void settle(Settled& settled);
  void end_load_step();
  void start_motion(double h, const Vector& eta);  // nothing without statics before

  void keep_state(StateArchive& archive);

 private:
  // Of the set's rows (s'), now, at the end of the step and at that of the last load step. w: F (f
  // + g); force: g; rate_before: of w in the last step; friction: of friction, as force is.
  struct NodeSet {
    std::shared_ptr<const ResidualCompliance::OfNodes> of;
    Vector w, w_end, w_start, force, force_end, force_start, rate_before, friction;
  };
  struct ResidualLoad {
    Vector f, Ff;  // s
    LoadHistory history;
    // beside the history's, at the end of the step, and at most; of add_turning_load()
    double factor = 1, largest = 1;
    bool turns = false;
    double now = 0, end = 0, start = 0;  // values; start: of the last load step
  };

  ResidualLoad load_of(const NodalForces& forces, const LoadHistory& history) const;
  void append_load(ResidualLoad load);
  void begin_load_step();
  double follow_on(double share, Index n_steps);
  double load_at_end(const ResidualLoad& load, double t) const;
  double damping_rate() const;
  Vector before_last_step() const;
  void add_rows(const NodeSet& set, const Vector& w, Points& x) const;
  void press_on(const NodeSet& set, const Points& impulses);
  void add_force(Index set, const Vector& still);

  std::shared_ptr<const ModalForm> form_;
  std::shared_ptr<const ResidualCompliance> of_;  // null: none
  std::shared_ptr<const IndexTable> rows_;
  Matrix3 T_;
  double beta_ = 0, h_ = 0, following_ = 0;  // h_: of one regular step
  Index n_steps_ = 1;                        // of the jump, and what they leave of g
  double left_ = 0;
  std::vector<NodeSet> sets_;
  std::vector<Matrix> means_;  // s x 3, mean over the nodes of B F's rows
  std::vector<ResidualLoad> loads_;
  // s, f + g along the rows; before: of the last step; start: of the last load step, empty before
  // the first relax()
  Vector g_, g_end_, g_before_, g_start_;
  Vector eta_before_;
  Vector pressed_;  // workspaces: impulses / following_ along a set's rows
  Matrix column_, still_;
  std::vector<Index> columns_;
  // has g at the end of this step; at the start or the end of the last one
  bool is_pushed_ = false, was_in_contact_ = false;
  bool has_force_ = false;  // has g now
  bool is_predicted_ = false;
  double still_left_ = 0;  // of g since contact last pushed, a share
  BodyWork work_;
};

}  // namespace cbr
