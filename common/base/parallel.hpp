// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace cbr {

// work(t) for t = 0 .. n - 1, each in a thread of its own, the first in the caller's. An exception
// of any of them is thrown again here when all have ended (that of the smallest t). A thread that
// the system does not grant is done without: its share is worked off by the caller.
void run_threads(int n, const std::function<void(int)>& work);

}  // namespace cbr
