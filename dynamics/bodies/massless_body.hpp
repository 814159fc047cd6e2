// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement whose interface has no mass: modes that move by themselves, and an interface that answers forces at once.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/bodies/massless_form.hpp"
#include "dynamics/bodies/superelement_body.hpp"

namespace cbr {

// u_c = V_c eta + F (f + lambda). Contact at the end of a step finds the force lambda there, given as impulse / h: the interface
// moves by F lambda, which is its response, and the modes feel lambda from then on as half a kick before and half a kick after that
// moment. With Scheme::exact that is Gautschi's trigonometric scheme, by the gain of set_contact_step(); with central differences
// leapfrog. docs/theory.md, 4. Not with Scheme::newmark, add_velocities() or nodal_masses().
class MasslessBody final : public Body {
 public:
  MasslessBody(std::string name, std::shared_ptr<const Superelement> superelement, std::shared_ptr<const MasslessForm> form,
               const Placement& placement, Scheme scheme);

  const std::string& name() const override { return modal_.name(); }
  Index n_dofs() const override { return modal_.n_dofs(); }
  double largest_frequency() const override { return form_->omega_closed; }
  Scheme scheme() const override { return modal_.scheme(); }
  double contact_share() const override { return 0.2; }
  void set_contact_step(double h) override { modal_.set_contact_step(h); }
  const Points& reference_positions() const override { return modal_.reference_positions(); }

  Index track(const std::vector<Index>& nodes) override;
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  MotionBound motion_bound(Index set) const override;
  MotionBound quick_motion_bound(Index set) const override;
  bool at_rest() const override { return modal_.at_rest() && g_.isZero(0) && loads_.empty(); }
  Index track_mean(const std::vector<Index>& nodes) override;
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const override;

  void predict(double t, double h) override;
  using Body::add_impulses;
  void add_impulses(Index set, const Points& impulses, ImpulseKind kind) override;
  void add_answered_impulses(Index set, const Points& contact, const Points& friction, const Points& move) override;
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  void accept() override;

  NodeResponse response(Index set, double h) const override;
  Points nodal_masses(Index set) const override;
  void add_force(const Points& forces, const LoadHistory& history) override;
  void add_gravity(const Vector3& acceleration, const LoadHistory& history) override { modal_.add_gravity(acceleration, history); }

  BodyState state() const override;
  BodyWork work() const override;
  void displacements(Points& u, Points& v) const override;
  void coordinates(Vector& q, Vector& rates) const override;
  void keep_state(StateArchive& archive) override;

 private:
  // w: F (f + lambda) of the nodes, force and friction: lambda, now and at the end of the step; m x 3, scene axes.
  struct NodeSet {
    Index modal = 0;
    std::vector<Index> nodes;
    Points w, w_end, force, force_end, friction, friction_end;
  };
  struct MeanSet {
    Index modal = 0;
    std::shared_ptr<const Matrix> Vt;  // n x 3
    Matrix F;                          // c x 3, mean over the nodes of F's rows
  };
  struct StaticLoad {
    Vector f, Ff;  // c
    LoadHistory history;
  };

  Index row(Index node, int d) const { return (*rows_)(node, d) - k_; }  // of F, below 0 for none
  void add_rows(const Vector& u_c, double factor, const std::vector<Index>& nodes, Points& u) const;
  void push(Index set, const Points& impulses, const Points& move);
  MotionBound with_statics(MotionBound bound, Index set) const;

  SuperelementBody modal_;
  std::shared_ptr<const Superelement> superelement_;
  std::shared_ptr<const MasslessForm> form_;
  Matrix3 T_;
  Index k_ = 0;
  std::shared_ptr<const IndexTable> rows_;
  std::vector<NodeSet> sets_;
  std::vector<MeanSet> means_;
  std::vector<StaticLoad> loads_;
  Vector g_, g_end_, g_before_;  // c, f + lambda in component axes; before: of the last step
  Vector eta_before_;
  std::vector<double> loads_now_, loads_end_;  // values of the histories
  double t_ = 0, h_ = 0;
  bool is_pushed_ = false, was_in_contact_ = false;  // in this step; at the start or the end of the last one
  bool has_force_ = false;                           // now
  BodyWork work_;                                    // of the statics
};

}  // namespace cbr
