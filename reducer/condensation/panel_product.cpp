// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/panel_product.hpp"

#include <algorithm>
#include <utility>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

// A sparse matrix with more than this share of non-zeros is faster as a dense one.
constexpr double dense_share = 0.03;

bool is_dense(const SparseMatrix& A) {
  return static_cast<double>(A.nonZeros()) >
         dense_share * static_cast<double>(A.rows()) * static_cast<double>(A.cols());
}

// out += alpha X^T a_j, three entries at a time, which are the dofs of a node more often than not:
// a third of the traffic of `out`.
void add_column(const SparseMatrix& A, const Eigen::Ref<const Matrix>& X_t, double alpha, Index j,
                Eigen::Ref<Vector> out) {
  const Index end = A.outerIndexPtr()[j + 1];
  const Index* row = A.innerIndexPtr();
  const double* a = A.valuePtr();
  Index k = A.outerIndexPtr()[j];
  for (; k + 2 < end; k += 3)
    out += (alpha * a[k]) * X_t.col(row[k]) + (alpha * a[k + 1]) * X_t.col(row[k + 1]) +
           (alpha * a[k + 2]) * X_t.col(row[k + 2]);
  for (; k < end; ++k) out += (alpha * a[k]) * X_t.col(row[k]);
}

void mirror_upper(Matrix& A) {
  constexpr Index tile = 64;
  for (Index j = 0; j < A.cols(); j += tile) {
    const Index columns = std::min(tile, A.cols() - j);
    for (Index i = 0; i < j; i += tile)
      A.block(j, i, columns, tile) = A.block(i, j, tile, columns).transpose();
    for (Index l = j; l < j + columns; ++l)
      for (Index i = j; i < l; ++i) A(l, i) = A(i, l);
  }
}

}  // namespace

Matrix product(const SparseMatrix& A, const Eigen::Ref<const Matrix>& X) {
  if (is_dense(A) && X.cols() > 1) return Matrix(A) * X;
  return A * X;
}

PanelProduct::PanelProduct(SparseMatrix A) : sparse_(std::move(A)) {
  if (is_dense(sparse_)) dense_ = Matrix(sparse_);
}

void PanelProduct::add(const Eigen::Ref<const Matrix>& X_t, double alpha,
                       Eigen::Ref<Matrix> out) const {
  if (dense_.size() > 0) {
    out.noalias() += alpha * X_t * dense_.rightCols(out.cols());
    return;
  }
  const Index first = sparse_.cols() - out.cols();
  for (Index j = 0; j < out.cols(); ++j) add_column(sparse_, X_t, alpha, first + j, out.col(j));
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<Index>(i);
  return place;
}

SparseMatrix reordered(const SparseMatrix& A, const std::vector<Index>& place,
                       const std::vector<Index>& order) {
  SparseMatrix B(A.rows(), A.cols());
  B.reserve(A.nonZeros());
  std::vector<std::pair<Index, double>> column;
  for (Index j = 0; j < A.cols(); ++j) {
    column.clear();
    for (SparseMatrix::InnerIterator it(A, order[j]); it; ++it)
      if (it.value() != 0) column.emplace_back(place[it.row()], it.value());
    std::sort(column.begin(), column.end());
    B.startVec(j);
    for (const auto& [row, value] : column) B.insertBack(row, j) = value;
  }
  B.finalize();
  return B;
}

std::vector<Index> rows_of(const SparseMatrix& A, Index first, Index count) {
  const Index* indices = A.innerIndexPtr();
  std::vector<Index> rows(indices + A.outerIndexPtr()[first],
                          indices + A.outerIndexPtr()[first + count]);
  sort_uniquely(rows);
  return rows;
}

std::vector<Index> by_first_row(const SparseMatrix& K_IC, const std::vector<Index>& place) {
  std::vector<Index> first(K_IC.cols(), K_IC.rows());
  for (Index j = 0; j < K_IC.cols(); ++j) {
    for (SparseMatrix::InnerIterator it(K_IC, j); it; ++it)
      first[j] = std::min(first[j], place[it.row()]);
  }
  return order_by(first.size(), [&](Index a, Index b) { return first[a] < first[b]; });
}

void restore_order(const std::vector<Index>& order, Matrix& B) {
  mirror_upper(B);
  const Index n = B.cols();
  const int threads = n_threads();
  run_threads(threads, [&](int t) {
    std::vector<double> column(order.size());
    for (Index j = n * t / threads; j < n * (t + 1) / threads; ++j) {
      double* b = B.data() + j * n;
      std::copy_n(b, n, column.begin());
      for (std::size_t i = 0; i < order.size(); ++i) b[order[i]] = column[i];
    }
  });
  // Column i goes to order[i], cycle by cycle.
  std::vector<bool> moved(order.size(), false);
  std::vector<double> waiting(order.size());
  for (std::size_t start = 0; start < order.size(); ++start) {
    if (moved[start]) continue;
    std::copy_n(B.data() + static_cast<Index>(start) * n, n, waiting.begin());
    for (std::size_t i = start; !moved[i]; i = static_cast<std::size_t>(order[i])) {
      std::swap_ranges(waiting.begin(), waiting.end(), B.data() + order[i] * n);
      moved[i] = true;
    }
  }
}

}  // namespace cbr
