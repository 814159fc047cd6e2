// SPDX-License-Identifier: GPL-3.0-or-later
// Order of the methods. First Newton, with factors or Krylov methods. Its failures go to the
// augmented Lagrangian, or to sweeps if W is too large, and then to Newton with factors. The work
// of each method is bounded.
#include "dynamics/contact/solve/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/contact/solve/augmented_lagrangian.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/newton/contact_newton.hpp"

namespace cbr {
namespace {

// Relative to the largest |g|: tolerance, that of the augmented Lagrangian, and the residual that
// needs no further method.
constexpr double aim = 1e-12, lagrangian_aim = 1e-11, enough = 1e-10;
// Rows of a dense W from which Krylov methods are faster than factors
// (docs/decisions/contact-solver.md).
constexpr Index krylov_rows = 400;
// Limits for a factor when Krylov methods fail, by rows (dense) or entries (sparse) of W: seconds
// in total.
constexpr Index factor_rows = 4000, factor_entries = 1000000, lu_rows = 1500, lu_entries = 200000;
constexpr int newton_iterations = 30;
// Sweeps before the first Newton attempt without a guess, and when the augmented Lagrangian is too
// expensive.
constexpr int first_sweeps = 20, most_sweeps = 540;
// Without friction: residual that shows incompatible gaps, and the margin by which they are opened
// then.
constexpr double impossible = 1e-7, margin = 1e-9;

bool has_law(const ContactProblem& problem, ContactLaw law) {
  return std::any_of(problem.laws.begin(), problem.laws.end(),
                     [law](const PointLaw& of) { return of.law == law; });
}

bool can_factor(const ContactProblem& problem) {
  const bool friction = has_law(problem, ContactLaw::coulomb);
  if (problem.W.is_sparse)
    return problem.W.sparse.nonZeros() <= (friction ? lu_entries : factor_entries);
  return problem.n_rows() <= (friction ? lu_rows : factor_rows);
}

// The best solution so far; p within the laws' cones. Initially none, which remains after overflow.
struct BestImpulses {
  explicit BestImpulses(const Vector& g) : p(Vector::Zero(g.size())), gap(g) {}
  Vector p, gap;
  double residual = std::numeric_limits<double>::infinity();  // a length
  // a residual that needs no further method
  double good = 0;
  int iterations = 0;

  bool done() const { return residual <= good; }
  // Accepts a better solution. `scale`: the largest |g|.
  void offer(const ContactProblem& problem, double scale, Vector new_p, Vector new_gap,
             double new_residual) {
    if (!(new_residual < residual)) return;
    good = std::min(enough * scale + gap_round_off(problem, new_p), 1e2 * enough * scale);
    p = std::move(new_p);
    gap = std::move(new_gap);
    residual = new_residual;
  }
};

}  // namespace

// Each method offers its impulses to `best` and adds its iterations. `scale`: the largest |g|.
struct ContactSolver::Impl {
  ContactProblem problem;
  bool friction = has_law(problem, ContactLaw::coulomb);
  bool is_finite = all_finite(problem.W);
  ContactNewton newton = {};
  Vector last = {}, last_answer = {};  // p of the last solution, and W p
  bool lagrangian_first = false;       // it has succeeded where Newton failed
  std::optional<AugmentedLagrangian> lagrangian = {};
  std::optional<BlockGaussSeidel> sweeps = {};

