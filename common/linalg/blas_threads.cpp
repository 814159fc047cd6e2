// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/blas_threads.hpp"

#include <mutex>

// Of OpenBLAS; not in cblas.h of every version.
extern "C" {
void openblas_set_num_threads(int n);
int openblas_get_num_threads(void);
// What OpenBLAS calls before a fork: threads are started anew when they are next needed.
[[gnu::weak]] int blas_thread_shutdown_(void);
}

namespace cbr {
namespace {

std::mutex lock;
int n_alive = 0, threads_before = 1;

}  // namespace

void rest_blas_threads() {
  const std::scoped_lock guard(lock);
  if (blas_thread_shutdown_ != nullptr) blas_thread_shutdown_();
}

SingleThreadedBlas::SingleThreadedBlas() {
  const std::scoped_lock guard(lock);
  if (n_alive++ > 0) return;
  threads_before = openblas_get_num_threads();
  openblas_set_num_threads(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  const std::scoped_lock guard(lock);
  if (--n_alive == 0) openblas_set_num_threads(threads_before);
}

}  // namespace cbr
