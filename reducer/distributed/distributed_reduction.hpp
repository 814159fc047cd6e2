// SPDX-License-Identifier: GPL-3.0-or-later
// reduce() of bases/reduce.hpp, by all processes at once.
#pragma once

#include <vector>

#include "reducer/bases/reduce.hpp"

namespace cbr {

// Called in all processes (processes.hpp) with the same arguments. The first returns the
// superelement, others an empty one. The numbers are those of reduce(): matrices and frequencies to
// 1e-9, modes up to their signs. Basis craig-bampton; InputError naming any unsupported option. All
// processes throw errors, as those of reduce().
Superelement reduce_in_processes(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 ReductionFigures* figures);

}  // namespace cbr
