// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace cbr {

// What OPENBLAS_CORETYPE should say where OpenBLAS found `core` and the processor has these
// instructions; empty: core is right. OpenBLAS falls back to "Prescott" (SSE3) on every x86
// processor that is newer than it is.
std::string_view better_kernels(std::string_view core, bool has_avx2, bool has_avx512);

// First in main(): starts the program again with OPENBLAS_CORETYPE set where better_kernels() has a
// name. OpenBLAS chooses before main() and never again. What the user has set stays. Returns when
// there is nothing to do, and when it cannot be done.
void restart_with_better_kernels(char** argv);

}  // namespace cbr
