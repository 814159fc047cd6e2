// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/kept_factor.hpp"

#include <algorithm>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

// Smaller pivots of the scaled matrix are round-off.
constexpr double weakest_pivot = 1e-11;
// Fractions of the rows up to which updates cost less than a new factor.
constexpr double most_removed = 0.25, most_added = 0.1;
// Updates lose accuracy at smaller pivots: a new factor is made.
constexpr double weakest_kept = 1e-7;

// Factors A; returns the smallest pivot, or 0 if it is round-off.
double factor_in_place(Eigen::Ref<Matrix> A) {
  if (A.rows() == 0) return 1;
  const double pivot = cholesky_in_place(A) ? A.diagonal().cwiseAbs2().minCoeff() : 0;
  return pivot > weakest_pivot ? pivot : 0;
}

}  // namespace

void KeptFactor::clear() {
  n_ = 0;
  row_.clear();
  removed_.clear();
  positions_.clear();
  X_.resize(0, 0);
}

KeptFactor::Change KeptFactor::change(const std::vector<Index>& rows) const {
  Change change;
  const Index largest = rows.empty() ? 0 : rows.back() + 1;
  std::vector<char> wanted(static_cast<std::size_t>(largest), 0),
      was_removed(static_cast<std::size_t>(n_), 0);
  for (const Index row : rows) wanted[row] = 1;
  for (const Index position : removed_) was_removed[position] = 1;
  for (Index i = 0; i < n_; ++i) {
    const bool want = row_[i] < largest && wanted[row_[i]];
    if (want) wanted[row_[i]] = 2;
    if (want && was_removed[i]) change.returned.push_back(i);
    if (!want && !was_removed[i]) change.removed.push_back(i);
  }
  for (const Index row : rows)
    if (wanted[row] == 1) change.added.push_back(row);
  return change;
}

bool KeptFactor::is_small(const Change& change) const {
  if (change.added.empty() && change.removed.empty() && change.returned.empty()) return true;
  if (pivot_ < weakest_kept) return false;
  const double n = static_cast<double>(n_);
  const std::size_t removed = removed_.size() + change.removed.size() - change.returned.size();
  return static_cast<double>(removed) <= most_removed * n &&
         static_cast<double>(change.added.size()) <= most_added * n;
}

bool KeptFactor::is_near(const std::vector<Index>& rows) const {
  return n_ > 0 && is_small(change(rows));
}

bool KeptFactor::adapt(const Matrix& W, const std::vector<Index>& rows) {
  if (n_ > 0) {
    const Change what = change(rows);
    if (is_small(what) && (what.added.empty() || append(W, what.added)) && remove(what)) {
      place(rows);
      return true;
    }
  }
  if (factor(W, rows)) {
    place(rows);
    return true;
  }
  clear();
  return false;
}

bool KeptFactor::factor(const Matrix& W, const std::vector<Index>& rows) {
  clear();
  n_ = static_cast<Index>(rows.size());
  if (L_.rows() < n_) L_.resize(n_ + n_ / 8, n_ + n_ / 8);
  scale_ = W.diagonal()(rows).cwiseSqrt().cwiseInverse();
  for (Index j = 0; j < n_; ++j)
    for (Index i = j; i < n_; ++i) L_(i, j) = scale_[i] * scale_[j] * W(rows[i], rows[j]);
  row_ = rows;
  pivot_ = factor_in_place(L_.topLeftCorner(n_, n_));
  return pivot_ > 0;
}

