// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/version.hpp"

namespace cbr {

const char* version() { return CBR_VERSION; }

}  // namespace cbr
