// SPDX-License-Identifier: GPL-3.0-or-later
// `impulse` with a W that is formed, or kept and corrected by the bodies' own responses.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/enforce/few_unknowns.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// W is formed anew if the defect shrinks by less in one product, or after this number of products.
constexpr double slowest_rate = 0.5;
constexpr int most_pushes = 15;
// Cost of a new W in products with the bodies' responses; its factor costs one more per so many
// rows: docs/decisions/contact-cost.md.
constexpr double products_of_W = 4, rows_of_a_product = 400;
// Products per step that W_0 always needs with large rotation, as W changes in each step. The first
// finds the defect, the second confirms it. A new W saves none of them.
constexpr int products_of_turns = 2;
constexpr Index longest_wait = 64;
// New points are added to W_0 below this fraction.
constexpr double most_new = 0.25;
// Solutions between products, until the model's prediction of the defect agrees with the
// assumption.
constexpr int most_solutions = 4;

void fill_keys(const ContactList& list, const std::vector<PointLaw>& laws,
               std::vector<PointKey>& keys) {
  keys.clear();
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    const ContactTerm &first = list.terms[point.first_term],
                      &last = list.terms[point.first_term + point.n_terms - 1];
    PointKey key{first.body, last.body,  point.slot, point.n_slave_terms == 1 ? first.node : -1,
                 0,          laws[i].law};
    if (!keys.empty()) {
      PointKey before = keys.back();
      before.ordinal = 0;
      if (before == key) key.ordinal = keys.back().ordinal + 1;
    }
    keys.push_back(key);
  }
}

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
  fill_keys(step.list, step.laws, memory.keys);
  memory.defects.clear();
  memory.extra = 0;
  ++memory.n_formed;
}

// Solves with gaps from the bodies' own products, which the step needs anyway.
void solve_exactly(ImpulseStep& step, const std::vector<ContactBody>& bodies,
                   ImpulseMemory& memory) {
  Vector pushed;
  const GapsOf gaps_of = [&](const Vector& p, Vector& gap) {
    memory.moves.push(step.list, step.laws, p, bodies);
    gap = step.g;
    memory.moves.add_to_gaps(step.list, step.laws, gap);
    pushed = p;
  };
  ContactSolution solution = memory.solver->solve(step.g, step.guess, Effort::all, gaps_of);
  step.p = std::move(solution.p);
  step.gap = std::move(solution.gap);
  step.residual = solution.residual;
  step.fallback = solution.fallback;
  step.moved = pushed.size() > 0 && pushed == step.p;
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
  if (!(violation <= memory.options.tolerance * scale)) return false;
  step.p = std::move(p);
  step.residual = violation > 0 ? violation / scale : 0;
  step.moved = true;
  return true;
}

// Updates W_0 to the points of this step: copies rows of points that remain, and computes others,
// column by column.
void change_points(const ImpulseStep& step, const std::vector<Index>& from,
                   const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  const Matrix& old = memory.solver->W().dense;
  const std::vector<Index> old_first = first_rows(memory.laws), first = first_rows(step.laws);
  std::vector<Index> rows(static_cast<std::size_t>(first.back()), -1);
  for (std::size_t i = 0; i < from.size(); ++i)
    for (Index d = 0; from[i] >= 0 && d < n_rows(step.laws[i].law); ++d)
      rows[first[i] + d] = old_first[from[i]] + d;
  const Index m = first.back();
  GapResponse W;
  W.dense.resize(m, m);
  for (Index j = 0; j < m; ++j)
    for (Index i = 0; rows[j] >= 0 && i < m; ++i)
      if (rows[i] >= 0) W.dense(i, j) = old(rows[i], rows[j]);
  Vector unit = Vector::Zero(m), column(m);
  for (Index j = 0; j < m; ++j) {
    if (rows[j] >= 0) continue;
    unit[j] = 1;
    memory.moves.push(step.list, step.laws, unit, bodies);
    unit[j] = 0;
    column.setZero();
    memory.moves.add_to_gaps(step.list, step.laws, column);
    W.dense.col(j) = column;
    W.dense.row(j) = column.transpose();
  }
  memory.defects.renumber(rows);
  memory.solver->renumber(std::move(W), step.laws, from);
  memory.rows = ContactList();  // rows of several steps
  memory.laws = step.laws;
  memory.keys = memory.new_keys;
  ++memory.n_changed;
}

