// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion/modal: bodies in modal coordinates; large rotations.
//
// A body that moves by the modes of a form, advanced exactly, by central differences or by Newmark.
// With large rotation in a floating frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/damping.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/modal/frame.hpp"
#include "dynamics/motion/modal/modal_flow.hpp"
#include "dynamics/motion/modal/modal_newmark.hpp"
#include "dynamics/motion/modal/residual_motion.hpp"
#include "dynamics/motion/schemes.hpp"

namespace cbr {

// Where an instance of a component is: x_scene = T x_component + position, u_scene = T u_component.
struct Placement {
  Matrix3 T = Matrix3::Identity();
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();  // of the whole body at the start, scene axes

  // of points of the component, n x 3
  std::shared_ptr<const Points> placed(const Points& x) const {
    return std::make_shared<const Points>((x * T.transpose()).rowwise() + position.transpose());
  }
  // Of a linear motion, without energies. moment, rate: 6, R^T M u and R^T M v of the rigid motions
  // R about the centre of mass, component axes.
  BodyState state(const RigidBody& rigid, const Vector& moment, const Vector& rate) const;
};

// The modes of a form and its residual compliance. Modes with mass get impulses of contact at the
// start of the step. Beside a massless interface they get half of the force of contact before the
// end of the step and half after it: Gautschi's trigonometric scheme with Scheme::exact, by the
// gain of BodyPlan::contact_step, and leapfrog with central differences (docs/theory.md, (39),
// (40)). Displacements and rotations relative to the placed component are small (state().rotation).
class ModalBody final : public Body {
 public:
  // `form` belongs to `superelement`; both are shared by the instances of a component (a held
  // instance has its own form). add_velocities() and nodal_masses() need the superelement's
  // matrices, and no residual compliance. Not with Scheme::newmark: add_velocities(),
  // motion_bound(), a massless interface. `newmark` is read with Scheme::newmark only.
  ModalBody(std::string name, std::shared_ptr<const Superelement> superelement,
            std::shared_ptr<const ModalForm> form, const Placement& placement, Scheme scheme,
            const NewmarkOptions& newmark = {}, const Damping& damping = {});

  // From here on a free body with large rotation. angular_velocity: rad/s, scene axes; end: of the
  // run, s.
  void turn_freely(const Vector3& angular_velocity, double end) {
    frame_ = std::make_unique<Frame>(*this, angular_velocity, end);
  }
  const Frame* frame() const { return frame_.get(); }  // null: rotations are small

  double largest_frequency() const override;
  bool is_damped() const { return damping_.hash != 0; }

  double lasting_share() const override {
    if (scheme() == Scheme::newmark || frame_) return 0;
    return facts_.kicks_at_end ? -0.5 : 0.5;
  }
  FloatingForces floating_forces() const override;
  void float_by(const Vector& move) override;
  const ResidualMotion& residual() const { return residual_; }
  double mass() const { return superelement_->rigid_body.mass; }
  Vector3 center_of_mass() const { return center_at(now_.eta); }
  // as predicted_positions()
  Vector3 predicted_center_of_mass() const { return center_at(end_.eta); }
  Vector3 center_velocity() const;
  bool turns() const override { return frame_ != nullptr; }
  Matrix3 turn_of_step() const override { return frame_->R(); }
  BodyTurn turn_now() const override { return frame_->now(); }
  BodyTurn turn_at_end() const override { return frame_->at_end(); }
  Vector3 spin() const override { return frame_->angular_velocity(); }
  void unturned_displacements(Points& u, Points& v) const override;
  void add_moment(const Vector3& moment) override { frame_->add_moment(moment); }
  const Vector& modal_coordinates() const { return now_.eta; }
  const Vector& predicted_modal_coordinates() const { return end_.eta; }
  const Vector& modal_velocities() const { return now_.v; }
  const Vector& predicted_modal_velocities() const { return end_.v; }
  // V^T f, with the pattern's forces on modal coordinates
  Vector modal_force(const ForcePattern& pattern) const;
  // Inputs of a harmonic response and of mode shapes.
  const ModalForm& form() const { return *form_; }
  const Vector& damping_rates() const { return damping_.c; }  // n; 0: none
  const Matrix3& axes() const { return placement_.T; }
  // of form().V, for each node and component; -1: none
  const IndexTable& rows() const { return *rows_; }
  Vector load_amplitude() const;       // of all loads with a factor of 1, n
  void take_shape(const Vector& eta);  // at rest there, until the next predict()
  // Shapes alone follow: other coordinates of the same nodes, for take_shape() and displacements().
  void take_form(std::shared_ptr<const ModalForm> form);
  // From here on forces on nodes are also summed, with a factor of 1 (N x 3, component axes).
  void sum_forces() { forces_ = Points::Zero(own_nodes().rows(), 3); }
  const Points& forces() const { return forces_; }
  Points nodal_masses(Index set) const override;
  void add_start_impulse(const Vector& impulse) override;

