// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/enforcement.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

EnforcementResult solve(ContactSolver& solver, const ContactList& list,
                        const std::vector<PointLaw>& laws, const Points& guess) {
  const ContactSolution solution = solver.solve(pack(gaps(list), laws), pack(guess, laws));
  return {unpack(solution.p, laws), unpack(solution.gap, laws), solution.residual,
          solution.fallback};
}

// Largest eigenvalue by Lanczos with reorthogonalisation, converged to round-off, so that it does
// not depend on the order of the points.
double largest_eigenvalue(const GapResponse& W) {
  const Index n = W.size(), most = std::min<Index>(n, 300);
  Matrix Q(n, most);
  Vector alpha = Vector::Zero(most), beta = Vector::Zero(most);
  Vector q = Vector::LinSpaced(n, 1.0, 2.0);  // not orthogonal to modes of any symmetry
  for (Index i = 0; i < n; i += 2) q[i] = -0.7 * q[i];
  q.normalize();
  for (Index j = 0; j < most; ++j) {
    Q.col(j) = q;
    Vector w = apply(W, q);
    alpha[j] = q.dot(w);
    for (int pass = 0; pass < 2; ++pass)
      w -= Q.leftCols(j + 1) * (Q.leftCols(j + 1).transpose() * w);
    beta[j] = w.norm();
    const bool exhausted = !(beta[j] > 1e-14 * std::abs(alpha[0])) || j + 1 == most;
    if (exhausted || j % 8 == 7) {
      const RitzValue ritz = largest_ritz_value(alpha, beta, j + 1);
      // Upper bound: adds the residual
      if (exhausted || ritz.residual <= 1e-13 * ritz.value) return ritz.value + ritz.residual;
    }
    q = w / beta[j];
  }
  return 0;
}

// Solves s + 4 zeta sqrt(s) = share (4 - x^2) for s, and sets spring and dashpot. Points that no
// impulse moves need none.
void fit_spring(double lambda, double h, double x, double damping, PenaltyMemory& memory) {
  if (!(lambda > 0)) return;
  const double root = std::sqrt(4 * damping * damping + penalty_share * (4 - x * x)) - 2 * damping,
               s = root * root;
  const double k = s / (h * lambda);
  memory.stiffness = memory.stiffness > 0 ? std::min(memory.stiffness, k) : k;
  memory.dashpot = 2 * damping * std::sqrt(memory.stiffness * h / lambda);
}

// Whether a node of the point has residual compliance: forces set its velocity, impulses alone do
// not change it.
bool is_static(const ContactList& list, const ContactPoint& point,
               const std::vector<ContactBody>& bodies) {
  const auto first = list.terms.begin() + point.first_term;
  return std::any_of(first, first + point.n_terms, [&](const ContactTerm& term) {
    return bodies[term.body].response.is_static(term.node);
  });
}

// Closed or tied points with an impulse, between nodes with mass.
std::vector<Index> points_to_settle(const ContactList& list, const std::vector<PointLaw>& laws,
                                    const Points& p, const std::vector<ContactBody>& bodies) {
  std::vector<Index> rows;
  for (Index i = 0; i < p.rows(); ++i) {
    const bool acts = laws[i].law == ContactLaw::tied ? !p.row(i).isZero(0) : p(i, 0) > 0;
    if (acts && !is_static(list, list.points[i], bodies)) rows.push_back(i);
  }
  return rows;
}

// A selection of points with their own terms only, so that different selections have different
// lists.
ContactList points_of(const ContactList& list, const std::vector<Index>& rows) {
  ContactList some;
  for (const Index i : rows) {
    ContactPoint point = list.points[i];
    const auto first = list.terms.begin() + point.first_term;
    point.first_term = static_cast<Index>(some.terms.size());
    some.terms.insert(some.terms.end(), first, first + point.n_terms);
    some.points.push_back(point);
  }
  return some;
}

}  // namespace

