// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_forces.hpp"

#include <algorithm>

#include "dynamics/motion/modal/modal_body.hpp"

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

TurningLoad::TurningLoad(const VectorForce& force, const LoadHistory& history,
                         const ModalBody& modal)
    : value_(force.value),
      follows_(force.follows),
      history_(history),
      elastic_(Matrix::Zero(modal.n_dofs(), 3)),
      bend_(Matrix::Zero(modal.n_dofs(), 9)) {
  const Vector3 c = modal.center_of_mass();
  const Points& X = modal.own_nodes();
  const Matrix& V = modal.form().V;
  for (Index a = 0; a < 3; ++a) {
    const ForcePattern& pattern = force.patterns[a];
    elastic_.col(a) = modal.modal_force(pattern);
    const Points forces = pattern.forces.on_nodes();
    for (Index i = 0; i < forces.rows(); ++i) {
      const Vector3 f = forces.row(i).transpose();
      if (f.isZero(0)) continue;
      resultant_.col(a) += f;
      moment_.col(a) += Vector3(X.row(i).transpose() - c).cross(f);
      for (int d = 0; d < 3; ++d) {
        const Index row = modal.rows()(i, d);
        if (row < 0) continue;
        const Vector3 arm = modal.axes().col(d);  // scene axes, of the component's axis d
        bend_.middleCols(3 * a, 3) += V.row(row).transpose() * arm.cross(f).transpose();
      }
    }
  }
  const Index n_rigid = modal.form().n_rigid;
  elastic_.topRows(n_rigid).setZero();
  bend_.topRows(n_rigid).setZero();
}

Vector3 TurningLoad::moment(const Eigen::Quaterniond& q, const Vector& eta) const {
  const Vector bent = bend_.transpose() * eta;
  const Matrix3 all = moment_ + Eigen::Map<const Matrix3>(bent.data());
  return q * (all * vector(q));
}

}  // namespace cbr
