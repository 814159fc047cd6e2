// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/signed_factor.hpp"

#include <algorithm>
#include <utility>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/kernels/narrow_product.hpp"

namespace cbr {

SignedFactor::SignedFactor(const SparseMatrix& K, double sigma, const SparseMatrix& M,
                           const SparseCholesky& like) {
  // Smaller pivots make entries of L that all digits of the others are lost in.
  constexpr double vanishing = 1e-9;
  SupernodalFactor factor = like.tree().factor();
  px_.push_back(0);
  for (Index s = 0; s < factor.n_super; ++s)
    px_.push_back(px_.back() + factor.columns(s) * factor.height(s));
  x_ = on_huge_pages(px_.back(), 1);
  SignedPivots pivots;
  const auto count =
      factor_with_signs(like.tree(), {K, sigma, &M}, vanishing, px_.data(), x_.data(), pivots);
  if (!count || *count < 0) return;
  n_negative_ = *count;
  rename(factor, pivots);
  factor.px = px_.data();
  factor.x = x_.data();
  factor.rows = rows_.data();
  factor.order = order_.data();
  tree_ = SupernodeTree(factor);
  solve_ = std::make_unique<SharedSolve>(tree_, n_threads(), std::move(pivots.signs));
}

// Rows by the places that pivots have come to; within its front a row has moved with its pivot.
void SignedFactor::rename(const SupernodalFactor& factor, const SignedPivots& pivots) {
  std::vector<Index> place(pivots.order.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    place[pivots.order[i]] = static_cast<Index>(i);
    order_.push_back(factor.order[pivots.order[i]]);
  }
  for (Index s = 0; s < factor.n_super; ++s) {
    const Index end = pivots.front_end[s];
    for (Index i = factor.pi[s]; i < factor.pi[s + 1]; ++i) {
      const Index row = factor.rows[i];
      rows_.push_back(row < end ? row : place[row]);
    }
  }
}

void SignedFactor::solve_in_place(Eigen::Ref<Matrix> B) {
  for (Index first = 0; first < B.cols(); first += narrow::width)
    (*solve_)(B.middleCols(first, std::min(narrow::width, B.cols() - first)));
}

}  // namespace cbr
