// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model that moves, by central differences or Newmark: its matrices are factored once,
// before the first step.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/motion/coupled/coupled_model.hpp"
#include "dynamics/motion/coupled/coupled_system.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/motion/schemes.hpp"

namespace cbr {

// What moves are the displacements u and the momenta p = M v of all coordinates; velocities are
// M^-1 p when someone asks, so that impulses change the momentum by exactly their sum. A step of
// central differences solves with M once and multiplies with K once; one of Newmark solves with A =
// M + theta K instead; HHT-alpha solves with M too, to account for its damping. Nothing is
// allocated.
class CoupledBody final : public Body {
 public:
  // `scheme` is not exact. add_velocities() is not for Scheme::newmark.
  CoupledBody(std::string name, std::shared_ptr<CoupledSystem> system, const Placement& placement,
              Scheme scheme, const NewmarkOptions& newmark, const MaterialDamping& damping = {});

  // Under newmark, where no step depends on it, without damping.
  double largest_frequency() const override {
    return critical_frequency(system_->largest_frequency(),
                              scheme() == Scheme::newmark ? 0 : damping_.beta);
  }

  double lasting_share() const override { return scheme() == Scheme::central_difference ? 0.5 : 0; }

  FloatingForces floating_forces() const override;
  void float_by(const Vector& move) override;

  Points nodal_masses(Index set) const override;
  void add_start_impulse(const Vector& impulse) override;

 private:
  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  Index own_track_mean(const std::vector<Index>& nodes) override;
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_expect_forces(Index set, const Points& forces) override;
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
  Vector3 own_add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  BodyState own_state() const override;
  BodyWork own_work() const override { return work_; }
  void own_displacements(Points& u, Points& v) const override;
  void own_coordinates(Vector& q, Vector& rates) const override;
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan& plan) override { add_loads(plan.loads); }
  void predict_end() override;

  bool is_damped() const { return damping_ != MaterialDamping(); }
  // Of the matrix whose inverse answers impulses, mass_factor (M + theta K): of damped bodies C
  // adds to both.
  double theta(double h) const {
    if (scheme() != Scheme::newmark) return 0;
    const double theta = newmark_.numbers().stiffness_factor(h);
    return is_damped() ? theta * (1 + 2 * damping_.beta / h) / mass_factor(h) : theta;
  }
  double mass_factor(double h) const {
    if (scheme() != Scheme::newmark) return 1 + 0.5 * h * damping_.alpha;
    return 1 + 2 * newmark_.numbers().stiffness_factor(h) * damping_.alpha / h;
  }
  void solve_for_velocities();
  void damping_force(const Vector& p, const Vector& v, Vector& f) const;
  void book_central_damping();
  auto displacement(const Vector& u, Index node) const {
    return u.segment<3>(system_->n_modal() + 3 * node);
  }
  void gather(const Vector& u, const std::vector<Index>& nodes, Points& x) const;
  // f: forces on nodes (n x 3, scene axes) as forces on the coordinates, held directions dropped.
  void spread(const std::vector<Index>& nodes, const Points& forces, Vector& f) const;
  // weight G M^-1 G^T
  NodeResponse mass_response(const std::vector<Index>& nodes, double weight) const;
  void add_loads(const std::vector<BodyLoad>& loads);
  void append_load(Vector force, const LoadHistory& history);
  const Vector& stiffness_force() const;  // K u, formed once for each u
  const Vector& present_velocities() const;
  void predict_central(double h);
  void begin_central(double h, const Vector& F);
  void accept_central();
  NewmarkOperators operators();
  void arrive_newmark();

  std::shared_ptr<CoupledSystem> system_;
  Placement placement_;
  std::vector<std::vector<Index>> sets_, means_;
  Loads<Vector> loads_;  // n, component axes
  // Component axes. Central differences: p_ and v_ are half a step behind u_. Newmark has no v_.
  Vector u_, p_, v_, u_end_, p_end_, v_end_;
  Kick kick_;
  Vector lasting_;      // forces that last, n; empty: none
  Kick velocity_kick_;  // M times the velocities that add_velocities() brought
  MaterialDamping damping_;
  Newmark newmark_;
  StaticState statics_;  // empty before the first relax()
  Vector Cv_;            // damped central differences: beta K v-
  mutable Vector room_, work_vector_, Ku_, v_now_;
  Vector Ku_end_;  // Newmark
  mutable bool Ku_is_current_ = false, v_now_is_current_ = false;
  double last_h_ = 0;
  BodyWork work_;
};

// `held`: ascending by node, component axes. RunError when the mass is not positive definite.
std::unique_ptr<Body> coupled_body(std::string name, std::shared_ptr<const CoupledModel> model,
                                   const Placement& placement,
                                   const std::vector<HeldDirection>& held, Scheme scheme,
                                   const NewmarkOptions& newmark);

}  // namespace cbr
