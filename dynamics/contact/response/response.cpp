// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response/response.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

// `points`: those with terms of the body, ascending; first: their first rows (first_rows()).
BodyRows rows_of_body(const ContactList& list, const std::vector<PointLaw>& laws,
                      const std::vector<Index>& first, const std::vector<Index>& points, Index body,
                      const NodeResponse& S, bool in_body_axes) {
  BodyRows part;
  part.body = body;
  part.response = &S;
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (const Index i : points) {
    const ContactPoint& point = list.points[i];
    const Matrix3 frame = in_body_axes ? point.frame : Matrix3(point.frame * S.axes);
    for (int d = 0; d < n_rows(laws[i].law); ++d) {
      const std::size_t before = entries.size();
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = list.terms[t];
        if (term.body != body) continue;
        for (int c = 0; c < 3; ++c)
          if (frame(d, c) != 0)
            entries.emplace_back(static_cast<Index>(part.rows.size()), 3 * term.node + c,
                                 term.coefficient * frame(d, c));
      }
      if (entries.size() > before) part.rows.push_back(first[i] + d);
    }
  }
  part.G.resize(static_cast<Index>(part.rows.size()), S.n_dofs());
  part.G.setFromTriplets(entries.begin(), entries.end());
  return part;
}

// The rows of unknowns, A^T G_b, in the place of those of points.
void combine(const SparseMatrix& A, BodyRows& part) {
  std::vector<Eigen::Triplet<double, Index>> own;
  for (std::size_t i = 0; i < part.rows.size(); ++i)
    own.emplace_back(part.rows[i], static_cast<Index>(i), 1.0);
  SparseMatrix place(A.rows(), static_cast<Index>(part.rows.size()));
  place.setFromTriplets(own.begin(), own.end());
  const RowMajorSparse share = A.transpose() * place;
  part.rows.clear();
  std::vector<Eigen::Triplet<double, Index>> filled;
  for (Index u = 0; u < share.rows(); ++u) {
    const std::size_t before = filled.size();
    for (RowMajorSparse::InnerIterator it(share, u); it; ++it)
      filled.emplace_back(static_cast<Index>(part.rows.size()), it.col(), it.value());
    if (filled.size() > before) part.rows.push_back(u);
  }
  RowMajorSparse chosen(static_cast<Index>(part.rows.size()), share.cols());
  chosen.setFromTriplets(filled.begin(), filled.end());
  part.G = RowMajorSparse(chosen * part.G);
}

}  // namespace

std::vector<BodyRows> rows_of_bodies(const ContactList& list, const std::vector<PointLaw>& laws,
                                     const std::vector<ContactBody>& bodies,
                                     NodeResponse ContactBody::*of, const SparseMatrix* A,
                                     bool in_body_axes) {
  std::vector<std::pair<Index, Index>> meet;  // body, point
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const std::pair<Index, Index> of_term{list.terms[t].body, static_cast<Index>(i)};
      if (meet.empty() || meet.back() != of_term) meet.push_back(of_term);
    }
  }
  sort_uniquely(meet);
  const std::vector<Index> first = first_rows(laws);
  std::vector<BodyRows> parts;
  std::vector<Index> points;
  for (std::size_t i = 0; i < meet.size();) {
    const Index body = meet[i].first;
    points.clear();
    for (; i < meet.size() && meet[i].first == body; ++i) points.push_back(meet[i].second);
    parts.push_back(rows_of_body(list, laws, first, points, body, bodies[body].*of, in_body_axes));
    if (A != nullptr) combine(*A, parts.back());
  }
  return parts;
}

RowMajorSparse static_rows_of(const RowMajorSparse& G, const StaticRows& rows) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index j = 0; j < G.rows(); ++j)
    for (RowMajorSparse::InnerIterator it(G, j); it; ++it) {
      const Index node = it.col() / 3, c = it.col() % 3;
      for (Index i = rows.first[node]; i < rows.first[node + 1]; ++i)
        if (rows.direction(i, c) != 0)
          entries.emplace_back(j, i, it.value() * rows.direction(i, c));
    }
  RowMajorSparse H(G.rows(), rows.size());
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

