// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/superelement.hpp"

namespace cbr {

// check() of what was read: matrices that were not asked for are not missed.
void check_parts(const Superelement& superelement, const SuperelementParts& parts, const std::string& where);

// InputError, naming the field: rigid motions by coordinates and rigid_body, and by what has been read of matrices, modes and
// loads, are not the same (1e-2). An interface that does not tell all six of them passes. For who moves a superelement: check()
// does not ask for it.
void check_rigid_motions(const Superelement& superelement, const std::string& where);

}  // namespace cbr
