// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/superelement_body.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

Eigen::Map<const Vector> flat(const Points& p) { return {p.data(), p.size()}; }
Eigen::Map<Vector> flat(Points& p) { return {p.data(), p.size()}; }

}  // namespace

SuperelementBody::SuperelementBody(std::string name, std::shared_ptr<const Superelement> superelement,
                                   std::shared_ptr<const DiagonalForm> form, const Placement& placement, Scheme scheme,
                                   const NewmarkOptions& newmark)
    : name_(std::move(name)),
      superelement_(std::move(superelement)),
      form_(std::move(form)),
      placement_(placement),
      scheme_(scheme),
      newmark_(newmark),
      rows_(displacement_rows(*superelement_)) {
  X_ = (superelement_->coordinates * placement_.T.transpose()).rowwise() + placement_.position.transpose();
  const Index n = form_->omega.size();
  for (Vector* x : {&eta_, &v_, &eta_end_, &v_end_, &kick_, &friction_kick_, &end_kick_, &f_, &f0_, &f1_, &work_eta_, &work_v_})
    x->setZero(n);
  // v = V^T M^ R_t v0: the rigid motion, or its projection when directions are held.
  v_.noalias() = form_->E.leftCols(3) * (placement_.T.transpose() * placement_.velocity);
}

double SuperelementBody::largest_frequency() const { return form_->omega.size() ? form_->omega.maxCoeff() : 0; }

// Modal rows of the nodes' displacements in scene axes, transposed: u_scene = T u.
Matrix SuperelementBody::scene_rows(const std::vector<Index>& nodes) const {
  const Index n = form_->omega.size(), m = static_cast<Index>(nodes.size());
  Matrix Vt = Matrix::Zero(n, 3 * m);
  for (Index i = 0; i < m; ++i) {
    for (int d = 0; d < 3; ++d) {
      const Index row = rows_(nodes[i], d);
      if (row < 0) continue;
      for (int c = 0; c < 3; ++c) {
        if (placement_.T(c, d) != 0) Vt.col(3 * i + c) += placement_.T(c, d) * form_->V.row(row).transpose();
      }
    }
  }
  return Vt;
}

Index SuperelementBody::track(const std::vector<Index>& nodes) {
  NodeSet set;
  set.nodes = nodes;
  set.X = X_(nodes, Eigen::all);
  set.Vt = scene_rows(nodes);
  sets_.push_back(std::move(set));
  return static_cast<Index>(sets_.size()) - 1;
}

Index SuperelementBody::track_mean(const std::vector<Index>& nodes) {
  MeanSet set{X_(nodes, Eigen::all).colwise().mean().transpose(), Matrix::Zero(form_->omega.size(), 3)};
  Matrix mean_rows = Matrix::Zero(form_->omega.size(), 3);
  for (const Index node : nodes) {
    for (int d = 0; d < 3; ++d) {
      if (rows_(node, d) >= 0) mean_rows.col(d) += form_->V.row(rows_(node, d)).transpose();
    }
  }
  set.Vt.noalias() = mean_rows * placement_.T.transpose() / static_cast<double>(nodes.size());
  means_.push_back(std::move(set));
  return static_cast<Index>(means_.size()) - 1;
}

void SuperelementBody::positions(Index set, Points& x) const {
  const NodeSet& s = sets_[set];
  x = s.X;
  if (eta_.size() > 0) flat(x).noalias() += s.Vt.transpose() * eta_;  // BLAS minds a product over nothing: every dof held
}

void SuperelementBody::predicted_positions(Index set, Points& x) const {
  const NodeSet& s = sets_[set];
  x = s.X;
  if (eta_.size() > 0) flat(x).noalias() += s.Vt.transpose() * eta_end_;
}

void SuperelementBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& s = means_[set];
  position = s.X, velocity.setZero();
  if (eta_.size() == 0) return;
  position += s.Vt.transpose() * eta_;
  velocity = s.Vt.transpose() * present_rates();
}