// Whether W_0 is usable: dense, regular, large enough, for similar points. If so, its points are
// updated to those of the step.
bool keep(const ImpulseStep& step, const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (memory.solver->W().is_sparse || step.g.size() < memory.options.least_rows ||
      !step.g.allFinite())
    return false;
  // With a singular W a solution costs more than a new W, and with friction it is too inexact for
  // corrections. Rows of two geometries may make a singular W indefinite
  if (memory.solver->W_is_singular()) return false;
  if (memory.wait > 0) {
    --memory.wait;
    return false;
  }
  const double dear = products_of_W + static_cast<double>(step.g.size()) / rows_of_a_product;
  if (memory.extra > dear) return false;
  fill_keys(step.list, step.laws, memory.new_keys);
  if (memory.new_keys == memory.keys) {
    take_friction(step.laws, memory);
    return true;
  }
  const std::vector<Index> from = match(memory.new_keys, memory.keys);
  const auto n_new = static_cast<double>(std::count(from.begin(), from.end(), Index{-1}));
  if (n_new > most_new * static_cast<double>(from.size())) return false;
  change_points(step, from, bodies, memory);
  return true;
}

bool has_friction(const std::vector<PointLaw>& laws) {
  return std::any_of(laws.begin(), laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::coulomb; });
}

// Impulses by W_0 with the defect that the model predicts for them; `taken`: the defect assumed.
ContactSolution solve_with_model(const ImpulseStep& step, const Vector& guess, double enough,
                                 ImpulseMemory& memory, Vector& taken) {
  ContactSolution solution;
  memory.defects.predict(guess, taken);
  Vector expected;
  // With friction a solution costs more than a product
  const int most = memory.defects.empty() || has_friction(step.laws) ? 1 : most_solutions;
  for (int i = 0; i < most; ++i) {
    solution =
        memory.solver->solve(step.g + taken, i == 0 ? guess : solution.p, Effort::first_methods);
    if (i + 1 == most || solution.fallback) break;
    memory.defects.predict(solution.p, expected);
    if ((expected - taken).lpNorm<Eigen::Infinity>() <= enough) break;
    taken.swap(expected);
  }
  return solution;
}

// Iterates until the defect (W - W_0) p is consistent: W_0 with g + defect satisfies the laws, and
// so does W. False if it converges slowly.
bool correct(ImpulseStep& step, const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  const double scale = step.g.size() > 0 ? step.g.lpNorm<Eigen::Infinity>() : 0;
  const double aim = memory.options.tolerance * scale;
  double last = HUGE_VAL, enough = std::max(0.3 * aim, 0.1 * memory.first_error * scale);
  Vector guess = step.guess, taken;
  for (int push = 1; push <= most_pushes; ++push) {
    ContactSolution solution = solve_with_model(step, guess, enough, memory, taken);
    if (solution.fallback || !(solution.residual < 1e-8)) break;
    memory.moves.push(step.list, step.laws, solution.p, bodies);
    ++memory.n_pushes;
    step.gap = step.g;
    memory.moves.add_to_gaps(step.list, step.laws, step.gap);
    const Vector error = step.gap - solution.gap;  // (W - W_0) p - assumed defect
    const double violation = memory.solver->largest_violation(solution.p, step.gap),
                 size = error.lpNorm<Eigen::Infinity>();
    if (push == 1) memory.first_error = scale > 0 ? size / scale : 0;
    const bool done = violation <= aim;
    if (!done || push > 1 || size > aim) memory.defects.add(solution.p, taken + error);
    if (done) {
      step.p = std::move(solution.p);
      step.residual = scale > 0 ? violation / scale : 0;
      step.moved = true;
      ++memory.n_steps;
      memory.extra += std::max(0, push - (any_turns(step.list, bodies) ? products_of_turns : 1));
      memory.backoff = 1;
      return true;
    }
    if (push > 1 && !(size < slowest_rate * last)) break;
    last = size;
    enough = std::max(0.3 * aim, 0.1 * size);
    guess = std::move(solution.p);
  }
  memory.wait = memory.backoff - 1;
  memory.backoff = std::min(2 * memory.backoff, longest_wait);
  return false;
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
    if (!solve_by_moves(step, bodies, memory)) solve_exactly(step, bodies, memory);
  } else if (!stands || !keep(step, bodies, memory) || !correct(step, bodies, memory)) {
    form(step, h, bodies, memory);
    solve_exactly(step, bodies, memory);
  }
  if (!step.moved) memory.moves.push(list, laws, step.p, bodies);
  memory.moves.give(bodies);
  EnforcementResult result{unpack(step.p, laws), unpack(step.gap, laws),
                           seen_residual(step, bodies), step.fallback};
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

}  // namespace cbr
