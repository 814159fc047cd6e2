// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/parallel.hpp"

#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace cbr {

void run_threads(int n, const std::function<void(int)>& work) {
  if (n <= 0) return;
  std::vector<std::exception_ptr> failures(n);
  const auto guarded = [&](int t) {
    try {
      work(t);
    } catch (...) {
      failures[t] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;  // joined at the end of this block
    threads.reserve(n);
    int started = 1;
    try {
      for (; started < n; ++started) threads.emplace_back(guarded, started);
    } catch (const std::system_error&) {
    }
    guarded(0);
    for (int t = started; t < n; ++t) guarded(t);
  }
  for (const auto& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace cbr
