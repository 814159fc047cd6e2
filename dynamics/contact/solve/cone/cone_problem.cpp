// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/cone/cone_problem.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

constexpr double weakest_pivot = 1e-13;  // of a unit diagonal
// What may be left of A beyond it, in a product with ones of either sign: round-off leaves 1e-12.
constexpr double most_left = 1e-9;
// Of H: beside the identity in the system the point takes no part in it; in the step itself it
// does.
constexpr double no_part = 1e-12;

// Whether A = L L^T: a negative eigenvalue shows in what is left beside the diagonal, on which it
// ends the pivots like a zero.
bool is_product(const Matrix& A, const Matrix& L) {
  Vector signs(A.rows());
  std::uint32_t state = 1;
  for (double& sign : signs) {
    state = 1664525u * state + 1013904223u;
    sign = (state >> 31) != 0 ? 1.0 : -1.0;
  }
  const Vector left = symmetric_product(A, signs) - L * (L.transpose() * signs);
  return left.lpNorm<Eigen::Infinity>() <= most_left;
}

// A = L L^T   (m x r), A symmetric positive semi-definite; false when it is not, or r passes
// `most`.
bool pivoted_cholesky(const Matrix& A, Index most, Matrix& L) {
  const Index m = A.rows();
  Vector left = A.diagonal();  // of A - L L^T
  L.resize(m, std::min(most, m));
  for (Index r = 0; r < m; ++r) {
    Index pivot = 0;
    const double largest = left.maxCoeff(&pivot);
    if (!(largest > weakest_pivot)) {
      L.conservativeResize(Eigen::NoChange, r);
      return is_product(A, L);
    }
    if (r == most) return false;
    L.col(r) =
        (A.col(pivot) - L.leftCols(r) * L.row(pivot).head(r).transpose()) / std::sqrt(largest);
    left -= L.col(r).cwiseAbs2();
    left[pivot] = -1;
  }
  return true;
}

}  // namespace

ConeProblem cone_problem(const ContactProblem& problem, Index most_columns) {
  const Index n = problem.n_points();
  ConeProblem cones;
  cones.scale.resize(n);
  cones.friction.resize(n);
  cones.tied.resize(n);
  cones.moves.resize(n);
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
  if (!pivoted_cholesky(row_scale.asDiagonal() * problem.W.dense * row_scale.asDiagonal(),
                        most_columns, rows)) {
    cones.L.resize(3 * n, 0);
    return cones;
  }
  cones.L.setZero(3 * n, rows.cols());
  for (Index i = 0; i < n; ++i)
    cones.L.middleRows(3 * i, n_rows(problem.laws[i].law)) =
        rows.middleRows(problem.first[i], n_rows(problem.laws[i].law));
  return cones;
}

ConeGaps cone_gaps(const ContactProblem& problem, const ConeProblem& cones, const Vector& g) {
  ConeGaps gaps;
  gaps.g.setZero(cones.n_points(), 3);
  gaps.weight.setZero(cones.n_points());
  for (Index i = 0; i < cones.n_points(); ++i)
    for (Index d = 0; d < n_rows(problem.laws[i].law); ++d)
      gaps.g(i, d) = cones.scale[i] * g[problem.first[i] + d];
  const double largest = gaps.g.cwiseAbs().maxCoeff();
  gaps.unit = largest > 0 ? largest : 1.0;
  gaps.g /= gaps.unit;
  for (Index i = 0; i < cones.n_points(); ++i)
    if (cones.moves[i] != 0)
      gaps.weight[i] = gaps.unit / cones.scale[i] / g.lpNorm<Eigen::Infinity>();
  return gaps;
}

Vector unscaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps,
                const Points& p) {
  Vector result(problem.n_rows());
  for (Index i = 0; i < cones.n_points(); ++i)
    for (Index d = 0; d < n_rows(problem.laws[i].law); ++d)
      result[problem.first[i] + d] = gaps.unit * cones.scale[i] * p(i, d);
  return result;
}

Points scaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps,
              const Vector& p) {
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
      size = std::hypot(std::min(p(i, 0), gap(i, 0)),
                        (p.row(i).tail<2>().transpose() - target).norm());
    }
    if (!(size * gaps.weight[i] <= largest)) largest = size * gaps.weight[i];
  }
  return largest;
}

Matrix3 projection_derivative(const ConeProblem& cones, Index i, const Vector3& tau) {
  if (cones.tied[i] != 0) return Matrix3::Identity();
  Matrix3 D = Matrix3::Zero();
  if (!(tau[0] > 0)) return D;
  const double mu = cones.friction[i], limit = mu * tau[0], length = std::hypot(tau[1], tau[2]);
  if (length <= limit) return Matrix3::Identity();
  const Eigen::Vector2d d = tau.tail<2>() / length;
  D(0, 0) = 1;
  D.block<2, 2>(1, 1) = limit / length * (Eigen::Matrix2d::Identity() - d * d.transpose());
  D.block<2, 1>(1, 0) = mu * d;
  return D;
}

ConeSystem::ConeSystem(const ConeProblem& cones, const std::vector<Matrix3>& H) : cones_(cones) {
  const Index r = cones.rank();
  std::vector<Index> on;
  for (Index i = 0; i < cones.n_points(); ++i)
    if (!(H[i].cwiseAbs().maxCoeff() <= no_part)) on.push_back(i);
  const Index n = static_cast<Index>(on.size());
  Matrix L(3 * n, r), HL(3 * n, r);  // rows of those points
  for (Index j = 0; j < r; ++j)
    for (Index a = 0; a < n; ++a) {
      const Vector3 l = cones.L.col(j).segment<3>(3 * on[a]);
      L.col(j).segment<3>(3 * a) = l;
      HL.col(j).segment<3>(3 * a).noalias() = H[on[a]] * l;
    }
  Matrix K = Matrix::Identity(r, r);
  if (n > 0) K.noalias() += L.transpose() * HL;
  if (!K.allFinite()) return;
  factor_.emplace(std::move(K));
}

Vector ConeSystem::solve(const Points& b, const Vector& r) const {
  return factor_->solve(cones_.L.transpose() * Eigen::Map<const Vector>(b.data(), b.size()) - r);
}

}  // namespace cbr
