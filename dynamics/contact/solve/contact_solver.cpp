// SPDX-License-Identifier: GPL-3.0-or-later
// The order of the methods. Newton first: with factors where there are few rows, with Krylov
// methods where there are many. What it does not solve goes to other methods, each bounded: without
// friction an active set that ends whatever W is, or projected gradients; with it sweeps, and
// friction that grows from a tenth to the whole; and Newton again from there.
#include "dynamics/contact/solve/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/contact/solve/contact_methods.hpp"

namespace cbr {
namespace {

// A share of the largest |g|: what is aimed at.
constexpr double aim = ContactMethods::aim;
// Up to how many points the active set that takes one at a time is tried.
constexpr Index basic_rows = 1500;
// Where a factor is still tried when Krylov methods fail, by rows (dense) or entries of W (sparse):
// seconds, not minutes, in all.
constexpr Index factor_rows = 4000, factor_entries = 1000000, lu_rows = 1500, lu_entries = 200000;
constexpr int newton_iterations = ContactMethods::newton_iterations,
              retry_iterations = ContactMethods::retry_iterations;
// Sweeps before Newton's first attempt from nothing, and the growing numbers of them after a failed
// one.
constexpr int first_sweeps = 20, first_retry = 60, most_sweeps = 540, growth_steps = 30;
// Of the proximal problems that find the least violation.
constexpr double ridge = 1e-6, margin = 1e-9;
constexpr int proximal_steps = 15;

LinearSolver first_choice(const ContactMethods& methods) {
  return methods.problem().n_rows() > methods.krylov_rows() ? LinearSolver::krylov
                                                            : LinearSolver::factor;
}

bool can_factor(const ContactProblem& problem) {
  const bool friction = has_friction(problem);
  if (problem.W.is_sparse)
    return problem.W.sparse.nonZeros() <= (friction ? lu_entries : factor_entries);
  return problem.n_rows() <= (friction ? lu_rows : factor_rows);
}

// Newton's first attempt, warm from `guess` or from a few sweeps, and with factors when Krylov
// methods fail.
void attempt(ContactMethods& methods, const Vector& g, const Vector& guess, double scale,
             const GapsOf& gaps_of, BestImpulses& best) {
  const ContactProblem& problem = methods.problem();
  const NewtonResult standing = methods.standing(g, scale, best);
  if (standing.converged) return;
  // Newton's first step from the last set is made: the next one goes on from there
  const bool goes_on = standing.iterations > 0 && all_frictionless(problem);
  if (goes_on) {
    if (methods.inexact(g, standing.outside, standing.gap, scale, gaps_of, best)) return;
    methods.newton(g, standing.outside, standing.gap, first_choice(methods), newton_iterations,
                   scale, best);
    if (best.done()) return;
  }
  BestImpulses start(g);
  Vector p = guess.size() == g.size() ? guess : Vector::Zero(g.size());
  project(problem, p);
  const bool warm = !p.isZero(0);
  if (!goes_on && methods.inexact(g, p, warm ? methods.gap_of(g, p) : g, scale, gaps_of, best))
    return;
  if (!warm && methods.friction()) {
    methods.sweep(g, p, first_sweeps, scale, start);
  } else {
    Vector gap = warm ? methods.gap_of(g, p) : g;
    const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
    start.offer(problem, scale, std::move(p), std::move(gap), residual);
  }
  best.iterations += start.iterations;
  const LinearSolver linear = first_choice(methods);
  // Newton's impulses are the least of those with the same gaps, the sweeps' are not
  if (!(warm && start.residual <= aim * scale))
    methods.newton(g, start.p, start.gap, linear, newton_iterations, scale, best);
  if (!best.done() && !start.done() && linear == LinearSolver::krylov && can_factor(problem))
    methods.newton(g, start.p, start.gap, LinearSolver::factor, newton_iterations, scale, best);
  if (!best.done())
    best.offer(problem, scale, std::move(start.p), std::move(start.gap), start.residual);
}

// Without friction the impulses minimise an energy: descend, then let Newton take the set that was
// found to round-off.
void descend(ContactMethods& methods, const Vector& g, double scale, BestImpulses& best) {
  const ContactProblem& problem = methods.problem();
  if (all_frictionless(problem) && !problem.W.is_sparse && problem.n_rows() <= basic_rows)
    methods.basic(g, scale, best);
  if (best.done()) return;
  methods.gradients(g, Vector::Zero(g.size()), scale, best);
  if (best.done() || !can_factor(methods.problem())) return;
  const BestImpulses start = best;
  methods.newton(g, start.p, start.gap, LinearSolver::factor, newton_iterations, scale, best);
}

// Follows the solution while all friction grows from a tenth to the whole.
void let_friction_grow(ContactMethods& methods, const Vector& g, double scale, BestImpulses& best) {
  Vector p = Vector::Zero(g.size()), gap = g;
  double share = 0, step = 0.1;
  for (int i = 0; i < growth_steps && share < 1 && step > 1e-3; ++i) {
    const double next = std::min(1.0, share + step);
    if (methods.newton_with(next, g, scale, best, p, gap)) {
      share = next;
      step *= 2;
    } else {
      step /= 2;
    }
  }
  if (!(share < 1)) {
    const double residual = law_violations(methods.problem(), p, gap).lpNorm<Eigen::Infinity>();
    best.offer(methods.problem(), scale, std::move(p), std::move(gap), residual);
  }
}

void sweep_and_attempt(ContactMethods& methods, const Vector& g, double scale, BestImpulses& best) {
  const bool factor = can_factor(methods.problem()), singular = methods.singular_with_friction();
  // where Newton cycles, more sweeps do not help it
  const int most = singular ? first_retry : most_sweeps;
  for (int n = first_retry; n <= most && !best.done(); n *= 3) {
    methods.sweep(g, best.p, n, scale, best);
    if (best.done()) return;
    const BestImpulses start = best;
    methods.newton(g, start.p, start.gap, factor ? LinearSolver::factor : LinearSolver::krylov,
                   retry_iterations, scale, best);
    if (!best.done() && factor && !singular && n == first_retry)
      let_friction_grow(methods, g, scale, best);
  }
}

// No impulse satisfies all: the proximal point method (Rockafellar 1976, doi 10.1137/0314056) tends
// to the gaps that violate least (Chiche, Gilbert 2016), and with these forgiven the problem has a
// solution of a bounded size.
void forgive(ContactMethods& methods, const Vector& g, double scale, BestImpulses& best) {
  ContactProblem shifted = methods.problem();
  const Vector epsilon = ridge * shifted.diagonal;
  if (shifted.W.is_sparse) {
    for (Index i = 0; i < epsilon.size(); ++i)
      if (epsilon[i] > 0) shifted.W.sparse.coeffRef(i, i) += epsilon[i];
  } else {
    shifted.W.dense.diagonal() += epsilon;
  }
  ContactMethods proximal(contact_problem(std::move(shifted.W), shifted.laws));
  Vector p = Vector::Zero(g.size()), gap = g;
  double moved = scale;
  for (int i = 0; i < proximal_steps && moved > aim * scale; ++i) {
    BestImpulses step(g);
    attempt(proximal, g - epsilon.cwiseProduct(p), p, scale, {}, step);
    best.iterations += step.iterations;
    p = std::move(step.p);
    const Vector next = g + respond(methods.problem(), p);
    moved = (next - gap).lpNorm<Eigen::Infinity>();
    gap = next;
  }
  Vector forgiven = g;
  Index row = 0;
  for (const PointLaw& law : shifted.laws) {
    for (Index d = 0; d < n_rows(law.law); ++d, ++row)
      if (law.law == ContactLaw::tied || gap[row] < 0)
        forgiven[row] -= gap[row] - (law.law == ContactLaw::tied ? 0.0 : margin * scale);
  }
  BestImpulses bounded(forgiven);
  attempt(methods, forgiven, Vector(), scale, {}, bounded);
  if (!bounded.done()) descend(methods, forgiven, scale, bounded);
  Vector bounded_gap = g + respond(methods.problem(), bounded.p);
  const double residual =
      law_violations(methods.problem(), bounded.p, bounded_gap).lpNorm<Eigen::Infinity>();
  // A somewhat smaller violation that takes huge impulses in opposite directions is no better
  if (residual <= 4 * best.residual || !(best.p.norm() < 1e4 * bounded.p.norm())) {
    best.p = std::move(bounded.p);
    best.gap = std::move(bounded_gap);
    best.residual = residual;
  }
}

}  // namespace

struct ContactSolver::Impl {
  ContactMethods methods;
};

ContactSolver::ContactSolver(GapResponse W, std::vector<PointLaw> laws, bool stands)
    : impl_(std::make_unique<Impl>(
          Impl{ContactMethods(contact_problem(std::move(W), std::move(laws)),
                              stands ? ContactMethods::krylov_rows_of_kept_W
                                     : ContactMethods::krylov_rows_of_new_W)})) {}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

const GapResponse& ContactSolver::W() const { return impl_->methods.problem().W; }

bool ContactSolver::standing_impulses(const Vector& g, Vector& p) {
  ContactMethods& methods = impl_->methods;
  return methods.is_finite() && g.allFinite() && methods.standing_impulses(g, p);
}

double ContactSolver::largest_violation(const Vector& p, const Vector& gap) const {
  return p.size() > 0 ? law_violations(impl_->methods.problem(), p, gap).lpNorm<Eigen::Infinity>()
                      : 0;
}

void ContactSolver::renumber(GapResponse W, std::vector<PointLaw> laws,
                             const std::vector<Index>& from) {
  impl_->methods.renumber(std::move(W), std::move(laws), from);
}

void ContactSolver::keep_state(StateArchive& archive) { impl_->methods.keep_state(archive); }

bool ContactSolver::W_is_singular() const {
  return impl_->methods.cones_first() || impl_->methods.basic_first();
}

void ContactSolver::begin_as(const ContactSolver& other) {
  impl_->methods.begin_as(other.impl_->methods);
}

Index ContactSolver::n_factored() const { return impl_->methods.n_factored(); }

ContactSolution ContactSolver::solve(const Vector& g, const Vector& guess, Effort effort,
                                     const GapsOf& gaps_of) {
  ContactMethods& methods = impl_->methods;
  const double scale = g.size() > 0 ? g.lpNorm<Eigen::Infinity>() : 0;
  const Vector none = Vector::Zero(g.size());
  // Of the bodies' motion, or of magnitudes beyond a double's reach: the loop will say so
  const ContactSolution not_finite{none, g, std::numeric_limits<double>::infinity()};
  if (!g.allFinite() || !methods.is_finite()) return not_finite;
  if (!(scale > 0) || law_violations(methods.problem(), none, g).isZero(0)) return {none, g};
  BestImpulses best(g);
  if (methods.basic_first()) methods.basic(g, scale, best);
  const bool cones_first = methods.cones_first();
  const bool good = cones_first && methods.cones(g, guess, scale, best);
  if (!best.done() && !good) attempt(methods, g, guess, scale, gaps_of, best);
  ContactSolution solution;
  if (!best.done() && !good) {
    solution.fallback = true;
    if (effort == Effort::all && methods.friction()) {
      if (cones_first || !methods.cones(g, guess, scale, best))
        sweep_and_attempt(methods, g, scale, best);
    } else if (effort == Effort::all) {
      descend(methods, g, scale, best);
      if (best.residual > 1e-7 * scale) forgive(methods, g, scale, best);
    }
  }
  if (!std::isfinite(best.residual) || !best.p.allFinite() || !best.gap.allFinite())
    return not_finite;
  methods.remember(g, best.p, best.gap);
  solution.p = std::move(best.p);
  solution.gap = std::move(best.gap);
  solution.residual = best.residual / scale;
  solution.iterations = best.iterations;
  return solution;
}

}  // namespace cbr
