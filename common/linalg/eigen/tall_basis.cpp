// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/tall_basis.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <functional>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/kernels/narrow_product.hpp"

namespace cbr {
namespace {

// Rows of a slab: with a panel of 128 columns half of the second cache. Sums are taken of at most
// so many parts.
constexpr Index slab_rows = 512, most_parts = 16;
constexpr Index panel_columns = 128;
// Fused multiplications below which waking a thread costs more than it brings.
constexpr double worth_a_thread = 2e6;

// work(i) for i < n on as many threads as the work is worth.
void share(Index n, double multiplications, const std::function<void(Index)>& work) {
  const int threads =
      multiplications < worth_a_thread ? 1 : static_cast<int>(std::min<Index>(n_threads(), n));
  std::atomic<Index> next{0};
  run_kept_threads(threads, [&](int) {
    for (Index i = next++; i < n; i = next++) work(i);
  });
}

double product_of(Index a, Index b, Index c) {
  return static_cast<double>(a) * static_cast<double>(b) * static_cast<double>(c);
}

struct Rows {
  Index first, count;
};

Rows part_of(Index n, Index parts, Index i) {
  const Index first = n * i / parts;
  return {first, n * (i + 1) / parts - first};
}

// One entry a column, on the diagonal.
bool is_diagonal(const SparseMatrix& M) {
  for (Index j = 0; j < M.cols(); ++j)
    if (M.outerIndexPtr()[j + 1] != j + 1 || M.innerIndexPtr()[j] != j) return false;
  return true;
}

Index n_parts(Index n) { return std::clamp<Index>(n / slab_rows, 1, most_parts); }

// Transposed, in groups of as many columns as the narrow products take, filled up with zeros (width
// x rows of each group)
Matrix in_groups(const Eigen::Ref<const Matrix>& P) {
  const Index groups = (P.cols() + narrow::width - 1) / narrow::width;
  Matrix groups_of_P = Matrix::Zero(narrow::width, P.rows() * groups);
  for (Index g = 0; g < groups; ++g) {
    const Index first = g * narrow::width, count = std::min(narrow::width, P.cols() - first);
    groups_of_P.block(0, g * P.rows(), count, P.rows()) = P.middleCols(first, count).transpose();
  }
  return groups_of_P;
}

// The negative of U^T P in groups: V is read once from memory, nothing is packed   (width x columns
// of U, of each group of P)
void subtract_transposed(const Eigen::Ref<const Matrix>& U, const Eigen::Ref<const Matrix>& P,
                         Matrix& sums, Index first_column) {
  const Index groups = (P.cols() + narrow::width - 1) / narrow::width,
              columns = sums.cols() / groups;
  for (Index first = 0; first < U.rows(); first += slab_rows) {
    const Index count = std::min(slab_rows, U.rows() - first);
    const Matrix P_t = in_groups(P.middleRows(first, count));
    for (Index g = 0; g < groups; ++g)
      narrow::subtract_transposed(U.data() + first, U.outerStride(), count, U.cols(),
                                  P_t.col(g * count).data(),
                                  sums.col(g * columns + first_column).data());
  }
}

// From the groups of all parts, in their order   (columns x p)
Matrix added_up(const std::vector<Matrix>& parts, Index columns, Index p) {
  Matrix sum = parts[0];
  for (std::size_t i = 1; i < parts.size(); ++i) sum += parts[i];
  Matrix product(columns, p);
  for (Index j = 0; j < p; ++j)
    product.col(j) =
        -sum.row(j % narrow::width).segment(j / narrow::width * columns, columns).transpose();
  return product;
}

Matrix empty_groups(Index columns, Index p) {
  return Matrix::Zero(narrow::width, columns * ((p + narrow::width - 1) / narrow::width));
}

// U <- U - V h of a slab; h_t: h in groups.
void subtract_slab(const Eigen::Ref<const Matrix>& V, const Matrix& h_t, Index h_rows,
                   Index first_row, Eigen::Ref<Matrix> U) {
  Matrix Y_t(narrow::width, U.rows());
  for (Index first = 0; first < U.cols(); first += narrow::width) {
    const Index g = first / narrow::width, count = std::min(narrow::width, U.cols() - first);
    narrow::multiply(V.data(), V.outerStride(), V.rows(), V.cols(),
                     h_t.col(g * h_rows + first_row).data(), Y_t.data());
    U.middleCols(first, count) -= Y_t.topRows(count).transpose();
  }
}

}  // namespace

TallBasis::TallBasis(Index n, Index block, Index most) : n_(n), block_(block) {
  const Index wanted = std::min(std::max(panel_columns, block), most);
  panel_ = std::max<Index>(1, wanted / block) * block;
}

Index TallBasis::n_slabs() const { return (n_ + slab_rows - 1) / slab_rows; }

Eigen::Ref<Matrix> TallBasis::block(Index first) {
  assert(first % block_ == 0);
  const auto panel = static_cast<std::size_t>(first / panel_);
  while (panels_.size() <= panel) panels_.push_back(on_huge_pages(n_, panel_));
  return panels_[panel].middleCols(first % panel_, block_);
}

Matrix TallBasis::transposed_product(Index columns, const Eigen::Ref<const Matrix>& P) const {
  const Index parts = n_parts(n_);
  std::vector<Matrix> sums(parts);
  share(parts, product_of(n_, columns, P.cols()), [&](Index i) {
    const Rows rows = part_of(n_, parts, i);
    Matrix& sum = sums[i];
    sum = empty_groups(columns, P.cols());
    for (Index first = 0; first < columns; first += panel_) {
      const Index count = std::min(panel_, columns - first);
      const auto V = panels_[first / panel_].block(rows.first, 0, rows.count, count);
      subtract_transposed(V, P.middleRows(rows.first, rows.count), sum, first);
    }
  });
  return added_up(sums, columns, P.cols());
}

void TallBasis::subtract(const Matrix& h, Eigen::Ref<Matrix> U) const {
  const Matrix h_t = in_groups(h);
  share(n_slabs(), product_of(n_, h.rows(), h.cols()), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n_ - row);
    for (Index first = 0; first < h.rows(); first += panel_) {
      const Index columns = std::min(panel_, h.rows() - first);
      const auto V = panels_[first / panel_].block(row, 0, count, columns);
      subtract_slab(V, h_t, h.rows(), first, U.middleRows(row, count));
    }
  });
}

