// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/blas_kernels.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string>

// Of OpenBLAS; not in cblas.h of every version.
extern "C" char* openblas_get_corename(void);

namespace cbr {

std::string_view better_kernels(std::string_view core, bool has_avx2, bool has_avx512) {
  if (core != "Prescott" || !has_avx2) return "";
  return has_avx512 ? "SkylakeX" : "Haswell";
}

void restart_with_better_kernels([[maybe_unused]] char** argv) {
#ifdef __x86_64__
  constexpr const char* variable = "OPENBLAS_CORETYPE";
  if (std::getenv(variable) != nullptr) return;
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  const std::string better(better_kernels(openblas_get_corename(), avx2, avx2 && avx512));
  if (better.empty() || ::setenv(variable, better.c_str(), 1) != 0) return;
  ::execv("/proc/self/exe", argv);
#endif
}

}  // namespace cbr
