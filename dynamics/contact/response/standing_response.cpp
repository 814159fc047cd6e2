// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response/standing_response.hpp"

#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/response/body_rows.hpp"

namespace cbr {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void add_scaled(const double* from, Index n, double factor, double* to) {
  Eigen::Map<Vector>(to, n) += factor * Eigen::Map<const Vector>(from, n);
}

// Columns of `all` go where they are from now on; others are 0. Those that stay keep their order,
// so that none is written over before it has been read.
void move_columns(const std::vector<Index>& from, Index rows, Matrix& all) {
  const auto n = static_cast<Index>(from.size());
  if (all.cols() < n) all.conservativeResize(rows, n + n / 2);
  const auto move = [&](Index to) { all.col(to) = all.col(from[static_cast<std::size_t>(to)]); };
  for (Index to = 0; to < n; ++to)
    if (from[static_cast<std::size_t>(to)] > to) move(to);
  for (Index to = n; to-- > 0;)
    if (const Index old = from[static_cast<std::size_t>(to)]; old >= 0 && old < to) move(to);
  for (Index to = 0; to < n; ++to)
    if (from[static_cast<std::size_t>(to)] < 0) all.col(to).setZero();
}

bool has_one_row(const Combinations& of, Index u) {
  SparseMatrix::InnerIterator share(of.Y, u), row(of.Z, u);
  return !share && row && !++row;
}

}  // namespace

// What one row of the points gets as a unit impulse.
void StandingResponse::Part::add_row(Index row, double factor, double* x, double* f) const {
  if (x != nullptr && X.rows() > 0) add_scaled(X.col(row).data(), X.rows(), factor, x);
  for (RowMajorSparse::InnerIterator it(H, row); it; ++it)
    add_scaled(F->col(it.col()).data(), F->rows(), factor * share * it.value(), f);
}

void StandingResponse::start(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<ContactBody>& bodies, const SparseMatrix& N) {
  parts_.clear();
  const RowMajorSparse by_rows = N;  // a column of F serves all functions while it is in the cache
  for (const BodyRows& rows : rows_of_bodies(list, laws, bodies, &ContactBody::response, nullptr)) {
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
          part.X.col(rows.rows[static_cast<std::size_t>(j)]) +=
              it.value() * part.thin->A->col(it.col());
    } else {
      part.F = rows.response->block;
      own = rows.G;
    }
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (Index j = 0; j < own.rows(); ++j)
      for (RowMajorSparse::InnerIterator it(own, j); it; ++it)
        entries.emplace_back(rows.rows[static_cast<std::size_t>(j)], it.col(), it.value());
    part.H.resize(N.rows(), own.cols());
    part.H.setFromTriplets(entries.begin(), entries.end());
    part.X_of_N.setZero(part.X.rows(), N.cols());
    part.F_of_N.setZero(part.H.cols(), N.cols());
    for (Index row = 0; row < by_rows.rows(); ++row)
      for (RowMajorSparse::InnerIterator it(by_rows, row); it; ++it)
        part.add_row(row, it.value(), part.X_of_N.col(it.col()).data(),
                     part.F_of_N.col(it.col()).data());
    parts_.push_back(std::move(part));
  }
}

void StandingResponse::Part::add_statics(const Combinations& of, Index u, double factor,
                                         double* f) const {
  for (SparseMatrix::InnerIterator it(of.Y, u); it; ++it)
    add_scaled(F_of_N.col(it.row()).data(), H.cols(), factor * it.value(), f);
  for (SparseMatrix::InnerIterator it(of.Z, u); it; ++it)
    add_row(of.rows[static_cast<std::size_t>(it.row())], factor * it.value(), nullptr, f);
}

void StandingResponse::Part::take(const Combinations& of, const std::vector<Index>& from,
                                  const std::vector<Index>& mixed,
                                  const std::vector<Index>& mixed_from) {
  move_columns(from, X.rows(), X_of_A);
  move_columns(mixed_from, H.cols(), F_of_A);
  for (std::size_t u = 0; u < from.size(); ++u) {
    const auto column = static_cast<Index>(u);
    if (from[u] < 0 && X.rows() > 0) {
      double* x = X_of_A.col(column).data();
      for (SparseMatrix::InnerIterator it(of.Y, column); it; ++it)
        add_scaled(X_of_N.col(it.row()).data(), X.rows(), it.value(), x);
      for (SparseMatrix::InnerIterator it(of.Z, column); it; ++it)
        add_scaled(X.col(of.rows[static_cast<std::size_t>(it.row())]).data(), X.rows(), it.value(),
                   x);
    }
    if (mixed[u] >= 0 && mixed_from[static_cast<std::size_t>(mixed[u])] < 0)
      add_statics(of, column, 1, F_of_A.col(mixed[u]).data());
  }
}

