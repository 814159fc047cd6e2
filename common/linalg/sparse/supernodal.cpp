// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/supernodal.hpp"

#include <cblas.h>

#include <algorithm>
#include <cassert>

#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/narrow_product.hpp"

namespace cbr {
namespace {

// Columns of a panel that are moved at a time: a line of the cache.
constexpr Index line = 8;

// OpenBLAS has a kernel for small products that packs nothing, up to this many multiplications. It
// is faster where few columns of L meet a panel, and keeps the panel's slab in the cache for the
// scatter.
constexpr Index small_product = 1000000, most_small_columns = 200;
constexpr Index forward_slab = 64, backward_slab = 16;

double flops(const SupernodalFactor& factor, Index s) {
  const auto columns = static_cast<double>(factor.columns(s)),
             height = static_cast<double>(factor.height(s));
  return columns * columns + 2 * columns * (height - columns);
}

// How the product of a panel with the part of a supernode below its diagonal block is cut.
struct Slabs {
  Index rows, columns;  // of X^T

  Slabs(Index width, Index supernode_columns, Index below, Index slab)
      : rows(width), columns(below) {
    if (supernode_columns > most_small_columns) return;
    rows = std::min(slab, width);
    columns = std::max<Index>(1, small_product / (rows * supernode_columns));
  }
};

}  // namespace

SupernodeTree::SupernodeTree(const SupernodalFactor& factor)
    : factor_(factor),
      supernode_of_(static_cast<std::size_t>(factor.n)),
      parent_(static_cast<std::size_t>(factor.n_super), -1) {
  for (Index s = 0; s < factor.n_super; ++s) {
    std::fill_n(supernode_of_.begin() + factor.first(s), factor.columns(s), s);
    all_.supernodes.push_back(s);
    all_.flops_per_column += flops(factor, s);
  }
  for (Index s = 0; s < factor.n_super; ++s) {
    if (factor.height(s) == factor.columns(s)) continue;
    const Index* rows = factor.rows + factor.pi[s];
    const Index row = *std::min_element(rows + factor.columns(s), rows + factor.height(s));
    parent_[s] = supernode_of_[row];
  }
  if (factor.x != nullptr) invert_tiles();
}

void SupernodeTree::invert_tiles() {
  const SingleThreadedBlas blas;
  inverse_.resize(tile, factor_.n);
  for (Index s = 0; s < factor_.n_super; ++s) {
    const Index stride = factor_.stride(s);
    for (Index j = 0; j < factor_.columns(s); j += tile) {
      const Index size = std::min(tile, factor_.columns(s) - j);
      auto inverse = inverse_.block(0, factor_.first(s) + j, size, size);
      inverse.setIdentity();
      cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, as_int(size),
                  as_int(size), 1.0, factor_.x + factor_.px[s] + j * (stride + 1), as_int(stride),
                  inverse.data(), as_int(tile));
    }
  }
}

SupernodeSet SupernodeTree::reach(const std::vector<Index>& rows) const {
  std::vector<char> reached(parent_.size(), 0);
  SupernodeSet set;
  for (const Index row : rows) {
    Index s = supernode_of_[row];
    for (; s >= 0 && !reached[s]; s = parent_[s]) {
      reached[s] = 1;
      set.supernodes.push_back(s);
      set.flops_per_column += flops(factor_, s);
    }
  }
  std::sort(set.supernodes.begin(), set.supernodes.end());
  return set;
}

PanelSolver::PanelSolver(const SupernodeTree& tree, Index width)
    : tree_(tree), factor_(tree.factor()) {
  Index longest = SupernodeTree::tile;
  for (Index s = 0; s < factor_.n_super; ++s)
    longest = std::max(longest, factor_.height(s) - factor_.columns(s));
  work_.resize(width, longest);
}

