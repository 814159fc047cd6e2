// SPDX-License-Identifier: GPL-3.0-or-later
// Shells that solids hold as hinges do: nodes of solids have no rotations.
#pragma once

#include <string>

#include "common/fem/assembly.hpp"

namespace cbr {

// A warning about shells that hold together and share nodes with solids on one line only, about
// which they turn; empty when there are none.
std::string hinged_shells(const Mesh& mesh, const FiniteElementModel& model);

}  // namespace cbr
