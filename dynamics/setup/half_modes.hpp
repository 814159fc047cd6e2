// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement with half of its modes, made from what was read: how much a run depends on them (cbr-dyn --check-error).
#pragma once

#include "common/superelement.hpp"

namespace cbr {

enum class HalfBy { frequency, participation };

// InputError for one that has no half to keep: basis characteristic. What keep_half() throws, for before a run.
void require_half(const Superelement& superelement);

// Keeps half (rounded down) of the modes: the lowest, or those with the largest |alpha_j|^2; residual vectors and, with basis
// massless, rigid motions stay all, and F takes up what the dropped modes had of the compliance. Its diagonal form is dropped, its
// matrices must be there. Returns how many modes went.
Index keep_half(Superelement& superelement, HalfBy by);

}  // namespace cbr