Points settle_velocities(const ContactList& list, const std::vector<PointLaw>& laws,
                         const Points& p, const Points& velocities,
                         const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  Points change = Points::Zero(p.rows(), 3);
  const std::vector<Index> rows = points_to_settle(list, laws, p, bodies);
  if (rows.empty()) return change;
  ContactList closed = points_of(list, rows);
  std::vector<PointLaw> closed_laws;
  for (const Index i : rows) closed_laws.push_back(laws[i]);
  if (!memory.solver || memory.unknowns.A.size() > 0 || !same_laws(closed_laws, memory.laws) ||
      !same_rows(closed, memory.rows, closed_laws, same_row_tolerance)) {
    memory.unknowns.A.resize(0, 0);
    memory.solver.emplace(
        gap_response(closed, closed_laws, bodies, &ContactBody::velocity_response), closed_laws);
    memory.rows = std::move(closed);
  }
  take_friction(closed_laws, memory);
  const Vector packed_p = pack(p(rows, Eigen::all), memory.laws);
  const Vector without =
      pack(velocities(rows, Eigen::all), memory.laws) - apply(memory.solver->W(), packed_p);
  const ContactSolution solution = memory.solver->solve(without, packed_p);
  if (!std::isfinite(solution.residual)) return Points::Constant(p.rows(), 3, solution.residual);
  change(rows, Eigen::all) = unpack(solution.p - packed_p, memory.laws);
  return change;
}

Points settle_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                       const ContactUnknowns& unknowns, const Points& velocities,
                       const std::vector<ContactBody>& bodies, Vector& x, ImpulseMemory& memory) {
  const std::vector<Index> first = first_rows(unknowns.laws), of_points = first_rows(laws);
  std::vector<Index> rows;
  std::vector<PointLaw> closed_laws;
  for (std::size_t u = 0; u < unknowns.laws.size(); ++u) {
    const Index n = first[u + 1] - first[u];
    const bool tied = unknowns.laws[u].law == ContactLaw::tied;
    if (tied ? x.segment(first[u], n).isZero(0) : !(x[first[u]] > 0)) continue;
    bool settles = false;
    for (SparseMatrix::InnerIterator it(unknowns.A, first[u]); it; ++it) {
      const auto at = std::upper_bound(of_points.begin(), of_points.end(), it.row()) - 1;
      settles = !is_static(list, list.points[at - of_points.begin()], bodies);
      if (!settles) break;
    }
    if (!settles) continue;
    closed_laws.push_back(unknowns.laws[u]);
    for (Index d = 0; d < n; ++d) rows.push_back(first[u] + d);
  }
  Points change = Points::Zero(static_cast<Index>(laws.size()), 3);
  if (rows.empty()) return change;
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (SparseMatrix::InnerIterator it(unknowns.A, rows[i]); it; ++it)
      entries.emplace_back(it.row(), static_cast<Index>(i), it.value());
  SparseMatrix A(unknowns.A.rows(), static_cast<Index>(rows.size()));
  A.setFromTriplets(entries.begin(), entries.end());
  if (!memory.solver || !same_laws(closed_laws, memory.laws) ||
      !same_matrix(A, memory.unknowns.A) ||
      !same_rows(list, memory.rows, laws, same_row_tolerance)) {
    memory.solver.emplace(gap_response(list, laws, bodies, &ContactBody::velocity_response, &A),
                          closed_laws);
    memory.rows = list;
    memory.unknowns.A = A;
  }
  take_friction(closed_laws, memory);
  const Vector packed = x(rows);
  const Vector without = A.transpose() * pack(velocities, laws) - apply(memory.solver->W(), packed);
  const ContactSolution solution = memory.solver->solve(without, packed);
  if (!std::isfinite(solution.residual)) return Points::Constant(change.rows(), 3, HUGE_VAL);
  x(rows) = solution.p;
  return unpack(A * (solution.p - packed), laws);
}

