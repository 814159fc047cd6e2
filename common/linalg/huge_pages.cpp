// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/huge_pages.hpp"

#include <sys/mman.h>

#include <cstdint>

namespace cbr {

void prefer_huge_pages(const Matrix& A) {
  constexpr std::uintptr_t page = 2 << 20;
  const auto first = reinterpret_cast<std::uintptr_t>(A.data()),
             last = first + sizeof(double) * static_cast<std::uintptr_t>(A.size());
  // Whole pages inside the matrix
  const std::uintptr_t begin = (first + page - 1) / page * page, end = last / page * page;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

Matrix on_huge_pages(Index rows, Index columns) {
  Matrix A(rows, columns);
  prefer_huge_pages(A);
  return A;
}

Matrix zeros_on_huge_pages(Index rows, Index columns) {
  Matrix A = on_huge_pages(rows, columns);
  A.setZero();
  return A;
}

}  // namespace cbr
