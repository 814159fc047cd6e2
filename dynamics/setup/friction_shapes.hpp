// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a face can give way to friction.
#pragma once

#include "dynamics/setup/build.hpp"

namespace cbr {

// Warns when a pair with friction has a face of basis characteristic whose nodes have fewer shapes than directions: then it slides
// and sticks in large pieces, and friction takes several times what it should (docs/decisions/characteristic.md).
void warn_of_few_shapes(const ContactPair& pair, const BuiltScene& built, Report& report);

}  // namespace cbr
