// SPDX-License-Identifier: GPL-3.0-or-later
// How a superelement of modes, and a rigid body, rest when their supports are moved.
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/prescribed_motion.hpp"

namespace cbr {

// Of u_c = V_c q + F f_c, as the bases massless and characteristic (without F) have it. `free`: its
// free form. Column j of `motion` (held x m) moves the held directions in the j-th motion.
SupportShapes modal_shapes(const Superelement& superelement, const ModalForm& free,
                           const std::vector<HeldDirection>& held, const Matrix& motion);

// Of the nodes of a rigid body. InputError, after `where`: motions that would strain it.
SupportShapes rigid_shapes(const Superelement& nodes, const std::vector<HeldDirection>& held,
                           const Matrix& motion, const std::string& where);

}  // namespace cbr
