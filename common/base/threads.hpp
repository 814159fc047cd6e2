// SPDX-License-Identifier: GPL-3.0-or-later
// A few threads that share work: once, again and again, or in phases.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Threads that are kept alive between steps, for the rows of a product.
class RowThreads {
 public:
  // n_threads <= 1: everything runs on the caller's thread.
  explicit RowThreads(int n_threads);
  ~RowThreads();
  RowThreads(RowThreads&&) noexcept;
  RowThreads& operator=(RowThreads&&) noexcept;

  int size() const;
  // work(t) for t = 0 .. size() - 1, each on a thread of its own, the first on the caller's;
  // returns when all are done. An exception of any of them is thrown again then (that of the
  // smallest t). A thread that has done its part looks out for the next for some 50 microseconds
  // before it sleeps: steps follow each other closely.
  void run(const std::function<void(int)>& work);
  // work(begin, end) over equal parts of 0 .. n.
  void for_rows(Index n, const std::function<void(Index, Index)>& work);
  // Begin of part t of n rows in size() equal parts; t = size(): n.
  Index part(Index n, int t) const { return n * t / size(); }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// work(t) for t = 0 .. n - 1, each in a thread of its own, by RowThreads::run(). A thread that the
// system does not grant is done without: its share is worked off by the caller.
void run_threads(int n, const std::function<void(int)>& work);

// run_threads() for work that comes again and again, of some tenths of a millisecond: by threads
// that all callers share and that are kept. Who finds them taken works alone, as does a call with n
// <= 1.
void run_kept_threads(int n, const std::function<void(int)>& work);

// work(i) for i = 0 .. n_items - 1, each once, by the same threads: who is free takes the next few.
// Alone where there are too few items to wake anybody for.
void share_among_threads(Index n_items, int n_threads, const std::function<void(Index)>& work);

// Short pieces of work in phases, planned once and done again and again by a few threads. Pieces of
// a phase begin when all of the phases before are done, in any order. Who is free takes the next
// piece, so that a thread that the system stops holds up one piece only.
class PhasedWork {
 public:
  void next_phase() { first_of_phase_ = pieces_.size(); }
  // work(thread), thread < n_threads of run(); it must not throw.
  void add(std::function<void(int)> work) { pieces_.push_back({first_of_phase_, std::move(work)}); }
  // By run_kept_threads().
  void run(int n_threads) const;

 private:
  struct Piece {
    std::size_t after;  // so many must be done before
    std::function<void(int)> work;
  };

  std::vector<Piece> pieces_;
  std::size_t first_of_phase_ = 0;
};

}  // namespace cbr
