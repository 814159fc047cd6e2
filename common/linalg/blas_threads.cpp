// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/blas_threads.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/format_text.hpp"

// Of OpenBLAS; not in cblas.h of every version.
extern "C" {
void openblas_set_num_threads(int n);
int openblas_get_num_threads(void);
// OpenBLAS calls it before a fork: threads restart when they are next needed.
[[gnu::weak]] int blas_thread_shutdown_(void);
// A buffer of one caller, which stays its process's until the end
[[gnu::weak]] void* blas_memory_alloc(int);
[[gnu::weak]] void blas_memory_free(void*);
}
// Of OpenBLAS; not in cblas.h of every version.
extern "C" char* openblas_get_corename(void);

namespace cbr {
namespace {

std::mutex lock;
int n_alive = 0, n_raised = 0;  // objects of SingleThreadedBlas, and of LargeBlasWork with threads

// More than any machine of today gains from, fewer than a system refuses to start.
constexpr int most_threads = 256;

// OpenBLAS's choice at the start: the processors of this process, or OPENBLAS_NUM_THREADS.
int initial_threads() {
  static const int n = openblas_get_num_threads();
  return n;
}

std::atomic<int>& bound() {
  static std::atomic<int> n{initial_threads()};
  return n;
}

[[maybe_unused]] const bool begins_with_one = [] {
  initial_threads();
  openblas_set_num_threads(1);
  return true;
}();

}  // namespace

void set_threads(int threads) {
  bound() = std::min(threads > 0 ? threads : initial_threads(), most_threads);
}

int n_threads() { return bound(); }

void rest_blas_threads() {
  const std::scoped_lock guard(lock);
  if (blas_thread_shutdown_ != nullptr) blas_thread_shutdown_();
}

std::string reserve_blas_memory() {
  const int threads = n_threads(), started = initial_threads();
  constexpr double buffer = 144e6;  // the largest of its kernels takes 134 MB
  rlimit limit{};
  if (blas_memory_alloc == nullptr || blas_memory_free == nullptr) return "";
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
  // ours and BLAS's own
  const auto bytes = static_cast<std::size_t>(buffer * (threads + std::max(threads, started)));
  void* const room =
      mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED)
    return format_text(
        "the address space is limited to %.0f MB (ulimit -v), which leaves no %.0f MB for the "
        "threads of BLAS: raise the limit%s",
        1e-6 * static_cast<double>(limit.rlim_cur), 1e-6 * static_cast<double>(bytes),
        std::max(threads, started) > 1 ? ", or take one thread (OPENBLAS_NUM_THREADS=1)" : "");
  munmap(room, bytes);
  std::vector<void*> buffers(threads + 1);
  for (void*& b : buffers) b = blas_memory_alloc(0);
  for (void* b : buffers) blas_memory_free(b);
  return "";
}

SingleThreadedBlas::SingleThreadedBlas() {
  const std::scoped_lock guard(lock);
  if (n_alive++ == 0 && n_raised > 0) openblas_set_num_threads(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  const std::scoped_lock guard(lock);
  if (--n_alive == 0 && n_raised > 0) openblas_set_num_threads(n_threads());
}

LargeBlasWork::LargeBlasWork(bool is_large) {
  if (!is_large) return;
  const std::scoped_lock guard(lock);
  if (n_alive > 0) return;
  raised_ = true;
  if (n_raised++ == 0) openblas_set_num_threads(n_threads());
}

LargeBlasWork::~LargeBlasWork() {
  if (!raised_) return;
  const std::scoped_lock guard(lock);
  if (--n_raised == 0) openblas_set_num_threads(1);
}

std::string_view better_kernels(std::string_view core, bool has_avx2, bool has_avx512) {
  if (core != "Prescott" || !has_avx2) return "";
  return has_avx512 ? "SkylakeX" : "Haswell";
}

void restart_with_better_kernels([[maybe_unused]] char** argv) {
#ifdef __x86_64__
  constexpr const char* variable = "OPENBLAS_CORETYPE";
  if (std::getenv(variable) != nullptr) return;
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  const std::string better(better_kernels(openblas_get_corename(), avx2, avx2 && avx512));
  if (better.empty() || ::setenv(variable, better.c_str(), 1) != 0) return;
  ::execv("/proc/self/exe", argv);
#endif
}

}  // namespace cbr
