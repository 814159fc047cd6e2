// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/superelement/superelement.hpp"

namespace cbr {

// check() of the parts that were read: it misses no others.
void check_parts(const Superelement& superelement, const SuperelementParts& parts,
                 const std::string& where);

// InputError, naming the field: rigid motions by coordinates and rigid_body differ (1e-2) from
// those of the matrices, modes and loads that were read. Passes an interface that does not
// determine all six of them, and a part that is constrained inside. For programs that move
// superelements: check() does not require it.
void check_rigid_motions(const Superelement& superelement, const std::string& where);

// True if K_cc resists a translation by 1e-6 of |K_cc| |R|. That is far above the digits of a float
// and far below one clamped node. (Rotations prove nothing: K_cc also resists those of wrong
// coordinates.) Without the matrices: a diagonal form has fewer than six motions of frequency 0.
// cbr-reduce makes no such parts, others clamp nodes inside.
bool is_held_inside(const Superelement& superelement);

}  // namespace cbr
