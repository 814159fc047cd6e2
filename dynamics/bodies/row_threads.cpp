// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/row_threads.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace cbr {
namespace {

// Whether `happened` within a short while: waking a sleeping thread takes as long as a step of a small mesh.
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

}  // namespace

struct RowThreads::Impl {
  std::mutex mutex;
  std::condition_variable start, done;
  std::vector<std::thread> threads;
  const std::function<void(int)>* work = nullptr;
  std::atomic<std::uint64_t> round = 0;
  std::atomic<int> running = 0;
  std::atomic<bool> quit = false;

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
      (*work)(t);
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
  for (int t = 1; t < n_threads; ++t) impl_->threads.emplace_back([impl = impl_.get(), t] { impl->loop(t); });
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
  work(0);
  const auto is_done = [&] { return impl_->running.load() == 0; };
  if (soon(is_done)) return;
  std::unique_lock lock(impl_->mutex);
  impl_->done.wait(lock, is_done);
}

void RowThreads::for_rows(Index n, const std::function<void(Index, Index)>& work) {
  run([&](int t) { work(part(n, t), part(n, t + 1)); });
}

}  // namespace cbr
