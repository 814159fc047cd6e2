// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/supernodal.hpp"

#include <gtest/gtest.h>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "tests/unit/common/linalg/grid_matrices.hpp"

extern "C" int openblas_get_num_threads(void);

namespace cbr::test::supernodal_test {
namespace {

// X^T in the order of elimination, of B in A's order.
Matrix panel_of(const SupernodalFactor& f, const Matrix& B) {
  Matrix X_t(B.cols(), f.n);
  load_panel(f, B, X_t);
  return X_t;
}

TEST(Supernodal, PanelsGoInAndOutUnchanged) {
  const SparseCholesky factor(grid_stiffness(6, true));
  const Matrix B = random_like(factor.n_rows(), 19, 0.4);
  Matrix C(B.rows(), B.cols());
  store_panel(factor.tree().factor(), panel_of(factor.tree().factor(), B), C);
  EXPECT_EQ(B, C);
}

TEST(Supernodal, FactorTimesItsTransposeIsTheMatrix) {
  // A X = B with X known: L^-1 (P A X) = L^T (P X) is checked by going back, for panels above and
  // below the small products' slabs.
  const SparseMatrix A = grid_stiffness(10, true);
  const SparseCholesky factor(A);
  const auto& tree = factor.tree();
  for (const Index width : {Index{1}, Index{5}, Index{64}, Index{131}}) {
    const Matrix X = random_like(A.rows(), width, 0.2);
    Matrix P = panel_of(tree.factor(), A * X);
    PanelSolver solver(tree, width);
    solver.forward(P, tree.all());
    // |L^-1 P A X|_F^2 = trace(X^T A X)
    EXPECT_NEAR(P.squaredNorm(), (X.transpose() * (A * X)).trace(), 1e-12 * P.squaredNorm());
    solver.backward(P, tree.all());
    EXPECT_LT((P - panel_of(tree.factor(), X)).norm(), 1e-12 * X.norm()) << width;
  }
}

TEST(Supernodal, SparseRightHandSidesAndWantedRowsVisitLess) {
  const SparseMatrix A = grid_stiffness(10, true);
  const SparseCholesky factor(A);
  const auto& tree = factor.tree();
  const auto& f = tree.factor();
  std::vector<Index> place(f.n);
  for (Index i = 0; i < f.n; ++i) place[f.order[i]] = i;
  const std::vector<Index> rows = {0, 1, 31};
  Matrix B = Matrix::Zero(f.n, 3);
  std::vector<Index> places;
  for (Index j = 0; j < 3; ++j) {
    B(rows[j], j) = 1;
    places.push_back(place[rows[j]]);
  }
  const SupernodeSet some = tree.reach(places);
  EXPECT_LT(some.flops_per_column, 0.9 * tree.all().flops_per_column);
  EXPECT_EQ(tree.reach({}).supernodes.size(), 0u);

  PanelSolver solver(tree, 3);
  Matrix all = panel_of(f, B), part = all;
  solver.forward(all, tree.all());
  solver.forward(part, some);
  EXPECT_EQ(all, part);
  solver.backward(all, tree.all());
  solver.backward(part, some);
  for (const Index i : places) EXPECT_EQ(all.col(i), part.col(i));
}

TEST(Supernodal, BlasHasThreadsForLargeWorkAlone) {
  set_threads(2);
  EXPECT_EQ(openblas_get_num_threads(), 1);
  {
    const LargeBlasWork large(1e12), reading = LargeBlasWork::reading(2'000'000);
    EXPECT_EQ(openblas_get_num_threads(), 2);
    {
      const SingleThreadedBlas outer;
      EXPECT_EQ(openblas_get_num_threads(), 1);
      {
        const SingleThreadedBlas inner;
        const LargeBlasWork within(1e12);
        EXPECT_EQ(openblas_get_num_threads(), 1);
      }
      EXPECT_EQ(openblas_get_num_threads(), 1);
    }
    EXPECT_EQ(openblas_get_num_threads(), 2);
  }
  EXPECT_EQ(openblas_get_num_threads(), 1);
  {
    const LargeBlasWork small(1e3), reading = LargeBlasWork::reading(1000);
    EXPECT_EQ(openblas_get_num_threads(), 1);
  }
  set_threads(0);
}

}  // namespace
}  // namespace cbr::test::supernodal_test
