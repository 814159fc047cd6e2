// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response/standing_response.hpp"

#include <algorithm>
#include <utility>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/clones.hpp"
#include "dynamics/contact/response/response.hpp"

namespace cbr {
namespace {

// y += factor x
CBR_CLONES void add_scaled(const double* __restrict__ x, Index n, double factor,
                           double* __restrict__ y) {
  for (Index i = 0; i < n; ++i) y[i] += factor * x[i];
}

// Columns of `all` go where they are from now on; others are 0. Those that stay keep their order,
// so that none is written over before it has been read.
void move_columns(const std::vector<Index>& from, Index rows, Matrix& all) {
  const auto n = static_cast<Index>(from.size());
  if (all.cols() < n) all.conservativeResize(rows, n + n / 2);
  const auto move = [&](Index to) { all.col(to) = all.col(from[to]); };
  for (Index to = 0; to < n; ++to)
    if (from[to] > to) move(to);
  for (Index to = n; to-- > 0;)
    if (const Index old = from[to]; old >= 0 && old < to) move(to);
  for (Index to = 0; to < n; ++to)
    if (from[to] < 0) all.col(to).setZero();
}

bool has_one_row(const Combinations& of, Index u) {
  SparseMatrix::InnerIterator share(of.Y, u), row(of.Z, u);
  return !share && row && !++row;
}

}  // namespace

// share H^T of rows of the points with their weights: rows of F, ascending.
std::vector<RowWeight> StandingResponse::Part::pressed(const std::vector<RowWeight>& rows) const {
  std::vector<RowWeight> all, sums;
  for (const RowWeight& of : rows)
    for (RowMajorSparse::InnerIterator it(H, of.row); it; ++it)
      all.push_back({it.col(), share * of.weight * it.value()});
  std::stable_sort(all.begin(), all.end(),
                   [](const RowWeight& a, const RowWeight& b) { return a.row < b.row; });
  for (const RowWeight& of : all) {
    if (sums.empty() || sums.back().row != of.row)
      sums.push_back(of);
    else
      sums.back().weight += of.weight;
  }
  return sums;
}

void StandingResponse::start(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<ContactBody>& bodies, const SparseMatrix& N,
                             bool in_body_axes) {
  parts_.clear();
  N_ = N;
  has_.assign(static_cast<std::size_t>(N.cols()), 0);
  of_N_.setZero(N.cols(), N.cols());
  rows_of_N_.setZero(N.cols(), N.rows());
  for (const BodyRows& rows :
       rows_of_bodies(list, laws, bodies, &ContactBody::response, nullptr, in_body_axes)) {
    Part part;
    part.body = rows.body;
    part.thin = rows.response->thin;
    RowMajorSparse own;
    if (part.thin) {
      part.F = part.thin->rows->F;
      part.share = 1 / part.thin->h;
      own = static_rows_of(rows.G, *part.thin->rows);
      part.X.setZero(part.thin->A->rows(), N.rows());
      for (Index j = 0; j < rows.G.rows() && part.X.rows() > 0; ++j)
        for (RowMajorSparse::InnerIterator it(rows.G, j); it; ++it)
          part.X.col(rows.rows[j]) += it.value() * part.thin->A->col(it.col());
    } else {
      part.F = rows.response->block;
      own = rows.G;
    }
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (Index j = 0; j < own.rows(); ++j)
      for (RowMajorSparse::InnerIterator it(own, j); it; ++it)
        entries.emplace_back(rows.rows[j], it.col(), it.value());
    part.H.resize(N.rows(), own.cols());
    part.H.setFromTriplets(entries.begin(), entries.end());
    part.X_of_N.resize(part.X.rows(), N.cols());
    part.F_of_N.resize(part.H.cols(), N.cols());
    parts_.push_back(std::move(part));
  }
}

void StandingResponse::Part::combine(const SparseMatrix& N, const std::vector<Index>& fresh) {
  std::vector<std::vector<RowWeight>> of_fresh;
  for (const Index a : fresh) {
    X_of_N.col(a).setZero();
    F_of_N.col(a).setZero();
    std::vector<RowWeight> rows;
    for (SparseMatrix::InnerIterator it(N, a); it; ++it) {
      rows.push_back({it.row(), it.value()});
      if (X.rows() > 0)
        add_scaled(X.col(it.row()).data(), X.rows(), it.value(), X_of_N.col(a).data());
    }
    of_fresh.push_back(pressed(rows));
  }
  std::vector<double*> columns;
  for (const Index a : fresh) columns.push_back(F_of_N.col(a).data());
  F.add_products(of_fresh, columns);
}

// Forms the responses of combinations that an unknown has a share of for the first time.
void StandingResponse::form_combinations(const Combinations& of) {
  std::vector<Index> fresh;
  for (Index u = 0; u < of.Y.cols(); ++u)
    for (SparseMatrix::InnerIterator it(of.Y, u); it; ++it)
      if (!std::exchange(has_[it.row()], 1)) fresh.push_back(it.row());
  if (fresh.empty()) return;
  std::sort(fresh.begin(), fresh.end());
  const auto k = static_cast<Index>(fresh.size());
  Matrix of_rows = Matrix::Zero(k, N_.rows()), of_N = Matrix::Zero(k, N_.cols());
  for (Part& part : parts_) {
    part.combine(N_, fresh);
    const Matrix by_rows = part.F_of_N(Eigen::all, fresh).transpose();
    for (Index row = 0; row < N_.rows(); ++row)
      for (RowMajorSparse::InnerIterator it(part.H, row); it; ++it)
        add_scaled(by_rows.col(it.col()).data(), k, it.value(), of_rows.col(row).data());
  }
  for (Index a = 0; a < N_.cols(); ++a)
    for (SparseMatrix::InnerIterator it(N_, a); it; ++it)
      add_scaled(of_rows.col(it.row()).data(), k, it.value(), of_N.col(a).data());
  rows_of_N_(fresh, Eigen::all) = of_rows;
  of_N_(fresh, Eigen::all) = of_N;
}

// F H^T / h of column u of A, of which f has 0.
void StandingResponse::Part::fill_statics(const Combinations& of, Index u, double* f) const {
  for (SparseMatrix::InnerIterator it(of.Y, u); it; ++it)
    add_scaled(F_of_N.col(it.row()).data(), H.cols(), it.value(), f);
  std::vector<RowWeight> rows;
  for (SparseMatrix::InnerIterator it(of.Z, u); it; ++it)
    rows.push_back({of.rows[it.row()], it.value()});
  F.add_product(pressed(rows), f);
}

void StandingResponse::Part::take(const Combinations& of, const std::vector<Index>& from,
                                  const std::vector<Index>& mixed,
                                  const std::vector<Index>& mixed_from) {
  single_row.clear();
  single_column.clear();
  single_value.clear();
  for (std::size_t i = 0; i < of.rows.size(); ++i)
    for (RowMajorSparse::InnerIterator it(H, of.rows[i]); it; ++it) {
      single_row.push_back(static_cast<Index>(i));
      single_column.push_back(it.col());
      single_value.push_back(it.value());
    }
  move_columns(from, X.rows(), X_of_A);
  move_columns(mixed_from, H.cols(), F_of_A);
  for (std::size_t u = 0; u < from.size(); ++u) {
    const auto column = static_cast<Index>(u);
    if (from[u] < 0 && X.rows() > 0) {
      double* x = X_of_A.col(column).data();
      for (SparseMatrix::InnerIterator it(of.Y, column); it; ++it)
        add_scaled(X_of_N.col(it.row()).data(), X.rows(), it.value(), x);
      for (SparseMatrix::InnerIterator it(of.Z, column); it; ++it)
        add_scaled(X.col(of.rows[it.row()]).data(), X.rows(), it.value(), x);
    }
    if (mixed[u] >= 0 && mixed_from[mixed[u]] < 0)
      fill_statics(of, column, F_of_A.col(mixed[u]).data());
  }
}

void StandingResponse::take(Combinations of, const std::vector<Index>& from) {
  form_combinations(of);
  std::vector<Index> mixed(from.size(), -1), mixed_from;
  for (std::size_t u = 0; u < from.size(); ++u) {
    if (has_one_row(of, static_cast<Index>(u))) continue;
    mixed[u] = static_cast<Index>(mixed_from.size());
    mixed_from.push_back(from[u] >= 0 ? mixed_[from[u]] : -1);
  }
  for (Part& part : parts_) part.take(of, from, mixed, mixed_from);
  of_ = std::move(of);
  mixed_ = std::move(mixed);
}

// `rows` += H of the statics of column u of A, at the single rows.
void StandingResponse::Part::add_to_rows(const StandingResponse& all, Index u, double* rows) const {
  // moved(e): of entry e of the single rows
  const auto add = [&](const auto& moved, double factor) {
    for (std::size_t e = 0; e < single_row.size(); ++e)
      rows[single_row[e]] += factor * single_value[e] * moved(e);
  };
  const auto add_column = [&](const double* f, double factor) {
    add([f, column = single_column.data()](std::size_t e) { return f[column[e]]; }, factor);
  };
  if (all.is_mixed(u)) return add_column(F_of_A.col(all.mixed_[u]).data(), 1);
  const SparseMatrix::InnerIterator one(all.of_.Z, u);
  const std::vector<RowWeight> pushed = pressed({{all.of_.rows[one.row()], one.value()}});
  if (F.dense() != nullptr) {
    for (const RowWeight& of : pushed) add_column(F.dense()->col(of.row).data(), of.weight);
    return;
  }
  Vector moved = Vector::Zero(static_cast<Index>(single_column.size()));
  F.add_product_at(pushed, single_column, moved);
  add([&](std::size_t e) { return moved[static_cast<Index>(e)]; }, 1);
}

// Columns `some` of A^T G S G^T A.
Matrix StandingResponse::columns(const std::vector<Index>& some) const {
  const Index n = of_.Y.cols();
  const auto n_some = static_cast<Index>(some.size());
  // Displacements of the functions, and of the rows of single points, by residual compliance
  RowMajor of_N = RowMajor::Zero(of_N_.rows(), n_some);
  Matrix by_column = Matrix::Zero(static_cast<Index>(of_.rows.size()), n_some);
  Vector sum(of_N_.rows());
  for (Index k = 0; k < n_some; ++k) {
    const Index u = some[k];
    sum.setZero();
    for (SparseMatrix::InnerIterator it(of_.Y, u); it; ++it)
      add_scaled(of_N_.col(it.row()).data(), sum.size(), it.value(), sum.data());
    for (SparseMatrix::InnerIterator it(of_.Z, u); it; ++it)
      add_scaled(rows_of_N_.col(of_.rows[it.row()]).data(), sum.size(), it.value(), sum.data());
    of_N.col(k) = sum;
    for (const Part& part : parts_) part.add_to_rows(*this, u, by_column.col(k).data());
  }
  const RowMajor of_rows = by_column;
  RowMajor statics = RowMajor::Zero(n, n_some);
  for (Index u = 0; u < n; ++u) {
    for (SparseMatrix::InnerIterator it(of_.Y, u); it; ++it)
      add_scaled(of_N.row(it.row()).data(), n_some, it.value(), statics.row(u).data());
    for (SparseMatrix::InnerIterator it(of_.Z, u); it; ++it)
      add_scaled(of_rows.row(it.row()).data(), n_some, it.value(), statics.row(u).data());
  }
  Matrix columns = statics;
  for (const Part& part : parts_) {
    if (part.X.rows() == 0) continue;
    const Matrix X_of_some = part.X_of_A(Eigen::all, some);
    columns.noalias() += part.X_of_A.leftCols(n).transpose() * part.thin->weighed(X_of_some);
  }
  return columns;
}

Matrix StandingResponse::form(const std::vector<Index>& from, const Matrix* old) const {
  const auto n = static_cast<Index>(from.size());
  std::vector<Index> changed, stays, was;
  for (Index u = 0; u < n; ++u) {
    const Index before = from[u];
    (before < 0 ? changed : stays).push_back(u);
    if (before >= 0) was.push_back(before);
  }
  const auto n_changed = static_cast<Index>(changed.size());
  constexpr Index at_once = 48;  // columns: their rows stay in the cache
  Matrix columns(n, n_changed);
  for (Index k = 0; k < n_changed; k += at_once) {
    const Index end = std::min(k + at_once, n_changed);
    columns.middleCols(k, end - k) = this->columns({changed.begin() + k, changed.begin() + end});
  }
  Matrix W(n, n);
  if (old != nullptr) W(stays, stays) = (*old)(was, was);
  for (Index k = 0; k < n_changed; ++k) {
    const Index j = changed[k];
    W.col(j) = columns.col(k);
    W.row(j) = columns.col(k).transpose();
  }
  // Of two that are new the product has an entry by each
  for (Index k = 0; k < n_changed; ++k)
    for (Index l = k + 1; l < n_changed; ++l) {
      const Index i = changed[k], j = changed[l];
      W(i, j) = W(j, i) = 0.5 * (columns(i, l) + columns(j, k));
    }
  return W;
}

StaticAnswers StandingResponse::statics(const Vector& x) const {
  StaticAnswers answers;
  if (empty()) return answers;
  Vector of_mixed =
      Vector::Zero(std::count_if(mixed_.begin(), mixed_.end(), [](Index i) { return i >= 0; }));
  std::vector<RowWeight> rows;
  for (Index u = 0; u < x.size(); ++u) {
    if (x[u] == 0) continue;
    if (is_mixed(u)) {
      of_mixed[mixed_[u]] = x[u];
    } else {
      const SparseMatrix::InnerIterator one(of_.Z, u);
      rows.push_back({of_.rows[one.row()], x[u] * one.value()});
    }
  }
  for (const Part& part : parts_) {
    if (!part.thin || part.H.cols() == 0) continue;
    answers.body.push_back(part.body);
    Vector still = Vector::Zero(part.H.cols());
    const LargeBlasWork blas = LargeBlasWork::reading(part.F_of_A.size());
    if (of_mixed.size() > 0) still.noalias() += part.F_of_A.leftCols(of_mixed.size()) * of_mixed;
    part.F.add_product(part.pressed(rows), still.data());
    answers.still.push_back(std::move(still));
  }
  return answers;
}

}  // namespace cbr
