// SPDX-License-Identifier: GPL-3.0-or-later
// The bases of a superelement, each in a file of its name: a straight line from the condensed
// matrices to a superelement.
#pragma once

#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {

// Ingredients of a basis beside K_cc and M_cc, which the superelement has already.
struct Ingredients {
  FixedInterfaceModes modes;  // of first_modes(), those that are kept
  Condensation condensed;
};

// basis_craig_bampton.cpp
void make_basis_craig_bampton(Reduction& r, Ingredients&& given, Superelement& s);

// basis_massless.cpp. Of free modes, which it computes itself.
void make_basis_massless(Reduction& r, Superelement& s);

// basis_characteristic.cpp
void make_basis_characteristic(Reduction& r, Ingredients&& given, Superelement& s);
// The same by sparse solves alone, without a condensation: of one factor, or of two, one after the
// other. False: the component is for make_basis_characteristic().
bool make_basis_of_free_shapes(Reduction& r, Superelement& s);

}  // namespace cbr
