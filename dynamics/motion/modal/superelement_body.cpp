// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/superelement_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/linalg/dense.hpp"
#include "dynamics/motion/modal/contact_gain.hpp"

namespace cbr {
namespace {

Eigen::Map<Vector> flat(Points& p) { return {p.data(), p.size()}; }

bool is_massless(const DiagonalForm& form) { return form.residual && form.residual->is_massless; }

// An interface without mass changes the energy as it lands and lets go. Of a bouncing bar it was
// 1.3e-3 at 0.16 of the critical step and 3.5e-2 at 0.33: docs/decisions/massless.md, "Steps".
constexpr double massless_share = 0.2;

}  // namespace

SuperelementBody::SuperelementBody(std::string name,
                                   std::shared_ptr<const Superelement> superelement,
                                   std::shared_ptr<const DiagonalForm> form,
                                   const Placement& placement, Scheme scheme,
                                   const NewmarkOptions& newmark, const Damping& damping)
    : Body({.name = std::move(name),
            .scheme = scheme,
            .n_dofs = form->omega.size(),
            .positions = placement.placed(superelement->coordinates),
            .steps_alone = scheme == Scheme::exact,
            .contact_share = is_massless(*form) ? massless_share : 1,
            .kicks_at_end = is_massless(*form)}),
      superelement_(std::move(superelement)),
      form_(std::move(form)),
      placement_(placement),
      newmark_(newmark),
      rows_(form_->shared.row_table(*superelement_)),
      residual_(form_, rows_, placement.T, damping.material.beta),
      damping_(damping.rates(form_->omega)) {
  assert(scheme != Scheme::newmark || !is_massless(*form_));
  const Index n = form_->omega.size();
  for (Vector* x :
       {&eta_, &v_, &eta_end_, &v_end_, &kick_, &end_kick_, &f_, &f0_, &f1_, &work_eta_, &work_v_})
    x->setZero(n);
  // v = V^T M^ R_t v0: the rigid motion, or its projection when directions are constrained.
  v_.noalias() = form_->E.leftCols(3) * (placement_.T.transpose() * placement_.velocity);
}

double SuperelementBody::largest_frequency() const {
  return form_->residual ? residual_.critical_frequency() : highest_mode();
}

Index SuperelementBody::own_track(const std::vector<Index>& nodes) {
  sets_.push_back({form_->shared.rows(form_->V, *rows_, nodes), own_nodes()(nodes, Eigen::all)});
  residual_.track(*sets_.back().rows);
  if (frame_) frame_->track();
  local_.resize(std::max<Index>(local_.rows(), static_cast<Index>(nodes.size())), 3);
  return static_cast<Index>(sets_.size()) - 1;
}

Index SuperelementBody::own_track_mean(const std::vector<Index>& nodes) {
  means_.push_back({form_->shared.mean_rows(form_->V, *rows_, nodes),
                    own_nodes()(nodes, Eigen::all).colwise().mean().transpose()});
  residual_.track_mean(nodes);
  return static_cast<Index>(means_.size()) - 1;
}

void SuperelementBody::own_positions(Index set, Points& x) const {
  unturned_positions(set, x);
  if (frame_) frame_->turn_positions(set, x);
}

void SuperelementBody::own_predicted_positions(Index set, Points& x) const {
  unturned_end(set, x);
  if (frame_) frame_->turn_predicted_positions(set, x);
}

void SuperelementBody::unturned_positions(Index set, Points& x) const {
  sets_[set].rows->displacements(eta_, placement_.T, x);
  x += sets_[set].X;
  residual_.add_positions(set, x);
}

void SuperelementBody::unturned_end(Index set, Points& x) const {
  sets_[set].rows->displacements(eta_end_, placement_.T, x);
  x += sets_[set].X;
  residual_.add_predicted_positions(set, x);
}

void SuperelementBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& s = means_[set];
  position = s.X;
  velocity.setZero();
  if (eta_.size() > 0) {
    position += placement_.T * Vector3(s.Vt->transpose() * eta_);
    velocity = placement_.T * Vector3(s.Vt->transpose() * present_rates());
  }
  residual_.add_mean_motion(set, *s.Vt, eta_, position, velocity);
  if (frame_) frame_->turn_mean_motion(position, velocity);
}

