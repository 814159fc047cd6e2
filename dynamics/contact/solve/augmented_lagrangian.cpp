// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/augmented_lagrangian.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

constexpr Index most_rows = 6000, most_columns = 600;
constexpr double weakest_pivot = 1e-13;  // relative to a unit diagonal
// Newton steps in total and per sigma; subproblems that do not halve the violation.
constexpr int most_steps = 150, steps_of_sigma = 30, most_idle = 20;
// Above the largest sigma the round-off of y outweighs the gain in convergence.
constexpr double growth = 10, largest_sigma = 1e5, least_sigma = 1e-3;
constexpr double shortest_step = 0.003, least_descent = 0.01, round_off = 3e-15;

// A = L L^T   (m x r) by pivoted Cholesky factorisation of a symmetric positive semi-definite A;
// empty if r exceeds `most`.
Matrix pivoted_cholesky(const Matrix& A, Index most) {
  const Index m = A.rows();
  Vector left = A.diagonal();  // diagonal of A - L L^T
  Matrix L(m, std::min(most, m));
  for (Index r = 0; r < m; ++r) {
    Index pivot = 0;
    const double largest = left.maxCoeff(&pivot);
    if (!(largest > weakest_pivot)) return L.leftCols(r);
    if (r == most) return {};
    L.col(r) =
        (A.col(pivot) - L.leftCols(r) * L.row(pivot).head(r).transpose()) / std::sqrt(largest);
    left -= L.col(r).cwiseAbs2();
    left[pivot] = -1;
  }
  return L;
}

// The problem for one p_k and sigma.
class Subproblem {
 public:
  Subproblem(const ContactProblem& problem, const Matrix& L, const Vector& g, const Vector& p,
             double sigma)
      : problem_(problem),
        L_(L),
        shifted_(p - sigma * g),
        sigma_(sigma),
        convex_(std::none_of(problem.laws.begin(), problem.laws.end(),
                             [](const PointLaw& law) { return law.law == ContactLaw::coulomb; })) {}

  // Newton's method from y, until R is round-off or small relative to the step from p. False:
  // neither.
  bool solve(const Vector& p, Vector& y, int most, int& steps) {
    Vector Ly = L_ * y;
    evaluate(y, Ly);
    for (int i = 0; i < most; ++i) {
      const double floor = std::max(1e-13, round_off * sigma_ * (1 + y.norm()));
      if (R_.norm() <= std::max(floor, 0.1 * (next_ - p).norm() / sigma_) && i > 0) return true;
      const Vector dy = direction();
      ++steps;
      if (!dy.allFinite()) return false;
      const Vector Ldy = L_ * dy, R = R_;
      const double merit = merit_, slope = convex_ ? R.dot(dy) : -R.squaredNorm();
      double best = std::numeric_limits<double>::infinity(), best_t = 0;
      for (double t = 1; t > shortest_step; t /= 2) {
        evaluate(y + t * dy, Ly + t * Ldy);
        if (merit_ < best) {
          best = merit_;
          best_t = t;
        }
        if (merit_ <= merit + least_descent * t * slope) break;
      }
      const bool stalls = !(best < merit);
      if (stalls) best_t = 1;
      y += best_t * dy;
      Ly = L_ * y;
      evaluate(y, Ly);
      if (stalls && !(R_.norm() < 0.5 * R.norm())) {
        if (R_.norm() <= floor) return true;
        y -= best_t * dy;
        evaluate(y, L_ * y);
        return R_.norm() <= floor;
      }
    }
    return false;
  }

  const Vector& next() const { return next_; }

 private:
  void evaluate(const Vector& y, const Vector& Ly) {
    tau_ = shifted_ - sigma_ * Ly;
    next_ = tau_;
    project(problem_, next_);
    R_ = y - L_.transpose() * next_;
    merit_ =
        convex_ ? 0.5 * (y.squaredNorm() + next_.squaredNorm() / sigma_) : 0.5 * R_.squaredNorm();
  }

  // A generalised derivative of P at a point: closed rows, and their derivative with sliding.
  void add_point(Index i, std::vector<Index>& rows, std::vector<Matrix3>& slides) const {
    const Index row = problem_.first[i];
    const PointLaw& law = problem_.laws[i];
    slides.push_back(Matrix3::Zero());
    if (!(problem_.w[i] > 0) || (law.law != ContactLaw::tied && !(tau_[row] > 0))) return;
    for (Index d = 0; d < n_rows(law.law); ++d) rows.push_back(row + d);
    Matrix3& D = slides.back();
    D.setIdentity();
    if (law.law != ContactLaw::coulomb) return;
    const double limit = law.friction * tau_[row], length = length_of(tau_[row + 1], tau_[row + 2]);
    if (length <= limit) return;
    const Eigen::Vector2d d = tau_.segment<2>(row + 1) / length;
    D.block<2, 2>(1, 1) = limit / length * (Eigen::Matrix2d::Identity() - d * d.transpose());
    D.block<2, 1>(1, 0) = law.friction * d;
  }

