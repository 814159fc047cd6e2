// SPDX-License-Identifier: GPL-3.0-or-later
// A few threads that share the rows of a product, kept alive between steps.
#pragma once

#include <functional>
#include <memory>

#include "common/base/types.hpp"

namespace cbr {

class RowThreads {
 public:
  // n_threads <= 1: everything runs on the caller's thread.
  explicit RowThreads(int n_threads);
  ~RowThreads();
  RowThreads(RowThreads&&) noexcept;
  RowThreads& operator=(RowThreads&&) noexcept;

  int size() const;
  // work(t) for t = 0 .. size() - 1, each on a thread of its own; returns when all are done. An
  // exception of any of them is thrown again then. A thread that has done its part looks out for
  // the next for some 50 microseconds before it sleeps: steps follow each other closely.
  void run(const std::function<void(int)>& work);
  // work(begin, end) over equal parts of 0 .. n.
  void for_rows(Index n, const std::function<void(Index, Index)>& work);
  // Begin of part t of n rows in size() equal parts; t = size(): n.
  Index part(Index n, int t) const { return n * t / size(); }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// run_threads() for work that comes again and again, of some tenths of a millisecond: by threads
// that all callers share and that are kept. Who finds them taken works alone, as does a call with n
// <= 1.
void run_kept_threads(int n, const std::function<void(int)>& work);

// work(i) for i = 0 .. n_items - 1, each once, by the same threads: who is free takes the next few.
// Alone where there are too few items to wake anybody for.
void share_among_threads(Index n_items, int n_threads, const std::function<void(Index)>& work);

}  // namespace cbr
