// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "common/base/types.hpp"

namespace cbr {

// Bounds the threads of BLAS (and of ours) to `threads`, 0: all processors.
void set_threads(int threads);
int n_threads();

// BLAS with one thread while several of ours call it. Objects may overlap, in one thread or in
// many: the last to go restores what the first one found.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

// Ends BLAS's threads, which spin for a tenth of a second after a product and take from ours; its
// next product for which it wants them starts them again, as does a change of their number. Where
// BLAS is not OpenBLAS nothing is done.
void rest_blas_threads();

// Where the address space is limited (ulimit -v): takes the buffers of n_threads() callers of BLAS
// and one more now, as OpenBLAS, when it gets none, asks again for ever; so do its own threads,
// which it starts with the program. Empty, or why there is no room for all of them: then the
// process can end by std::_Exit() alone.
std::string reserve_blas_memory();

// From here on BLAS has one thread, and `threads` only in the life of a BlasForWork that is worth
// them: for a program whose own threads do most of the work. 0: BLAS has its threads again whenever
// nobody takes them.
void spare_blas_threads(int threads);

// BLAS with the threads that are spared for large work, where there are such (spare_blas_threads())
// and `flops`, of all calls in the object's life, are more than about a tenth of a second's; else
// as it was.
class LargeBlasWork {
 public:
  explicit LargeBlasWork(double flops);
  ~LargeBlasWork();
  LargeBlasWork(const LargeBlasWork&) = delete;
  LargeBlasWork& operator=(const LargeBlasWork&) = delete;

 private:
  bool raised_ = false;
};

// BLAS with one thread for work of less than about a tenth of a second, and with all that it may
// have for more. OpenBLAS's threads wait for each other by sched_yield, which beside other programs
// gives a whole time slice away at each call, and spin for a tenth of a second after it. Beside
// four compilers the reduction of an ordinary part took 11.4 s with BLAS's threads in every
// product, 3.0 s on two idle processors.
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
