// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace cbr {

// Does `action` in a copy of this process, and tells whether it came back within a minute: for libraries that crash on damaged
// files. What it changes is lost. True without a trial where the system makes no copy.
bool survives_in_child(const std::function<void()>& action);

}  // namespace cbr
