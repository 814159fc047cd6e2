// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/cone_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

constexpr double weakest_pivot = 1e-13;  // of a unit diagonal

// A = L L^T   (m x r), A symmetric positive semi-definite; false when r passes `most`.
bool pivoted_cholesky(const Matrix& A, Index most, Matrix& L) {
  const Index m = A.rows();
  Vector left = A.diagonal();  // of A - L L^T
  L.resize(m, std::min(most, m));
  for (Index r = 0; r < m; ++r) {
    Index pivot = 0;
    const double largest = left.maxCoeff(&pivot);
    if (!(largest > weakest_pivot)) {
      L.conservativeResize(Eigen::NoChange, r);
      return true;
    }
    if (r == most) return false;
    L.col(r) = (A.col(pivot) - L.leftCols(r) * L.row(pivot).head(r).transpose()) / std::sqrt(largest);
    left -= L.col(r).cwiseAbs2();
    left[pivot] = -1;
  }
  return true;
}

}  // namespace

ConeProblem cone_problem(const ContactProblem& problem, Index most_columns) {
  const Index n = problem.n_points();
  ConeProblem cones;
  cones.scale.resize(n), cones.friction.resize(n), cones.tied.resize(n), cones.moves.resize(n);
  Vector row_scale(problem.n_rows());
  for (Index i = 0; i < n; ++i) {
    const PointLaw& law = problem.laws[i];
    cones.moves[i] = problem.w[i] > 0;
    cones.scale[i] = cones.moves[i] ? 1 / std::sqrt(problem.w[i]) : 0.0;
    cones.friction[i] = law.law == ContactLaw::coulomb ? law.friction : 1.0;
    cones.tied[i] = law.law == ContactLaw::tied;
    row_scale.segment(problem.first[i], n_rows(law.law)).setConstant(cones.scale[i]);
  }
  Matrix rows;
  if (!pivoted_cholesky(row_scale.asDiagonal() * problem.W.dense * row_scale.asDiagonal(), most_columns, rows)) {
    cones.L.resize(3 * n, 0);
    return cones;
  }
  cones.L.setZero(3 * n, rows.cols());
  for (Index i = 0; i < n; ++i)
    cones.L.middleRows(3 * i, n_rows(problem.laws[i].law)) = rows.middleRows(problem.first[i], n_rows(problem.laws[i].law));
  return cones;
}

ConeGaps cone_gaps(const ContactProblem& problem, const ConeProblem& cones, const Vector& g) {
  ConeGaps gaps;
  gaps.g.setZero(cones.n_points(), 3);
  gaps.weight.setZero(cones.n_points());
  for (Index i = 0; i < cones.n_points(); ++i)
    for (Index d = 0; d < n_rows(problem.laws[i].law); ++d) gaps.g(i, d) = cones.scale[i] * g[problem.first[i] + d];
  const double largest = gaps.g.cwiseAbs().maxCoeff();
  gaps.unit = largest > 0 ? largest : 1.0;
  gaps.g /= gaps.unit;
  for (Index i = 0; i < cones.n_points(); ++i)
    if (cones.moves[i] != 0) gaps.weight[i] = gaps.unit / cones.scale[i] / g.lpNorm<Eigen::Infinity>();
  return gaps;
}

Vector unscaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps, const Points& p) {
  Vector result(problem.n_rows());
  for (Index i = 0; i < cones.n_points(); ++i)
    for (Index d = 0; d < n_rows(problem.laws[i].law); ++d) result[problem.first[i] + d] = gaps.unit * cones.scale[i] * p(i, d);
  return result;
}

Points scaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps, const Vector& p) {
  Points result = Points::Zero(cones.n_points(), 3);
  for (Index i = 0; i < cones.n_points(); ++i)
    for (Index d = 0; d < n_rows(problem.laws[i].law) && cones.moves[i] != 0; ++d)
      result(i, d) = p[problem.first[i] + d] / (gaps.unit * cones.scale[i]);
  return result;
}

Points response_gap(const ConeProblem& cones, const Points& g, const Points& p) {
  Points gap = g;
  const Vector y = cones.L.transpose() * Eigen::Map<const Vector>(p.data(), p.size());
  Eigen::Map<Vector>(gap.data(), gap.size()) += cones.L * y;
  return gap;
}

void project(const ConeProblem& cones, Points& p) {
  for (Index i = 0; i < p.rows(); ++i) {
    if (cones.tied[i] != 0) continue;
    p(i, 0) = std::max(0.0, p(i, 0));
    const double length = std::hypot(p(i, 1), p(i, 2)), limit = cones.friction[i] * p(i, 0);
    if (length > limit) p.row(i).tail<2>() *= limit / length;
  }
}

double violation(const ConeProblem& cones, const ConeGaps& gaps, Points p) {
  project(cones, p);
  const Points gap = response_gap(cones, gaps.g, p);
  double largest = 0;
  for (Index i = 0; i < p.rows(); ++i) {
    if (cones.moves[i] == 0) continue;
    double size = gap.row(i).norm();
    if (cones.tied[i] == 0) {
      const double limit = cones.friction[i] * p(i, 0);
      Eigen::Vector2d target = (p.row(i) - gap.row(i)).tail<2>();
      const double length = target.norm();
      if (length > limit) target *= limit / length;
      size = std::hypot(std::min(p(i, 0), gap(i, 0)), (p.row(i).tail<2>().transpose() - target).norm());
    }
    if (!(size * gaps.weight[i] <= largest)) largest = size * gaps.weight[i];
  }
  return largest;
}

ConeSystem::ConeSystem(const ConeProblem& cones, const std::vector<Matrix3>& H) : cones_(cones) {
  const Index r = cones.rank();
  Matrix HL(cones.L.rows(), r);
  for (Index j = 0; j < r; ++j)
    for (Index i = 0; i < cones.n_points(); ++i) HL.col(j).segment<3>(3 * i) = H[i] * cones.L.col(j).segment<3>(3 * i);
  Matrix K = Matrix::Identity(r, r);
  K.noalias() += cones.L.transpose() * HL;
  if (!K.allFinite()) return;
  factor_.compute(K);
  ok_ = true;
}

Vector ConeSystem::solve(const Points& b, const Vector& r) const {
  return factor_.solve(cones_.L.transpose() * Eigen::Map<const Vector>(b.data(), b.size()) - r);
}

}  // namespace cbr
