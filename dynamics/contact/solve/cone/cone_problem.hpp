// SPDX-License-Identifier: GPL-3.0-or-later
// Contact laws where W is singular, in the coordinates that it feels: W = L L^T, L with as many
// columns as W has rank.
#pragma once

#include <optional>
#include <vector>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

// Every point has three rows here, zeros where its law has one (the law of the tangential rows then
// holds with p_t = 0). Impulses and gaps of a point are scaled by one number, so that its largest
// W_ii is 1: cones stay cones.
struct ConeProblem {
  Matrix L;                      // 3 n x r
  Vector scale;                  // n: 1 / sqrt(w); 0 of points that nothing moves
  std::vector<double> friction;  // 1 of frictionless points, any would do
  std::vector<char> tied, moves;
  Index n_points() const { return scale.size(); }
  Index rank() const { return L.cols(); }
};

// By Cholesky's factorisation with pivots, down to 1e-13 of the diagonal (of `problem`, dense). No
// columns when more than `most_columns` would be needed, or when W is not positive semi-definite.
ConeProblem cone_problem(const ContactProblem& problem, Index most_columns);

// One right-hand side: g (n x 3) scaled, its largest entry 1; `weight`: what a scaled length of a
// point is as a share of the largest |g| unscaled.
struct ConeGaps {
  Points g;
  Vector weight;
  double unit = 1;  // p = scale x unit x scaled p
};
ConeGaps cone_gaps(const ContactProblem& problem, const ConeProblem& cones, const Vector& g);
// Impulses (rows of `problem`) of scaled ones.
Vector unscaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps,
                const Points& p);

// And back.
Points scaled(const ContactProblem& problem, const ConeProblem& cones, const ConeGaps& gaps,
              const Vector& p);

// g + L L^T p.
Points response_gap(const ConeProblem& cones, const Points& g, const Points& p);
// The nearest impulses that the laws allow, as project() has it.
void project(const ConeProblem& cones, Points& p);
// Of the projection of point i, by what is projected (3 x 3): one of its generalised derivatives on
// edges.
Matrix3 projection_derivative(const ConeProblem& cones, Index i, const Vector3& tau);
// Largest violation of a law by p after its projection, as a share of the largest |g|: see
// law_violations.
double violation(const ConeProblem& cones, const ConeGaps& gaps, Points p);

// dp = b - H L q per point, where q = L^T dp - r is sought: (I + L^T H L) q = L^T b - r. Points
// with H = 0 cost nothing.
class ConeSystem {
 public:
  ConeSystem(const ConeProblem& cones, const std::vector<Matrix3>& H);
  bool ok() const { return factor_.has_value(); }
  Vector solve(const Points& b, const Vector& r) const;

 private:
  const ConeProblem& cones_;
  std::optional<Lu> factor_;
};

}  // namespace cbr