void StandingResponse::take(Combinations of, const std::vector<Index>& from) {
  std::vector<Index> mixed(from.size(), -1), mixed_from;
  for (std::size_t u = 0; u < from.size(); ++u) {
    if (has_one_row(of, static_cast<Index>(u))) continue;
    mixed[u] = static_cast<Index>(mixed_from.size());
    mixed_from.push_back(from[u] >= 0 ? mixed_[static_cast<std::size_t>(from[u])] : -1);
  }
  for (Part& part : parts_) part.take(of, from, mixed, mixed_from);
  of_ = std::move(of);
  mixed_ = std::move(mixed);
}

Matrix StandingResponse::form(const SparseMatrix& A, const std::vector<Index>& from,
                              const Matrix* old) const {
  const Index n = A.cols();
  std::vector<Index> changed;
  for (Index u = 0; u < n; ++u)
    if (from[static_cast<std::size_t>(u)] < 0) changed.push_back(u);
  const auto n_changed = static_cast<Index>(changed.size());
  // Of the points' rows
  RowMajor answers = RowMajor::Zero(A.rows(), n_changed), statics;
  Matrix columns = Matrix::Zero(n, n_changed);
  Vector one;
  for (const Part& part : parts_) {
    statics.resize(part.H.cols(), n_changed);
    for (Index k = 0; k < n_changed; ++k) {
      const Index u = changed[static_cast<std::size_t>(k)];
      if (is_mixed(u)) {
        statics.col(k) = part.F_of_A.col(mixed_[static_cast<std::size_t>(u)]);
        continue;
      }
      one.setZero(part.H.cols());
      part.add_statics(of_, u, 1, one.data());
      statics.col(k) = one;
    }
    for (Index row = 0; row < A.rows(); ++row)
      for (RowMajorSparse::InnerIterator it(part.H, row); it; ++it)
        add_scaled(statics.row(it.col()).data(), n_changed, it.value(), answers.row(row).data());
    if (part.X.rows() == 0) continue;
    const Matrix X_of_changed = part.X_of_A(Eigen::all, changed);
    columns.noalias() += part.X_of_A.leftCols(n).transpose() * part.thin->weighed(X_of_changed);
  }
  Vector sum(n_changed);
  for (Index u = 0; u < n; ++u) {
    sum.setZero();
    for (SparseMatrix::InnerIterator it(A, u); it; ++it)
      add_scaled(answers.row(it.row()).data(), n_changed, it.value(), sum.data());
    columns.row(u) += sum.transpose();
  }
  Matrix W(n, n);
  for (Index j = 0; j < n && old != nullptr; ++j) {
    const Index before = from[static_cast<std::size_t>(j)];
    for (Index i = 0; before >= 0 && i < n; ++i)
      if (from[static_cast<std::size_t>(i)] >= 0)
        W(i, j) = (*old)(from[static_cast<std::size_t>(i)], before);
  }
  for (Index k = 0; k < n_changed; ++k) {
    const Index j = changed[static_cast<std::size_t>(k)];
    W.col(j) = columns.col(k);
    W.row(j) = columns.col(k).transpose();
  }
  // Of two that are new the product has an entry by each
  for (Index k = 0; k < n_changed; ++k)
    for (Index l = k + 1; l < n_changed; ++l) {
      const Index i = changed[static_cast<std::size_t>(k)],
                  j = changed[static_cast<std::size_t>(l)];
      W(i, j) = W(j, i) = 0.5 * (columns(i, l) + columns(j, k));
    }
  return W;
}

StaticAnswers StandingResponse::statics(const Vector& x) const {
  StaticAnswers answers;
  for (const Part& part : parts_) {
    if (!part.thin || part.H.cols() == 0) continue;
    answers.body.push_back(part.body);
    Vector still = Vector::Zero(part.H.cols());
    for (Index u = 0; u < x.size(); ++u) {
      if (x[u] == 0) continue;
      if (is_mixed(u)) {
        add_scaled(part.F_of_A.col(mixed_[static_cast<std::size_t>(u)]).data(), still.size(), x[u],
                   still.data());
      } else {
        part.add_statics(of_, u, x[u], still.data());
      }
    }
    answers.still.push_back(std::move(still));
  }
  return answers;
}

}  // namespace cbr
