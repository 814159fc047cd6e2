// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/superelement/superelement.hpp"

namespace cbr {

// check() of what was read: matrices that were not asked for are not missed.
void check_parts(const Superelement& superelement, const SuperelementParts& parts,
                 const std::string& where);

// InputError, naming the field: rigid motions by coordinates and rigid_body, and by what has been
// read of matrices, modes and loads, are not the same (1e-2). An interface that does not tell all
// six of them passes, and a part that is held inside. For who moves a superelement: check() does
// not ask for it.
void check_rigid_motions(const Superelement& superelement, const std::string& where);

// Whether a translation is resisted by 1e-6 of |K_cc| |R|: far above what digits of a float leave,
// far below what one clamped node makes. (Rotations are no sign of it: those of coordinates that do
// not belong to the matrices are resisted, too.) Without the matrices: a diagonal form has fewer
// than six motions of frequency 0. cbr-reduce makes no such parts, others clamp nodes inside.
bool is_held_inside(const Superelement& superelement);

}  // namespace cbr
