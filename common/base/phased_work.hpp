// SPDX-License-Identifier: GPL-3.0-or-later
// Short pieces of work in phases, planned once and done again and again by a few threads.
#pragma once

#include <functional>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Pieces of a phase begin when all of the phases before are done, in any order. Who is free takes
// the next piece, so that a thread that the system stops holds up one piece only.
class PhasedWork {
 public:
  void next_phase() { first_of_phase_ = pieces_.size(); }
  // work(thread), thread < n_threads of run(); it must not throw.
  void add(std::function<void(int)> work) { pieces_.push_back({first_of_phase_, std::move(work)}); }
  // On so many of the threads that are kept (row_threads.hpp).
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
