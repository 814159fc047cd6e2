// SPDX-License-Identifier: GPL-3.0-or-later
// Fixed-interface modes by the sparse solver (ARPACK, block Lanczos, slices of the spectrum), by
// block Lanczos from one shift, by slices, and by dense LAPACK: seconds of each over the number of
// dofs and the share of modes asked for. docs/decisions/eigen-crossover.md holds tables of it.
// Arguments: largest number of dofs (default 4000). CSV to stdout.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/eigen/spectrum_slices.hpp"
#include "reducer/partition/partition.hpp"
#include "tests/benchmarks/seconds.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace {

using cbr::Index;

void row(Index elements, double share) {
  const cbr::Mesh mesh = cbr::test::box_mesh(
      {{2 * elements, elements, elements + elements / 2}, {2, 1, 1.5}, {0, 0, 0}, 0});
  const auto model = cbr::assemble(mesh, cbr::test::properties(mesh, cbr::test::paper_steel()),
                                   cbr::MassKind::lumped);
  const cbr::Partition p = cbr::partition(model, cbr::interface_nodes(mesh, model, {"x_max"}));
  const Index n = p.n_interior(),
              k = std::max<Index>(1, static_cast<Index>(share * static_cast<double>(n)));
  const cbr::SparseCholesky factor(p.K_II);
  cbr::Eigenpairs dense, sparse;
  const double t_dense = seconds([&] {
    dense = cbr::dense_eigenpairs(cbr::Matrix(p.K_II), cbr::Vector(p.M_II.diagonal()), k);
  });
  const double t_sparse =
      seconds([&] { sparse = cbr::sparse_eigenpairs(p.K_II, p.M_II, factor, 0, k); });
  double t_one = 0, t_slices = 0;
  if (k >= 10 && 2 * k <= n) {
    const auto solve = [&](Eigen::Ref<cbr::Matrix> B) { factor.solve_in_place(B); };
    t_one = seconds(
        [&] { cbr::block_lanczos(p.n_interior(), cbr::product_with(p.M_II), solve, 0, k); });
    const Index width = cbr::slice_width(n, factor.flops());
    t_slices =
        seconds([&] { cbr::eigenpairs_by_slices(p.K_II, p.M_II, factor, k, width, 1e-13, {}); });
  }
  const double difference =
      ((sparse.lambda - dense.lambda).array() / dense.lambda.array()).abs().maxCoeff();
  std::printf("%lld,%lld,%.4g,%.3g,%.3f,%.3f,%.3f,%.3f,%lld,%.1e\n", static_cast<long long>(n),
              static_cast<long long>(k), share, factor.n_nonzeros(), t_dense, t_sparse, t_one,
              t_slices, static_cast<long long>(sparse.iterations), difference);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  const double largest = argc > 1 ? std::atof(argv[1]) : 4000;
  std::printf(
      "n,k,share,factor_nonzeros,dense_seconds,sparse_seconds,one_shift_seconds,slices_seconds,"
      "restarts,difference\n");
  for (const Index elements : {2, 6, 8, 10, 12}) {
    const double n = 9.0 * std::pow(static_cast<double>(elements), 3) +
                     30.0 * static_cast<double>(elements * elements);
    if (elements > 2 && n > largest) break;
    for (const double share : {0.005, 0.02, 0.05, 0.1, 0.2, 0.4}) row(elements, share);
  }
  return 0;
}
