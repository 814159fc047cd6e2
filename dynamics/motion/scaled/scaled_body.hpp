// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion/scaled: superelements with modal mass scaling.
//
// A superelement whose modes above a clip frequency are slowed down to it, and advanced exactly:
// longer steps in contact.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/motion/breakpoints.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"
#include "dynamics/motion/scaled/scaled_model.hpp"
#include "dynamics/motion/scaled/scaled_motion.hpp"

namespace cbr {

// Statics, rigid motion and the modes below the clip are those of the superelement; a step costs
// O(n_kept + 3 m) and one product with a shared 3 m x 3 m matrix, m the tracked nodes. Assumes
// small displacements and rotations as SuperelementBody does. Nothing is scaled when BodyPlan::clip
// is not below the highest frequency or no node is tracked. Sets are tracked before prepare():
// std::logic_error after it. RunError: ScaledModel::clipped().
class ScaledBody final : public Body {
 public:
  // `model` is shared by the instances of a component (a held instance has its own).
  ScaledBody(std::string name, std::shared_ptr<ScaledModel> model, const Placement& placement);

  bool is_scaled() const { return modes_ && modes_->part; }
  Index n_kept() const { return modes_ ? modes_->n_kept() : 0; }
  Index n_scaled() const { return modes_ ? modes_->n_scaled : 0; }
  // Kinetic + strain energy that sits in scaled modes now: its share of all energy says how much
  // the scaling matters.
  double scaled_energy() const;

  // of the superelement before prepare(), of what it has become after
  double largest_frequency() const override;

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  MotionBound own_motion_bound(Index set, bool) const override;
  Index own_track_mean(const std::vector<Index>& nodes) override;
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_accept() override;
  NodeResponse own_response(Index set, double h) const override;  // shared between the instances
  BodyState own_state() const override;
  BodyWork own_work() const override { return work_; }
  void own_displacements(Points& u, Points& v) const override;
  void own_coordinates(Vector& q, Vector& rates) const override;
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan& plan) override;
  void predict_end() override;

  struct NodeSet {
    std::vector<Index> nodes;
    Points X;                                        // m x 3, scene axes
    std::vector<Index> slot;                         // among the nodes of all sets
    bool whole = false;                              // the set is all of them, in their order
    mutable std::shared_ptr<const ScaledRows> rows;  // filled when first needed
  };
  struct MeanSet {
    std::vector<Index> nodes;
    Vector3 X;
    Matrix Vt, St;  // n_kept x 3, (3 m + loads) x 3: component axes
  };
  // Force [nodal forces] + M^ R rigid, component axes, times a history.
  struct Load {
    Points forces;  // n_nodes x 3 or nothing
    Eigen::Matrix<double, 6, 1> rigid;
    LoadHistory history;
    bool is_load = true;  // false: the velocity at the start, which has no history
  };

  void scale(double clip);
  void require_plan(bool is_there) const;
  void append_load(Load load);
  void take_known_moves(const Impulses& impulses);
  Matrix force_columns() const;
  void fill_loads();
  void fill_mean(MeanSet& set) const;
  const ScaledStep& step_of(double h) const;
  void load_amplitudes(double t, ScaledLoad& load) const;
  void propagate(const ScaledState& start, ScaledState& end, double& external_work);
  void apply_gain(ScaledKick& kick) const;
  void local_kick(const NodeSet& set, const Points& impulses);
  void write_positions(const NodeSet& set, const ScaledState& state, Points& x) const;
  Matrix whole_motion() const;
  Index n_tracked() const { return 3 * static_cast<Index>(tracked_.size()); }

  std::shared_ptr<ScaledModel> model_;
  std::shared_ptr<const ScaledModes> modes_;
  Placement placement_;
  std::vector<NodeSet> sets_;
  std::vector<MeanSet> means_;
  std::vector<Index> tracked_;  // nodes of all sets
  std::vector<Index> slot_of_;  // per node, -1 for none
  std::shared_ptr<const ScaledRows> rows_;

  std::vector<Load> loads_;
  LoadNumbers load_of_;
  Breakpoints breakpoints_;  // of all histories
  Matrix load_modal_;        // n_kept x loads, V^T f
  Matrix load_scaled_;       // (3 m + loads) x loads, S f at the tracked dofs and along the loads
  // 6 x (3 m + loads), R^T M^ S; empty when the scaled part has no momentum
  Matrix rigid_scaled_;
  bool loaded_ = false;  // some load has a history, not only the velocity at the start

  ScaledState now_, end_, part_;
  ScaledGain gain_;
  double contact_step_ = 0;  // 0: without gain
  ScaledKick kick_, friction_, fresh_;
  ScaledLoad f0_, f1_;
  mutable Vector local_;  // 3 m
  Vector weighted_;       // n_kept
  double step_work_ = 0;
  mutable ScaledStep regular_, other_;  // of the last two step lengths
  BodyWork work_;
};

}  // namespace cbr
