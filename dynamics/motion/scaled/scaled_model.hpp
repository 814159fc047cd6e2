// SPDX-License-Identifier: GPL-3.0-or-later
// Where the modes of a body with modal mass scaling come from: shared by the instances of a
// component.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/diagonal_form.hpp"
#include "dynamics/motion/scaled/scaled_modes.hpp"

namespace cbr {

class ScaledModel {
 public:
  virtual ~ScaledModel() = default;

  const Superelement& superelement() const { return *superelement_; }
  virtual Index n_modes() const = 0;
  virtual double largest_frequency() = 0;  // of the component as it is, rad/s

  // Modes up to `clip` as they are, those above it scaled. A clip of at least largest_frequency()
  // scales nothing. The last answer is kept for the other instances. RunError: see the two ways
  // below.
  std::shared_ptr<const ScaledModes> clipped(double clip);

 protected:
  explicit ScaledModel(std::shared_ptr<const Superelement> superelement)
      : superelement_(std::move(superelement)) {}
  virtual std::shared_ptr<ScaledModes> make(double clip) = 0;

 private:
  std::shared_ptr<const Superelement> superelement_;
  std::shared_ptr<const ScaledModes> last_;
  double last_clip_ = -1;
};

// From all modes: any form (held, with shells, of a group). Nothing is computed but products.
std::shared_ptr<ScaledModel> scaled_model(std::shared_ptr<const Superelement> superelement,
                                          std::shared_ptr<const DiagonalForm> form);

// From the matrices alone, for some thousand interface dofs: modes below the clip by block Lanczos,
// those above it together from a factor of K_cc; no mode was missed, which a factor of K^ - clip^2
// M^ without the found ones proves. Where that does not go (a clip above all modes or a third of
// them, motions without stiffness), all modes of a small component are computed, of a large one it
// is a RunError, named by `where`. Keeps one matrix of the interface's size.
std::shared_ptr<ScaledModel> scaled_model(std::shared_ptr<const Superelement> superelement,
                                          std::vector<HeldDirection> held, std::string where);

}  // namespace cbr
