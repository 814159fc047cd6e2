// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/spectrum_slices.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"
#include "common/linalg/eigen/tall_basis.hpp"
#include "common/linalg/kernels/narrow_product.hpp"
#include "common/linalg/sparse/signed_factor.hpp"

namespace cbr {
namespace {

// Slices are cut at the widest gap of the last so many pairs: vectors of two slices are orthogonal
// to their residuals over the gap. So many on both sides of a cut are looked at.
constexpr Index cut_among = 8;
// Shifts tried for one slice. A shift may be too far off, or at an eigenvalue, or its small pivots
// cost the solves digits.
constexpr int most_shifts = 8;

class Slices {
 public:
  Slices(const SparseMatrix& K, const SparseMatrix& M, const SparseCholesky& factor, Index k,
         double tolerance, const Progress& progress)
      : K_(K), M_(M), factor_(factor), k_(k), progress_(progress) {
    options_.tolerance = tolerance;
    options_.block = narrow::width;
    all_.lambda.resize(k);
    all_.Phi.resize(M.rows(), k);
  }

  Eigenpairs run(Index width, const Eigenpairs& known) {
    all_.method = "block lanczos in slices";
    if (known.lambda.size() > 1) take(known, 0, known.lambda.size());
    if (have_ == 0 && !lowest(width)) return std::move(all_);
    while (have_ < k_) {
      const Index slices = (k_ - have_ + width - 1) / width;
      if (!next((k_ - have_ + slices - 1) / slices)) return std::move(all_);
    }
    all_.n_converged = k_;
    all_.converged = true;
    return std::move(all_);
  }

 private:
  // Shares of the whole that one slice goes through.
  BlockLanczosOptions options_for(Index pairs) {
    BlockLanczosOptions options = options_;
    options.progress = [this, pairs](double share) {
      if (progress_)
        progress_((static_cast<double>(have_) +
                   share * static_cast<double>(std::min(pairs, k_ - have_))) /
                  static_cast<double>(k_));
    };
    return options;
  }

  bool lowest(Index width) {
    const Index wanted = std::min(k_ + 1, width);
    const Eigenpairs pairs = block_lanczos(
        M_.rows(), product_with(M_), [&](Eigen::Ref<Matrix> B) { factor_.solve_in_place(B); }, 0,
        wanted, options_for(wanted));
    if (!pairs.converged) return false;
    take(pairs, 0, wanted);
    return true;
  }

  // Pairs first ... last - 1 go to those that are had. Where more follow, they end at the widest
  // gap among the last ones: a twin of the last may be missing.
  void take(const Eigenpairs& pairs, Index first, Index last) {
    Index end = last - 1;
    double widest = 0;
    for (Index j = std::max(first + 1, last - cut_among); j < last; ++j) {
      const double gap = pairs.lambda(j) - pairs.lambda(j - 1);
      if (gap < widest) continue;
      widest = gap;
      end = j;
    }
    const Index left = k_ - have_, count = last - first > left ? left : end - first;
    all_.lambda.segment(have_, count) = pairs.lambda.segment(first, count);
    all_.Phi.middleCols(have_, count) = pairs.Phi.middleCols(first, count);
    have_ += count;
  }

  // Some `width` pairs about a shift beyond those that are had.
  bool next(Index width) {
    // Pairs between the last that is had and the shift, as far as can be guessed
    auto ahead = static_cast<double>(std::max<Index>(1, width / 2));
    for (int attempt = 0; attempt < most_shifts; ++attempt) {
      const double sigma = all_.lambda(have_ - 1) + ahead * spacing();
      SignedFactor factor(K_, sigma, M_, factor_);
      if (!factor.ok()) {
        ahead *= 0.99;
        continue;
      }
      const Index below = factor.n_negative() - have_;
      if (below < 0) return false;  // one that is had is not one of the lowest
      if (below > 3 * width / 4 + 2) {
        ahead *= 0.5 * static_cast<double>(width) / static_cast<double>(below);
        continue;
      }
      if (about(sigma, factor, below, width)) return true;
      ahead *= 0.8;
    }
    return false;
  }

  // Of the last pairs that are had.
  double spacing() const {
    const Index pairs = std::min<Index>(have_ - 1, 40);
    if (pairs == 0) return all_.lambda(0);
    return (all_.lambda(have_ - 1) - all_.lambda(have_ - 1 - pairs)) / static_cast<double>(pairs);
  }

  bool about(double sigma, SignedFactor& factor, Index below, Index width) {
    // One more, to find the gap to cut at
    const Index above = std::max<Index>(std::min(width, k_ - have_ + 1) - below, 2);
    BlockLanczosOptions options = options_for(below + above);
    options.max_restarts = 0;  // its basis is large enough for none
    options.inside = BlockLanczosOptions::Inside{below, above};
    const Eigenpairs pairs = block_lanczos(
        M_.rows(), product_with(M_), [&](Eigen::Ref<Matrix> B) { factor.solve_in_place(B); }, sigma,
        below + above, options);
    ++all_.iterations;
    if (!pairs.converged) return false;
    const Index found = (pairs.lambda.array() < sigma).count();
    if (found < below || !is_new(pairs.Phi.middleCols(found - below, std::min(below, cut_among))))
      return false;
    take(pairs, found - below, pairs.lambda.size());
    return true;
  }

  // False when the lowest vectors of a slice repeat the last ones before it.
  bool is_new(const Eigen::Ref<const Matrix>& Phi) const {
    constexpr double alike = 1e-6;
    if (Phi.cols() == 0) return true;
    const Index last = std::min(have_, cut_among);
    const SingleThreadedBlas blas;
    Matrix M_Phi;
    multiply_symmetric(M_, Phi, M_Phi);
    return tall_product(all_.Phi.middleCols(have_ - last, last), M_Phi).cwiseAbs().maxCoeff() <
           alike;
  }

  const SparseMatrix &K_, &M_;
  const SparseCholesky& factor_;
  Index k_, have_ = 0;
  const Progress& progress_;
  BlockLanczosOptions options_;
  Eigenpairs all_;
};

}  // namespace

Index slice_width(Index n, double flops) {
  constexpr double least = 120, most = 400;
  // About three vectors for a pair, each of which meets all others twice, there and back
  const double products = 36 * static_cast<double>(std::max<Index>(n, 1));
  return static_cast<Index>(std::clamp(std::sqrt(flops / products), least, most));
}

bool slices_pay(Index k, Index width, bool in_outline) {
  return 2 * k > (in_outline ? 8 : 5) * width;
}

Eigenpairs eigenpairs_by_slices(const SparseMatrix& K, const SparseMatrix& M,
                                const SparseCholesky& factor, Index k, Index width,
                                double tolerance, const Progress& progress,
                                const Eigenpairs& known) {
  return Slices(K, M, factor, k, tolerance, progress).run(width, known);
}

}  // namespace cbr
