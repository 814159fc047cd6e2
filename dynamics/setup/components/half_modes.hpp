// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement with half of its modes, made from what was read: how much a run depends on them
// (cbr-dyn --check-error).
#pragma once

#include "common/superelement/superelement.hpp"

namespace cbr {

enum class HalfBy { frequency, participation };

// InputError for one that has no half to keep: basis characteristic, massless ones of older files
// whose half is not known, fixed modes too few to be halved. For before a run.
void require_half(const Superelement& superelement);

// Keeps half (rounded down) of the modes: the lowest, or those with the largest |alpha_j|^2;
// residual vectors stay all. With basis massless it is what a reduction with half of the modes
// would be, whichever massless_modes: rigid motions stay all, and statics as they are. Its diagonal
// form is dropped, its matrices must be there. Returns how many modes went. InputError:
// require_half(), or half of the fixed modes leave a rigid motion without mass.
Index keep_half(Superelement& superelement, HalfBy by);

}  // namespace cbr
