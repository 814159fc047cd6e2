// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model that moves, by central differences or Newmark: its matrices are factored once, before the first step.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/bodies/body.hpp"
#include "dynamics/bodies/coupled_model.hpp"
#include "dynamics/bodies/newmark.hpp"
#include "dynamics/bodies/superelement_body.hpp"

namespace cbr {

// `held`: ascending by node, component axes. RunError when the mass is not positive definite.
std::unique_ptr<Body> coupled_body(std::string name, std::shared_ptr<const CoupledModel> model, const Placement& placement,
                                   const std::vector<HeldDirection>& held, Scheme scheme, const NewmarkOptions& newmark);

}  // namespace cbr
