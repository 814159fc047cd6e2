// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark's method on modes.
#pragma once

#include <memory>

#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/schemes.hpp"

namespace cbr {

// Newmark's method on the modes of a form, which are uncoupled, so that a step solves nothing.
class ModalNewmark {
 public:
  ModalNewmark(const NewmarkOptions& numbers, std::shared_ptr<const ModalForm> form,
               ModalRates damping);
  ModalNewmark(const ModalNewmark&) = delete;

  double stiffness_factor(double h) const { return scheme_.numbers().stiffness_factor(h); }
  // Whether impulses of contact act at the start of a step h, as with the other schemes. Residual
  // compliance follows forces at once and has no velocities: so it is beside it, where the step is
  // no longer than the critical one.
  bool kicks_at_start(double h) const { return form_->residual && form_->highest() * h <= 2; }
  // The move of each mode's end by a unit impulse of contact.
  const Vector& kick_weight(double h) const;

  // As of Newmark.
  void predict(double t, double h, const Loads<Vector>& loads, const ModalState& start,
               ModalState& end);
  void push(const Vector& kick, const ModalState& start, ModalState& end);
  // Once a step: further calls change nothing. A kick at the start moves from `kick` to the rates
  // of the start.
  void arrive(const Loads<Vector>& loads, Kick& kick, ModalState& start, ModalState& end,
              BodyWork& work);
  // Of an impulse at the end, after arrive().
  void push_end(const Vector& kick, ModalState& end, BodyWork& work);
  void accept() { scheme_.accept(); }
  void keep_state(StateArchive& archive) { scheme_.keep_state(archive); }

 private:
  NewmarkOperators operators();
  void weigh(double h) const;
  void correct(const NewmarkStep& step);
  void correct_damped(const NewmarkStep& step);

  std::shared_ptr<const ModalForm> form_;
  ModalRates damping_;
  Newmark scheme_;
  double h_ = 0;
  Vector room_;  // workspace
  mutable Vector weight_, kick_weight_;
  mutable double weighed_h_ = 0;
  mutable Index n_soft_ = 0;  // modes whose omega h is not large
};

}  // namespace cbr
