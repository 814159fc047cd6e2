// SPDX-License-Identifier: GPL-3.0-or-later
// The integers of BLAS and LAPACK.
#pragma once

#include "common/base/types.hpp"

namespace cbr {

inline int as_int(Index n) { return static_cast<int>(n); }

}  // namespace cbr
