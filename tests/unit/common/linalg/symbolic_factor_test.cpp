// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "common/linalg/sparse/shared_solve.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/linalg/sparse/symbolic_factor.hpp"
#include "tests/unit/common/linalg/grid_matrices.hpp"

namespace cbr::test::symbolic_factor_test {
namespace {

using Indices = std::vector<Index>;

// A chain of three nodes of three dofs each, all of which meet.
SparseMatrix chain_of_nodes(bool lower) {
  Triplets entries;
  for (Index i = 0; i < 9; ++i)
    for (Index j = 0; j < 9; ++j)
      if (std::abs(i / 3 - j / 3) < 2 && (i >= j || !lower))
        entries.emplace_back(i, j, i == j ? 20.0 : -1.0);
  SparseMatrix A(9, 9);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

TEST(EliminationOrder, KnowsNodesByTheirBlocks) {
  EXPECT_EQ(dofs_per_node(chain_of_nodes(false)), 3);
  EXPECT_EQ(dofs_per_node(chain_of_nodes(true)), 3);
  EXPECT_EQ(dofs_per_node(grid_stiffness(6, true)), 1);  // 216 rows, but no blocks
  EXPECT_EQ(dofs_per_node(grid_stiffness(5, true)), 1);
}

TEST(EliminationOrder, GraphOfNodesIsTheSameOfEitherStorage) {
  for (const bool lower : {false, true}) {
    const Matrix whole(node_graph(chain_of_nodes(lower), 3, {}));
    EXPECT_EQ(whole, (Matrix(3, 3) << 1, 0, 0, 1, 1, 0, 0, 1, 1).finished());
    // Without the node in the middle the others do not meet
    EXPECT_EQ(Matrix(node_graph(chain_of_nodes(lower), 3, {3, 4, 5})), Matrix::Identity(2, 2));
  }
}

TEST(EliminationOrder, RowsFollowTheirNodesAndTheLastOnesComeLast) {
  EXPECT_EQ(order_of_rows({2, 0, 1}, 3, 9, {}), (Indices{6, 7, 8, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(order_of_rows({1, 0}, 3, 9, {3, 4, 5}), (Indices{6, 7, 8, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(order_of_rows({1, 0}, 1, 3, {0}), (Indices{2, 1, 0}));
}

TEST(SharedSolve, SolvesByAnyNumberOfThreads) {
  const SparseMatrix A = grid_stiffness(12, true);
  const SparseCholesky factor(A);
  for (const int threads : {1, 2, 3, 7}) {
    SharedSolve solve(factor.tree(), threads);
    for (const Index columns : {8, 3, 1, 8}) {
      const Matrix B = random_like(A.rows(), columns, 0.3);
      Matrix X = B, again = B;
      solve(X);
      EXPECT_LT((A * X - B).norm(), 1e-13 * B.norm()) << threads << ' ' << columns;
      solve(again);
      EXPECT_EQ(X, again);
    }
  }
}

// Seven columns: supernode 0 of two columns above rows 4 and 5, supernode 1 of five columns above
// none.
struct Example {
  Indices super{0, 2, 7}, pi{0, 4, 9}, px{0, 8, 33}, rows{0, 1, 4, 5, 2, 3, 4, 5, 6};
  SupernodalFactor factor() const {
    SupernodalFactor f;
    f.n = 7;
    f.n_super = 2;
    f.super = super.data();
    f.pi = pi.data();
    f.px = px.data();
    f.rows = rows.data();
    return f;
  }
};

TEST(CutSupernodes, LeavesNarrowOnesAsTheyAre) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 5);
  EXPECT_EQ(made.super, example.super);
  EXPECT_EQ(made.pi, example.pi);
  EXPECT_EQ(made.px, example.px);
  EXPECT_EQ(made.rows, example.rows);
}

TEST(CutSupernodes, PiecesBeginWithTheirOwnRowsOfTheSharedList) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 2);
  EXPECT_EQ(made.super, (Indices{0, 2, 3, 5, 7}));
  EXPECT_EQ(made.pi, (Indices{0, 4, 9, 13, 15}));
  EXPECT_EQ(made.px, (Indices{0, 8, 13, 21, 25}));  // 25 entries instead of 33
  EXPECT_EQ(made.rows, (Indices{0, 1, 4, 5, 2, 3, 4, 5, 6, 3, 4, 5, 6, 5, 6}));
}

TEST(CutSupernodes, ASupernodeBeginsAtTheBoundary) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 5, 3);
  EXPECT_EQ(made.super, (Indices{0, 2, 3, 7}));
  EXPECT_EQ(made.pi, (Indices{0, 4, 9, 13}));
  EXPECT_EQ(made.px, (Indices{0, 8, 13, 29}));
  EXPECT_EQ(made.rows, (Indices{0, 1, 4, 5, 2, 3, 4, 5, 6, 3, 4, 5, 6}));
  // What stands before it: the rows of columns 3 to 6 are left out, their values stay where they
  // are
  SupernodalFactor cut = example.factor();
  cut.n_super = 3;
  cut.super = made.super.data();
  cut.pi = made.pi.data();
  cut.px = made.px.data();
  cut.rows = made.rows.data();
  const SupernodePattern leading = leading_pattern(cut, 3);
  EXPECT_EQ(leading.super, (Indices{0, 2, 3}));
  EXPECT_EQ(leading.pi, (Indices{0, 2, 3}));
  EXPECT_EQ(leading.rows, (Indices{0, 1, 2}));
  cut.n = 3;
  cut.n_super = 2;
  cut.super = leading.super.data();
  cut.pi = leading.pi.data();
  cut.rows = leading.rows.data();
  EXPECT_EQ(cut.height(0), 2);
  EXPECT_EQ(cut.stride(0), 4);
  EXPECT_EQ(cut.stride(1), 5);
}

}  // namespace
}  // namespace cbr::test::symbolic_factor_test