void SuperelementBody::load_amplitudes(double t, Vector& f) const {
  f.setZero(form_->omega.size());
  for (const auto& load : loads_) f += load.history.value(t) * load.amplitude;
}

const ModalPropagator& SuperelementBody::propagator(double h) const {
  if (regular_ && regular_->h == h) return *regular_;
  std::swap(regular_, other_);
  if (!regular_ || regular_->h != h) regular_ = make_propagator(h);
  return *regular_;
}

// From t_ to t_ + h_ with loads, cut at the histories' breakpoints, and where forces that turn with
// the body bend, so that each part is linear in time.
void SuperelementBody::propagate(const Vector& eta, const Vector& v, Vector& eta_end, Vector& v_end,
                                 FlowWork* work) {
  if (!is_driven()) return propagate_free(propagator(h_), eta, v, eta_end, v_end);
  eta_end = eta;
  v_end = v;
  if (turning_.couples()) turning_.pull_at_start(t_, h_, eta_end, v_end, work);
  const Index n = std::max<Index>(1, turning_.n_parts());
  breakpoints_.cut(t_, h_, [&](double from, double to, bool whole) {
    for (Index i = 0; i < n; ++i) {
      const double start =
          std::max(from, t_ + h_ * static_cast<double>(i) / static_cast<double>(n));
      const double end =
          i + 1 == n ? to
                     : std::min(to, t_ + h_ * static_cast<double>(i + 1) / static_cast<double>(n));
      if (n == 1 || end > start)
        propagate_driven(start, end, whole && n == 1, eta_end, v_end, work);
    }
  });
  if (turning_.couples()) turning_.pull_at_end(t_, h_, eta_end, v_end, work);
}

// Leapfrog with the damping of half a step on each side of t, so that the critical step stays:
//   (1 + c h / 2) v+ = (1 - c h- / 2) v- + (h- + h)/2 (f - omega^2 eta),   eta+ = eta + h v+.
// At the start v- is half a step before t = 0.
void SuperelementBody::predict_central(double h) {
  load_amplitudes(t_, f_);
  f_ -= form_->omega.cwiseAbs2().cwiseProduct(eta_);
  const auto c = damping_.c.array();
  if (last_h_ == 0) {
    // The half kick back is booked as work of the loads and of damping: the energy balance starts
    // from the given velocity.
    const Vector all = f_.array() - c * v_.array();
    const double of_loads = 0.5 * h * f_.dot(0.25 * h * f_ - v_);
    work_.external += of_loads;
    work_.damping += 0.5 * h * all.dot(0.25 * h * all - v_) - of_loads;
    v_ -= 0.5 * h * all;
    last_h_ = h;
  }
  // Forces at the end of the last step are a kick at the start of this one
  const bool late = is_damped() && late_.size() > 0;
  if (late) v_ -= late_;
  v_end_ = (1 - 0.5 * last_h_ * c) * v_.array() + 0.5 * (last_h_ + h) * f_.array();
  if (late) {
    v_end_ += late_;
    v_ += late_;
  }
  v_end_.array() /= 1 + 0.5 * h * c;
  eta_end_ = eta_ + h * v_end_;
}

std::shared_ptr<const ModalPropagator> SuperelementBody::make_propagator(double h) const {
  if (is_damped()) return form_->shared.propagator(form_->omega, damping_, h, may_be_driven());
  return form_->shared.propagator(form_->omega, h, may_be_driven());
}

double SuperelementBody::flow_energy(const Vector& eta, const Vector& v) const {
  const Vector forces = form_->omega.cwiseProduct(eta);
  return 0.5 * (v.squaredNorm() + forces.squaredNorm());
}

void SuperelementBody::set_contact_step(double h) {
  if (!is_exact() || highest_mode() * h > 2.1) return;  // above: forced steps
  contact_step_ = h;
  gain_ = is_damped() ? contact_gain(form_->omega, damping_.c, form_->n_rigid, h)
                      : contact_gain(form_->omega, h);
}

