// SPDX-License-Identifier: GPL-3.0-or-later
// Rates of this machine, beside which the benchmarks set theirs. CSV to stdout: name, threads,
// value, unit. Argument: matrix size (default 2000; small for a smoke run, where vectors are small
// too).
//
// dgemm, dsyrk: OpenBLAS on n x n. triad: a = b + s c as in STREAM (McCalpin 1995), 24 bytes an
// entry (what a write reads first is not counted), on vectors far beyond the second cache and on
// vectors that stay in it; each thread has its own. gemv: a matrix that stays in the second cache
// times a vector, and one far beyond it. Best of some repetitions.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "common/base/threads.hpp"
#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"

namespace {

using cbr::Index;
using cbr::Matrix;
using cbr::Vector;

// Of `work`, repeated until `least` seconds have gone by, the best.
template <typename Work>
double best_seconds(const Work& work, double least) {
  double best = HUGE_VAL, sum = 0;
  for (int i = 0; i < 3 || sum < least; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = std::min(best, seconds);
    sum += seconds;
  }
  return best;
}

void say(const char* name, int threads, double value, const char* unit) {
  std::printf("%s,%d,%.5g,%s\n", name, threads, value, unit);
  std::fflush(stdout);
}

void products(Index n, int threads, double least) {
  cbr::set_threads(threads);
  const Matrix A = Matrix::Constant(n, n, 0.5), B = Matrix::Constant(n, n, 0.25);
  Matrix C = Matrix::Zero(n, n);
  const double n3 = std::pow(static_cast<double>(n), 3);
  say("dgemm", threads, 2 * n3 / best_seconds([&] { C.noalias() = A * B; }, least), "flop/s");
  // C = A A^T, lower triangle: half the flops
  say("dsyrk", threads,
      n3 / best_seconds([&] { C.selfadjointView<Eigen::Lower>().rankUpdate(A); }, least), "flop/s");
}

struct Vectors {
  std::vector<double> a, b, c;
};

void triad(const char* name, Index n, int threads, double least) {
  std::vector<Vectors> of(static_cast<std::size_t>(threads));
  const auto size = static_cast<std::size_t>(n);
  cbr::run_threads(threads, [&](int t) {
    of[t] = {std::vector<double>(size), std::vector<double>(size, 1), std::vector<double>(size, 2)};
  });
  const int repeats = std::max(1, static_cast<int>(2000000 / n));
  const auto sweep = [&](int t) {
    double *a = of[t].a.data(), *b = of[t].b.data(), *c = of[t].c.data();
    for (int r = 0; r < repeats; ++r) {
      for (std::size_t i = 0; i < size; ++i) a[i] = b[i] + 0.5 * c[i];
      std::swap(a, c);  // so that no sweep can be left out
    }
  };
  const double seconds = best_seconds([&] { cbr::run_threads(threads, sweep); }, least);
  say(name, threads, 24.0 * static_cast<double>(n) * repeats * threads / seconds, "byte/s");
}

void matrix_times_vector(const char* name, Index n, int threads, double least) {
  cbr::set_threads(threads);
  const Matrix A = Matrix::Constant(n, n, 0.5);
  const Vector x = Vector::Ones(n);
  Vector y(n);
  const int repeats = std::max(1, static_cast<int>(4000000 / (n * n)));
  const double seconds = best_seconds(
      [&] {
        for (int r = 0; r < repeats; ++r) y.noalias() = A * x;
      },
      least);
  say(name, threads, 8.0 * static_cast<double>(n * n) * repeats / seconds, "byte/s");
}

}  // namespace

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  const Index n = argc > 1 ? std::atoi(argv[1]) : 2000;
  if (n < 10) return 2;
  const bool smoke = n < 1000;
  const double least = smoke ? 0.01 : 0.3;
  const int all = cbr::n_threads();
  std::printf("name,threads,value,unit\n");
  for (const int threads : {1, all}) {
    products(n, threads, least);
    triad("triad_large", smoke ? 1 << 18 : 1 << 23, threads, least);
    triad("triad_l2", 1 << 15, threads, least);
    matrix_times_vector("gemv_large", smoke ? 512 : 4096, threads, least);
    matrix_times_vector("gemv_l2", 384, threads, least);
    if (all == 1) break;
  }
  return 0;
}
