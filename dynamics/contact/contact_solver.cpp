// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/contact_solver.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "dynamics/contact/block_gauss_seidel.hpp"
#include "dynamics/contact/complementarity.hpp"
#include "dynamics/contact/contact_newton.hpp"

namespace cbr {

struct ContactSolver::Impl {
  ContactProblem problem;
  ContactNewton newton;
  std::optional<BlockGaussSeidel> sweeps;
  std::optional<ComplementaritySolver> descent;

  ContactSolution newton_and_sweeps(const Vector& g, const Vector& guess, double scale);
};

namespace {

// Share of the largest |g| to which laws are solved.
constexpr double accuracy = 1e-12;

}  // namespace

// Newton, and between its attempts more and more sweeps, that bring the sets near.
ContactSolution ContactSolver::Impl::newton_and_sweeps(const Vector& g, const Vector& guess, double scale) {
  if (!sweeps) sweeps.emplace(problem);
  ContactSolution best;
  best.residual = -1;
  Vector p = guess.size() == g.size() ? guess : Vector::Zero(g.size());
  project(problem, p);
  Vector gap = g + apply(problem.W, p);
  if (p.isZero(0)) sweeps->sweep(problem, 5, accuracy * scale, p, gap);
  for (int n_sweeps = 20; n_sweeps <= 1280; n_sweeps *= 4) {
    NewtonResult result = newton.solve(problem, g, p, gap, 20, accuracy * scale);
    best.iterations += result.iterations;
    if (best.residual < 0 || result.residual < best.residual)
      best.p = result.p, best.gap = result.gap, best.residual = result.residual;
    if (result.converged) return best;
    best.fallback = true;
    p = best.p, gap = best.gap;
    best.iterations += sweeps->sweep(problem, n_sweeps, accuracy * scale, p, gap);
    gap = g + apply(problem.W, p);
    const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
    if (residual < best.residual) best.p = p, best.gap = gap, best.residual = residual;
    if (residual <= accuracy * scale) break;
  }
  return best;
}

ContactSolver::ContactSolver(GapResponse W, std::vector<PointLaw> laws) : impl_(std::make_unique<Impl>()) {
  impl_->problem = contact_problem(std::move(W), std::move(laws));
}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

const GapResponse& ContactSolver::W() const { return impl_->problem.W; }

ContactSolution ContactSolver::solve(const Vector& g, const Vector& guess) {
  const double scale = g.size() > 0 ? g.lpNorm<Eigen::Infinity>() : 0;
  if (!(scale > 0)) return {Vector::Zero(g.size()), g};
  ContactSolution solution = impl_->newton_and_sweeps(g, guess, scale);
  solution.residual /= scale;
  const auto& laws = impl_->problem.laws;
  if (solution.residual > 1e-9 &&
      std::all_of(laws.begin(), laws.end(), [](const PointLaw& law) { return law.law == ContactLaw::frictionless; })) {
    if (!impl_->descent) impl_->descent.emplace(impl_->problem.W);
    ComplementarityResult result = impl_->descent->solve(g, std::vector<char>(g.size(), 0));
    if (result.residual < solution.residual) {
      solution.p = std::move(result.p), solution.gap = std::move(result.gap);
      solution.residual = law_violations(impl_->problem, solution.p, solution.gap).lpNorm<Eigen::Infinity>() / scale;
    }
  }
  return solution;
}

}  // namespace cbr
