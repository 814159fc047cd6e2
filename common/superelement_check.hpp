// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/superelement.hpp"

namespace cbr {

// check() of what was read: matrices that were not asked for are not missed.
void check_parts(const Superelement& superelement, const SuperelementParts& parts, const std::string& where);

// InputError, naming the field: rigid motions by coordinates and rigid_body, and by what has been read of matrices, modes and
// loads, are not the same (1e-2). An interface that does not tell all six of them passes, and a part that is held inside. For who
// moves a superelement: check() does not ask for it.
void check_rigid_motions(const Superelement& superelement, const std::string& where);

// Rigid motions that K_cc resists, orthonormal as combinations of the columns of R whose rotations are divided by `size`   (r x 6): no
// rows when the part is free, as cbr-reduce makes it, or when its matrices are not read. Other makers clamp nodes inside. Forces count
// from 1e-6 of |K_cc| |R| on: far above what digits of a float leave, far below what one clamped node makes.
Matrix resisted_rigid_motions(const Superelement& superelement, double size);
// A translation is among them; without the matrices, a diagonal form has fewer than six motions of frequency 0. (Rotations are no
// sign of it: those of coordinates that do not belong to the matrices are resisted, too.)
bool is_held_inside(const Superelement& superelement);

}  // namespace cbr
