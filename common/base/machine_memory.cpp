// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/machine_memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace cbr {

double machine_memory_bytes() {
  const double physical = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                          static_cast<double>(::sysconf(_SC_PAGE_SIZE));
  double limit = 0;  // of a container (control groups, version 2); "max" is no number
  std::ifstream("/sys/fs/cgroup/memory.max") >> limit;
  return limit > 0 ? std::min(limit, physical) : physical;
}

}  // namespace cbr
