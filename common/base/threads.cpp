// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/threads.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace cbr {
namespace {

// Whether `happened` within a short while: waking a sleeping thread takes as long as a step of a
// small mesh.
template <typename Condition>
bool soon(const Condition& happened) {
  constexpr auto patience = std::chrono::microseconds(50);
  const auto start = std::chrono::steady_clock::now();
  do {
    for (int i = 0; i < 32; ++i) {
      if (happened()) return true;
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  } while (std::chrono::steady_clock::now() - start < patience);
  return false;
}

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

struct RowThreads::Impl {
  std::mutex mutex;
  std::condition_variable start, done;
  std::vector<std::thread> threads;
  const std::function<void(int)>* work = nullptr;
  std::exception_ptr failure;  // of the smallest t in a round
  int failed = 0;              // this t
  std::atomic<std::uint64_t> round = 0;
  std::atomic<int> running = 0;
  std::atomic<bool> quit = false;

  void guarded(int t) {
    try {
      (*work)(t);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (failure && failed < t) return;
      failure = std::current_exception();
      failed = t;
    }
  }

  void loop(int t) {
    std::uint64_t seen = 0;
    for (;;) {
      const auto is_called = [&] { return quit.load() || round.load() != seen; };
      if (!soon(is_called)) {
        std::unique_lock lock(mutex);
        start.wait(lock, is_called);
      }
      if (quit) return;
      seen = round;
      guarded(t);
      if (running.fetch_sub(1) == 1) {
        // Taken, so that the caller cannot fall asleep between its look at `running` and this.
        const std::lock_guard lock(mutex);
        done.notify_one();
      }
    }
  }
};

RowThreads::RowThreads(int n_threads) {
  if (n_threads <= 1) return;
  impl_ = std::make_unique<Impl>();
  impl_->threads.reserve(static_cast<std::size_t>(n_threads) - 1);
  try {
    for (int t = 1; t < n_threads; ++t)
      impl_->threads.emplace_back([impl = impl_.get(), t] { impl->loop(t); });
  } catch (const std::system_error&) {  // the system grants no more: see size()
  }
}

RowThreads::~RowThreads() {
  if (!impl_) return;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->quit = true;
  }
  impl_->start.notify_all();
  for (auto& thread : impl_->threads) thread.join();
}

RowThreads::RowThreads(RowThreads&&) noexcept = default;
RowThreads& RowThreads::operator=(RowThreads&&) noexcept = default;

int RowThreads::size() const { return impl_ ? static_cast<int>(impl_->threads.size()) + 1 : 1; }

void RowThreads::run(const std::function<void(int)>& work) {
  if (!impl_) return work(0);
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->work = &work;
    impl_->running = static_cast<int>(impl_->threads.size());
    ++impl_->round;
  }
  impl_->start.notify_all();
  impl_->guarded(0);
  const auto is_done = [&] { return impl_->running.load() == 0; };
  if (!soon(is_done)) {
    std::unique_lock lock(impl_->mutex);
    impl_->done.wait(lock, is_done);
  }
  if (impl_->failure) std::rethrow_exception(std::exchange(impl_->failure, nullptr));
}

void RowThreads::for_rows(Index n, const std::function<void(Index, Index)>& work) {
  run([&](int t) { work(part(n, t), part(n, t + 1)); });
}

namespace {

// The shares of threads that the system did not grant come last.
void run_all(RowThreads& threads, int n, const std::function<void(int)>& work) {
  std::exception_ptr failure;
  const auto guarded = [&](const auto& share) {
    try {
      share();
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  };
  guarded([&] { threads.run(work); });
  for (int t = threads.size(); t < n; ++t) guarded([&] { work(t); });
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

void run_threads(int n, const std::function<void(int)>& work) {
  if (n <= 0) return;
  RowThreads threads(n);
  run_all(threads, n, work);
}

void run_kept_threads(int n, const std::function<void(int)>& work) {
  static std::mutex taken;
  static std::unique_ptr<RowThreads> kept;
  static int wanted = 0;
  const std::unique_lock lock(taken, std::try_to_lock);
  if (n <= 1 || !lock) {
    for (int t = 0; t < n; ++t) work(t);
    return;
  }
  if (wanted != n) {
    kept = std::make_unique<RowThreads>(n);
    wanted = n;
  }
  run_all(*kept, n, work);
}

void share_among_threads(Index n_items, int n_threads, const std::function<void(Index)>& work) {
  constexpr Index few = 32, at_once = 8;
  std::atomic<Index> next = 0;
  run_kept_threads(n_items < few ? 1 : n_threads, [&](int) {
    for (Index first = next.fetch_add(at_once); first < n_items; first = next.fetch_add(at_once))
      for (Index i = first; i < std::min(first + at_once, n_items); ++i) work(i);
  });
}

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
