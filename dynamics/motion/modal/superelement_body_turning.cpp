// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement's modes under loads, and under forces that turn with the body, linear in time.
#include <algorithm>

#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

void SuperelementBody::propagate_driven(double from, double to, bool whole, Vector& eta_end,
                                        Vector& v_end, FlowWork* work) {
  const ModalPropagator shorter = whole ? ModalPropagator{}
                                  : is_damped()
                                      ? damped_propagator(form_->omega, damping_.c, to - from, true)
                                      : modal_propagator(form_->omega, to - from, true);
  const ModalPropagator& step = whole ? propagator(h_) : shorter;
  work_eta_ = eta_end;
  work_v_ = v_end;
  load_amplitudes(from, f0_);
  load_amplitudes(to, f1_);
  const Index n_others = turning_H_.cols() - n_spin_;
  if (turning_g_.cols() > 0 && n_others > 0) {
    f0_ += turning_force(from, n_spin_, n_others);
    f1_ += turning_force(to, n_spin_, n_others);
  }
  propagate_free(step, work_eta_, work_v_, eta_end, v_end);
  add_load(step, f0_, f1_, eta_end, v_end);
  const bool lasts = lasting_.now.size() > 0;
  if (lasts) add_load(step, lasting_.now, lasting_.now, eta_end, v_end);
  const bool spins = turning_g_.cols() > 0 && n_spin_ > 0;
  const Vector spin0 = spins ? turning_force(from, 0, n_spin_) : Vector(),
               spin1 = spins ? turning_force(to, 0, n_spin_) : Vector();
  if (spins) add_load(step, spin0, spin1, eta_end, v_end);
  if (!work) return;
  if (lasts) work->contact += lasting_.now.dot(eta_end - work_eta_);
  const auto work_of = [&](LinearForce all, const LinearForce& of) {
    const Vector start = lasts ? Vector(all.start + lasting_.now) : Vector(),
                 end = lasts ? Vector(all.end + lasting_.now) : Vector();
    const LinearForce with_lasting{start, end};
    return load_work(step, work_eta_, work_v_, eta_end, lasts ? with_lasting : all, of);
  };
  const bool has_others = !loads_.empty() || n_others > 0;
  if (!spins || !has_others) {
    if (has_others) work->external += work_of({f0_, f1_}, {f0_, f1_});
    if (spins) work->spin += work_of({spin0, spin1}, {spin0, spin1});
    return;
  }
  const Vector all0 = f0_ + spin0, all1 = f1_ + spin1;
  work->external += work_of({all0, all1}, {f0_, f1_});
  work->spin += work_of({all0, all1}, {spin0, spin1});
}

bool SuperelementBody::feel_spin() {
  const Matrix& moments = superelement_->spin_moments;
  if (moments.rows() != form_->V.rows() || moments.rows() == 0) return false;
  turning_H_.noalias() = form_->V.transpose() * moments;
  turning_H_.topRows(form_->n_rigid).setZero();
  n_spin_ = turning_H_.cols();
  turning_histories_.resize(static_cast<std::size_t>(n_spin_));
  coupling_ = form_->shared.spin_coupling(*superelement_, form_->n_rigid, form_->omega.size());
  return true;
}

void SuperelementBody::couple(const Vector3& start, const Vector3& end) {
  if (!pulls_) pulls_ = Pulls{};
  if (!pulls_->is_known || pulls_->w_start != start) {
    pulls_->is_known = false;
    pulls_->w_start = start;
    pulls_->start = coupling_->pull(start);
  }
  pulls_->end = coupling_->pull(end);
}

void SuperelementBody::take_drift(const Vector& drift) {
  drift_.setZero(drift.size() > 0 ? eta_.size() : 0);
  if (drift.size() == 0) return;
  drift_.segment(coupling_->first(), coupling_->size()) = drift;
}

