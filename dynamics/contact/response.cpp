// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response.hpp"

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

// The columns of G that belong to a body, as triplets per row: G_b   (m x 3 m_b)
using RowMajorSparse = Eigen::SparseMatrix<double, Eigen::RowMajor, Index>;

RowMajorSparse rows_of_body(const ContactList& list, const std::vector<PointLaw>& laws, Index m, Index body, Index n_nodes) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index row = 0;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    for (int d = 0; d < n_rows(laws[i].law); ++d, ++row) {
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = list.terms[t];
        if (term.body != body) continue;
        for (int c = 0; c < 3; ++c)
          if (point.frame(d, c) != 0) entries.emplace_back(row, 3 * term.node + c, term.coefficient * point.frame(d, c));
      }
    }
  }
  RowMajorSparse G(m, 3 * n_nodes);
  G.setFromTriplets(entries.begin(), entries.end());
  return G;
}

// W += G_b S_b G_b^T, with S_b read once.
void add_dense(const RowMajorSparse& G, const Matrix& S, Matrix& W) {
  // Only columns that G uses are formed: T = G_b S_b   (m x 3 m_b)
  std::vector<char> used(S.cols(), 0);
  for (Index i = 0; i < G.nonZeros(); ++i) used[G.innerIndexPtr()[i]] = 1;
  Matrix T(G.rows(), S.cols());
  for (Index c = 0; c < S.cols(); ++c)
    if (used[c]) T.col(c).noalias() = G * S.col(c);
  for (Index row = 0; row < G.rows(); ++row)
    for (RowMajorSparse::InnerIterator it(G, row); it; ++it) W.col(row) += it.value() * T.col(it.col());
}

}  // namespace

Vector apply(const GapResponse& W, const Vector& p) {
  if (W.is_sparse) return W.sparse * p;
  return W.dense * p;
}

std::vector<Index> first_rows(const std::vector<PointLaw>& laws) {
  std::vector<Index> first(laws.size() + 1, 0);
  for (std::size_t i = 0; i < laws.size(); ++i) first[i + 1] = first[i] + n_rows(laws[i].law);
  return first;
}

GapResponse gap_response(const ContactList& list, const std::vector<PointLaw>& laws, const std::vector<ContactBody>& bodies) {
  const Index m = first_rows(laws).back();
  std::vector<Index> used;
  for (const ContactTerm& term : list.terms)
    if (used.empty() || used.back() != term.body) used.push_back(term.body);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  GapResponse W;
  W.is_sparse = m > 300;
  for (const Index b : used) W.is_sparse &= bodies[b].response.is_diagonal();
  if (W.is_sparse) {
    W.sparse.resize(m, m);
  } else {
    W.dense.setZero(m, m);
  }
  for (const Index b : used) {
    const NodeResponse& S = bodies[b].response;
    const Index n_nodes = (S.is_diagonal() ? S.diagonal.size() : S.dense.rows()) / 3;
    const RowMajorSparse G = rows_of_body(list, laws, m, b, n_nodes);
    if (!S.is_diagonal()) {
      add_dense(G, S.dense, W.dense);
      continue;
    }
    const RowMajorSparse GS = G * S.diagonal.asDiagonal();
    const SparseMatrix GSG = GS * G.transpose();
    if (W.is_sparse) {
      W.sparse += GSG;
    } else {
      W.dense += GSG;
    }
  }
  return W;
}

void spread_impulses(const ContactList& list, const std::vector<PointLaw>& laws, const Points& p,
                     std::vector<ContactBody>& bodies) {
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    const auto of = p.row(static_cast<Index>(i));
    if (of.isZero(0)) continue;
    const bool tied = laws[i].law == ContactLaw::tied;
    const Vector3 normal = tied ? Vector3(point.frame.transpose() * of.transpose()) : Vector3(of[0] * point.normal());
    const Vector3 tangential = point.frame.bottomRows<2>().transpose() * of.tail<2>().transpose();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      bodies[term.body].impulses.row(term.node) += term.coefficient * normal.transpose();
      if (laws[i].law == ContactLaw::coulomb)
        bodies[term.body].friction.row(term.node) += term.coefficient * tangential.transpose();
    }
  }
}

bool same_rows(const ContactList& a, const ContactList& b, const std::vector<PointLaw>& laws, double tolerance) {
  if (a.points.size() != b.points.size() || a.terms.size() != b.terms.size()) return false;
  for (std::size_t t = 0; t < a.terms.size(); ++t) {
    const ContactTerm &x = a.terms[t], &y = b.terms[t];
    if (x.body != y.body || x.node != y.node || std::abs(x.coefficient - y.coefficient) > tolerance) return false;
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const ContactPoint &x = a.points[i], &y = b.points[i];
    const Index n = n_rows(laws[i].law);
    if (x.n_terms != y.n_terms || (x.frame - y.frame).topRows(n).cwiseAbs().maxCoeff() > tolerance) return false;
  }
  return true;
}

}  // namespace cbr
