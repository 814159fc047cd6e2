// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/row_threads.hpp"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace cbr {

struct RowThreads::Impl {
  std::mutex mutex;
  std::condition_variable start, done;
  std::vector<std::thread> threads;
  const std::function<void(Index, Index)>* work = nullptr;
  Index n = 0;
  std::uint64_t round = 0;
  int running = 0;
  bool quit = false;

  Index part(std::size_t t) const { return n * static_cast<Index>(t) / static_cast<Index>(threads.size() + 1); }

  void loop(std::size_t t) {
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex);
    for (;;) {
      start.wait(lock, [&] { return quit || round != seen; });
      if (quit) return;
      seen = round;
      lock.unlock();
      (*work)(part(t), part(t + 1));
      lock.lock();
      if (--running == 0) done.notify_one();
    }
  }
};

RowThreads::RowThreads(int n_threads) {
  if (n_threads <= 1) return;
  impl_ = std::make_unique<Impl>();
  impl_->threads.resize(static_cast<std::size_t>(n_threads) - 1);
  // All slots exist before the first thread reads their number.
  for (std::size_t t = 0; t < impl_->threads.size(); ++t)
    impl_->threads[t] = std::thread([impl = impl_.get(), t] { impl->loop(t + 1); });
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

void RowThreads::for_rows(Index n, const std::function<void(Index, Index)>& work) {
  if (!impl_) return work(0, n);
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->work = &work;
    impl_->n = n;
    impl_->running = static_cast<int>(impl_->threads.size());
    ++impl_->round;
  }
  impl_->start.notify_all();
  work(impl_->part(0), impl_->part(1));
  std::unique_lock lock(impl_->mutex);
  impl_->done.wait(lock, [&] { return impl_->running == 0; });
}

}  // namespace cbr
