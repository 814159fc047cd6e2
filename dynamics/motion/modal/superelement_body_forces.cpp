// SPDX-License-Identifier: GPL-3.0-or-later
// The modes under forces that are linear in time: loads, those of a floating frame, and forces of
// contact that last. The modes move under these, and impulses are their changes (docs/theory.md,
// "Forces that last").
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
  if (turning_.of_loads()) {
    f0_ += turning_.load_force(from, t_, h_);
    f1_ += turning_.load_force(to, t_, h_);
  }
  propagate_free(step, work_eta_, work_v_, eta_end, v_end);
  add_load(step, f0_, f1_, eta_end, v_end);
  const bool lasts = lasting_.now.size() > 0;
  if (lasts) add_load(step, lasting_.now, lasting_.now, eta_end, v_end);
  const bool spins = turning_.of_spin();
  const Vector spin0 = spins ? turning_.spin_force(from, t_, h_) : Vector(),
               spin1 = spins ? turning_.spin_force(to, t_, h_) : Vector();
  if (spins) add_load(step, spin0, spin1, eta_end, v_end);
  if (!work) return;
  if (lasts) work->contact += lasting_.now.dot(eta_end - work_eta_);
  const auto work_of = [&](LinearForce all, const LinearForce& of) {
    const Vector start = lasts ? Vector(all.start + lasting_.now) : Vector(),
                 end = lasts ? Vector(all.end + lasting_.now) : Vector();
    const LinearForce with_lasting{start, end};
    return load_work(step, work_eta_, work_v_, eta_end, lasts ? with_lasting : all, of);
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

// Adds the effect of a kick at the start on the end of the step, to round-off as propagate() has
// it.
void SuperelementBody::add_coupled(const Vector& kick) {
  Vector eta = Vector::Zero(kick.size()), v = kick;
  turning_.move_at_start(h_, eta, v);
  propagate_free(propagator(h_), eta, v, work_eta_, work_v_);
  turning_.move_at_end(h_, work_eta_, work_v_);
  eta_end_ += work_eta_;
  v_end_ += work_v_;
}

void SuperelementBody::add_turning_force(const Vector& column, const LoadHistory& history) {
  turning_.add(column, history);
  breakpoints_.add(history);
  regular_ = other_ = nullptr;
}

// Of the forces in a share of the step, as impulses.
Vector SuperelementBody::lasting_kick(double share, const Vector& force) const {
  if (force.size() == 0) return Vector::Zero(eta_.size());
  return share * contact_kick(h_, force);
}

void SuperelementBody::own_expect_forces(Index set, const Points& forces) {
  lasting_.next.resize(0);
  if (scheme() == Scheme::newmark || frame_ || forces.rows() == 0) return;
  take_force(set, forces);
  lasting_.next = f_;
  if (lasting_.ever) return;
  lasting_.ever = true;
  regular_ = other_ = nullptr;  // without terms of forces
}

// From statics: forces of contact as they are.
void SuperelementBody::let_last(const Vector& force) {
  lasting_.ever = true;
  regular_ = other_ = nullptr;
  lasting_.now = force;
}

// The impulses of contact to come have the lasting forces in them, which act by themselves.
void SuperelementBody::kick_back() {
  if (lasting_.now.size() == 0) return;
  f_ = lasting_kick(-1, lasting_.now);
  feel_kick();
}

// Of a kick that finds the rates v.
void SuperelementBody::book_kick(const Vector& kick, const Vector& v) {
  work_.contact += kick.dot(v) + 0.5 * kick.squaredNorm();
}

// Half of the change of forces acts before the moment at which they do, and half after it.
void SuperelementBody::change_force() {
  if (lasting_.now.size() == 0 && lasting_.next.size() == 0) return;
  const Vector kick = lasting_kick(0.5, lasting_.next) - lasting_kick(0.5, lasting_.now);
  book_kick(kick, v_end_);
  v_end_ += kick;
}

// Work of forces at the ends of steps, from the middle of the kick at the start of the step to that
// of the kick at its end. The next step gets the rest of that kick.
void SuperelementBody::accept_late() {
  const Vector start = 0.5 * late_;
  book_kick(start, v_ - start);
  v_end_ -= late_end_;
  const Vector before = 0.5 * (late_end_ - lasting_kick(1, lasting_.now));
  book_kick(before, v_end_);
  late_end_ -= lasting_kick(1, lasting_.next);
  v_end_ += before + 0.5 * late_end_;
}

}  // namespace cbr