MotionBound SuperelementBody::motion_bound(Index set) const {
  assert(is_exact());
  const NodeSet& s = sets_[set];
  const Index r = form_->n_rigid, e = eta_.size() - r, m = s.Vt.cols();
  const auto omega = form_->omega.tail(e).array();
  Vector force = Vector::Zero(eta_.size());  // largest modal force at any time
  for (const auto& load : loads_) {
    double largest = load.history.value.empty() ? 1 : 0;
    for (const double value : load.history.value) largest = std::max(largest, std::abs(value));
    force += largest * load.amplitude.cwiseAbs();
  }
  // Amplitude sqrt(eta^2 + (v / omega)^2); a force adds at most its impulse / omega.
  const Vector amplitude = (eta_.tail(e).array().square() + (v_.tail(e).array() / omega).square()).sqrt();
  const Vector rate = force.tail(e).array() / omega;
  MotionBound bound;
  bound.lower = bound.lower_speed = Vector3::Constant(HUGE_VAL);
  bound.upper = bound.upper_speed = Vector3::Constant(-HUGE_VAL);
  bound.growth = bound.acceleration = Vector3::Zero();
  for (Index i = 0; i < m; ++i) {
    const Index c = i % 3;
    const auto rigid = s.Vt.col(i).head(r);
    const auto elastic = s.Vt.col(i).tail(e).cwiseAbs();
    const double x = s.X(i / 3, c) + rigid.dot(eta_.head(r)), speed = rigid.dot(v_.head(r)), spread = elastic.dot(amplitude);
    bound.lower[c] = std::min(bound.lower[c], x - spread), bound.upper[c] = std::max(bound.upper[c], x + spread);
    bound.lower_speed[c] = std::min(bound.lower_speed[c], speed), bound.upper_speed[c] = std::max(bound.upper_speed[c], speed);
    if (loads_.empty()) continue;
    bound.growth[c] = std::max(bound.growth[c], elastic.dot(rate));
    bound.acceleration[c] = std::max(bound.acceleration[c], rigid.cwiseAbs().dot(force.head(r)));
  }
  return bound;
}

void SuperelementBody::load_amplitudes(double t, Vector& f) const {
  f.setZero();
  for (const auto& load : loads_) f += history_value(load.history, t) * load.amplitude;
}

const ModalPropagator& SuperelementBody::propagator(double h) const {
  if (regular_.h == h) return regular_;
  if (other_.h == h) {
    std::swap(regular_, other_);
    return regular_;
  }
  other_ = std::move(regular_);
  regular_ = modal_propagator(form_->omega, h, !loads_.empty());
  return regular_;
}

// From t_ to t_ + h_ with loads, cut at the histories' breakpoints so that each part is linear in time.
void SuperelementBody::propagate(const Vector& eta, const Vector& v, Vector& eta_end, Vector& v_end, double* external_work) {
  if (loads_.empty()) return propagate_free(propagator(h_), eta, v, eta_end, v_end);
  work_eta_ = eta, work_v_ = v;
  double from = t_;
  const double to = t_ + h_, tolerance = 1e-9 * h_;
  auto breakpoint = std::upper_bound(breakpoints_.begin(), breakpoints_.end(), t_ + tolerance);
  while (from < to) {
    // Breakpoints that differ by round-off are one
    while (breakpoint != breakpoints_.end() && *breakpoint <= from + tolerance) ++breakpoint;
    const bool last = breakpoint == breakpoints_.end() || *breakpoint >= to - tolerance;
    const double next = last ? to : *breakpoint;
    const bool whole = last && from == t_;
    const ModalPropagator part = whole ? ModalPropagator{} : modal_propagator(form_->omega, next - from, true);
    const ModalPropagator& step = whole ? propagator(h_) : part;
    load_amplitudes(from, f0_);
    load_amplitudes(next, f1_);
    propagate_free(step, work_eta_, work_v_, eta_end, v_end);
    add_load(step, f0_, f1_, eta_end, v_end);
    if (external_work) *external_work += load_work(step, work_eta_, work_v_, eta_end, f0_, f1_);
    if (last) break;
    work_eta_ = eta_end, work_v_ = v_end;
    from = next;
  }
}

// Leapfrog: v+ = v- + (h- + h)/2 (f - omega^2 eta), eta+ = eta + h v+. At the start v- is half a step before t = 0.
void SuperelementBody::predict_central(double h) {
  load_amplitudes(t_, f_);
  v_end_ = f_ - form_->omega.cwiseAbs2().cwiseProduct(eta_);
  if (last_h_ == 0) {
    // The half kick back is booked as work of the loads, so that the energy balance starts from the given velocity.
    work_.external += 0.5 * h * v_end_.dot(0.25 * h * v_end_ - v_);
    v_ -= 0.5 * h * v_end_;
    last_h_ = h;
  }
  v_end_ = v_ + 0.5 * (last_h_ + h) * v_end_;
  eta_end_ = eta_ + h * v_end_;
}

