// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/block_gauss_seidel.hpp"

#include <algorithm>

#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Least-norm inverse of a symmetric positive semi-definite block.
Matrix3 pseudo_inverse(const Matrix3& B) {
  const auto [values, vectors] = symmetric_eigen3(B);
  const double largest = values[2];
  Vector3 inverse = Vector3::Zero();
  for (int d = 0; d < 3; ++d)
    if (values[d] > 1e-12 * largest) inverse[d] = 1 / values[d];
  return vectors * inverse.asDiagonal() * vectors.transpose();
}

}  // namespace

BlockGaussSeidel::BlockGaussSeidel(const ContactProblem& problem)
    : blocks_(problem.n_points()), inverses_(problem.n_points()), coulomb_(problem.n_points()) {
  for (Index i = 0; i < problem.n_points(); ++i) {
    blocks_[i] = point_block(problem, i);
    if (problem.laws[i].law == ContactLaw::tied) inverses_[i] = pseudo_inverse(blocks_[i]);
    if (problem.laws[i].law == ContactLaw::coulomb && blocks_[i](0, 0) > 0)
      coulomb_[i] = CoulombPoint(blocks_[i], problem.laws[i].friction);
  }
}

double BlockGaussSeidel::relax(const ContactProblem& problem, Index point, Vector& p,
                               Vector& gap) const {
  const Index row = problem.first[point];
  const Matrix3& B = blocks_[point];
  Vector3 change = Vector3::Zero();
  switch (problem.laws[point].law) {
    case ContactLaw::frictionless:
      if (B(0, 0) > 0) change[0] = std::max(-p[row], -gap[row] / B(0, 0));
      break;
    case ContactLaw::tied:
      change = -inverses_[point] * gap.segment<3>(row);
      break;
    case ContactLaw::coulomb: {
      if (!(B(0, 0) > 0)) break;
      const Vector3 old = p.segment<3>(row);
      if (old.isZero(0) && gap[row] >= 0) break;
      change = coulomb_[point].solve(gap.segment<3>(row) - B * old) - old;
      break;
    }
  }
  if (change.isZero(0)) return 0;
  p.segment(row, n_rows(problem.laws[point].law)) += change.head(n_rows(problem.laws[point].law));
  add_response(problem, point, change.data(), gap);
  return problem.w[point] * change.norm();
}

int BlockGaussSeidel::sweep(const ContactProblem& problem, int max_sweeps, double tolerance,
                            Vector& p, Vector& gap) const {
  const Index n = problem.n_points();
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    double moved = 0;
    for (Index k = 0; k < n; ++k)
      moved = std::max(moved, relax(problem, sweep % 2 ? n - 1 - k : k, p, gap));
    if (moved <= tolerance) return sweep + 1;
  }
  return max_sweeps;
}

}  // namespace cbr
