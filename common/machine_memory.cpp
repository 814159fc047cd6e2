// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/machine_memory.hpp"

#include <unistd.h>

namespace cbr {

double machine_memory_bytes() {
  return static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
}

}  // namespace cbr