void SuperelementBody::predict(double t, double h) {
  t_ = t, h_ = h;
  kicked_ = rubbed_ = end_kicked_ = false;
  switch (scheme_) {
    case Scheme::exact:
      propagate(eta_, v_, eta_end_, v_end_, nullptr);
      break;
    case Scheme::central_difference:
      predict_central(h);
      break;
    case Scheme::newmark:
      predict_newmark(h);
      break;
  }
}

void SuperelementBody::add_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  const NodeSet& s = sets_[set];
  // kick = V^T p, only over the dofs that an impulse acts on
  f_.setZero();
  for (Index i = 0; i < impulses.size(); ++i) {
    if (impulses.data()[i] != 0) f_ += impulses.data()[i] * s.Vt.col(i);
  }
  if (!kicked_) kick_.setZero();
  kick_ += f_;
  kicked_ = true;
  if (kind == ImpulseKind::friction) {
    if (!rubbed_) friction_kick_.setZero();
    friction_kick_ += f_;
    rubbed_ = true;
  }
  if (is_exact()) {
    const ModalPropagator& step = propagator(h_);
    eta_end_.array() += step.s.array() * f_.array();
    v_end_.array() += step.c.array() * f_.array();
  } else if (scheme_ == Scheme::newmark) {
    push_newmark(f_);
  } else {
    eta_end_ += h_ * f_;
    v_end_ += f_;
  }
}

Vector3 SuperelementBody::add_velocities(Index set, const Points& velocities, const Vector3& momentum) {
  assert(scheme_ != Scheme::newmark);
  NodeSet& s = sets_[set];
  if (s.B.size() == 0) fill_velocity_map(s);
  // change = V^T M^ [0; dv]: V^-1 of a velocity of the interface dofs alone
  f_.noalias() = s.B * flat(velocities);
  // Uniform velocity of the set's nodes for the rest of the momentum: T E^T B [I; I; ...] extra = momentum - T E^T f   (3 x 3)
  Matrix uniform = Matrix::Zero(f_.size(), 3);
  for (Index i = 0; i < s.B.cols(); ++i) uniform.col(i % 3) += s.B.col(i);
  const auto to_momentum = form_->E.leftCols(3).transpose();
  const Eigen::LDLT<Matrix3> mass(placement_.T * (to_momentum * uniform));
  Vector3 extra = Vector3::Zero();
  if (mass.info() == Eigen::Success && mass.isPositive()) {
    extra = mass.solve(momentum - placement_.T * (to_momentum * f_));
    f_.noalias() += uniform * extra;
  }
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

// Its share of what has been booked as work of contact.
void SuperelementBody::book_friction(double work) {
  work_.friction += work;
  work_.contact -= work;
}

void SuperelementBody::accept_exact() {
  if (kicked_) work_.contact += kick_.dot(v_) + 0.5 * kick_.squaredNorm();
  if (rubbed_) book_friction(friction_kick_.dot(v_) + 0.5 * friction_kick_.dot(kick_));
  if (!loads_.empty()) {
    if (kicked_) v_ += kick_;
    propagate(eta_, v_, eta_end_, v_end_, &work_.external);
  }
  if (!end_kicked_) return;
  if (!loads_.empty()) eta_end_ += h_ * end_kick_, v_end_ += end_kick_;
  // Energy that the change at the end of the step brought: of (eta + h d, v + d) less that of (eta, v)
  const auto omega2 = form_->omega.cwiseAbs2().array();
  work_.contact += end_kick_.dot(v_end_) - 0.5 * end_kick_.squaredNorm() +
                   h_ * (omega2 * end_kick_.array() * (eta_end_ - 0.5 * h_ * end_kick_).array()).sum();
}

void SuperelementBody::accept_central() {
  // v- and v+ average: the work of the kick and of the load that the leapfrog's own energy answers to
  const double mean_h = 0.5 * (last_h_ + h_);
  if (kicked_) work_.contact += 0.5 * kick_.dot(v_ + v_end_);
  if (rubbed_) book_friction(0.5 * friction_kick_.dot(v_ + v_end_));
  if (!loads_.empty()) {
    load_amplitudes(t_, f_);
    work_.external += 0.5 * mean_h * f_.dot(v_ + v_end_);
  }
  last_h_ = h_;
}

void SuperelementBody::accept() {
  switch (scheme_) {
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
  eta_.swap(eta_end_);
  v_.swap(v_end_);
  t_ += h_;
}

}  // namespace cbr
