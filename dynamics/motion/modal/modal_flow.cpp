// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/modal_flow.hpp"

#include <algorithm>
#include <utility>

namespace cbr {

ModalFlow::ModalFlow(std::shared_ptr<const ModalForm> form, ModalRates damping)
    : form_(std::move(form)), damping_(std::move(damping)) {
  for (Vector* x : {&start_.eta, &start_.v, &f0_, &f1_}) x->setZero(form_->omega.size());
}

void ModalFlow::add_load(const Vector& amplitude, const LoadHistory& history) {
  forget_propagators();
  if (loads_.add(amplitude, history)) breakpoints_.add(history);
}

void ModalFlow::add_turning_force(const Vector& column, const LoadHistory& history) {
  turning_.add(column, history);
  breakpoints_.add(history);
  forget_propagators();
}

void ModalFlow::set_contact_step(double h) {
  contact_step_ = h;
  gain_ = damping_.hash != 0 ? contact_gain(form_->omega, damping_.c, form_->n_rigid, h)
                             : contact_gain(form_->omega, h);
}

void ModalFlow::let_last(Vector force) {
  has_lasted_ = true;
  forget_propagators();
  lasting_ = std::move(force);
}

void ModalFlow::expect(Vector force) {
  next_lasting_ = std::move(force);
  if (has_lasted_ || next_lasting_.size() == 0) return;
  has_lasted_ = true;
  forget_propagators();  // they are without terms of forces
}

void ModalFlow::accept() {
  lasting_ = std::move(next_lasting_);
  next_lasting_.resize(0);
}

const ModalPropagator& ModalFlow::propagator(double h) const {
  if (regular_ && regular_->h == h) return *regular_;
  std::swap(regular_, other_);
  if (!regular_ || regular_->h != h)
    regular_ = form_->shared.propagator(form_->omega, damping_, h, may_be_driven());
  return *regular_;
}

// Cut at the histories' breakpoints, and where forces that turn with the body bend, so that each
// part is linear in time.
void ModalFlow::advance(double t, double h, const ModalState& start, ModalState& end,
                        FlowWork* work) {
  if (!is_driven()) return propagate_free(propagator(h), start.eta, start.v, end.eta, end.v);
  end = start;
  if (turning_.couples()) turning_.pull_at_start(t, h, end.eta, end.v, work);
  const Index n = std::max<Index>(1, turning_.n_parts());
  const auto at = [&](Index i) { return t + h * static_cast<double>(i) / static_cast<double>(n); };
  breakpoints_.cut(t, h, [&](double from, double to, bool whole) {
    for (Index i = 0; i < n; ++i) {
      const double begin = std::max(from, at(i)), stop = i + 1 == n ? to : std::min(to, at(i + 1));
      if (n == 1 || stop > begin) advance_part(begin, stop, whole && n == 1, t, h, end, work);
    }
  });
  if (turning_.couples()) turning_.pull_at_end(t, h, end.eta, end.v, work);
}

// A part of the step h from t, in which all forces are linear.
void ModalFlow::advance_part(double from, double to, bool whole, double t, double h,
                             ModalState& end, FlowWork* work) {
  const ModalPropagator shorter =
      whole ? ModalPropagator{} : modal_propagator(form_->omega, damping_, to - from, true);
  const ModalPropagator& step = whole ? propagator(h) : shorter;
  start_ = end;
  loads_.sum(from, f0_);
  loads_.sum(to, f1_);
  if (turning_.of_loads()) {
    f0_ += turning_.load_force(from, t, h);
    f1_ += turning_.load_force(to, t, h);
  }
  propagate_free(step, start_.eta, start_.v, end.eta, end.v);
  cbr::add_load(step, f0_, f1_, end.eta, end.v);
  const bool lasts = lasting_.size() > 0;
  if (lasts) cbr::add_load(step, lasting_, lasting_, end.eta, end.v);
  const bool spins = turning_.of_spin();
  const Vector spin0 = spins ? turning_.spin_force(from, t, h) : Vector(),
               spin1 = spins ? turning_.spin_force(to, t, h) : Vector();
  if (spins) cbr::add_load(step, spin0, spin1, end.eta, end.v);
  if (!work) return;
  if (lasts) work->contact += lasting_.dot(end.eta - start_.eta);
  const auto work_of = [&](LinearForce all, const LinearForce& of) {
    const Vector start = lasts ? Vector(all.start + lasting_) : Vector(),
                 stop = lasts ? Vector(all.end + lasting_) : Vector();
    const LinearForce with_lasting{start, stop};
    return load_work(step, start_.eta, start_.v, end.eta, lasts ? with_lasting : all, of);
  };
  const bool has_others = !loads_.empty() || turning_.of_loads();
  if (!spins || !has_others) {
    if (has_others) work->external += work_of({f0_, f1_}, {f0_, f1_});
    if (spins) work->spin += work_of({spin0, spin1}, {spin0, spin1});
    return;
  }
  const Vector all0 = f0_ + spin0, all1 = f1_ + spin1;
  work->external += work_of({all0, all1}, {f0_, f1_});
  work->spin += work_of({all0, all1}, {spin0, spin1});
}

// To round-off as advance() has it.
void ModalFlow::push(double h, const Vector& impulse, ModalState& end) {
  const ModalPropagator& step = propagator(h);
  if (!turning_.couples()) {
    end.eta.array() += step.s.array() * impulse.array();
    end.v.array() += step.velocity_left().array() * impulse.array();
    return;
  }
  Vector eta = Vector::Zero(impulse.size()), v = impulse;
  turning_.move_at_start(h, eta, v);
  propagate_free(step, eta, v, start_.eta, start_.v);
  turning_.move_at_end(h, start_.eta, start_.v);
  end.eta += start_.eta;
  end.v += start_.v;
}

void ModalFlow::keep_state(StateArchive& archive) {
  archive(lasting_);
  if (!archive.restores()) return;
  has_lasted_ |= lasting_.size() > 0;
  forget_propagators();
}

}  // namespace cbr
