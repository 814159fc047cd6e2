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
  constexpr int patience = 200;
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
    for (std::size_t i = next.load(); i < pieces_.size();) {
      const Piece& piece = pieces_[i];
      // Before the piece is taken, so that nobody waits for a thread that waits and is stopped.
      // None of this phase or a later one is done before all earlier ones are.
      await(
          [&] { return done.load(std::memory_order_acquire) >= piece.after || next.load() != i; });
      if (!next.compare_exchange_strong(i, i + 1)) continue;
      piece.work(thread);
      done.fetch_add(1, std::memory_order_release);
      i = next.load();
    }
  });
}

}  // namespace cbr
