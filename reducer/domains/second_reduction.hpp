// SPDX-License-Identifier: GPL-3.0-or-later
// The domains of a component, put together and reduced once more to the component's own interface:
// one superelement.
#pragma once

#include <vector>

#include "common/superelement/superelement_group.hpp"
#include "reducer/bases/reduce.hpp"

namespace cbr {

// Interior: the modal coordinates of all domains and the shared nodes that the component does not
// keep; interface: the joined nodes with an id of `interface_ids`. Statically the same as one
// reduction of the whole; its modes lie in the span of the domains' modes. `options`: second_modes
// or second_cutoff_hz (lowest modes), recovery (the domains must have theirs). Sets everything but
// content_hash, provenance and the diagonal form, which add_diagonal_form() adds. InputError: more
// modes than there are, a part that the interface does not constrain.
Superelement reduce_again(const SuperelementGroup& group, const std::vector<Index>& interface_ids,
                          const ReductionOptions& options, const ReduceSettings& settings,
                          Report& report, ReductionFigures* figures = nullptr);

}  // namespace cbr
