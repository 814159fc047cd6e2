// SPDX-License-Identifier: GPL-3.0-or-later
// What is inside and what on the interface, in several processes, and which reductions they do not
// know.
#pragma once

#include <string>
#include <vector>

#include "reducer/bases/reduction_steps.hpp"

namespace cbr {

// InputError: `what` is supported in one process only.
[[noreturn]] void refuse(const std::string& what);
void refuse_unknown(const ReductionOptions& options);

// Nodes inside and on the interface, without K and M.
void divide(Reduction& r);

// Per node of the mesh its place in a list of model nodes, or -1.
std::vector<Index> places(const Reduction& r, const std::vector<Index>& nodes);

}  // namespace cbr
