// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "common/base/types.hpp"

namespace cbr {

// Bounds the threads of BLAS (and of ours) to `threads`, 0: all processors.
void set_threads(int threads);
int n_threads();

// BLAS has one thread, but in the life of a LargeBlasWork.
//
// OpenBLAS's threads wait by sched_yield, which beside other programs yields a whole time slice at
// each call. They busy-wait for a tenth of a second afterwards. The reduction of an ordinary part
// beside four compilers took 11.4 s with BLAS's threads in every product, 3.0 s on two idle
// processors. The setup of its run took 1.4 s beside two compilers, and 0.05 s without them.
class LargeBlasWork {
 public:
  // Of all calls in the object's life: work of a tenth of a second has all threads.
  explicit LargeBlasWork(double flops) : LargeBlasWork(flops >= 5e9) {}
  // `size`: numbers that one product reads. 8 MB are a millisecond of one core's reading, against
  // some 50 us to wake a thread.
  static LargeBlasWork reading(Index size) { return LargeBlasWork(size >= 1'000'000); }
  ~LargeBlasWork();
  LargeBlasWork(const LargeBlasWork&) = delete;
  LargeBlasWork& operator=(const LargeBlasWork&) = delete;

 private:
  explicit LargeBlasWork(bool is_large);
  bool raised_ = false;
};

// Keeps BLAS at one thread while several threads of this program call it, in a LargeBlasWork too.
// Objects may overlap, in one thread or in many.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

// Ends BLAS's threads, which busy-wait for a tenth of a second after a product and delay ours. BLAS
// restarts them at its next threaded product or change of their number. No effect unless BLAS is
// OpenBLAS.
void rest_blas_threads();

// Reserves the buffers of n_threads() callers of BLAS and one more where the address space is
// limited (ulimit -v). OpenBLAS and its own threads, which start with the program, retry a failed
// allocation for ever. Returns an empty text, or why memory is short: then the process can end by
// std::_Exit() alone.
std::string reserve_blas_memory();

// The value of OPENBLAS_CORETYPE for a processor with these instructions where OpenBLAS found
// `core`. Empty: core is right. OpenBLAS falls back to "Prescott" (SSE3) on every x86 processor
// that is newer than itself.
std::string_view better_kernels(std::string_view core, bool has_avx2, bool has_avx512);

// Restarts the program with OPENBLAS_CORETYPE set where better_kernels() has a name. First in
// main(), as OpenBLAS chooses once, before it. The user's own setting stays. Returns when there is
// nothing to do, or it fails.
void restart_with_better_kernels(char** argv);

}  // namespace cbr
