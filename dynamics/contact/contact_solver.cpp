// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/contact_solver.hpp"

#include <algorithm>
#include <utility>

#include "common/error.hpp"
#include "dynamics/contact/complementarity.hpp"

namespace cbr {

struct ContactSolver::Impl {
  ComplementaritySolver solver;
};

ContactSolver::ContactSolver(GapResponse W, std::vector<PointLaw> laws)
    : impl_(std::make_unique<Impl>(Impl{ComplementaritySolver(std::move(W))})) {
  if (std::any_of(laws.begin(), laws.end(), [](const PointLaw& law) { return law.law != ContactLaw::frictionless; }))
    throw RunError("contact: friction and tied surfaces are not solved yet");
}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

const GapResponse& ContactSolver::W() const { return impl_->solver.W(); }

ContactSolution ContactSolver::solve(const Vector& g, const Vector& guess) {
  std::vector<char> active(g.size(), 0);
  for (Index i = 0; i < guess.size(); ++i) active[i] = guess[i] > 0;
  ComplementarityResult result = impl_->solver.solve(g, active);
  return {std::move(result.p), std::move(result.gap), result.residual, result.iterations, result.fallback};
}

}  // namespace cbr
