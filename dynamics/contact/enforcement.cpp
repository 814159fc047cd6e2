// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforcement.hpp"

#include <algorithm>
#include <utility>

namespace cbr {
namespace {

Vector gaps(const std::vector<Constraint>& constraints) {
  Vector g(static_cast<Index>(constraints.size()));
  for (Index i = 0; i < g.size(); ++i) g[i] = constraints[i].gap;
  return g;
}

// Largest eigenvalue from above: power iteration, 5 % for what it has not yet found, never more than the largest row sum.
double largest_eigenvalue(const GapResponse& W) {
  Vector x = Vector::Ones(W.size());
  for (Index i = 0; i < x.size(); i += 2) x[i] = -0.7;  // no symmetry to hide behind
  double lambda = 0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    x /= x.norm();
    const Vector y = apply(W, x);
    lambda = std::max(lambda, y.norm());
    if (!(y.norm() > 0)) break;
    x = y;
  }
  const double row_sum =
      W.is_sparse ? Vector(W.sparse.cwiseAbs() * Vector::Ones(W.size())).maxCoeff() : W.dense.cwiseAbs().rowwise().sum().maxCoeff();
  return std::min(1.05 * lambda, row_sum);
}

EnforcementResult take(ComplementarityResult&& solved) {
  return {std::move(solved.p), std::move(solved.gap), solved.residual, solved.fallback};
}

// Rows that differ by round-off give the same impulses to round-off.
constexpr double same_row_tolerance = 1e-11;

}  // namespace

EnforcementResult enforce_impulse(const std::vector<Constraint>& constraints, const std::vector<char>& guess, double h,
                                  std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (!memory.solver || memory.h != h || !same_rows(constraints, memory.rows, same_row_tolerance)) {
    memory.rows = constraints;
    memory.h = h;
    memory.solver.emplace(gap_response(constraints, bodies));
  }
  EnforcementResult result = take(memory.solver->solve(gaps(constraints), guess));
  spread_impulses(memory.rows, result.p, bodies);
  return result;
}

EnforcementResult enforce_penalty(const std::vector<Constraint>& constraints, double h, double x, std::vector<ContactBody>& bodies,
                                  PenaltyMemory& memory) {
  const Index m = static_cast<Index>(constraints.size());
  if (m > memory.n_seen) {
    const double lambda = largest_eigenvalue(gap_response(constraints, bodies));
    const double k = penalty_share * (4 - x * x) / (h * lambda);
    memory.stiffness = memory.n_seen > 0 ? std::min(memory.stiffness, k) : k;
    memory.n_seen = m;
  }
  EnforcementResult result;
  result.p.resize(m);
  for (Index i = 0; i < m; ++i) {
    const double g = constraints[i].start_gap;
    result.p[i] = memory.stiffness * h * std::max(0.0, -g);
  }
  result.gap = gaps(constraints);  // without this step's impulses: what may be behind a face at the end
  spread_impulses(constraints, result.p, bodies);
  return result;
}

EnforcementResult enforce_nodal(const std::vector<Constraint>& constraints, const std::vector<char>& guess, double h,
                                const std::vector<Points>& masses, std::vector<ContactBody>& bodies) {
  // S = h / m of each node and direction: the mass matrix by its row sums
  std::vector<ContactBody> weighed(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Eigen::Map<const Vector> m(masses[b].data(), masses[b].size());
    weighed[b].response.diagonal = h * m.cwiseInverse();
  }
  EnforcementResult result = take(ComplementaritySolver(gap_response(constraints, weighed)).solve(gaps(constraints), guess));
  spread_impulses(constraints, result.p, bodies);
  return result;
}

}  // namespace cbr
