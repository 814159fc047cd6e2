// SPDX-License-Identifier: GPL-3.0-or-later
// Friction of pressure functions where two faces rotate against each other.
#pragma once

#include <vector>

#include "dynamics/contact/enforce/contact_unknowns.hpp"

namespace cbr {

// Factors of mu, per unknown, for the next step. Friction of a function has one direction at all of
// its points, that of their mean slip. Where the faces rotate, its points slide in different
// directions. Uniform friction lacks their couple, so a face that spins had 4 % too little torque.
// A larger mu gives the same power instead. Near the centre of rotation the directions nearly
// cancel, and mu becomes smaller. The rotation is that of the rigid motion that fits the mean slips
// of all functions of a search best, as slips within a function are elastic, too.
// `gap`: of the points' rows at the end of the step; `x`: impulses of the unknowns. Functions that
// stick keep their factor.
Vector friction_factors(const ContactUnknowns& unknowns, const ContactList& list,
                        const std::vector<PointLaw>& laws, const std::vector<ContactBody>& bodies,
                        const Vector& gap, const Vector& x);

}  // namespace cbr
