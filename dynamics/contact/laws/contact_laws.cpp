// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/contact_laws.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

// Of the largest of a point's rows: below it an entry is round-off of a direction in which supports
// hold both sides.
constexpr double held = 1e-12;

}  // namespace

ContactProblem contact_problem(GapResponse W, std::vector<PointLaw> laws) {
  ContactProblem problem;
  problem.W = std::move(W);
  problem.laws = std::move(laws);
  problem.first = first_rows(problem.laws);
  problem.diagonal = problem.W.is_sparse ? Vector(problem.W.sparse.diagonal())
                                         : Vector(problem.W.dense.diagonal());
  problem.w.resize(problem.n_points());
  for (Index i = 0; i < problem.n_points(); ++i) {
    auto rows = problem.diagonal.segment(problem.first[i], n_rows(problem.laws[i].law));
    problem.w[i] = std::max(0.0, rows.maxCoeff());
    for (double& of_row : rows)
      if (of_row <= held * problem.w[i]) of_row = 0;
  }
  return problem;
}

Matrix3 point_block(const ContactProblem& problem, Index point) {
  const Index row = problem.first[point], n = n_rows(problem.laws[point].law);
  Matrix3 block = Matrix3::Zero();
  if (!problem.W.is_sparse) {
    block.topLeftCorner(n, n) = problem.W.dense.block(row, row, n, n);
    return block;
  }
  for (Index d = 0; d < n; ++d)
    for (SparseMatrix::InnerIterator it(problem.W.sparse, row + d); it; ++it)
      if (it.row() >= row && it.row() < row + n) block(it.row() - row, d) = it.value();
  return block;
}

Vector respond(const ContactProblem& problem, const Vector& p) {
  if (problem.W.is_sparse) return problem.W.sparse * p;
  std::vector<Index> pushed;
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != 0) pushed.push_back(j);
  if (2 * static_cast<Index>(pushed.size()) > p.size())
    return symmetric_product(problem.W.dense, p);
  Matrix y = Matrix::Zero(p.size(), 1);
  add_columns(problem.W.dense, pushed, p, y, 1);
  return y.col(0);
}

void add_response(const ContactProblem& problem, Index point, const double* change, Vector& y) {
  const Index row = problem.first[point], n = n_rows(problem.laws[point].law);
  if (!problem.W.is_sparse && n == 3) {
    y += problem.W.dense.col(row) * change[0] + problem.W.dense.col(row + 1) * change[1] +
         problem.W.dense.col(row + 2) * change[2];
    return;
  }
  for (Index d = 0; d < n; ++d) {
    if (problem.W.is_sparse) {
      y += change[d] * problem.W.sparse.col(row + d);
    } else {
      y += change[d] * problem.W.dense.col(row + d);
    }
  }
}

void project(const ContactProblem& problem, Vector& p) {
  for (Index i = 0; i < problem.n_points(); ++i) {
    const PointLaw& law = problem.laws[i];
    const Index row = problem.first[i];
    if (law.law == ContactLaw::tied) continue;
    p[row] = std::max(0.0, p[row]);
    if (law.law != ContactLaw::coulomb) continue;
    const double length = length_of(p[row + 1], p[row + 2]), limit = law.friction * p[row];
    if (length > limit) p.segment<2>(row + 1) *= limit / length;
  }
}

Vector law_violations(const ContactProblem& problem, const Vector& p, const Vector& gap) {
  Vector violation(problem.n_points());
  for (Index i = 0; i < problem.n_points(); ++i) {
    const PointLaw& law = problem.laws[i];
    const Index row = problem.first[i];
    const double w = problem.w[i];
    if (law.law == ContactLaw::tied) {
      violation[i] = length_of(gap[row], length_of(gap[row + 1], gap[row + 2]));
      continue;
    }
    violation[i] = w > 0 ? std::abs(std::min(w * p[row], gap[row])) : std::max(0.0, -gap[row]);
    if (law.law != ContactLaw::coulomb || !(w > 0)) continue;
    // open: no friction, whatever the slip
    if (p[row] <= 0 && p[row + 1] == 0 && p[row + 2] == 0) continue;
    const double limit = law.friction * std::max(0.0, p[row]);
    Eigen::Vector2d target = p.segment<2>(row + 1) - gap.segment<2>(row + 1) / w;
    const double length = length_of(target[0], target[1]);
    if (length > limit) target *= limit / length;
    violation[i] = length_of(violation[i],
                             length_of(w * (p[row + 1] - target[0]), w * (p[row + 2] - target[1])));
  }
  for (double& of : violation)
    if (std::isnan(of)) of = HUGE_VAL;  // beyond a double's reach; norms may leave a NaN out
  return violation;
}

double gap_round_off(const ContactProblem& problem, const Vector& p) {
  // |W_ij| <= sqrt(W_ii W_jj)
  const Vector root = problem.diagonal.cwiseMax(0).cwiseSqrt();
  return root.size() > 0 ? 1e-15 * root.maxCoeff() * root.cwiseProduct(p).lpNorm<Eigen::Infinity>()
                         : 0.0;
}

}  // namespace cbr
