// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/reached_compliance.hpp"

#include <algorithm>
#include <atomic>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/linalg/blas_threads.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/condensation/panel_product.hpp"

namespace cbr {
namespace {

std::vector<Index> rows_of(const SparseMatrix& A, Index first, Index count) {
  const Index* indices = A.innerIndexPtr();
  std::vector<Index> rows(indices + A.outerIndexPtr()[first],
                          indices + A.outerIndexPtr()[first + count]);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

}  // namespace

Matrix reached_compliance(const SparseCholesky& factor, const SparseMatrix& B, double bytes) {
  const SupernodeTree& tree = factor.tree();
  const Index n = factor.n_rows(), s = B.cols();
  Matrix C = Matrix::Zero(s, s);
  if (s == 0) return C;
  const std::vector<Index> place = inverse({tree.factor().order, tree.factor().order + n});
  const std::vector<Index> columns = by_first_row(B, place);
  const PanelProduct loads(reordered(B, place, columns));
  const SparseMatrix& L = loads.sparse();
  const SupernodeSet wanted = tree.reach(rows_of(L, 0, s));
  const double column_bytes = 8.0 * static_cast<double>(n) * n_threads();
  const Index width =
      std::clamp<Index>(static_cast<Index>(bytes / column_bytes), 1, std::min(good_panel, s));
  const Index n_panels = (s + width - 1) / width;
  std::atomic<Index> next{0};
  const SingleThreadedBlas blas;
  run_threads(static_cast<int>(std::min<Index>(n_threads(), n_panels)), [&](int) {
    PanelSolver solver(tree, width);
    Matrix X, out;
    for (Index i = next++; i < n_panels; i = next++) {
      const Index first = i * width, count = std::min(width, s - first);
      // Rows that are not reached are neither written nor read
      if (X.rows() != count) X.resize(count, n);
      for (const Index supernode : wanted.supernodes)
        X.middleCols(tree.factor().first(supernode), tree.factor().columns(supernode)).setZero();
      for (Index j = 0; j < count; ++j)
        for (SparseMatrix::InnerIterator it(L, first + j); it; ++it) X(j, it.row()) = it.value();
      solver.forward(X, tree.reach(rows_of(L, first, count)));
      solver.backward(X, wanted);
      // The columns from the panel's own on, as the rest is the other triangle
      out.setZero(count, s - first);
      loads.add(X, 1, out);
      C.block(first, first, count, s - first) = out;
    }
  });
  restore_order(columns, C);
  return C;
}

}  // namespace cbr
