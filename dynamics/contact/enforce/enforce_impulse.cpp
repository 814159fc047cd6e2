// SPDX-License-Identifier: GPL-3.0-or-later
// `impulse` with a W that is formed when its rows change.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/enforce/few_unknowns.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// Of the laws with the bodies' own gaps, relative to the largest |g|.
constexpr double most_violation = 1e-11;

// One step's problem and its solution.
struct ImpulseStep {
  const ContactList& list;
  const std::vector<PointLaw>& laws;
  Vector g, guess;
  Vector p, gap;
  double residual = 0;
  bool fallback = false, moved = false;  // moved: the memory's moves are those of p
};

void form(const ImpulseStep& step, double h, const std::vector<ContactBody>& bodies,
          ImpulseMemory& memory) {
  memory.rows = step.list;
  memory.laws = step.laws;
  memory.h = h;
  ContactSolver solver(gap_response(step.list, step.laws, bodies), step.laws);
  if (memory.solver) solver.begin_as(*memory.solver);
  memory.solver = std::move(solver);
  ++memory.n_formed;
}

void solve_by_W(ImpulseStep& step, ImpulseMemory& memory) {
  ContactSolution solution = memory.solver->solve(step.g, step.guess);
  step.p = std::move(solution.p);
  step.gap = std::move(solution.gap);
  step.residual = solution.residual;
  step.fallback = solution.fallback;
}

// Tries the set of closed points of the last step. The bodies' own products, which the step needs
// anyway, give the gaps, so that W is not read.
bool solve_by_moves(ImpulseStep& step, const std::vector<ContactBody>& bodies,
                    ImpulseMemory& memory) {
  Vector p;
  if (!memory.solver->standing_impulses(step.g, p)) return false;
  memory.moves.push(step.list, step.laws, p, bodies);
  step.gap = step.g;
  memory.moves.add_to_gaps(step.list, step.laws, step.gap);
  const double scale = step.g.lpNorm<Eigen::Infinity>(),
               violation = memory.solver->largest_violation(p, step.gap);
  if (!(violation <= most_violation * scale)) return false;
  step.p = std::move(p);
  step.residual = violation > 0 ? violation / scale : 0;
  step.moved = true;
  return true;
}

// Whether no point closes without impulses, so that all are 0 for any W.
bool stays_apart(const ContactList& list, const std::vector<PointLaw>& laws) {
  for (std::size_t i = 0; i < list.points.size(); ++i)
    if (laws[i].law == ContactLaw::tied || !(list.points[i].gap[0] >= 0)) return false;
  return true;
}

// Residual above the round-off of gaps, which are differences of positions. Without impulses
// `scale` may itself be of that size.
double seen_residual(const ImpulseStep& step, const std::vector<ContactBody>& bodies) {
  constexpr double worth_a_look = 1e-9, round_off = 1e-15;
  if (!(step.residual > worth_a_look) || !std::isfinite(step.residual)) return step.residual;
  double reach = 0;
  for (const ContactTerm& term : step.list.terms)
    reach = std::max(reach, bodies[term.body].end.row(term.node).lpNorm<Eigen::Infinity>());
  const double violation = step.residual * step.g.lpNorm<Eigen::Infinity>();
  return violation <= round_off * reach ? 0 : step.residual;
}

}  // namespace

EnforcementResult enforce_impulse(const ContactList& list, const std::vector<PointLaw>& laws,
                                  const Points& guess, double h, std::vector<ContactBody>& bodies,
                                  ImpulseMemory& memory,
                                  const std::vector<FunctionsOfSearch>& searches) {
  if (stays_apart(list, laws)) {
    const Points none = Points::Zero(static_cast<Index>(laws.size()), 3);
    return {none, unpack(pack(gaps(list), laws), laws), 0, false};
  }
  if (!searches.empty() && are_rigid(list, bodies)) {
    memory.unknowns = ContactUnknowns();
    if (auto result = enforce_point_by_point(list, laws, guess, searches, h, bodies, memory))
      return std::move(*result);
  }
  ContactUnknowns unknowns = choose_unknowns(list, laws, searches, &memory.unknowns);
  if (unknowns.reduced)
    return enforce_in_functions(list, laws, searches, unknowns, h, bodies, memory);
  ImpulseStep step{list, laws, pack(gaps(list), laws), pack(guess, laws), {}, {}, 0, false, false};
  const bool stands = memory.solver && memory.h == h && !memory.unknowns.reduced;
  memory.unknowns = ContactUnknowns();
  if (stands && !any_turns(list, bodies) && same_laws(laws, memory.laws) &&
      same_rows(list, memory.rows, laws, same_row_tolerance)) {
    take_friction(laws, memory);
    if (!solve_by_moves(step, bodies, memory)) solve_by_W(step, memory);
  } else {
    form(step, h, bodies, memory);
    solve_by_W(step, memory);
  }
  if (!step.moved) memory.moves.push(list, laws, step.p, bodies);
  memory.moves.give(bodies);
  EnforcementResult result{unpack(step.p, laws), unpack(step.gap, laws),
                           seen_residual(step, bodies), step.fallback};
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

}  // namespace cbr
