// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement whose interface answers forces at once, beside modes that move by themselves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/modal/forms/statics_form.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

// u_c = V_c eta + B F B^T (f + g). Contact at the end of a step finds the force lambda there, given
// as impulse / h. Statics follow it: g_end = (1 - theta) g + theta lambda, theta = h /
// StaticsForm::following(h); massless without damping: 1. The interface moves by theta B F B^T
// lambda, which is in its response. Massless: the modes feel lambda from then on as half a kick
// before and half a kick after that moment. With Scheme::exact that is Gautschi's trigonometric
// scheme, by the gain of BodyPlan::contact_step; with central differences leapfrog. docs/theory.md,
// (39), (40). Not with Scheme::newmark. Shapes with mass: the modes get the impulse at the start of
// the step, as those of SuperelementBody. The statics lose theta (1 - theta / 2) |lambda - g|_F^2
// in a step and never bring energy. Neither with add_velocities() or nodal_masses().
// Stiffness-proportional damping acts on the statics too, other damping on the modes alone.
class StaticsBody final : public Body {
 public:
  StaticsBody(std::string name, std::shared_ptr<const Superelement> superelement,
              std::shared_ptr<const StaticsForm> form, const Placement& placement, Scheme scheme,
              const NewmarkOptions& newmark = {}, const Damping& damping = {});

  double largest_frequency() const override {
    return form_->is_massless ? critical_frequency(form_->omega_limit, beta_) : form_->omega_limit;
  }

  double lasting_share() const override { return modal_.lasting_share(); }

  FloatingForces floating_forces() const override;
  void float_by(const Vector& move) override;
  const SuperelementBody& modal() const { return modal_; }
  SuperelementBody& modal() { return modal_; }
  const StaticRows& static_rows() const { return form_->rows; }  // of all nodes, component axes
  // of all loads with a factor of 1, s
  Vector static_load() const;

  // Statics of nodal forces whose factor another sets, as SuperelementBody::turn_forces() has it of
  // their modal forces: first `factor`, then at the end of the next step a number for each call.
  void add_turning_statics(const Points& forces, double factor, const LoadHistory& history);
  void turn_statics(const Vector& factors, const Vector& largest);
  void add_start_impulse(const Vector& impulse) override { modal_.add_start_impulse(impulse); }

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  MotionBound own_motion_bound(Index set, bool quick) const override;
  bool own_at_rest() const override { return modal_.at_rest() && g_.isZero(0) && loads_.empty(); }
  Index own_track_mean(const std::vector<Index>& nodes) override;
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_expect_forces(Index set, const Points& forces) override {
    modal_.expect_forces(sets_[set].modal, forces);
  }
  double own_residual_friction(Index set, const Points& impulses, bool between) override;
  void own_accept() override;
  // Of the modes: what statics do to velocities is over at the end of a step.
  void own_end_velocities(Index set, Points& v) override {
    modal_.end_velocities(sets_[set].modal, v);
  }
  NodeResponse own_velocity_response(Index set) const override;
  void own_add_end_impulses(Index set, const Points& impulses) override {
    modal_.add_end_impulses(sets_[set].modal, impulses);
  }
  void own_relax(double t, double share) override;
  Matrix own_floating_motions(Index set) const override;
  NodeResponse own_static_response(Index set) const override;
  void own_add_static_forces(Index set, const Points& forces) override;
  Settled own_settle() override;
  void own_end_load_step() override;
  void own_start_motion(double h, const std::vector<BodyLoad>& loads) override;
  NodeResponse own_response(Index set, double h) const override;
  BodyState own_state() const override;
  BodyWork own_work() const override;
  void own_displacements(Points& u, Points& v) const override;
  void own_coordinates(Vector& q, Vector& rates) const override;
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan& plan) override;
  void predict_end() override;

  // Of the set's static rows (s'), now and at the end of the step. w: F (f + g); force: g;
  // rate_before: of w in the last step; friction: of friction, as force is.
  struct NodeSet {
    Index modal = 0;
    std::shared_ptr<const StaticsForm::OfNodes> of;
    Vector w, w_end, force, force_end, rate_before, friction;
  };
  struct MeanSet {
    Index modal = 0;
    std::shared_ptr<const Matrix> Vt;  // n x 3
    Matrix F;                          // s x 3, mean over the nodes of B F's rows
  };
  struct StaticLoad {
    Vector f, Ff;  // s
    LoadHistory history;
    // beside the history's, at the end of the step, and at most; of add_turning_statics()
    double factor = 1, largest = 1;
    bool turns = false;
  };

  StaticLoad static_load_of(const Points& forces, const LoadHistory& history) const;
  void add_statics(const std::vector<BodyLoad>& loads);
  void append_load(StaticLoad load);
  void keep_load_step();
  NodeResponse massless_static_response(const NodeSet& set, const ResponseOf& of,
                                        const Vector& weight) const;
  double follow_on(double share);
  void add_rows(const NodeSet& set, const Vector& w, Points& x) const;
  void pressed_by(const NodeSet& set, const Points& impulses, Vector& rows) const;
  void push(Index set, const Vector& pressed, const Vector& still);
  void kick(Index set, const Points& impulses);

  SuperelementBody modal_;
  std::shared_ptr<const Superelement> superelement_;
  std::shared_ptr<const StaticsForm> form_;
  Matrix3 T_;
  Index k_ = 0;
  double beta_ = 0;  // s, damping of the stiffness
  // At the end of the last load step, of each set and of the whole body.
  struct LoadStep {
    std::vector<Vector> w, force;
    Vector g;
    std::vector<double> loads;
  };
  std::vector<NodeSet> sets_;
  LoadStep load_step_;  // empty before the first relax()
  std::vector<MeanSet> means_;
  std::vector<StaticLoad> loads_;
  Vector g_, g_end_, g_before_;  // s, f + g along the rows; before: of the last step
  Vector eta_before_;
  std::vector<double> loads_now_, loads_end_;  // values of the histories
  Vector pressed_;                             // workspace: impulses / h along a set's rows
  Matrix rows_, still_;
  std::vector<Index> columns_;
  double following_ = 0;
  // has g at the end of this step; at the start or the end of the last one
  bool is_pushed_ = false, was_in_contact_ = false;
  bool has_force_ = false;  // has g now
  double still_left_ = 0;   // of g since contact last pushed, a share
  BodyWork work_;           // of the statics
};

}  // namespace cbr