 private:
  friend class Frame;

  Index own_track(const std::vector<Index>& nodes) override;
  void own_positions(Index set, Points& x) const override;
  void own_predicted_positions(Index set, Points& x) const override;
  void unturned_positions(Index set, Points& x) const override;
  void unturned_end(Index set, Points& x) const override;
  NodeResponse unturned_response(Index set, double h) const override;
  MotionBound own_motion_bound(Index set, bool quick) const override;
  bool own_at_rest() const override {
    return flow_.loads().empty() && now_.v.isZero(0) && now_.eta.isZero(0) && residual_.at_rest() &&
           (!frame_ || frame_->at_rest());
  }
  Index own_track_mean(const std::vector<Index>& nodes) override;
  void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const override;
  void own_take_impulses(Index set, const Impulses& impulses) override;
  void own_expect_forces(Index set, const Points& forces) override;
  double own_residual_friction(Index set, const Points& impulses, bool between) override {
    return frame_ ? residual_.friction(set, impulses * frame_->R(), between)
                  : residual_.friction(set, impulses, between);
  }
  void own_accept() override;
  void own_end_velocities(Index set, Points& v) override;
  NodeResponse own_velocity_response(Index set) const override;
  // At the end of a step the residual compliance moves no further: velocities are of the modes.
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
  BodyWork own_work() const override {
    BodyWork work = work_;
    work += residual_.work();
    if (frame_) work += frame_->work();
    return work;
  }
  void own_displacements(Points& u, Points& v) const override;
  void own_coordinates(Vector& q, Vector& rates) const override;  // q = V eta, in axes that turn
  void own_turn(const Points& X, Points& u, Points& v) const override {
    if (frame_) frame_->turn(X, u, v);
  }
  void own_keep_state(StateArchive& archive) override;
  void take_plan(const BodyPlan& plan) override;
  void predict_end() override;

  struct NodeSet {
    std::shared_ptr<const NodeRows> rows;
    Points X;  // m x 3, scene axes
  };
  struct MeanSet {
    std::shared_ptr<const Matrix> Vt;  // n x 3, component axes
    Vector3 X;                         // scene axes
  };
  // Impulses of contact at the ends of steps.
  struct LateKicks {
    Vector start, end;  // n, without lasting forces; the rates have `start`. Empty: none yet
    explicit operator bool() const { return start.size() > 0; }
    void begin(Index n) {
      for (Vector* kick : {&start, &end}) kick->setZero(n);
    }
  };

  // Of V_c diag(weight) V_c^T, for a step h, and of it in equilibrium.
  ResponseOf response_of(double h, Vector& weight) const;
  ResponseOf static_response_of(Vector& weight) const;
  // The same and the residual compliance, formed or as factors, whichever is smaller.
  NodeResponse answer(Index set, const ResponseOf& of, const Vector& weight) const;
  const Matrix& velocity_map(const NodeRows& rows) const;
  const Vector& present_rates() const;
  void take_load(const BodyLoad& load);
  // The parts of a step and of the public functions that the modes have in the axes of the frame.
  void predict_modes();
  void push_modes(Index set, const Impulses& impulses);
  void accept_modes();
  void add_late(Index set, const Points& impulses);
  void take_force(Index set, const Points& forces);
  void feel_kick();
  void kick_back();
  Vector3 center_at(const Vector& eta) const;
  Index n_floating() const;
  Vector contact_kick(double h, const Vector& force) const;
  void predict_central(double h);
  void accept_late();
  void change_force();
  void accept_exact();
  void accept_end_kick(const Vector& kick);
  void accept_central();
  void arrive_newmark();

  std::shared_ptr<const Superelement> superelement_;
  std::shared_ptr<const ModalForm> form_;
  Placement placement_;
  std::shared_ptr<const IndexTable> rows_;
  std::vector<NodeSet> sets_;
  std::vector<MeanSet> means_;
  ResidualMotion residual_;
  Points forces_;
  StaticState statics_;  // in modal coordinates; empty before the first relax()
  ModalRates damping_;
  ModalFlow flow_;
  ModalNewmark newmark_;
  ModalState now_, end_;  // central differences: rates are half a step behind
  // Modal impulses at the start of the step; changes of the rates at its end
  Kick kick_, end_kick_;
  LateKicks late_;
  Vector f_;  // workspaces: modal forces, impulses in component axes
  Points local_;
  mutable Vector rates_;  // central differences, and coupled with a spin: eta' at the time of eta
  double last_h_ = 0;
  BodyWork work_;
  double spin_work_ = 0;          // of the spin on the modes, of the last accepted step
  std::unique_ptr<Frame> frame_;  // null: rotations are small
};

}  // namespace cbr
