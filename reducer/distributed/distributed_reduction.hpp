// SPDX-License-Identifier: GPL-3.0-or-later
// Reductions by all processes at once: of one component, or of its domains.
#pragma once

#include <vector>

#include "reducer/bases/reduce.hpp"
#include "reducer/domains/domains.hpp"

namespace cbr {

// Called in all processes (processes.hpp) with the same arguments. The first returns the
// superelement, others an empty one. The numbers are those of reduce(): matrices and frequencies to
// 1e-9, modes up to their signs. InputError naming any unsupported option. All processes throw
// errors, as those of reduce().
Superelement reduce_in_processes(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 ReductionFigures* figures);

// Domains of this process, which it reduces as one process does, without a message. The first gets
// the superelements of all.
DomainShare share_of_domains();

}  // namespace cbr