void SuperelementBody::predict_end() { frame_ ? frame_->predict(t_, h_) : predict_modes(); }

void SuperelementBody::predict_modes() {
  kicked_ = end_kicked_ = false;
  late_end_.setZero();
  switch (scheme()) {
    case Scheme::exact:
      propagate(eta_, v_, eta_end_, v_end_, nullptr);
      if (!facts_.kicks_at_end) kick_back();
      break;
    case Scheme::central_difference:
      predict_central(h_);
      break;
    case Scheme::newmark:
      predict_newmark(h_);
      break;
  }
  residual_.predict(t_, h_);
}

// f_: modal forces of forces on the set's nodes. In a frame their sum moves the centre of mass in
// the scene's axes.
void SuperelementBody::take_force(Index set, const Points& impulses) {
  sets_[set].rows->kick(impulses, placement_.T, local_, f_);
  if (!frame_) return;
  const auto E = form_->E.topLeftCorner(form_->n_rigid, 3);
  const Vector3 momentum =
      placement_.T.transpose() * (frame_->R() * impulses.colwise().sum().transpose());
  f_.head(form_->n_rigid).noalias() = E * (momentum / E.col(0).squaredNorm());
}

// f_: change of the modal velocities by impulses on the set's nodes.
void SuperelementBody::take_kick(Index set, const Points& impulses) {
  take_force(set, impulses);
  if (gain_.size() > 0) f_.array() *= gain_.array();
}

void SuperelementBody::own_take_impulses(Index set, const Impulses& impulses) {
  frame_ ? frame_->take_impulses(set, impulses) : push_modes(set, impulses);
}

void SuperelementBody::push_modes(Index set, const Impulses& impulses) {
  residual_.push(set, impulses);
  if (facts_.kicks_at_end) return add_late(set, impulses.all);
  take_kick(set, impulses.all);
  feel_kick();
}

// Of the modal kick f_ at the start of the step.
void SuperelementBody::feel_kick() {
  if (!kicked_) kick_.setZero();
  kick_ += f_;
  kicked_ = true;
  if (turning_.couples()) {
    add_coupled(f_);
  } else if (is_exact()) {
    const ModalPropagator& step = propagator(h_);
    eta_end_.array() += step.s.array() * f_.array();
    v_end_.array() += step.velocity_left().array() * f_.array();
  } else if (scheme() == Scheme::newmark) {
    push_newmark(f_);
  } else {
    f_.array() /= 1 + 0.5 * h_ * damping_.c.array();
    eta_end_ += h_ * f_;
    v_end_ += f_;
  }
}

// Forces at the end of the step, times the step. Energies are of the middle of such a kick; with
// central differences it is half of the kick of the rates of the next step.
void SuperelementBody::add_late(Index set, const Points& impulses) {
  if (late_.size() == 0)
    for (Vector* kick : {&late_, &late_end_}) kick->setZero(eta_.size());
  take_kick(set, impulses);
  late_end_ += f_;
  v_end_ += f_;
}

Vector3 SuperelementBody::own_add_velocities(Index set, const Points& velocities,
                                             const Vector3& momentum) {
  if (form_->residual) lacks_nodal_masses();
  assert(scheme() != Scheme::newmark && gain_.size() == 0 && !is_damped());
  const Matrix3& T = placement_.T;
  const Matrix& B = velocity_map(*sets_[set].rows);
  // change = V^T M^ [0; dv]: V^-1 of a velocity of the interface dofs alone
  Points local = velocities * T;
  f_.noalias() = B * flat(local);
  // Uniform velocity of the set's nodes for the rest of the momentum: T E^T B [I; I; ...] T^T extra
  // = momentum - T E^T f   (3 x 3)
  Matrix uniform = Matrix::Zero(f_.size(), 3);
  for (Index i = 0; i < B.cols(); ++i) uniform.col(i % 3) += B.col(i);
  const auto to_momentum = form_->E.leftCols(3).transpose();
  const Matrix3 mass = T * (to_momentum * uniform) * T.transpose();
  const Vector3 missing = momentum - T * (to_momentum * f_);
  const Vector3 extra = solve_semidefinite(mass, missing).value_or(Vector3::Zero());
  f_.noalias() += uniform * (T.transpose() * extra);
  if (is_exact()) {
    if (!end_kicked_) end_kick_.setZero();
    end_kick_ += f_;
    end_kicked_ = true;
  } else {
    if (!kicked_) kick_.setZero();
    kick_ += f_;
    kicked_ = true;
  }
  eta_end_ += h_ * f_;
  v_end_ += f_;
  return extra;
}

