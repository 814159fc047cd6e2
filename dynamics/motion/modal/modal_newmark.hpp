// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark's method on modes.
#pragma once

#include <memory>
#include <utility>

#include "dynamics/motion/load_history.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/schemes.hpp"

namespace cbr {

// Newmark's method (HHT-alpha) on the modes of a form, which are uncoupled, so that a step solves
// nothing. In a step predict() comes first, then push() for each impulse, and then arrive().
class ModalNewmark {
 public:
  ModalNewmark(const NewmarkOptions& numbers, std::shared_ptr<const ModalForm> form,
               ModalRates damping)
      : numbers_(numbers), form_(std::move(form)), damping_(std::move(damping)) {}

  double stiffness_factor(double h) const { return numbers_.stiffness_factor(h); }
  // Whether impulses of contact act at the start of a step h, as with the other schemes. Residual
  // compliance follows forces at once and has no velocities: so it is beside it, where the step is
  // no longer than the critical one.
  bool kicks_at_start(double h) const { return form_->residual && form_->highest() * h <= 2; }
  // The move of each mode's end by a unit impulse of contact.
  const Vector& kick_weight(double h) const {
    weigh(h);
    return kick_weight_;
  }

  void predict(double t, double h, const Loads<Vector>& loads, const ModalState& start,
               ModalState& end);
  void push(const Vector& kick, const ModalState& start, ModalState& end);
  // The rates of the end under all impulses of the step, and their work. A kick at the start moves
  // from `kick` to the rates of the start. Once a step: further calls change nothing.
  void arrive(const Loads<Vector>& loads, Kick& kick, ModalState& start, ModalState& end,
              BodyWork& work);
  // Of an impulse at the end, after arrive().
  void push_end(const Vector& kick, ModalState& end, BodyWork& work);
  void accept() { arrived_ = false; }
  void keep_state(StateArchive& archive);

 private:
  void weigh(double h) const;
  void settle(bool loaded, const Kick& kick, const ModalState& start, ModalState& end,
              BodyWork& work);
  void settle_damped(bool loaded, const Kick& kick, const ModalState& start, ModalState& end,
                     BodyWork& work);
  void find_rates(const Kick& kick, const ModalState& start, ModalState& end);

  NewmarkOptions numbers_;
  std::shared_ptr<const ModalForm> form_;
  ModalRates damping_;
  // The step's move; accelerations at its start, and at its end without the part of the move; of
  // HHT-alpha the last step's move and change of load
  Vector d_, a_, e_, move_, load_change_;
  Vector f0_, f1_, change_;
  double h_ = 0;
  mutable Vector weight_, kick_weight_;
  mutable double weighed_h_ = 0;
  mutable Index n_soft_ = 0;  // modes whose omega h is not large
  // arrived_: the end of the step is known, impulses included
  bool started_ = false, arrived_ = false;
};

}  // namespace cbr