  Vector direction() const {
    std::vector<Index> rows;
    std::vector<Matrix3> slides;
    for (Index i = 0; i < problem_.n_points(); ++i) add_point(i, rows, slides);
    const Matrix L = L_(rows, Eigen::all);
    Matrix K = Matrix::Identity(L_.cols(), L_.cols());
    if (convex_) {
      K.noalias() += sigma_ * L.transpose() * L;
      if (!K.allFinite()) return Vector::Constant(K.rows(), HUGE_VAL);
      return Cholesky(std::move(K)).solve(Vector(-R_));
    }
    Matrix DL = L;
    for (std::size_t a = 0, i = 0; i < slides.size(); ++i) {
      const Index n = n_rows(problem_.laws[i].law);
      if (a == rows.size() || rows[a] != problem_.first[i]) continue;
      if (n == 3)
        DL.middleRows<3>(static_cast<Index>(a)) =
            (slides[i] * L.middleRows<3>(static_cast<Index>(a))).eval();
      a += static_cast<std::size_t>(n);
    }
    K.noalias() += sigma_ * L.transpose() * DL;
    if (!K.allFinite()) return Vector::Constant(K.rows(), HUGE_VAL);
    return Lu(std::move(K)).solve(Vector(-R_));
  }

  const ContactProblem& problem_;
  const Matrix& L_;
  const Vector shifted_;
  double sigma_;
  bool convex_;
  Vector tau_, next_, R_;
  double merit_ = 0;
};

}  // namespace

AugmentedLagrangian::AugmentedLagrangian(const ContactProblem& problem) {
  if (problem.n_rows() > most_rows) return;
  scale_.setZero(problem.n_rows());
  for (Index i = 0; i < problem.n_points(); ++i)
    for (Index row = problem.first[i]; row < problem.first[i + 1]; ++row)
      if (problem.diagonal[row] > 0 ||
          (problem.w[i] > 0 && problem.laws[i].law == ContactLaw::coulomb))
        scale_[row] = 1 / std::sqrt(problem.w[i]);
  const Matrix W = problem.W.is_sparse ? Matrix(problem.W.sparse) : problem.W.dense;
  L_ = pivoted_cholesky(scale_.asDiagonal() * W * scale_.asDiagonal(), most_columns);
}

AugmentedLagrangian::Result AugmentedLagrangian::solve(const ContactProblem& problem,
                                                       const Vector& g, const Vector& start,
                                                       double tolerance) const {
  const Vector scaled_g = scale_.cwiseProduct(g);
  const double largest = scaled_g.lpNorm<Eigen::Infinity>(), unit = largest > 0 ? largest : 1.0;
  const Vector h = scaled_g / unit;  // scaled gaps, largest 1
  // gaps for y, lengths; rows of zeros of W keep g
  const auto gap_of = [&](const Vector& y) {
    Vector gap = g;
    const Vector Ly = L_ * y;
    for (Index row = 0; row < gap.size(); ++row)
      if (scale_[row] > 0) gap[row] += unit * Ly[row] / scale_[row];
    return gap;
  };
  const auto offer = [&](const Vector& p, Result& best) {
    Vector impulses = unit * scale_.cwiseProduct(p);
    const double violation =
        law_violations(problem, impulses, gap_of(L_.transpose() * p)).lpNorm<Eigen::Infinity>();
    if (violation < best.violation) {
      best.p = std::move(impulses);
      best.violation = violation;
    }
    return violation;
  };
  Vector p = Vector::Zero(g.size());
  for (Index row = 0; row < g.size() && start.size() == g.size(); ++row)
    if (scale_[row] > 0) p[row] = start[row] / (unit * scale_[row]);
  project(problem, p);
  Result best{Vector::Zero(g.size()), {}};
  best.violation = std::numeric_limits<double>::infinity();
  double now = offer(p, best), last = now;  // last: violation of the best at its last halving
  Vector y = L_.transpose() * p;
  double sigma = 1;
  int idle = 0;
  while (best.steps < most_steps && best.violation > tolerance && sigma > least_sigma &&
         idle < most_idle) {
    Subproblem problem_of_k(problem, L_, h, p, sigma);
    const Vector before = y;
    int steps = 0;
    const bool ok =
        problem_of_k.solve(p, y, std::min(steps_of_sigma, most_steps - best.steps), steps);
    best.steps += steps;
    const double after = offer(problem_of_k.next(), best);
    if (sigma == largest_sigma) ++idle;
    if (best.violation < 0.5 * last) {
      last = best.violation;
      idle = 0;
    }
    if (ok || after < 0.5 * now) {
      p = problem_of_k.next();
      now = after;
      // y is stationary, with some laws violated
      if (ok && sigma == largest_sigma && (y - before).norm() <= 1e-12 * y.norm()) break;
      if (ok && steps <= steps_of_sigma / 2) sigma = std::min(largest_sigma, sigma * growth);
    } else {
      sigma /= std::sqrt(growth);
      y = L_.transpose() * p;
    }
  }
  best.motion = gap_of(y);
  return best;
}

}  // namespace cbr
