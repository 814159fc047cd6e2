// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/superelement.hpp"

namespace cbr {

// check() of what was read: matrices that were not asked for are not missed.
void check_parts(const Superelement& superelement, const SuperelementParts& parts, const std::string& where);

}  // namespace cbr