EnforcementResult enforce_penalty(const ContactList& list, const std::vector<PointLaw>& laws,
                                  double h, double x, const PenaltyLaw& law,
                                  std::vector<ContactBody>& bodies, PenaltyMemory& memory,
                                  Points& elastic_slip) {
  const Index m = static_cast<Index>(list.points.size());
  if (m > memory.n_seen) {
    const GapResponse W = gap_response(list, laws, bodies);
    const double lambda = all_finite(W) ? largest_eigenvalue(W) : HUGE_VAL;
    if (!std::isfinite(lambda)) return {Points::Zero(m, 3), gaps(list), HUGE_VAL};
    memory.most_stiffness = lambda > 0 ? (4 - x * x) / (h * lambda) : HUGE_VAL;
    fit_spring(lambda, h, x, law.damping, memory);
    memory.n_seen = m;
  }
  EnforcementResult result{
      Points::Zero(m, 3),
      gaps(list)};  // without this step's impulses: bounds the penetration at the end
  const bool is_given = !law.pressure.empty();
  const double c = memory.dashpot, steepest = is_given ? law.share * law.pressure.steepest() : 0;
  for (Index i = 0; i < m; ++i) {
    const ContactPoint& point = list.points[i];
    const double k = is_given ? steepest * point.area : memory.stiffness;
    if (is_given && k > memory.most_stiffness) return {Points::Zero(m, 3), gaps(list), HUGE_VAL};
    if (is_given && point.start_gap < 0)
      result.p(i, 0) = h * law.share * point.area * law.pressure.value(-point.start_gap);
    else if (point.start_gap < 0)
      result.p(i, 0) =
          h * std::max(0.0, -k * point.start_gap - c * (point.gap[0] - point.start_gap) / h);
    if (laws[i].law != ContactLaw::coulomb) continue;
    // Extension of the spring with the slip of this step, in the tangent plane, reduced to the
    // friction cone
    Vector3 stretch = point.frame * elastic_slip.row(i).transpose();
    stretch.tail<2>() += point.gap.tail<2>();
    stretch[0] = 0;
    const double pull = k * h * stretch.norm(), limit = laws[i].friction * result.p(i, 0);
    if (pull > limit) stretch *= limit / pull;
    result.p.row(i).tail<2>() = -k * h * stretch.tail<2>().transpose();
    // The slip without contact is subtracted; the caller adds the actual one
    stretch.tail<2>() -= point.gap.tail<2>();
    elastic_slip.row(i) = (point.frame.transpose() * stretch).transpose();
  }
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

EnforcementResult enforce_nodal(const ContactList& list, const Points& guess, double h,
                                const std::vector<Points>& masses,
                                std::vector<ContactBody>& bodies) {
  // S = h / m for each node and direction, with row sums of the mass matrix. Bodies are renumbered
  // in the order of the list, which may be a small part of the scene
  std::vector<ContactBody> weighed;
  std::unordered_map<Index, Index> place;
  ContactList own = list;
  for (ContactTerm& term : own.terms) {
    const auto [at, is_new] = place.try_emplace(term.body, static_cast<Index>(weighed.size()));
    if (is_new) {
      const Points& mass = masses[term.body];
      const Eigen::Map<const Vector> m(mass.data(), mass.size());
      weighed.emplace_back().response.diagonal = h * m.cwiseInverse();
    }
    term.body = at->second;
  }
  const std::vector<PointLaw> laws(list.points.size());
  ContactSolver solver(gap_response(own, laws, weighed), laws);
  EnforcementResult result = solve(solver, list, laws, guess);
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

void keep_state(StateArchive& archive, PenaltyMemory& memory) {
  archive(memory.stiffness, memory.dashpot, memory.n_seen, memory.most_stiffness);
}

void keep_state(StateArchive& archive, ImpulseMemory& memory) {
  archive(memory.rows, memory.laws, memory.h, memory.n_formed, memory.unknowns, memory.x);
  archive(memory.rotates, memory.axes);
  bool has_solver = memory.solver.has_value();
  archive(has_solver);
  if (archive.restores()) {
    memory.standing.clear();  // formed again from the rest
    memory.solver.reset();
    if (has_solver) memory.solver.emplace(GapResponse(), std::vector<PointLaw>());
  }
  if (has_solver) memory.solver->keep_state(archive);
}

void keep_state(StateArchive& archive, ContactBody& body) {
  archive(body.start, body.end, body.impulses, body.friction, body.move, body.has_move, body.swept,
          body.longest_way);
  archive(body.still, body.lasting, body.rubbed_before);
}

}  // namespace cbr
