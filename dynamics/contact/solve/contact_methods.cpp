// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/contact_methods.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/contact/solve/basic_impulses.hpp"
#include "dynamics/contact/solve/projected_gradients.hpp"

namespace cbr {
namespace {

// Shares of the largest |g|: what Krylov methods aim at, and the active set that takes one point at
// a time; and what is good enough not to call for another method.
constexpr double inexact_aim = 3e-12, basic_aim = 1e-11, enough = 1e-10;
// Rows and rank up to which a singular W with friction is solved in the coordinates that it feels;
// what no other method betters then.
constexpr Index cone_rows = 6000, cone_rank = 600;
constexpr double enough_of_cones = 1e-6;
constexpr int gradient_products = 3000;

}  // namespace

bool has_friction(const ContactProblem& problem) {
  return std::any_of(problem.laws.begin(), problem.laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::coulomb; });
}

bool all_frictionless(const ContactProblem& problem) {
  return std::all_of(problem.laws.begin(), problem.laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::frictionless; });
}

void BestImpulses::offer(const ContactProblem& problem, double scale, Vector new_p, Vector new_gap,
                         double new_residual) {
  if (!(new_residual < residual)) return;
  good = std::min(enough * scale + gap_round_off(problem, new_p), 1e-8 * scale);
  p = std::move(new_p);
  gap = std::move(new_gap);
  residual = new_residual;
}

ContactMethods::ContactMethods(ContactProblem problem, Index krylov_rows)
    : problem_(std::move(problem)), krylov_rows_(krylov_rows), is_finite_(all_finite(problem_.W)) {}

void ContactMethods::newton(const Vector& g, const Vector& p, const Vector& gap,
                            LinearSolver linear, int iterations, double scale, BestImpulses& best) {
  NewtonResult result = newton_.solve(problem_, g, p, gap, linear, iterations, aim * scale);
  best.iterations += result.iterations;
  best.offer(problem_, scale, std::move(result.p), std::move(result.gap), result.residual);
}

bool ContactMethods::inexact(const Vector& g, Vector p, Vector gap, double scale,
                             const GapsOf& gaps_of, BestImpulses& best) {
  if (problem_.W.is_sparse || problem_.n_rows() <= krylov_rows_) return false;
  go_on(g, p, gap);
  const GapsOf by_W = [&](const Vector& of, Vector& its) { its = g + respond(problem_, of); };
  NewtonResult result =
      inexact_.solve(problem_, g, std::move(p), std::move(gap), newton_iterations,
                     (friction() ? inexact_aim : aim) * scale, gaps_of ? gaps_of : by_W);
  best.iterations += result.iterations;
  best.offer(problem_, scale, std::move(result.p), std::move(result.gap), result.residual);
  if (best.done() && !friction())
    newton_.ends_with(problem_, contact_set(problem_, best.p, best.gap));
  return best.done();
}

NewtonResult ContactMethods::standing(const Vector& g, double scale, BestImpulses& best) {
  NewtonResult result = newton_.solve_standing(problem_, g, aim * scale);
  best.iterations += result.iterations;
  if (result.converged) best.offer(problem_, scale, result.p, result.gap, result.residual);
  return result;
}

bool ContactMethods::standing_impulses(const Vector& g, Vector& p) {
  return newton_.standing_impulses(problem_, g, p);
}

bool ContactMethods::newton_with(double share, const Vector& g, double scale, BestImpulses& best,
                                 Vector& p, Vector& gap) {
  const std::vector<PointLaw> laws = problem_.laws;
  for (PointLaw& law : problem_.laws) law.friction *= share;
  NewtonResult result =
      newton_.solve(problem_, g, p, gap, LinearSolver::factor, retry_iterations, aim * scale);
  problem_.laws = laws;
  best.iterations += result.iterations;
  if (!result.converged) return false;
  p = std::move(result.p);
  gap = std::move(result.gap);
  return true;
}

void ContactMethods::sweep(const Vector& g, Vector p, int n, double scale, BestImpulses& best) {
  if (!sweeps_) sweeps_.emplace(problem_);
  Vector gap = g + respond(problem_, p);
  best.iterations += sweeps_->sweep(problem_, n, aim * scale, p, gap);
  gap = g + respond(problem_, p);
  const double residual = law_violations(problem_, p, gap).lpNorm<Eigen::Infinity>();
  best.offer(problem_, scale, std::move(p), std::move(gap), residual);
}

