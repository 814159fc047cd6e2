// SPDX-License-Identifier: GPL-3.0-or-later
// A small superelement with every optional part, without a mesh: its numbers satisfy the rules of
// the format only.
#pragma once

#include "common/superelement/superelement_group.hpp"

namespace cbr::test {

// k = 4 modes, c = 12 dofs of a unit square's 4 nodes, quad4 and tri3 surfaces, a nodeset, diagonal
// form, recovery of 2 nodes.
Superelement sample_superelement(unsigned seed = 1);

// Bitwise equality of all numbers and names.
bool identical(const Superelement& a, const Superelement& b);

// Three of them with shared nodes, pairwise and all three, each with a part of the surfaces; with
// diagonal form and recovery.
SuperelementGroup sample_group();
bool identical(const SuperelementGroup& a, const SuperelementGroup& b);

}  // namespace cbr::test