void SuperelementBody::accept_exact() {
  spin_work_ = 0;
  if (kicked_) book_kick(kick_, v_);
  if (is_damped() || is_driven()) {
    // Between the kicks energy changes by the work of forces, spin and damping
    if (kicked_) v_ += kick_;
    if (kicked_) turning_.forget_start();
    FlowWork flow;
    flow.external = is_damped() ? 0 : work_.external;
    propagate(eta_, v_, eta_end_, v_end_, &flow);
    work_.external = is_damped() ? work_.external + flow.external : flow.external;
    work_.contact += flow.contact;
    spin_work_ = flow.spin;
    turning_.forget_start();
    if (is_damped())
      work_.damping += flow_energy(eta_end_, v_end_) - flow_energy(eta_, v_) - flow.sum();
    if (late_end_.size() > 0) v_end_ += late_end_;
  }
  if (late_.size() > 0) accept_late();
  accept_end_kick();
  if (!facts_.kicks_at_end) change_force();
}

// Of nodal contact.
void SuperelementBody::accept_end_kick() {
  if (!end_kicked_) return;
  if (!loads_.empty()) {
    eta_end_ += h_ * end_kick_;
    v_end_ += end_kick_;
  }
  // Energy that the change at the end of the step brought: of (eta + h d, v + d) less that of (eta,
  // v)
  const auto omega2 = form_->omega.cwiseAbs2().array();
  work_.contact +=
      end_kick_.dot(v_end_) - 0.5 * end_kick_.squaredNorm() +
      h_ * (omega2 * end_kick_.array() * (eta_end_ - 0.5 * h_ * end_kick_).array()).sum();
}

void SuperelementBody::accept_central() {
  // The rates before and after all of the forces at the start
  const bool late = late_.size() > 0;
  if (late) {
    v_ -= late_;
    v_end_ -= late_end_;
    work_.contact += 0.5 * (late_ + late_end_).dot(v_end_);
  }
  if (is_damped())
    work_.damping -=
        0.25 *
        (damping_.c.array() * (last_h_ * v_ + h_ * v_end_).array()).matrix().dot(v_ + v_end_);
  // v- and v+ average: the work of the kick and of the load that the leapfrog's own energy answers
  // to
  const double mean_h = 0.5 * (last_h_ + h_);
  if (kicked_) work_.contact += 0.5 * kick_.dot(v_ + v_end_);
  if (!loads_.empty()) {
    load_amplitudes(t_, f_);
    work_.external += 0.5 * mean_h * f_.dot(v_ + v_end_);
  }
  // Its energy holds a term -h/2 v . omega^2 eta: a change of h brings (h - h-)/4 omega^2 eta . (v+
  // - v-).
  if (h_ != last_h_)
    work_.numerical +=
        0.25 * (h_ - last_h_) * form_->omega.cwiseAbs2().cwiseProduct(eta_).dot(v_end_ - v_);
  last_h_ = h_;
  if (late) v_end_ += late_end_;
}

void SuperelementBody::own_accept() { frame_ ? frame_->accept() : accept_modes(); }

void SuperelementBody::accept_modes() {
  residual_.accept(eta_);
  switch (scheme()) {
    case Scheme::exact:
      accept_exact();
      break;
    case Scheme::central_difference:
      accept_central();
      break;
    case Scheme::newmark:
      arrive_newmark();
      arrived_ = false;
      break;
  }
  lasting_.now = std::move(lasting_.next);
  lasting_.next.resize(0);
  late_.swap(late_end_);
  eta_.swap(eta_end_);
  v_.swap(v_end_);
  t_ += h_;
}

}  // namespace cbr
