// SPDX-License-Identifier: GPL-3.0-or-later
// A body whose supports move unlike each other, or turn, and whose reactions are asked for set by
// set.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/motion/support_shapes.hpp"

namespace cbr {

// u = u_r + sum over the drives psi_j g_j(t). psi_j is the static displacement for a unit motion of
// drive j: K psi_j = 0 at free dofs. So u_r is 0 at the supports, and only the inertia -M psi_j
// g_j'' loads it. The reaction of a set is psi_s . (M u'' + K u - f), with the shape psi_s that
// moves this set alone. docs/theory.md, "Supports that move".
class SupportedBody final : public Body,
                            public JumpAbility,
                            public NodalAbility,
                            public EndImpulseAbility,
                            public StaticsAbility {
 public:
  // inner: held, before any set is tracked and any load.
  SupportedBody(std::unique_ptr<Body> inner, SupportPlan plan);

  const std::vector<ReactionSet>& reaction_sets() const { return plan_.sets; }
  struct Reaction {
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  };
  // Of the sets on the body: means over [t - interval, t], the time since the last call; 0 if
  // interval is 0.
  std::vector<Reaction> take_reactions(double t, double interval);
  std::vector<Reaction> static_reactions(double t) const;  // in statics, now

  const std::string& name() const override { return inner_->name(); }
  Index n_dofs() const override { return inner_->n_dofs(); }
  double largest_frequency() const override { return inner_->largest_frequency(); }
  Scheme scheme() const override { return inner_->scheme(); }
  double contact_share() const override { return inner_->contact_share(); }
  void set_contact_step(double h) override { inner_->set_contact_step(h); }
  void damp(const Damping& damping) override { inner_->damp(damping); }
  bool at_rest() const override { return plan_.drives.empty() && inner_->at_rest(); }

  const Points& reference_positions() const override { return inner_->reference_positions(); }
  Index track(const std::vector<Index>& nodes) override;
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  const JumpAbility* jumps() const override { return inner_->jumps() ? this : nullptr; }
  MotionBound motion_bound(Index set) const override {
    return moved(inner_->jumps()->motion_bound(set), set);
  }
  MotionBound quick_motion_bound(Index set) const override {
    return moved(inner_->jumps()->quick_motion_bound(set), set);
  }
  Index track_mean(const std::vector<Index>& nodes) override;
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override;

  void predict(double t, double h) override;
  using Body::add_impulses;
  void add_impulses(Index set, const Points& impulses, ImpulseKind kind) override;
  void add_answered_impulses(Index set, const Points& contact, const Points& friction,
                             const Points& move, const Vector& still) override;
  NodalAbility* nodal() override { return inner_->nodal() ? this : nullptr; }
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  void accept() override;
  EndImpulseAbility* end_impulses() override { return inner_->end_impulses() ? this : nullptr; }
  void end_velocities(Index set, Points& v) override;
  NodeResponse velocity_response(Index set) const override {
    return inner_->end_impulses()->velocity_response(set);
  }
  void add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) override;

  StaticsAbility* statics() override { return inner_->statics() ? this : nullptr; }
  void relax(const Rest& rest) override;
  NodeResponse static_response(Index set, double hold) const override {
    return inner_->statics()->static_response(set, hold);
  }
  void add_static_forces(Index set, const Points& forces, ImpulseKind kind) override;
  Settled settle() override;
  void end_load_step() override;
  void start_motion(double h) override;

  NodeResponse response(Index set, double h) const override { return inner_->response(set, h); }
  Points nodal_masses(Index set) const override { return inner_->nodal()->nodal_masses(set); }
  void add_force(const Points& forces, const LoadHistory& history) override;
  void add_gravity(const Vector3& acceleration, const LoadHistory& history) override;
  void add_modal_force(const Vector& forces, const LoadHistory& history) override;

  BodyState state() const override;
  // The supports' work is external.
  BodyWork work() const override;
  void displacements(Points& u, Points& v) const override;
  void coordinates(Vector& q, Vector& rates) const override;
  void turn(const Points& X, Points& u, Points& v) const override { inner_->turn(X, u, v); }
  void keep_state(StateArchive& archive) override;

 private:
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
  void add_inertia();
  void add_load(Vector on_shapes, const LoadHistory& history);
  void move(Index set, const Vector& g, Points& x) const;
  MotionBound moved(MotionBound bound, Index set) const;
  // psi^T of impulses or forces on the set
  Vector on_shapes(Index set, const Points& impulses) const;
  void push(Index set, const Points& impulses, ImpulseKind kind, double t);
  double energy_of_motion() const;
  Vector momenta() const;  // psi^T M u'
  std::vector<Reaction> by_sets(const Vector& on_shapes) const;

  std::unique_ptr<Body> inner_;
  SupportPlan plan_;
  Matrix mass_;   // psi^T M psi
  Matrix nodal_;  // 3 n x shapes: psi of the nodes, scene axes
  std::vector<NodeSet> sets_;
  std::vector<Matrix> means_;  // 3 x drives
  std::vector<WorkingLoad> loads_;
  double now_ = 0, t_ = 0, h_ = 0;
  double energy_at_start_ = 0;
  double contact_ = 0, friction_ = 0;  // work of impulses on the supports' motion
  Vector pushed_;                      // psi^T of impulses since the last take_reactions()
  Vector momenta_;                     // then
  // Statics: psi^T of contact and of friction, of this iteration and at the end of the last load
  // step, and its time
  Vector forces_[2], forces_start_[2];
  double start_ = 0;
};

}  // namespace cbr
