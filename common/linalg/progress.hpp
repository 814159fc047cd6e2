// SPDX-License-Identifier: GPL-3.0-or-later
// How long work tells how far it is.
#pragma once

#include <functional>

namespace cbr {

// Called with the share of the work that is done, 0 to 1, by the thread that asked for the work.
// May be empty.
using Progress = std::function<void(double)>;

}  // namespace cbr
