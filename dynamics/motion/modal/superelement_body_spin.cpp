// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement's modes under loads and the forces of a spin, both linear in time.
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
  propagate_free(step, work_eta_, work_v_, eta_end, v_end);
  add_load(step, f0_, f1_, eta_end, v_end);
  const bool spins = spin_g_.cols() > 0;
  const Vector spin0 = spins ? spin_force(from) : Vector(),
               spin1 = spins ? spin_force(to) : Vector();
  if (spins) add_load(step, spin0, spin1, eta_end, v_end);
  if (work && !loads_.empty())
    work->external += load_work(step, work_eta_, work_v_, eta_end, f0_, f1_, weight_);
  if (work && spins)
    work->spin += load_work(step, work_eta_, work_v_, eta_end, spin0, spin1, weight_);
}

bool SuperelementBody::feel_spin() {
  const Matrix& moments = superelement_->spin_moments;
  if (moments.rows() != form_->V.rows() || moments.rows() == 0) return false;
  spin_H_.noalias() = form_->V.transpose() * moments;
  spin_H_.topRows(form_->n_rigid).setZero();
  return true;
}

Vector SuperelementBody::spin_force(double t) const {
  const double at = std::clamp((t - t_) / h_, 0.0, 1.0) * static_cast<double>(spin_g_.cols() - 1);
  const Index i = std::min(static_cast<Index>(at), spin_g_.cols() - 2);
  const double share = at - static_cast<double>(i);
  return spin_H_ * ((1 - share) * spin_g_.col(i) + share * spin_g_.col(i + 1));
}

}  // namespace cbr
