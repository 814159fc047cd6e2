// SPDX-License-Identifier: GPL-3.0-or-later
// How a coupled model rests when its supports are moved.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/coupled/coupled_model.hpp"
#include "dynamics/motion/prescribed_motion.hpp"

namespace cbr {

// Column j of `motion` (held x m) moves the held directions in the j-th way. RunError: a mass that
// is not positive definite, named by `where`.
SupportShapes coupled_shapes(const std::shared_ptr<const CoupledModel>& model,
                             const std::vector<HeldDirection>& held, const Matrix& motion,
                             const std::string& where);

}  // namespace cbr
