// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/linalg/kernels: products that are compiled for several processors.
//
// A kernel that keeps its operands in registers has a form for AVX-512's 32 registers of eight
// numbers (CBR_AVX512, if has_avx512()) and another for 16 of four, which CBR_CLONES compiles.
// Both call templates that are CBR_INLINE. g++ keeps arrays of vectors in registers only where
// CBR_UNROLL unrolls all loops over them.
//
// CBR_CLONES before a function: it is compiled for several instruction sets, of which the running
// machine's is taken. Only for functions of an unnamed namespace that are not declared before:
// clang 14 compiles one that is declared in a header for AVX-512 alone, and other processors stop
// at it.
#pragma once

#ifdef __has_feature
#define CBR_CLANG_SANITIZES __has_feature(address_sanitizer)
#else
#define CBR_CLANG_SANITIZES 0
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && \
    !CBR_CLANG_SANITIZES
#define CBR_CLONES __attribute__((target_clones("avx512f", "fma", "default")))
#define CBR_AVX512 __attribute__((target("avx512f")))
#else
#define CBR_CLONES
#endif

#define CBR_INLINE inline __attribute__((always_inline))
#define CBR_UNROLL _Pragma("GCC unroll 8")

#ifdef CBR_AVX512
namespace cbr {
inline bool has_avx512() {
  static const bool has = __builtin_cpu_supports("avx512f");
  return has;
}
}  // namespace cbr
#endif
