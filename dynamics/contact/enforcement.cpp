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

double largest_row_sum(const GapResponse& W) {
  if (!W.is_sparse) return W.dense.cwiseAbs().rowwise().sum().maxCoeff();
  return (W.sparse.cwiseAbs() * Vector::Ones(W.size())).maxCoeff();
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

EnforcementResult enforce_penalty(const std::vector<Constraint>& constraints, double h, std::vector<ContactBody>& bodies,
                                  double& stiffness) {
  const GapResponse W = gap_response(constraints, bodies);
  const double row_sum = largest_row_sum(W);
  if (row_sum > 0) {
    const double k = penalty_share / (h * row_sum);
    stiffness = stiffness > 0 ? std::min(stiffness, k) : k;
  }
  EnforcementResult result;
  result.p.resize(static_cast<Index>(constraints.size()));
  for (Index i = 0; i < result.p.size(); ++i) result.p[i] = stiffness * h * std::max(0.0, -constraints[i].start_gap);
  result.gap = gaps(constraints) + apply(W, result.p);
  spread_impulses(constraints, result.p, bodies);
  return result;
}

EnforcementResult enforce_nodal(const std::vector<Constraint>& constraints, const std::vector<char>& guess, double h,
                                const std::vector<Points>& masses, std::vector<ContactBody>& bodies) {
  // S = h / m of each node and direction: the mass matrix by its row sums
  std::vector<ContactBody> weighed(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (masses[b].rows() == 0) continue;
    const Eigen::Map<const Vector> m(masses[b].data(), masses[b].size());
    weighed[b].response.diagonal = h * m.cwiseInverse();
  }
  EnforcementResult result = take(ComplementaritySolver(gap_response(constraints, weighed)).solve(gaps(constraints), guess));
  spread_impulses(constraints, result.p, bodies);
  return result;
}

double measure_gap(const Constraint& c, const std::vector<ContactBody>& bodies, bool at_end) {
  const Points& slave = at_end ? bodies[c.slave_body].end : bodies[c.slave_body].start;
  const Points& master = at_end ? bodies[c.master_body].end : bodies[c.master_body].start;
  Vector3 d = slave.row(c.slave).transpose();
  for (int a = 0; a < 4; ++a) d -= c.weights[a] * master.row(c.masters[a]).transpose();
  return c.normal.dot(d);
}

}  // namespace cbr
