// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace cbr {

// physical memory, whoever uses it, or what the container may have of it
double machine_memory_bytes();

}  // namespace cbr