// The first columns of some rows side by side   (n_rows x columns)
Matrix TallBasis::gathered(Index first_row, Index n_rows, Index columns) const {
  Matrix V(n_rows, columns);
  for (Index first = 0; first < columns; first += panel_) {
    const Index count = std::min(panel_, columns - first);
    V.middleCols(first, count) = panels_[first / panel_].block(first_row, 0, n_rows, count);
  }
  return V;
}

Matrix TallBasis::combined(const Eigen::Ref<const Matrix>& S) const {
  Matrix X(n_, S.cols());
  share(n_slabs(), product_of(n_, S.rows(), S.cols()), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n_ - row);
    X.middleRows(row, count).noalias() = gathered(row, count, S.rows()) * S;
  });
  return X;
}

void TallBasis::rotate(const Eigen::Ref<const Matrix>& S) {
  assert(S.cols() % block_ == 0 && S.cols() <= S.rows());
  share(n_slabs(), product_of(n_, S.rows(), S.cols()), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n_ - row);
    const Matrix X = gathered(row, count, S.rows()) * S;
    for (Index first = 0; first < S.cols(); first += panel_) {
      const Index columns = std::min(panel_, S.cols() - first);
      panels_[first / panel_].block(row, 0, count, columns) = X.middleCols(first, columns);
    }
  });
}

Matrix tall_product(const Eigen::Ref<const Matrix>& U, const Eigen::Ref<const Matrix>& P) {
  const Index n = U.rows(), parts = n_parts(n);
  std::vector<Matrix> sums(parts);
  share(parts, product_of(n, U.cols(), P.cols()), [&](Index i) {
    const Rows rows = part_of(n, parts, i);
    Matrix& sum = sums[i];
    sum = empty_groups(U.cols(), P.cols());
    subtract_transposed(U.middleRows(rows.first, rows.count), P.middleRows(rows.first, rows.count),
                        sum, 0);
  });
  return added_up(sums, U.cols(), P.cols());
}

void subtract_product(const Eigen::Ref<const Matrix>& V, const Eigen::Ref<const Matrix>& h,
                      Eigen::Ref<Matrix> U) {
  const Index n = U.rows(), slabs = (n + slab_rows - 1) / slab_rows;
  const Matrix h_t = in_groups(h);
  share(slabs, product_of(n, h.rows(), h.cols()), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n - row);
    subtract_slab(V.middleRows(row, count), h_t, h.rows(), 0, U.middleRows(row, count));
  });
}

void multiply_on_right(const Eigen::Ref<const Matrix>& T, Eigen::Ref<Matrix> U) {
  assert(T.rows() == U.cols() && T.cols() == U.cols());
  const Index n = U.rows(), p = U.cols(), slabs = (n + slab_rows - 1) / slab_rows;
  const Matrix T_t = in_groups(T);
  share(slabs, product_of(n, p, p), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n - row);
    const Matrix before = U.middleRows(row, count);
    Matrix Y_t(narrow::width, count);
    for (Index first = 0; first < p; first += narrow::width) {
      const Index columns = std::min(narrow::width, p - first);
      narrow::multiply(before.data(), count, count, p, T_t.col(first / narrow::width * p).data(),
                       Y_t.data());
      U.block(row, first, count, columns) = Y_t.topRows(columns).transpose();
    }
  });
}

void multiply_symmetric(const SparseMatrix& M, const Eigen::Ref<const Matrix>& U, Matrix& P) {
  const Index n = M.rows(), p = U.cols();
  P.resize(n, p);
  if (M.nonZeros() == n && is_diagonal(M)) {
    P.noalias() = Eigen::Map<const Vector>(M.valuePtr(), n).asDiagonal() * U;
    return;
  }
  // A row of U stands together, as every entry of M meets one
  const Matrix U_t = in_groups(U);
  const Index slabs = (n + slab_rows - 1) / slab_rows;
  share(slabs, static_cast<double>(M.nonZeros() * p), [&](Index i) {
    const Index row = i * slab_rows, count = std::min(slab_rows, n - row);
    Matrix P_t(narrow::width, count);
    for (Index first = 0; first < p; first += narrow::width) {
      const Index columns = std::min(narrow::width, p - first);
      narrow::multiply_columns(M, row, count, U_t.col(first / narrow::width * n).data(),
                               P_t.data());
      P.block(row, first, count, columns) = P_t.topRows(columns).transpose();
    }
  });
}

}  // namespace cbr
