// SPDX-License-Identifier: GPL-3.0-or-later
// A body whose supports move unlike each other, or turn, and whose reactions are asked for set by
// set.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "dynamics/motion/support_shapes.hpp"
#include "dynamics/motion/wrapped_body.hpp"

namespace cbr {

// u = u_r + sum over the drives psi_j g_j(t). psi_j is the static displacement for a unit motion of
// drive j: K psi_j = 0 at free dofs. So u_r is 0 at the supports, and only the inertia -M psi_j
// g_j'' loads it. The reaction of a set is psi_s . (M u'' + K u - f), with the shape psi_s that
// moves this set alone. docs/theory.md, "Supports that move".
class SupportedBody final : public WrappedBody {
 public:
  // inner: held, before any set is tracked.
  SupportedBody(std::unique_ptr<Body> inner, SupportPlan plan);

  const std::vector<ReactionSet>& reaction_sets() const { return plan_.sets; }
  struct Reaction {
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  };
  // Of the sets on the body: means over [t - interval, t], the time since the last call; 0 if
  // interval is 0.
  std::vector<Reaction> take_reactions(double t, double interval);
  std::vector<Reaction> static_reactions(double t) const;  // in statics, now

  bool at_rest() const override { return plan_.drives.empty() && inner_->at_rest(); }

  Index track(const std::vector<Index>& nodes) override;
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  MotionBound motion_bound(Index set) const override {
    return moved(inner_->bounds()->motion_bound(set), set);
  }
  MotionBound quick_motion_bound(Index set) const override {
    return moved(inner_->bounds()->quick_motion_bound(set), set);
  }
  Index track_mean(const std::vector<Index>& nodes) override;
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override;

  void take_impulses(Index set, const Impulses& impulses) override;
  void expect_forces(Index set, const Impulses& forces) override;
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
  void coordinates(Vector& q, Vector& rates) const override;
  void keep_state(StateArchive& archive) override;

 private:
  void take_plan(const BodyPlan& plan) override;

  // Of the nodes of a set, scene axes.
  struct NodeSet {
    Matrix psi;           // 3 m x shapes
    Matrix lower, upper;  // 3 x drives, the least and largest over the nodes
  };
  struct WorkingLoad {
    Vector on_shapes;  // psi^T f
    LoadHistory history;
  };

  Index n_drives() const { return static_cast<Index>(plan_.drives.size()); }
  Index n_shapes() const { return plan_.shapes.psi.cols(); }
  Vector displacement(double t) const;  // of the drives
  Vector velocity(double t) const;
  Matrix rows_of(const std::vector<Index>& nodes) const;
  std::vector<BodyLoad> with_inertia(const std::vector<BodyLoad>& loads) const;
  void add_load(const BodyLoad& load);
  void move(Index set, const Vector& g, Points& x) const;
  MotionBound moved(MotionBound bound, Index set) const;
  // psi^T of impulses or forces on the set
  Vector on_shapes(Index set, const Points& impulses) const;
  void book(const Vector& on_shapes, ImpulseKind kind, double t);
  double energy_of_motion() const;
  Vector momenta() const;  // psi^T M u'
  std::vector<Reaction> by_sets(const Vector& on_shapes) const;

  SupportPlan plan_;
  Matrix mass_;   // psi^T M psi
  Matrix nodal_;  // 3 n x shapes: psi of the nodes, scene axes
  std::vector<NodeSet> sets_;
  std::vector<Matrix> means_;  // 3 x drives
  std::vector<WorkingLoad> loads_;
  double now_ = 0;
  double energy_at_start_ = 0;
  double contact_ = 0, friction_ = 0;  // work of impulses on the supports' motion
  Vector pushed_;                      // psi^T of impulses since the last take_reactions()
  Vector momenta_;                     // then
  // Statics: psi^T of contact and of friction, of this iteration and at the end of the last load
  // step, and its time
  Vector forces_[2], forces_start_[2];
  // psi^T of forces that last, of contact and of friction; empty: none yet
  Vector lasting_[2];
  double start_ = 0;
};

}  // namespace cbr
