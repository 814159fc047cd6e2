// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/linalg/dense.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// L of the Schur complement M_res = M_cc - M_kc^T M_kc = L L^T, the interface's mass without the
// modes' (c x c). 2 k c^2 + c^3 / 3 flops, so that callers pass it on. Not ok(): the reduced mass
// is not positive definite.
Cholesky residual_mass_factor(const Superelement& superelement);

}  // namespace cbr