void ContactMethods::gradients(const Vector& g, Vector p, double scale, BestImpulses& best) {
  if (!(norm_ > 0)) norm_ = scaled_norm(problem_);
  Vector gap = g + respond(problem_, p);
  best.iterations +=
      projected_gradients(problem_, g, norm_, gradient_products, aim * scale, p, gap);
  const double residual = law_violations(problem_, p, gap).lpNorm<Eigen::Infinity>();
  best.offer(problem_, scale, std::move(p), std::move(gap), residual);
}

bool ContactMethods::cones(const Vector& g, const Vector& guess, double scale, BestImpulses& best) {
  if (problem_.W.is_sparse || problem_.n_rows() > cone_rows) return false;
  if (!cones_) cones_ = cone_problem(problem_, std::min(cone_rank, problem_.n_rows() - 1));
  if (cones_->rank() == 0) return false;
  ConeImpulses found = cone_impulses(problem_, *cones_, g, guess, enough * scale);
  best.iterations += found.steps;
  const bool good = found.residual <= enough_of_cones * scale;
  cones_first_ = cones_first_ || good;  // one failure does not make W regular
  best.offer(problem_, scale, std::move(found.p), std::move(found.gap), found.residual);
  return good;
}

void ContactMethods::basic(const Vector& g, double scale, BestImpulses& best) {
  BasicImpulses basic = basic_impulses(problem_, g, basic_aim * scale);
  basic_first_ = basic.found && basic.singular;
  best.iterations += basic.steps;
  const double residual = law_violations(problem_, basic.p, basic.gap).lpNorm<Eigen::Infinity>();
  best.offer(problem_, scale, std::move(basic.p), std::move(basic.gap), residual);
}

Vector ContactMethods::gap_of(const Vector& g, const Vector& p) const {
  return is_last(p) ? Vector(g + last_.answer) : g + respond(problem_, p);
}

void ContactMethods::remember(const Vector& g, const Vector& p, const Vector& gap) {
  before_ = std::move(last_);
  last_ = {p, gap - g};
}

void ContactMethods::renumber(GapResponse W, std::vector<PointLaw> laws,
                              const std::vector<Index>& from) {
  const std::vector<Index> first = problem_.first;
  problem_ = contact_problem(std::move(W), std::move(laws));
  is_finite_ = all_finite(problem_.W);
  std::vector<Index> rows(static_cast<std::size_t>(problem_.n_rows()), -1);
  for (std::size_t i = 0; i < from.size(); ++i)
    for (Index d = 0; from[i] >= 0 && d < n_rows(problem_.laws[i].law); ++d)
      rows[problem_.first[i] + d] = first[from[i]] + d;
  newton_.renumber(rows);
  inexact_.forget();
  last_ = before_ = Remembered();
  sweeps_.reset();
  cones_.reset();
  norm_ = 0;
}

void ContactMethods::keep_state(StateArchive& archive) {
  archive(problem_.W, problem_.laws);
  if (archive.restores()) {
    problem_ = contact_problem(std::move(problem_.W), std::move(problem_.laws));
    is_finite_ = all_finite(problem_.W);
  }
  archive(basic_first_, cones_first_, krylov_rows_);
  newton_.keep_state(archive, problem_);
  inexact_.keep_state(archive, problem_);
  archive(last_.p, last_.answer, before_.p, before_.answer);
}

void ContactMethods::begin_as(const ContactMethods& other) {
  basic_first_ = other.basic_first_;
  cones_first_ = other.cones_first_;
  inexact_.begin_as(other.inexact_);
}

void ContactMethods::go_on(const Vector& g, Vector& p, Vector& gap) const {
  if (before_.p.size() != p.size() || !is_last(p)) return;
  Vector next = 2 * last_.p - before_.p, next_gap = g + 2 * last_.answer - before_.answer;
  if (!(law_violations(problem_, next, next_gap).norm() < law_violations(problem_, p, gap).norm()))
    return;
  p = std::move(next);
  gap = std::move(next_gap);
}

}  // namespace cbr