  // g + W p, without a product for the last impulses.
  Vector gap_of(const Vector& g, const Vector& p) const {
    const bool is_last = p.size() == last.size() && p == last;
    return is_last ? Vector(g + last_answer) : g + respond(problem, p);
  }
  void start_over();
  bool attempt(const Vector& g, const Vector& guess, double scale, BestImpulses& best);
  bool by_newton(const Vector& g, const Vector& p, const Vector& gap, LinearSolver linear,
                 double scale, BestImpulses& best);
  void sweep(const Vector& g, Vector p, int n, double scale, BestImpulses& best);
  bool by_lagrangian(const Vector& g, const Vector& guess, double scale, BestImpulses& best);
  void forgive(const Vector& g, const Vector& motion, double scale, BestImpulses& best);
};

void ContactSolver::Impl::start_over() {
  friction = has_law(problem, ContactLaw::coulomb);
  is_finite = all_finite(problem.W);
  lagrangian.reset();
  sweeps.reset();
}

bool ContactSolver::Impl::by_newton(const Vector& g, const Vector& p, const Vector& gap,
                                    LinearSolver linear, double scale, BestImpulses& best) {
  NewtonResult result = newton.solve(problem, g, p, gap, linear, newton_iterations, aim * scale);
  best.iterations += result.iterations;
  best.offer(problem, scale, std::move(result.p), std::move(result.gap), result.residual);
  return best.done();
}

void ContactSolver::Impl::sweep(const Vector& g, Vector p, int n, double scale,
                                BestImpulses& best) {
  if (!sweeps) sweeps.emplace(problem);
  Vector gap = g + respond(problem, p);
  best.iterations += sweeps->sweep(problem, n, aim * scale, p, gap);
  gap = g + respond(problem, p);
  const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
  best.offer(problem, scale, std::move(p), std::move(gap), residual);
}

// First Newton attempt, from `guess` or from a few sweeps.
bool ContactSolver::Impl::attempt(const Vector& g, const Vector& guess, double scale,
                                  BestImpulses& best) {
  const bool many = problem.W.is_sparse || problem.n_rows() > krylov_rows;
  const LinearSolver linear = many ? LinearSolver::krylov : LinearSolver::factor;
  const NewtonResult standing = newton.solve_standing(problem, g, aim * scale);
  best.iterations += standing.iterations;
  if (standing.converged) best.offer(problem, scale, standing.p, standing.gap, standing.residual);
  if (best.done()) return true;
  // The standing set gave the first Newton step: continue from it
  const bool goes_on = standing.iterations > 0 && !friction && !has_law(problem, ContactLaw::tied);
  Vector p = guess.size() == g.size() ? guess : Vector::Zero(g.size());
  project(problem, p);
  if (goes_on) p = standing.outside;
  const bool warm = !p.isZero(0);
  Vector gap = goes_on ? standing.gap : warm ? gap_of(g, p) : g;
  if (!warm && friction) {
    BestImpulses start(g);
    sweep(g, p, first_sweeps, scale, start);
    best.iterations += start.iterations;
    p = start.p;
    gap = start.gap;
  }
  const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
  // Newton's impulses are the smallest with their gaps, those of sweeps are not
  if (!(warm && residual <= aim * scale)) by_newton(g, p, gap, linear, scale, best);
  if (!best.done() && !goes_on) best.offer(problem, scale, std::move(p), std::move(gap), residual);
  return best.done();
}

// False if W is too large, or the laws do not hold.
bool ContactSolver::Impl::by_lagrangian(const Vector& g, const Vector& guess, double scale,
                                        BestImpulses& best) {
  if (!lagrangian) lagrangian.emplace(problem);
  if (!lagrangian->ok()) return false;
  AugmentedLagrangian::Result found = lagrangian->solve(problem, g, guess, lagrangian_aim * scale);
  best.iterations += found.steps;
  Vector gap = g + respond(problem, found.p);
  const double residual = law_violations(problem, found.p, gap).lpNorm<Eigen::Infinity>();
  best.offer(problem, scale, std::move(found.p), std::move(gap), residual);
  if (best.done()) lagrangian_first = true;
  if (!friction && residual > impossible * scale) forgive(g, found.motion, scale, best);
  return best.done();
}

// For incompatible gaps: relaxing them by the least violation gives a problem with a bounded
// solution.
void ContactSolver::Impl::forgive(const Vector& g, const Vector& motion, double scale,
                                  BestImpulses& best) {
  Vector forgiven = g;
  Index row = 0;
  for (const PointLaw& law : problem.laws)
    for (Index d = 0; d < n_rows(law.law); ++d, ++row) {
      if (law.law == ContactLaw::tied) forgiven[row] -= motion[row];
      if (law.law != ContactLaw::tied && motion[row] < 0)
        forgiven[row] += margin * scale - motion[row];
    }
  AugmentedLagrangian::Result bounded =
      lagrangian->solve(problem, forgiven, Vector(), lagrangian_aim * scale);
  best.iterations += bounded.steps;
  Vector gap = g + respond(problem, bounded.p);
  const double residual = law_violations(problem, bounded.p, gap).lpNorm<Eigen::Infinity>();
  if (!(residual <= 2 * best.residual)) return;
  best.p = std::move(bounded.p);
  best.gap = std::move(gap);
  best.residual = best.good = residual;  // no other method improves it
}

ContactSolver::ContactSolver(GapResponse W, std::vector<PointLaw> laws)
    : impl_(std::make_unique<Impl>(Impl{contact_problem(std::move(W), std::move(laws))})) {}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

const GapResponse& ContactSolver::W() const { return impl_->problem.W; }

bool ContactSolver::standing_impulses(const Vector& g, Vector& p) {
  return impl_->is_finite && g.allFinite() && impl_->newton.standing_impulses(impl_->problem, g, p);
}

double ContactSolver::largest_violation(const Vector& p, const Vector& gap) const {
  return p.size() > 0 ? law_violations(impl_->problem, p, gap).lpNorm<Eigen::Infinity>() : 0;
}

void ContactSolver::take_friction(const std::vector<PointLaw>& laws) {
  if (laws == impl_->problem.laws) return;
  impl_->problem.laws = laws;
  impl_->sweeps.reset();
}

// All else is computed from W and the laws on demand.
void ContactSolver::keep_state(StateArchive& archive) {
  Impl& of = *impl_;
  archive(of.problem.W, of.problem.laws);
  if (archive.restores()) {
    of.problem = contact_problem(std::move(of.problem.W), std::move(of.problem.laws));
    of.start_over();
  }
  archive(of.lagrangian_first);
  of.newton.keep_state(archive, of.problem);
  archive(of.last, of.last_answer);
}

void ContactSolver::begin_as(const ContactSolver& other) {
  impl_->lagrangian_first = other.impl_->lagrangian_first;
}

ContactSolution ContactSolver::solve(const Vector& g, const Vector& guess) {
  Impl& of = *impl_;
  const double scale = g.size() > 0 ? g.lpNorm<Eigen::Infinity>() : 0;
  const Vector none = Vector::Zero(g.size());
  // From the bodies' motion, or by overflow: the time loop reports it
  const ContactSolution not_finite{none, g, std::numeric_limits<double>::infinity()};
  if (!g.allFinite() || !of.is_finite) return not_finite;
  if (!(scale > 0) || law_violations(of.problem, none, g).isZero(0)) return {none, g};
  BestImpulses best(g);
  ContactSolution solution;
  const bool known = of.lagrangian_first && of.by_lagrangian(g, guess, scale, best);
  if (!known && !of.attempt(g, guess, scale, best)) {
    solution.fallback = true;
    if (!of.by_lagrangian(g, guess, scale, best)) {
      if (!of.lagrangian->ok()) of.sweep(g, best.p, most_sweeps, scale, best);
      if (!best.done() && can_factor(of.problem)) {
        const BestImpulses start = best;
        of.by_newton(g, start.p, start.gap, LinearSolver::factor, scale, best);
      }
    }
  }
  if (!std::isfinite(best.residual) || !best.p.allFinite() || !best.gap.allFinite())
    return not_finite;
  of.last = best.p;
  of.last_answer = best.gap - g;
  solution.p = std::move(best.p);
  solution.gap = std::move(best.gap);
  solution.residual = best.residual / scale;
  solution.iterations = best.iterations;
  return solution;
}

}  // namespace cbr