namespace {

// From so many entries on a second thread gains more than it costs.
constexpr Index threaded_entries = 200 * 200;

// The lower triangle of W(at, at) += share G_b S_b G_b^T; `at` ascends. Threads take groups of
// columns in turn.
void add_dense_block(const RowMajorSparse& G, const StaticCompliance& S, double share,
                     const std::vector<Index>& at, Matrix& W) {
  const Index r = G.rows(), s = S.size();
  constexpr Index group = 32;
  const int used = r * r < threaded_entries ? 1 : n_threads();
  run_kept_threads(used, [&](int thread) {
    Matrix moved(s, group);  // columns of S_b G_b^T   (3 m_b x r)
    std::vector<std::vector<RowWeight>> pushed;
    std::vector<double*> columns;
    for (Index first = group * thread; first < r; first += group * used) {
      const Index n = std::min(group, r - first);
      pushed.assign(static_cast<std::size_t>(n), {});
      columns.clear();
      for (Index k = 0; k < n; ++k) {
        for (RowMajorSparse::InnerIterator it(G, first + k); it; ++it)
          pushed[k].push_back({it.col(), share * it.value()});
        columns.push_back(moved.col(k).data());
      }
      moved.setZero();
      S.add_products(pushed, columns);
      for (Index k = 0; k < n; ++k) {
        double* column = W.col(at[first + k]).data();
        const double* move = moved.col(k).data();
        for (Index i = first + k; i < r; ++i) {
          double sum = 0;
          for (RowMajorSparse::InnerIterator it(G, i); it; ++it) sum += it.value() * move[it.col()];
          column[at[i]] += sum;
        }
      }
    }
  });
}

// The same of modes and static rows. X = A G_b^T (n x r), H = G_b B (r x s), of a few entries in
// each row:
//   X^T C X + H F H^T / h   (r x r)
void add_thin_block(const RowMajorSparse& G, const ThinResponse& S, const std::vector<Index>& at,
                    Matrix& W) {
  const Index r = G.rows();
  Matrix X = Matrix::Zero(S.A->rows(), r);
  for (Index j = 0; j < r; ++j)
    for (RowMajorSparse::InnerIterator it(G, j); it; ++it)
      X.col(j) += it.value() * S.A->col(it.col());
  add_dense_block(static_rows_of(G, *S.rows), S.rows->F, 1 / S.h, at, W);
  if (X.rows() == 0) return;
  // By panels of columns, from the diagonal on
  constexpr Index width = 128;
  const Matrix CX = S.weighed(X);
  Matrix panel;
  for (Index j = 0; j < r; j += width) {
    const Index n = std::min(width, r - j);
    panel.noalias() = X.rightCols(r - j).transpose() * CX.middleCols(j, n);
    for (Index k = 0; k < n; ++k)
      for (Index i = j + k; i < r; ++i) W(at[i], at[j + k]) += panel(i - j, k);
  }
}

// The lower triangle of W(at, at) += G_b S_b G_b^T of a body that does not answer node by node,
// over its rows.
void add_block(const BodyRows& part, const std::vector<Index>& at, Matrix& W) {
  if (part.response->thin) {
    add_thin_block(part.G, *part.response->thin, at, W);
  } else {
    add_dense_block(part.G, part.response->block, 1, at, W);
  }
}

// G_b S_b G_b^T   (r x r)
SparseMatrix sparse_block(const BodyRows& part) {
  const Index r = part.G.rows();
  if (part.response->is_diagonal()) {
    const RowMajorSparse GS = part.G * part.response->diagonal.asDiagonal();
    return GS * part.G.transpose();
  }
  std::vector<Index> at = first_numbers(part.rows.size());
  Matrix block = Matrix::Zero(r, r);
  add_block(part, at, block);
  mirror_lower(block);
  SparseMatrix W(r, r);
  W.resizeNonZeros(r * r);
  for (Index j = 0; j <= r; ++j) W.outerIndexPtr()[j] = j * r;
  for (Index j = 0; j < r; ++j)
    std::iota(W.innerIndexPtr() + j * r, W.innerIndexPtr() + (j + 1) * r, Index{0});
  Eigen::Map<Matrix>(W.valuePtr(), r, r) = block;
  return W;
}

// The sum of all blocks at their rows   (m x m). Column by column, so that the work grows with the
// entries and not with the bodies times the entries.
SparseMatrix sum_of_blocks(const std::vector<BodyRows>& parts, Index m) {
  std::vector<SparseMatrix> blocks;
  std::vector<std::vector<std::pair<std::size_t, Index>>> of_column(static_cast<std::size_t>(m));
  Index most = 0;
  for (const BodyRows& part : parts) {
    for (std::size_t j = 0; j < part.rows.size(); ++j)
      of_column[part.rows[j]].emplace_back(blocks.size(), static_cast<Index>(j));
    blocks.push_back(sparse_block(part));
    most += blocks.back().nonZeros();
  }
  SparseMatrix W(m, m);
  W.resizeNonZeros(most);
  std::vector<std::pair<Index, double>> entries;
  Index end = 0;
  for (Index column = 0; column < m; ++column) {
    entries.clear();
    for (const auto& [b, j] : of_column[column])
      for (SparseMatrix::InnerIterator it(blocks[b], j); it; ++it)
        entries.emplace_back(parts[b].rows[it.row()], it.value());
    // Stable: what several bodies give is summed up in the order of the bodies
    if (of_column[column].size() > 1)
      std::stable_sort(entries.begin(), entries.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
    W.outerIndexPtr()[column] = end;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto& [row, value] = entries[i];
      if (i > 0 && row == entries[i - 1].first) {
        W.valuePtr()[end - 1] += value;
        continue;
      }
      W.innerIndexPtr()[end] = row;
      W.valuePtr()[end++] = value;
    }
  }
  W.outerIndexPtr()[m] = end;
  W.resizeNonZeros(end);
  return W;
}

// Many rows of which few answer to each other: lumped meshes, or many bodies in a chain.
bool is_sparse(const std::vector<BodyRows>& bodies, Index m) {
  double filled = 0;
  for (const BodyRows& body : bodies)
    if (!body.response->is_diagonal())
      filled += static_cast<double>(body.rows.size()) * static_cast<double>(body.rows.size());
  return m > 300 && filled < 0.25 * static_cast<double>(m) * static_cast<double>(m);
}

}  // namespace