// [L 0; B^T M] with B = L^-1 W_F,new, M M^T = W_new,new - B^T B
bool KeptFactor::append(const Matrix& W, const std::vector<Index>& rows) {
  const Index k = static_cast<Index>(rows.size()), n = n_ + k;
  if (L_.rows() < n) L_.conservativeResize(n + n / 8, n + n / 8);
  scale_.conservativeResize(n);
  scale_.tail(k) = W.diagonal()(rows).cwiseSqrt().cwiseInverse();
  Matrix B = W(row_, rows);
  B = scale_.head(n_).asDiagonal() * B * scale_.tail(k).asDiagonal();
  L_.topLeftCorner(n_, n_).triangularView<Eigen::Lower>().solveInPlace(B);
  Matrix M = W(rows, rows);
  M = scale_.tail(k).asDiagonal() * M * scale_.tail(k).asDiagonal();
  M.noalias() -= B.transpose() * B;
  const double pivot = factor_in_place(M);
  if (!(pivot > 0)) return false;
  pivot_ = std::min(pivot_, pivot);
  L_.block(n_, 0, k, n_) = B.transpose();
  L_.block(n_, n_, k, k) = M;
  row_.insert(row_.end(), rows.begin(), rows.end());
  if (!removed_.empty()) {
    // Continues L^-1 E: -M^-1 B^T X
    Matrix below = -B.transpose() * X_;
    M.triangularView<Eigen::Lower>().solveInPlace(below);
    X_.conservativeResize(n, Eigen::NoChange);
    X_.bottomRows(k) = below;
  }
  n_ = n;
  return true;
}

bool KeptFactor::remove(const Change& change) {
  if (change.removed.empty() && change.returned.empty() &&
      (removed_.empty() || change.added.empty()))
    return true;
  Index kept = 0;
  for (std::size_t j = 0; j < removed_.size(); ++j) {
    if (std::find(change.returned.begin(), change.returned.end(), removed_[j]) !=
        change.returned.end())
      continue;
    if (kept != static_cast<Index>(j)) X_.col(kept) = X_.col(static_cast<Index>(j));
    removed_[kept++] = removed_[j];
  }
  const Index more = static_cast<Index>(change.removed.size());
  removed_.resize(kept);
  removed_.insert(removed_.end(), change.removed.begin(), change.removed.end());
  X_.conservativeResize(n_, kept + more);
  if (more > 0) {
    // Columns are 0 above the first of them
    const Index first = change.removed.front();
    auto columns = X_.rightCols(more);
    columns.setZero();
    for (Index j = 0; j < more; ++j) columns(change.removed[j], j) = 1;
    auto below = columns.bottomRows(n_ - first);
    L_.block(first, first, n_ - first, n_ - first)
        .triangularView<Eigen::Lower>()
        .solveInPlace(below);
  }
  gram_.resize(kept + more, kept + more);
  gram_.noalias() = X_.transpose() * X_;
  return gram_.rows() == 0 || cholesky_in_place(gram_);
}

void KeptFactor::place(const std::vector<Index>& rows) {
  positions_.assign(rows.size(), 0);
  const Index largest = rows.empty() ? 0 : rows.back() + 1;
  std::vector<Index> position(static_cast<std::size_t>(largest), -1);
  for (Index i = 0; i < n_; ++i)
    if (row_[i] < largest) position[row_[i]] = i;
  for (std::size_t i = 0; i < rows.size(); ++i) positions_[i] = position[rows[i]];
}

void KeptFactor::solve(const Vector& b, Vector& p) const {
  y_.setZero(n_);
  for (std::size_t i = 0; i < positions_.size(); ++i)
    y_[positions_[i]] = scale_[positions_[i]] * b[static_cast<Index>(i)];
  solve_lower(L_, n_, y_.data());
  if (!removed_.empty()) {
    small_.noalias() = X_.transpose() * y_;
    const auto C = gram_.triangularView<Eigen::Lower>();
    C.solveInPlace(small_);
    C.transpose().solveInPlace(small_);
    y_.noalias() -= X_ * small_;
  }
  solve_lower_transposed(L_, n_, y_.data());
  p.resize(b.size());
  for (std::size_t i = 0; i < positions_.size(); ++i)
    p[static_cast<Index>(i)] = scale_[positions_[i]] * y_[positions_[i]];
}

void KeptFactor::keep_state(StateArchive& archive) {
  archive(n_, row_, scale_, removed_, X_, gram_, positions_, pivot_);
  // The rest of L_ is uninitialised memory, which must not get into a file.
  for (Index j = 0; !archive.restores() && j < n_; ++j) {
    L_.col(j).head(j).setZero();
    L_.col(j).tail(L_.rows() - n_).setZero();
  }
  archive.first_columns(L_, n_);
}

}  // namespace cbr
