// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_forces.hpp"

#include <algorithm>

namespace cbr {

bool TurningForces::feel_spin(const Superelement& superelement, const ModalForm& form,
                              const ModalRates& damping) {
  const Matrix& moments = superelement.spin_moments;
  if (moments.rows() != form.V.rows() || moments.rows() == 0) return false;
  H_.noalias() = form.V.transpose() * moments;
  H_.topRows(form.n_rigid).setZero();
  n_spin_ = H_.cols();
  histories_.resize(static_cast<std::size_t>(n_spin_));
  omega_ = form.omega;
  if (damping.hash != 0) damping_ = damping.c;
  coupling_ = form.shared.spin_coupling(superelement, form.n_rigid, form.omega.size());
  return true;
}

void TurningForces::add(const Vector& column, const LoadHistory& history) {
  H_.conservativeResize(column.size(), H_.cols() + 1);
  H_.rightCols(1) = column;
  histories_.push_back(history);
}

void TurningForces::couple(const Vector3& start, const Vector3& end) {
  if (!pulls_) pulls_ = Pulls{};
  if (!pulls_->is_known || pulls_->w_start != start) {
    pulls_->is_known = false;
    pulls_->w_start = start;
    pulls_->start = coupling_->pull(start);
  }
  pulls_->end = coupling_->pull(end);
}

void TurningForces::take_drift(const Vector& drift, Index n) {
  drift_.setZero(drift.size() > 0 ? n : 0);
  if (drift.size() == 0) return;
  drift_.segment(coupling_->first(), coupling_->size()) = drift;
}

// Kinetic and strain energy of the coupled modes.
double TurningForces::energy(const Vector& eta, const Vector& v) const {
  double sum = 0;
  for (Index j = coupling_->first(); j < coupling_->first() + coupling_->size(); ++j) {
    const double force = omega_[j] * eta[j];
    sum += v[j] * v[j] + force * force;
  }
  return 0.5 * sum;
}

void TurningForces::pull_at_start(double t, double h, Vector& eta, Vector& v, FlowWork* work) {
  Pulls& pulls = *pulls_;
  if (!pulls.is_known || pulls.h != h) {
    pulls.eta = eta;
    pulls.v = v;
    pulls.h = h;
    move_at_start(h, pulls.eta, pulls.v);
    pulls.is_known = true;
  }
  if (work) {
    book_drift(coupling_->drift(pulls.start, eta), t, t, h, v, *work);
    work->spin += energy(pulls.eta, pulls.v) - energy(eta, v);
  }
  eta = pulls.eta;
  v = pulls.v;
}

void TurningForces::pull_at_end(double t, double h, Vector& eta, Vector& v, FlowWork* work) {
  const double before = work ? energy(eta, v) : 0;
  move_at_end(h, eta, v);
  if (!work) return;
  book_drift(coupling_->drift(pulls_->end, eta), t + h, t, h, v, *work);
  work->spin += energy(eta, v) - before;
}

void TurningForces::move_at_start(double h, Vector& eta, Vector& v) const {
  coupling_->move(pulls_->start, 0.5 * h, damping_, eta, v);
}

void TurningForces::move_at_end(double h, Vector& eta, Vector& v) const {
  coupling_->move(pulls_->end, 0.5 * h, damping_, eta, v);
}

// Work of loads and damping on eta' beyond that on p, at t: by the trapezoidal rule.
void TurningForces::book_drift(const Vector& drift, double t, double t_0, double h, const Vector& v,
                               FlowWork& work) const {
  const Index first = coupling_->first(), m = coupling_->size();
  if (H_.cols() > n_spin_) {
    const double loads = 0.5 * h * load_force(t, t_0, h).segment(first, m).dot(drift);
    work.external += loads;
    work.spin -= loads;
  }
  if (damping_.size() > 0)  // which takes the rest
    work.spin += 0.5 * h *
                 (damping_.segment(first, m).array() * drift.array() *
                  (2 * v.segment(first, m) + drift).array())
                     .sum();
}

// Of `count` columns from `first` on.
Vector TurningForces::force(double t, double t_0, double h, Index first, Index count) const {
  const double at = std::clamp((t - t_0) / h, 0.0, 1.0) * static_cast<double>(g_.cols() - 1);
  const Index i = std::min(static_cast<Index>(at), g_.cols() - 2);
  const double share = at - static_cast<double>(i);
  Vector g =
      (1 - share) * g_.col(i).segment(first, count) + share * g_.col(i + 1).segment(first, count);
  for (Index j = 0; j < count; ++j)
    if (const LoadHistory& history = histories_[first + j]; history.has_points())
      g[j] *= history.value(t);
  return H_.middleCols(first, count) * g;
}

}  // namespace cbr
