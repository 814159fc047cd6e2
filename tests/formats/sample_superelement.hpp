// SPDX-License-Identifier: GPL-3.0-or-later
// A small superelement with every optional part, of no mesh: numbers that obey each rule of the
// format and nothing else.
#pragma once

#include "common/superelement/superelement_group.hpp"

namespace cbr::test {

// k = 4 modes, c = 12 dofs of a unit square's 4 nodes, quad4 and tri3 surfaces, a nodeset, diagonal
// form, recovery of 2 nodes.
Superelement sample_superelement(unsigned seed = 1);

// Every number and name of the two, bit by bit.
bool identical(const Superelement& a, const Superelement& b);

// Three of them that share nodes, two by two and all three, each with a part of the surfaces; with
// diagonal form and recovery.
SuperelementGroup sample_group();
bool identical(const SuperelementGroup& a, const SuperelementGroup& b);

}  // namespace cbr::test
