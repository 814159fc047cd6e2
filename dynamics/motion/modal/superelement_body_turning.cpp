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
  work_eta_ = eta_end, work_v_ = v_end;
  load_amplitudes(from, f0_);
  load_amplitudes(to, f1_);
  const Index n_others = turning_H_.cols() - n_spin_;
  if (turning_g_.cols() > 0 && n_others > 0) {
    f0_ += turning_force(from, n_spin_, n_others);
    f1_ += turning_force(to, n_spin_, n_others);
  }
  propagate_free(step, work_eta_, work_v_, eta_end, v_end);
  add_load(step, f0_, f1_, eta_end, v_end);
  const bool spins = turning_g_.cols() > 0 && n_spin_ > 0;
  const Vector spin0 = spins ? turning_force(from, 0, n_spin_) : Vector(),
               spin1 = spins ? turning_force(to, 0, n_spin_) : Vector();
  if (spins) add_load(step, spin0, spin1, eta_end, v_end);
  if (!work) return;
  const auto work_of = [&](const LinearForce& all, const LinearForce& of) {
    return load_work_among(step, work_eta_, work_v_, eta_end, all, of, weight_);
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
  return true;
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
