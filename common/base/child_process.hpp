// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace cbr {

// Runs `action` in a forked child; returns whether it ended after at most so many
// seconds of a processor's time: for libraries that crash on damaged files, or go round in them for
// ever. Side effects are lost. True without a trial where the system makes no copy. RunError
// names `what` if somebody else ended the copy.
bool survives_in_child(const std::string& what, const std::function<void()>& action,
                       unsigned seconds);

// More than a library takes for all of a sound file of this size, however it is compressed.
unsigned seconds_to_read(std::uintmax_t bytes);

}  // namespace cbr