// X_1^T <- X_1^T L_1^-T   (w x columns)
void PanelSolver::solve_diagonal(Index s, Eigen::Ref<Matrix> X_t) {
  const Index w = X_t.rows(), columns = factor_.columns(s), first = factor_.first(s);
  const int L_stride = as_int(factor_.stride(s)), stride = as_int(X_t.outerStride()),
            work_stride = as_int(work_.outerStride());
  const double* L = factor_.x + factor_.px[s];
  for (Index j = 0; j < columns; j += SupernodeTree::tile) {
    const Index size = std::min(SupernodeTree::tile, columns - j);
    auto X_j = X_t.middleCols(first + j, size);
    if (j > 0)
      cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(w), as_int(size), as_int(j), -1.0,
                  X_t.col(first).data(), stride, L + j, L_stride, 1.0, X_j.data(), stride);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(w), as_int(size), as_int(size), 1.0,
                X_j.data(), stride, tree_.inverse(first + j), as_int(SupernodeTree::tile), 0.0,
                work_.data(), work_stride);
    X_j = work_.topLeftCorner(w, size);
  }
}

// X_1^T <- X_1^T L_1^-1   (w x columns)
void PanelSolver::solve_diagonal_transposed(Index s, Eigen::Ref<Matrix> X_t) {
  const Index w = X_t.rows(), columns = factor_.columns(s), first = factor_.first(s);
  const int L_stride = as_int(factor_.stride(s)), stride = as_int(X_t.outerStride()),
            work_stride = as_int(work_.outerStride());
  const double* L = factor_.x + factor_.px[s];
  for (Index j = (columns - 1) / SupernodeTree::tile * SupernodeTree::tile; j >= 0;
       j -= SupernodeTree::tile) {
    const Index size = std::min(SupernodeTree::tile, columns - j), after = columns - j - size;
    auto X_j = X_t.middleCols(first + j, size);
    if (after > 0)
      cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, as_int(w), as_int(size), as_int(after),
                  -1.0, X_t.col(first + j + size).data(), stride, L + j * L_stride + j + size,
                  L_stride, 1.0, X_j.data(), stride);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, as_int(w), as_int(size), as_int(size),
                1.0, X_j.data(), stride, tree_.inverse(first + j), as_int(SupernodeTree::tile), 0.0,
                work_.data(), work_stride);
    X_j = work_.topLeftCorner(w, size);
  }
}

void PanelSolver::narrow_forward(Index s, double* X_t) {
  const Index columns = factor_.columns(s);
  narrow::solve_columns(tree_, s, 0, columns, X_t, work_.data());
  narrow::subtract_rows(factor_, s, 0, columns, columns, factor_.height(s), X_t, work_.data());
}

void PanelSolver::narrow_backward(Index s, double* X_t) {
  const Index columns = factor_.columns(s);
  narrow::subtract_rows_transposed(factor_, s, 0, columns, columns, factor_.height(s), X_t,
                                   work_.data());
  narrow::solve_columns_transposed(tree_, s, 0, columns, X_t, work_.data());
}

// Asks for the beginning of a supernode that is next, which no product before it does.
void PanelSolver::fetch(Index s) const {
  constexpr Index most = 1024;
  constexpr int to_be_read = 0, into_second_cache = 2;
  const double* L = factor_.x + factor_.px[s];
  const Index n = std::min(most, factor_.px[s + 1] - factor_.px[s]);
  for (Index i = 0; i < n; i += line) __builtin_prefetch(L + i, to_be_read, into_second_cache);
}

