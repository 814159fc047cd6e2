// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/estimate/machine_rates.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>

#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

constexpr int n_runs = 4;
constexpr Index product_size = 1024;  // 2.1 GFlop
// 134 MB: beyond the private caches, not beyond every shared one
constexpr Index sweep_size = 4096;

double best_seconds(const std::function<void()>& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < n_runs; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return std::max(best, 1e-9);
}

}  // namespace

MachineRates machine_rates() {
  // as a reduction's large products have them
  const LargeBlasWork all_threads(BlasForWork::enough);
  MachineRates rates;
  rates.threads = n_threads();
  const auto n = static_cast<double>(product_size), m = static_cast<double>(sweep_size);
  {
    const Matrix A = Matrix::Constant(product_size, product_size, 0.5);
    Matrix B(product_size, product_size);
    rates.flops = 2 * n * n * n / best_seconds([&] { B.noalias() = A * A; });
  }
  const Matrix A = Matrix::Constant(sweep_size, sweep_size, 0.5);
  const Vector x = Vector::Ones(sweep_size);
  Vector y(sweep_size);
  rates.bandwidth = 8 * m * m / best_seconds([&] { y.noalias() = A * x; });
  return rates;
}

}  // namespace cbr
