// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "common/base/types.hpp"

namespace cbr {

// Bounds the threads of BLAS (and of ours) to `threads`, 0: all processors.
void set_threads(int threads);
int n_threads();

// Limits BLAS to one thread while several threads of this program call it. Objects may overlap, in
// one thread or in many: the last to end restores the number that the first one found.
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

// Limits BLAS to one thread from here on, and to `threads` in the life of a BlasForWork that is
// worth them. For a program whose own threads do most of the work. 0: no limit but that of
// SingleThreadedBlas.
void spare_blas_threads(int threads);

// Raises the limit of spare_blas_threads(), if any, for work of more than a tenth of a second.
// `flops`: of all calls in the object's life.
class LargeBlasWork {
 public:
  explicit LargeBlasWork(double flops);
  ~LargeBlasWork();
  LargeBlasWork(const LargeBlasWork&) = delete;
  LargeBlasWork& operator=(const LargeBlasWork&) = delete;

 private:
  bool raised_ = false;
};

// Limits BLAS to one thread for work of less than a tenth of a second. OpenBLAS's threads wait by
// sched_yield, which beside other programs yields a whole time slice at each call. They busy-wait
// for a tenth of a second afterwards. The reduction of an ordinary part beside four compilers took
// 11.4 s with BLAS's threads in every product, 3.0 s on two idle processors.
class BlasForWork {
 public:
  explicit BlasForWork(double flops) : large_(flops) {
    if (flops < enough) one_.emplace();
  }
  static constexpr double enough = 5e9;

 private:
  LargeBlasWork large_;
  std::optional<SingleThreadedBlas> one_;
};

// BLAS with one thread for a small product: its threads wait by spinning, which takes more from the
// program than they give.
class SerialBlas {
 public:
  // `size`: numbers that the product reads. 8 MB are a millisecond of one core's reading, against
  // some 50 us to wake a thread.
  explicit SerialBlas(Index size) {
    if (size < 1'000'000) one_.emplace();
  }

 private:
  std::optional<SingleThreadedBlas> one_;
};

}  // namespace cbr
