// SPDX-License-Identifier: GPL-3.0-or-later
// P A Q = L U of a sparse matrix that need not be symmetric.
#pragma once

#include <memory>

#include "common/base/types.hpp"

namespace cbr {

class SparseLu {
 public:
  explicit SparseLu(const SparseMatrix& A);  // n x n
  ~SparseLu();
  SparseLu(SparseLu&&) noexcept;
  SparseLu& operator=(SparseLu&&) noexcept;

  bool ok() const;                      // false: a pivot is zero
  Vector solve(const Vector& b) const;  // A^-1 b, when ok()

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
