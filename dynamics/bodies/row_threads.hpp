// SPDX-License-Identifier: GPL-3.0-or-later
// A few threads that share the rows of a product, kept alive between steps.
#pragma once

#include <functional>
#include <memory>

#include "common/types.hpp"

namespace cbr {

class RowThreads {
 public:
  // n_threads <= 1: everything runs on the caller's thread.
  explicit RowThreads(int n_threads);
  ~RowThreads();
  RowThreads(RowThreads&&) noexcept;
  RowThreads& operator=(RowThreads&&) noexcept;

  // work(begin, end) over equal parts of 0 .. n; returns when all are done. Work must not throw.
  void for_rows(Index n, const std::function<void(Index, Index)>& work);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