// As flow_energy(), of the coupled modes.
double SuperelementBody::coupled_energy(const Vector& eta, const Vector& v) const {
  double sum = 0;
  for (Index j = coupling_->first(); j < coupling_->first() + coupling_->size(); ++j) {
    const double force = form_->omega[j] * eta[j];
    sum += v[j] * v[j] + force * force;
  }
  return 0.5 * sum;
}

// Half a step of the coupling.
void SuperelementBody::pull_at_start(Vector& eta, Vector& v, FlowWork* work) {
  Pulls& pulls = *pulls_;
  if (!pulls.is_known || pulls.h != h_) {
    pulls.eta = eta;
    pulls.v = v;
    pulls.h = h_;
    coupling_->move(pulls.start, 0.5 * h_, damping_.c, pulls.eta, pulls.v);
    pulls.is_known = true;
  }
  if (work) {
    book_drift(coupling_->drift(pulls.start, eta), t_, v, *work);
    work->spin += coupled_energy(pulls.eta, pulls.v) - coupled_energy(eta, v);
  }
  eta = pulls.eta;
  v = pulls.v;
}

void SuperelementBody::pull_at_end(Vector& eta, Vector& v, FlowWork* work) {
  const double before = work ? coupled_energy(eta, v) : 0;
  coupling_->move(pulls_->end, 0.5 * h_, damping_.c, eta, v);
  if (!work) return;
  book_drift(coupling_->drift(pulls_->end, eta), t_ + h_, v, *work);
  work->spin += coupled_energy(eta, v) - before;
}

// What a kick at the start brings to the end of the step, to round-off as propagate() has it.
void SuperelementBody::add_coupled(const Vector& kick) {
  Vector eta = Vector::Zero(kick.size()), v = kick;
  coupling_->move(pulls_->start, 0.5 * h_, damping_.c, eta, v);
  propagate_free(propagator(h_), eta, v, work_eta_, work_v_);
  coupling_->move(pulls_->end, 0.5 * h_, damping_.c, work_eta_, work_v_);
  eta_end_ += work_eta_;
  v_end_ += work_v_;
}

// What loads and damping do to eta' beyond what they do to p, at t: by the trapezoidal rule.
void SuperelementBody::book_drift(const Vector& drift, double t, const Vector& v,
                                  FlowWork& work) const {
  const Index first = coupling_->first(), m = coupling_->size();
  if (const Index n_others = turning_H_.cols() - n_spin_; n_others > 0) {
    const double loads =
        0.5 * h_ * turning_force(t, n_spin_, n_others).segment(first, m).dot(drift);
    work.external += loads;
    work.spin -= loads;
  }
  if (is_damped())  // which takes what is left
    work.spin += 0.5 * h_ *
                 (damping_.c.segment(first, m).array() * drift.array() *
                  (2 * v.segment(first, m) + drift).array())
                     .sum();
}

void SuperelementBody::add_turning_force(const Vector& column, const LoadHistory& history) {
  turning_H_.conservativeResize(column.size(), turning_H_.cols() + 1);
  turning_H_.rightCols(1) = column;
  turning_histories_.push_back(history);
  breakpoints_.add(history);
  regular_ = other_ = nullptr;
}

// Of `count` columns from `first` on.
Vector SuperelementBody::turning_force(double t, Index first, Index count) const {
  const double at =
      std::clamp((t - t_) / h_, 0.0, 1.0) * static_cast<double>(turning_g_.cols() - 1);
  const Index i = std::min(static_cast<Index>(at), turning_g_.cols() - 2);
  const double share = at - static_cast<double>(i);
  Vector g = (1 - share) * turning_g_.col(i).segment(first, count) +
             share * turning_g_.col(i + 1).segment(first, count);
  for (Index j = 0; j < count; ++j)
    if (const LoadHistory& history = turning_histories_[static_cast<std::size_t>(first + j)];
        history.has_points())
      g[j] *= history.value(t);
  return turning_H_.middleCols(first, count) * g;
}

}  // namespace cbr
