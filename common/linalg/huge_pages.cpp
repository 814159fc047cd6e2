// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/huge_pages.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>

namespace cbr {
namespace {

// Sanitizers have an allocator of their own, which would write notes of all that is reserved.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool is_sanitized = true;
#elif defined(__has_feature)
constexpr bool is_sanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||
                              __has_feature(memory_sanitizer);
#else
constexpr bool is_sanitized = false;
#endif

// Whole pages inside the range.
void advise(const void* start, std::size_t bytes) {
  constexpr std::uintptr_t page = 2 << 20;
  const auto first = reinterpret_cast<std::uintptr_t>(start);
  const std::uintptr_t begin = (first + page - 1) / page * page;
  const std::uintptr_t end = (first + bytes) / page * page;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

}  // namespace

void keep_heap_on_huge_pages(double ahead) {
  constexpr int most_mappings = 65536, never = -1;  // the first is the C library's own default
  mallopt(M_MMAP_THRESHOLD, 1 << 28);
  mallopt(M_TRIM_THRESHOLD, never);
  if (is_sanitized) return;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    ahead = std::min(ahead, 0.1 * static_cast<double>(limit.rlim_cur));
  const auto bytes = static_cast<std::size_t>(ahead);
  mallopt(M_MMAP_MAX, 0);
  void* const grown = std::malloc(bytes);
  mallopt(M_MMAP_MAX, most_mappings);
  if (grown == nullptr) return;
  advise(grown, bytes);
  std::free(grown);
}

void one_heap_for_all_threads() { mallopt(M_ARENA_MAX, 1); }

void return_unused_heap(double at_least) {
  // Heap that is reserved and never written is not resident
  double size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  const struct mallinfo2 used = mallinfo2();
  const double unused = resident * static_cast<double>(::sysconf(_SC_PAGE_SIZE)) -
                        static_cast<double>(used.uordblks + used.hblkhd);
  if (unused >= at_least) malloc_trim(0);
}

Matrix on_huge_pages(Index rows, Index columns) {
  Matrix A(rows, columns);
  advise(A.data(), sizeof(double) * static_cast<std::size_t>(A.size()));
  return A;
}

Matrix zeros_on_huge_pages(Index rows, Index columns) {
  Matrix A = on_huge_pages(rows, columns);
  A.setZero();
  return A;
}

}  // namespace cbr