bool all_finite(const GapResponse& W) {
  const auto is_finite = [](const auto& x) { return (0 * x.array()).sum() == 0; };  // in lanes
  if (!W.is_sparse) return is_finite(W.dense);
  return is_finite(Eigen::Map<const Vector>(W.sparse.valuePtr(), W.sparse.nonZeros()));
}

Vector apply(const GapResponse& W, const Vector& p) {
  if (W.is_sparse) return W.sparse * p;
  return W.dense * p;
}

std::vector<Index> first_rows(const std::vector<PointLaw>& laws) {
  std::vector<Index> first(laws.size() + 1, 0);
  for (std::size_t i = 0; i < laws.size(); ++i) first[i + 1] = first[i] + n_rows(laws[i].law);
  return first;
}

GapResponse gap_response(const ContactList& list, const std::vector<PointLaw>& laws,
                         const std::vector<ContactBody>& bodies, NodeResponse ContactBody::*of,
                         const SparseMatrix* A) {
  const Index m = A != nullptr ? A->cols() : first_rows(laws).back();
  const std::vector<BodyRows> parts = rows_of_bodies(list, laws, bodies, of, A);
  GapResponse W;
  W.is_sparse = is_sparse(parts, m);
  if (W.is_sparse) {
    W.sparse = sum_of_blocks(parts, m);
    return W;
  }
  W.dense.setZero(m, m);
  for (const BodyRows& part : parts) {
    if (part.response->is_diagonal()) {
      const SparseMatrix block = sparse_block(part);
      for (Index j = 0; j < block.cols(); ++j)
        for (SparseMatrix::InnerIterator it(block, j); it; ++it)
          W.dense(part.rows[it.row()], part.rows[j]) += it.value();
    } else {
      add_block(part, part.rows, W.dense);
    }
  }
  mirror_lower(W.dense);
  return W;
}

void spread_impulses(const ContactList& list, const std::vector<PointLaw>& laws, const Points& p,
                     std::vector<ContactBody>& bodies) {
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    const auto of = p.row(static_cast<Index>(i));
    if (of.isZero(0)) continue;
    const bool tied = laws[i].law == ContactLaw::tied;
    const Vector3 normal =
        tied ? Vector3(point.frame.transpose() * of.transpose()) : Vector3(of[0] * point.normal());
    const Vector3 tangential = point.frame.bottomRows<2>().transpose() * of.tail<2>().transpose();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      bodies[term.body].impulses.row(term.node) += term.coefficient * normal.transpose();
      if (laws[i].law == ContactLaw::coulomb)
        bodies[term.body].friction.row(term.node) += term.coefficient * tangential.transpose();
    }
  }
}

bool same_rows(const ContactList& a, const ContactList& b, const std::vector<PointLaw>& laws,
               double tolerance) {
  if (a.points.size() != b.points.size() || a.terms.size() != b.terms.size()) return false;
  for (std::size_t t = 0; t < a.terms.size(); ++t) {
    const ContactTerm &x = a.terms[t], &y = b.terms[t];
    if (x.body != y.body || x.node != y.node || std::abs(x.coefficient - y.coefficient) > tolerance)
      return false;
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const ContactPoint &x = a.points[i], &y = b.points[i];
    const Index n = n_rows(laws[i].law);
    if (x.n_terms != y.n_terms || (x.frame - y.frame).topRows(n).cwiseAbs().maxCoeff() > tolerance)
      return false;
  }
  return true;
}

}  // namespace cbr
