// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace cbr {

// The value of OPENBLAS_CORETYPE for a processor with these instructions where OpenBLAS found
// `core`. Empty: core is right. OpenBLAS falls back to "Prescott" (SSE3) on every x86 processor
// that is newer than itself.
std::string_view better_kernels(std::string_view core, bool has_avx2, bool has_avx512);

// Restarts the program with OPENBLAS_CORETYPE set where better_kernels() has a name. First in
// main(), as OpenBLAS chooses once, before it. The user's own setting stays. Returns when there is
// nothing to do, or it fails.
void restart_with_better_kernels(char** argv);

}  // namespace cbr
