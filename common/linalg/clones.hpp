// SPDX-License-Identifier: GPL-3.0-or-later
// CBR_CLONES before a function: it is compiled for several instruction sets, of which the running machine's is taken.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define CBR_CLONES __attribute__((target_clones("avx512f", "arch=haswell", "default")))
#else
#define CBR_CLONES
#endif
