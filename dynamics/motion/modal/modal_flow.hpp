// SPDX-License-Identifier: GPL-3.0-or-later
// The exact motion of modes between impulses.
#pragma once

#include <memory>

#include "common/files/state_archive.hpp"
#include "dynamics/motion/loads.hpp"
#include "dynamics/motion/modal/turning_forces.hpp"

namespace cbr {

// The modes of a form under forces that are linear in time: loads, those of a floating frame, and
// forces of contact that last. The modes move under these, and impulses are their changes
// (docs/theory.md, "Forces that last"). Schemes that are not exact have its loads and lasting
// forces alone. All forces are modal, V^T f   (n).
class ModalFlow {
 public:
  ModalFlow(std::shared_ptr<const ModalForm> form, ModalRates damping);

  void add_load(const Vector& amplitude, const LoadHistory& history);
  void add_turning_force(const Vector& column, const LoadHistory& history);
  const Loads<Vector>& loads() const { return loads_; }
  TurningForces& turning() { return turning_; }
  const TurningForces& turning() const { return turning_; }

  // Impulses of contact get the contact_gain() of steps h from here on.
  void set_contact_step(double h);
  double contact_step() const { return contact_step_; }  // 0: no gain
  void amplify(Vector& impulse) const {
    if (gain_.size() > 0) impulse.array() *= gain_.array();
  }

  // Forces of contact that last, in this step and in the next; empty: none.
  const Vector& lasting() const { return lasting_; }
  const Vector& next_lasting() const { return next_lasting_; }
  void let_last(Vector force);  // in this step
  void expect(Vector force);    // in the next
  void accept();                // the next step becomes this one

  bool is_driven() const { return !loads_.empty() || turning_.act() || lasting_.size() > 0; }
  bool may_be_driven() const { return !loads_.empty() || !turning_.empty() || has_lasted_; }
  const ModalPropagator& propagator(double h) const;
  // From t to t + h. work: of the forces, or null.
  void advance(double t, double h, const ModalState& start, ModalState& end, FlowWork* work);
  // Adds the effect of an impulse at the start of a step on its end.
  void push(double h, const Vector& impulse, ModalState& end);

  void keep_state(StateArchive& archive);

 private:
  void advance_part(double from, double to, bool whole, double t, double h, ModalState& end,
                    FlowWork* work);
  void forget_propagators() { regular_ = other_ = nullptr; }

  std::shared_ptr<const ModalForm> form_;
  ModalRates damping_;
  Loads<Vector> loads_;
  Breakpoints breakpoints_;  // of all histories
  TurningForces turning_;
  Vector lasting_, next_lasting_;
  bool has_lasted_ = false;  // once
  double contact_step_ = 0;
  Vector gain_;                                                     // empty: 1
  mutable std::shared_ptr<const ModalPropagator> regular_, other_;  // of the last two step lengths
  ModalState start_;                                                // workspaces
  Vector f0_, f1_;
};

}  // namespace cbr
