// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cbr {
namespace {

// The part of a row of G on one body: up to five nodes (a body may touch itself), coefficient times normal.
struct BodyRow {
  Index constraint = 0;
  int n = 0;
  std::array<Index, 5> node{};
  std::array<double, 5> coefficient{};
  Vector3 normal;
};

void add_node(BodyRow& row, Index node, double coefficient) {
  if (coefficient == 0) return;
  row.node[row.n] = node;
  row.coefficient[row.n++] = coefficient;
}

std::vector<BodyRow> rows_of_body(const std::vector<Constraint>& constraints, Index body) {
  std::vector<BodyRow> rows;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& c = constraints[i];
    BodyRow row;
    row.constraint = static_cast<Index>(i);
    row.normal = c.normal;
    if (c.slave_body == body) add_node(row, c.slave, 1);
    if (c.master_body == body)
      for (int a = 0; a < 4; ++a) add_node(row, c.masters[a], -c.weights[a]);
    if (row.n > 0) rows.push_back(row);
  }
  return rows;
}

// W += G_b S_b G_b^T
void add_dense(const std::vector<BodyRow>& rows, const Matrix& S, Matrix& W) {
  const Index m = static_cast<Index>(rows.size());
  Matrix SG(S.rows(), m);  // S_b G_b^T   (3 m_b x m)
  for (Index j = 0; j < m; ++j) {
    const BodyRow& row = rows[j];
    SG.col(j).setZero();
    for (int a = 0; a < row.n; ++a)
      for (int c = 0; c < 3; ++c)
        if (row.normal[c] != 0) SG.col(j) += row.coefficient[a] * row.normal[c] * S.col(3 * row.node[a] + c);
  }
  for (Index j = 0; j < m; ++j) {
    for (Index i = j; i < m; ++i) {
      const BodyRow& row = rows[i];
      double sum = 0;
      for (int a = 0; a < row.n; ++a) sum += row.coefficient[a] * row.normal.dot(SG.col(j).segment<3>(3 * row.node[a]));
      W(row.constraint, rows[j].constraint) += sum;
      if (i != j) W(rows[j].constraint, row.constraint) += sum;
    }
  }
}

SparseMatrix sparse_rows(const std::vector<BodyRow>& rows, Index m, Index n_nodes) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (const BodyRow& row : rows)
    for (int a = 0; a < row.n; ++a)
      for (int c = 0; c < 3; ++c) entries.emplace_back(row.constraint, 3 * row.node[a] + c, row.coefficient[a] * row.normal[c]);
  SparseMatrix G(m, 3 * n_nodes);
  G.setFromTriplets(entries.begin(), entries.end());
  return G;
}

}  // namespace

GapResponse gap_response(const std::vector<Constraint>& constraints, const std::vector<ContactBody>& bodies) {
  const Index m = static_cast<Index>(constraints.size());
  std::vector<Index> used;
  for (const Constraint& c : constraints) used.push_back(c.slave_body), used.push_back(c.master_body);
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
    const auto rows = rows_of_body(constraints, b);
    const NodeResponse& S = bodies[b].response;
    if (!S.is_diagonal()) {
      add_dense(rows, S.dense, W.dense);
      continue;
    }
    const SparseMatrix G = sparse_rows(rows, m, S.diagonal.size() / 3);
    const SparseMatrix GSG = G * S.diagonal.asDiagonal() * SparseMatrix(G.transpose());
    if (W.is_sparse) {
      W.sparse += GSG;
    } else {
      W.dense += Matrix(GSG);
    }
  }
  return W;
}

Vector apply(const GapResponse& W, const Vector& p) {
  if (W.is_sparse) return W.sparse * p;
  return W.dense * p;
}

void spread_impulses(const std::vector<Constraint>& constraints, const Vector& p, std::vector<ContactBody>& bodies) {
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    if (p[i] == 0) continue;
    const Constraint& c = constraints[i];
    bodies[c.slave_body].impulses.row(c.slave) += p[i] * c.normal.transpose();
    for (int a = 0; a < 4; ++a)
      if (c.weights[a] != 0) bodies[c.master_body].impulses.row(c.masters[a]) -= p[i] * c.weights[a] * c.normal.transpose();
  }
}

bool same_rows(const std::vector<Constraint>& a, const std::vector<Constraint>& b, double tolerance) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Constraint &x = a[i], &y = b[i];
    if (x.slave_body != y.slave_body || x.slave != y.slave || x.master_body != y.master_body || x.masters != y.masters)
      return false;
    if ((x.normal - y.normal).cwiseAbs().maxCoeff() > tolerance) return false;
    for (int k = 0; k < 4; ++k)
      if (std::abs(x.weights[k] - y.weights[k]) > tolerance) return false;
  }
  return true;
}

}  // namespace cbr
