// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "common/types.hpp"

namespace cbr {

// BLAS with one thread while several of ours call it. Objects may overlap, in one thread or in many: the last to go restores what
// the first one found.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

// Ends BLAS's threads, which spin for a tenth of a second after a product and take from ours; its next product for which it wants
// them starts them again, as does a change of their number. Where BLAS is not OpenBLAS nothing is done.
void rest_blas_threads();

// Where the address space is limited (ulimit -v): takes the buffers of `threads` callers of BLAS and one more now, as OpenBLAS,
// when it gets none, asks again for ever; its own threads, of which there are `started`, do so from the first. Empty, or why there
// is no room for all of them: then the process can end by std::_Exit() alone.
std::string reserve_blas_memory(int threads, int started);

// BLAS with one thread for work of less than about a tenth of a second (`flops`: of all calls in the object's life). OpenBLAS's
// threads wait for each other by sched_yield, which beside other programs gives a whole time slice away at each call: the reduction
// of 11088 dofs, 1 s on two idle processors with one thread or two, took 10 to 100 s beside four compilers while small problems
// made 37 000 such calls, and takes 3 to 5 s without them.
class BlasForWork {
 public:
  explicit BlasForWork(double flops) {
    if (flops < 5e9) one_.emplace();
  }

 private:
  std::optional<SingleThreadedBlas> one_;
};

// BLAS with one thread for a small product: its threads wait by spinning, which takes more from the program than they give.
class SerialBlas {
 public:
  // `size`: numbers that the product reads. 8 MB are a millisecond of one core's reading, against some 50 us to wake a thread.
  explicit SerialBlas(Index size) {
    if (size < 1'000'000) one_.emplace();
  }

 private:
  std::optional<SingleThreadedBlas> one_;
};

}  // namespace cbr
