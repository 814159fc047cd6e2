// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/huge_pages.hpp"

#include <malloc.h>
#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>

namespace cbr {
namespace {

// Whole pages inside the range.
void advise(const void* start, std::size_t bytes) {
  constexpr std::uintptr_t page = 2 << 20;
  const auto first = reinterpret_cast<std::uintptr_t>(start);
  const std::uintptr_t begin = (first + page - 1) / page * page;
  const std::uintptr_t end = (first + bytes) / page * page;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

}  // namespace

void prefer_huge_pages(const Matrix& A) {
  advise(A.data(), sizeof(double) * static_cast<std::size_t>(A.size()));
}

void keep_heap_on_huge_pages() {
  mallopt(M_MMAP_THRESHOLD, 1 << 28);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  constexpr int ahead = 256 << 20, usual = 1 << 20;
  mallopt(M_TOP_PAD, ahead);
  void* const grown = std::malloc(usual);  // more than is left: the heap grows by this and by `ahead`
  mallopt(M_TOP_PAD, usual);
  if (grown == nullptr) return;
  advise(grown, ahead);
  std::free(grown);
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
