// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/linalg/kernels: products that are compiled for several processors.
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
#else
#define CBR_CLONES
#endif