void PanelSolver::forward(Eigen::Ref<Matrix> X_t, const SupernodeSet& set) {
  const Index w = X_t.rows();
  assert(X_t.cols() == factor_.n && w <= work_.rows() && X_t.innerStride() == 1);
  const int stride = as_int(X_t.outerStride());
  for (auto it = set.supernodes.begin(); it != set.supernodes.end(); ++it) {
    const Index s = *it;
    if (w == narrow::width && stride == w && work_.rows() == w) {
      if (const auto next = it + 1; next != set.supernodes.end()) fetch(*next);
      narrow_forward(s, X_t.data());
      continue;
    }
    const Index columns = factor_.columns(s), height = factor_.height(s), below = height - columns;
    solve_diagonal(s, X_t);
    if (below == 0) continue;
    const Slabs slabs(w, columns, below, forward_slab);
    const Index* rows = factor_.rows + factor_.pi[s] + columns;
    for (Index r = 0; r < w; r += slabs.rows) {
      const Index m = std::min(slabs.rows, w - r);
      const double* X_1 = X_t.col(factor_.first(s)).data() + r;
      for (Index i = 0; i < below; i += slabs.columns) {
        const Index count = std::min(slabs.columns, below - i);
        // X_2^T -= X_1^T L_2^T   (w x below)
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(m), as_int(count),
                    as_int(columns), 1.0, X_1, stride, factor_.x + factor_.px[s] + columns + i,
                    as_int(factor_.stride(s)), 0.0, work_.data(), as_int(m));
        for (Index j = 0; j < count; ++j)
          cblas_daxpy(as_int(m), -1.0, work_.data() + j * m, 1, X_t.col(rows[i + j]).data() + r, 1);
      }
    }
  }
}

void PanelSolver::backward(Eigen::Ref<Matrix> X_t, const SupernodeSet& set) {
  const Index w = X_t.rows();
  assert(X_t.cols() == factor_.n && w <= work_.rows() && X_t.innerStride() == 1);
  const int stride = as_int(X_t.outerStride());
  for (auto it = set.supernodes.rbegin(); it != set.supernodes.rend(); ++it) {
    const Index s = *it, columns = factor_.columns(s), height = factor_.height(s),
                below = height - columns;
    if (w == narrow::width && stride == w && work_.rows() == w) {
      if (const auto next = it + 1; next != set.supernodes.rend()) fetch(*next);
      narrow_backward(s, X_t.data());
      continue;
    }
    const Slabs slabs(w, columns, below, backward_slab);
    const Index* rows = factor_.rows + factor_.pi[s] + columns;
    for (Index r = 0; r < w && below > 0; r += slabs.rows) {
      const Index m = std::min(slabs.rows, w - r);
      double* X_1 = X_t.col(factor_.first(s)).data() + r;
      for (Index i = 0; i < below; i += slabs.columns) {
        const Index count = std::min(slabs.columns, below - i);
        for (Index j = 0; j < count; ++j)
          std::copy_n(X_t.col(rows[i + j]).data() + r, m, work_.data() + j * m);
        // X_1^T -= X_2^T L_2   (w x columns)
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, as_int(m), as_int(columns),
                    as_int(count), -1.0, work_.data(), as_int(m),
                    factor_.x + factor_.px[s] + columns + i, as_int(factor_.stride(s)), 1.0, X_1,
                    stride);
      }
    }
    solve_diagonal_transposed(s, X_t);
  }
}

void load_panel(const SupernodalFactor& factor, const Eigen::Ref<const Matrix>& B,
                Eigen::Ref<Matrix> X_t) {
  const Index w = X_t.rows();
  for (Index first = 0; first < w; first += line) {
    const Index count = std::min(line, w - first);
    const double* b = B.col(first).data();
    const Index stride = B.outerStride();
    for (Index i = 0; i < factor.n; ++i) {
      double* x = X_t.col(i).data() + first;
      const double* from = b + factor.order[i];
      for (Index j = 0; j < count; ++j) x[j] = from[j * stride];
    }
  }
}

void store_panel(const SupernodalFactor& factor, const Eigen::Ref<const Matrix>& X_t,
                 Eigen::Ref<Matrix> B) {
  const Index w = X_t.rows();
  for (Index first = 0; first < w; first += line) {
    const Index count = std::min(line, w - first);
    double* b = B.col(first).data();
    const Index stride = B.outerStride();
    for (Index i = 0; i < factor.n; ++i) {
      const double* x = X_t.col(i).data() + first;
      double* to = b + factor.order[i];
      for (Index j = 0; j < count; ++j) to[j * stride] = x[j];
    }
  }
}

}  // namespace cbr
