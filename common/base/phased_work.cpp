// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/phased_work.hpp"

#include <atomic>
#include <thread>

#include "common/base/row_threads.hpp"

namespace cbr {
namespace {

// Until `happened`: pieces take some microseconds, a sleeping thread wakes in fifty. Who waits for
// longer, as the system has stopped the thread that works, leaves the processor to others.
template <typename Condition>
void await(const Condition& happened) {
  constexpr int patience = 2000;
  while (true) {
    for (int i = 0; i < patience; ++i) {
      if (happened()) return;
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
    std::this_thread::yield();
  }
}

}  // namespace

void PhasedWork::run(int n_threads) const {
  std::atomic<std::size_t> next{0}, done{0};
  run_kept_threads(n_threads, [&](int thread) {
    for (std::size_t i = next++; i < pieces_.size(); i = next++) {
      const Piece& piece = pieces_[i];
      // None of this phase or a later one is done before all earlier ones are
      await([&] { return done.load(std::memory_order_acquire) >= piece.after; });
      piece.work(thread);
      done.fetch_add(1, std::memory_order_release);
    }
  });
}

}  // namespace cbr
