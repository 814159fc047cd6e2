// SPDX-License-Identifier: GPL-3.0-or-later
// `impulse`: a W that is formed, or kept and corrected by what the bodies themselves answer.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// A defect that shrinks by less from product to product, or takes more of them, calls for a new W.
constexpr double slowest_rate = 0.5;
constexpr int most_pushes = 15;
// A new W costs about this many products, and its factor one more for each so many rows:
// docs/decisions/contact-cost.md.
constexpr double products_of_W = 4, rows_of_a_product = 400;
// Products a step that W_0 needs at any age where bodies turn, as W is another in each step: the
// first tells the defect, the second that it is right. A new W saves none of them.
constexpr int products_of_turns = 2;
constexpr Index longest_wait = 64;
// Points that come are added while they are fewer than this share.
constexpr double most_new = 0.25;
// Solutions between products, until what the model says of their impulses is what was taken for it.
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

// The solver takes the gaps that it ends with from the bodies' own products, as these are wanted in
// any case.
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

// While the rows and what is closed stand, the bodies' own products, which are wanted in any case,
// tell the gaps: W is not read.
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

// For each point the old one with its key, or -1. Both lists are searched in the same order, so
// that most follow each other.
std::vector<Index> match(const std::vector<PointKey>& keys, const std::vector<PointKey>& old) {
  std::vector<Index> from(keys.size(), -1);
  std::size_t next = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto begin = old.begin() + static_cast<std::ptrdiff_t>(next);
    const auto found = std::find(begin, old.end(), keys[i]);
    if (found == old.end()) continue;
    next = static_cast<std::size_t>(found - old.begin());
    from[i] = static_cast<Index>(next++);
  }
  return from;
}

// W_0 over the points of this step: rows of those that stay are kept, others formed, column by
// column.
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
  memory.rows = ContactList();  // of several steps
  memory.laws = step.laws;
  memory.keys = memory.new_keys;
  ++memory.n_changed;
}

// Whether W_0 may serve: dense, regular, large enough, of about the same points; they are those of
// the step then.
bool keep(const ImpulseStep& step, const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (memory.solver->W().is_sparse || step.g.size() < memory.options.least_rows ||
      !step.g.allFinite())
    return false;
  // A solution is dearer than W then, with friction it ends short of what a correction needs, and
  // rows of two geometries beside each other make no semi-definite W where it has no rank to spare
  if (memory.solver->W_is_singular()) return false;
  if (memory.wait > 0) {
    --memory.wait;
    return false;
  }
  const double dear = products_of_W + static_cast<double>(step.g.size()) / rows_of_a_product;
  if (memory.extra > dear) return false;
  fill_keys(step.list, step.laws, memory.new_keys);
  if (memory.new_keys == memory.keys) return same_laws(step.laws, memory.laws);
  const std::vector<Index> from = match(memory.new_keys, memory.keys);
  const auto n_new = static_cast<double>(std::count(from.begin(), from.end(), Index{-1}));
  if (n_new > most_new * static_cast<double>(from.size())) return false;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (from[i] >= 0 && !same_laws({step.laws[i]}, {memory.laws[from[i]]})) return false;
  change_points(step, from, bodies, memory);
  return true;
}

bool has_friction(const std::vector<PointLaw>& laws) {
  return std::any_of(laws.begin(), laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::coulomb; });
}

// Impulses of W_0 with the defect that the model expects of them; `taken`: what was taken for it.
ContactSolution solve_with_model(const ImpulseStep& step, const Vector& guess, double enough,
                                 ImpulseMemory& memory, Vector& taken) {
  ContactSolution solution;
  memory.defects.predict(guess, taken);
  Vector expected;
  // With friction a solution is dearer than a product
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

// A body that turns has a new response in each step.
bool any_turns(const ContactList& list, const std::vector<ContactBody>& bodies) {
  return std::any_of(list.terms.begin(), list.terms.end(),
                     [&](const ContactTerm& term) { return bodies[term.body].turn.has_value(); });
}

// With g + defect the laws hold for W_0, with what p does to the bodies for W: until both are the
// same. False when that takes long.
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
    const Vector error = step.gap - solution.gap;  // (W - W_0) p - what was taken for it
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

// Without impulses no point closes: nothing has to be pushed, whatever W is.
bool stays_apart(const ContactList& list, const std::vector<PointLaw>& laws) {
  for (std::size_t i = 0; i < list.points.size(); ++i)
    if (laws[i].law == ContactLaw::tied || !(list.points[i].gap[0] >= 0)) return false;
  return true;
}

// Gaps are differences of positions, and below the round-off of these there are none: `scale` may
// be no more than that where nothing pushes.
double seen_residual(const ImpulseStep& step, const std::vector<ContactBody>& bodies) {
  constexpr double worth_a_look = 1e-9, round_off = 1e-15;
  if (!(step.residual > worth_a_look) || !std::isfinite(step.residual)) return step.residual;
  double reach = 0;
  for (const ContactTerm& term : step.list.terms)
    reach = std::max(reach, bodies[term.body].end.row(term.node).lpNorm<Eigen::Infinity>());
  const double violation = step.residual * step.g.lpNorm<Eigen::Infinity>();
  return violation <= round_off * reach ? 0 : step.residual;
}

// The last step's impulses of the unknowns that are there again.
Vector guess_of(const ContactUnknowns& unknowns, const ImpulseMemory& memory) {
  const std::vector<Index> first = first_rows(unknowns.laws),
                           old_first = first_rows(memory.unknowns.laws);
  Vector guess = Vector::Zero(first.back());
  if (memory.x.size() != old_first.back()) return guess;
  const auto& old = memory.unknowns.keys;
  std::size_t next = 0;
  for (std::size_t i = 0; i < unknowns.keys.size(); ++i) {
    // Both are in the order of searches, functions and points, so that most follow each other
    const auto begin = old.begin() + static_cast<std::ptrdiff_t>(next);
    const auto found = std::find(begin, old.end(), unknowns.keys[i]);
    if (found == old.end()) continue;
    next = static_cast<std::size_t>(found - old.begin());
    const Index n = n_rows(unknowns.laws[i].law);
    if (n_rows(memory.unknowns.laws[next].law) == n)
      guess.segment(first[i], n) = memory.x.segment(old_first[next], n);
    ++next;
  }
  return guess;
}

bool same_matrix(const SparseMatrix& a, const SparseMatrix& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || a.nonZeros() != b.nonZeros()) return false;
  return std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.cols() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
         std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

// A = N Y + E Z: shares of functions, and what single rows of points differ by from these.
struct Decomposition {
  std::vector<Index> rows;  // ascending, that E has a column for
  SparseMatrix Y, Z;
};

Decomposition decompose(const ContactUnknowns& unknowns, const SparseMatrix& N) {
  Decomposition of;
  std::vector<Eigen::Triplet<double, Index>> shares, rest;
  const auto add = [&](Index row, Index u, double value) {
    if (value != 0) rest.emplace_back(row, u, value);
  };
  for (Index u = 0; u < unknowns.A.cols(); ++u) {
    const Index column = unknowns.column[static_cast<std::size_t>(u)];
    SparseMatrix::InnerIterator own(unknowns.A, u);
    if (column < 0) {
      for (; own; ++own) add(own.row(), u, own.value());
      continue;
    }
    const double share = unknowns.share[u];
    shares.emplace_back(column, u, share);
    // What is cut off; the rest is the same number
    for (SparseMatrix::InnerIterator whole(N, column); whole; ++whole) {
      if (own && own.row() == whole.row()) {
        ++own;
      } else {
        add(whole.row(), u, -share * whole.value());
      }
    }
  }
  for (const auto& entry : rest) of.rows.push_back(entry.row());
  std::sort(of.rows.begin(), of.rows.end());
  of.rows.erase(std::unique(of.rows.begin(), of.rows.end()), of.rows.end());
  for (auto& entry : rest)
    entry = {std::lower_bound(of.rows.begin(), of.rows.end(), entry.row()) - of.rows.begin(),
             entry.col(), entry.value()};
  of.Y.resize(N.cols(), unknowns.A.cols());
  of.Y.setFromTriplets(shares.begin(), shares.end());
  of.Z.resize(static_cast<Index>(of.rows.size()), unknowns.A.cols());
  of.Z.setFromTriplets(rest.begin(), rest.end());
  return of;
}

// A^T G S G^T A, from what is kept of all functions and from rows of single points.
GapResponse response_of_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                                 const std::vector<ContactBody>& bodies,
                                 const ContactUnknowns& unknowns, const Decomposition& of,
                                 const ImpulseMemory& memory) {
  GapResponse W;
  W.dense = of.Y.transpose() * Matrix(memory.between * of.Y);
  if (of.rows.empty()) return W;
  std::vector<Eigen::Triplet<double, Index>> own;
  for (std::size_t i = 0; i < of.rows.size(); ++i)
    own.emplace_back(of.rows[i], static_cast<Index>(i), 1.0);
  SparseMatrix E(unknowns.A.rows(), static_cast<Index>(of.rows.size()));
  E.setFromTriplets(own.begin(), own.end());
  const GapResponse single = gap_response(list, laws, bodies, &ContactBody::response, &E);
  const Matrix beside = memory.answers(of.rows, Eigen::all) * of.Y;
  const Matrix mixed = of.Z.transpose() * beside;
  const Matrix among =
      single.is_sparse ? Matrix(single.sparse * Matrix(of.Z)) : Matrix(single.dense * of.Z);
  W.dense += mixed + mixed.transpose();
  W.dense.noalias() += of.Z.transpose() * among;
  W.dense = 0.5 * (W.dense + W.dense.transpose()).eval();
  return W;
}

// Nodes that answer by their own masses make a sparse W, which costs little to form anew.
bool any_lumped(const ContactList& list, const std::vector<ContactBody>& bodies) {
  return std::any_of(list.terms.begin(), list.terms.end(), [&](const ContactTerm& term) {
    return bodies[term.body].response.is_diagonal();
  });
}

void keep_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                    const std::vector<FunctionsOfSearch>& searches,
                    const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  memory.statics = StaticAnswers();
  memory.N.resize(0, 0);
  if (any_lumped(list, bodies)) return;
  memory.N = function_matrix(list, laws, searches);
  memory.answers = gap_answers(list, laws, bodies, memory.N, memory.statics);
  memory.between = memory.N.transpose() * memory.answers;
}

// p = A x; what functions do to static rows is known.
void push_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                    const Decomposition& of, const Vector& p, const Vector& x,
                    const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (memory.N.size() == 0) return memory.moves.push(list, laws, p, bodies);
  Vector rest = Vector::Zero(p.size());
  rest(of.rows) = of.Z * x;
  const CombinedImpulses combined{memory.statics, of.Y * x, std::move(rest)};
  memory.moves.push(list, laws, p, bodies, &combined);
}

// Few unknowns: W is formed and factored whenever they change.
EnforcementResult enforce_in_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                                       const std::vector<FunctionsOfSearch>& searches,
                                       ContactUnknowns unknowns, double h,
                                       std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  const Vector g_points = pack(gaps(list), laws), g = unknowns.A.transpose() * g_points;
  const Vector guess = guess_of(unknowns, memory);
  const bool same_space = memory.solver && memory.h == h && memory.unknowns.reduced &&
                          !any_turns(list, bodies) && same_laws(laws, memory.laws) &&
                          same_rows(list, memory.rows, laws, same_row_tolerance);
  if (!same_space) {
    memory.rows = list;
    memory.laws = laws;
    memory.h = h;
    keep_functions(list, laws, searches, bodies, memory);
    memory.keys.clear();
    memory.defects.clear();
    memory.extra = 0;
  }
  const bool lumped = memory.N.size() == 0;
  const Decomposition of = lumped ? Decomposition() : decompose(unknowns, memory.N);
  if (!same_space || !same_laws(unknowns.laws, memory.unknowns.laws) ||
      !same_matrix(unknowns.A, memory.unknowns.A)) {
    memory.solver.emplace(
        lumped ? gap_response(list, laws, bodies, &ContactBody::response, &unknowns.A)
               : response_of_unknowns(list, laws, bodies, unknowns, of, memory),
        unknowns.laws, lumped);
    ++memory.n_formed;
  }
  const ContactSolution solution = memory.solver->solve(g, guess);
  const Vector p = unknowns.A * solution.p;
  push_functions(list, laws, of, p, solution.p, bodies, memory);
  Vector gap = g_points;
  memory.moves.add_to_gaps(list, laws, gap);
  memory.moves.give(bodies);
  memory.unknowns = std::move(unknowns);
  memory.x = solution.p;
  EnforcementResult result{unpack(p, laws), unpack(gap, laws), solution.residual, solution.fallback,
                           memory.unknowns.of_searches()};
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

// Bodies that no force deforms give way in six motions each: few points hold them, and all others
// stay apart then.
bool are_rigid(const ContactList& list, const std::vector<ContactBody>& bodies) {
  constexpr Index rigid_motions = 6;
  return std::all_of(list.terms.begin(), list.terms.end(), [&](const ContactTerm& term) {
    const auto& thin = bodies[term.body].response.thin;
    return thin && thin->A->rows() <= rigid_motions && thin->rows->size() == 0;
  });
}

// The points that push, found one by one: those of the last step, and then in each round those that
// would end deepest. None: they are too many for that.
class PointByPoint {
 public:
  PointByPoint(const ContactList& list, const std::vector<PointLaw>& laws, const Points& guess,
               const std::vector<FunctionsOfSearch>& searches,
               const std::vector<ContactBody>& bodies)
      : list_(list),
        laws_(laws),
        guess_(guess),
        searches_(searches),
        bodies_(bodies),
        g_(pack(gaps(list), laws)) {
    is_taken_.assign(laws.size(), 0);
    for (std::size_t i = 0; i < laws.size(); ++i)
      if (laws[i].law == ContactLaw::tied) is_taken_[i] = 1;
    // Where points pushed, these begin: those that touch as deep but for round-off would change
    // from step to step
    const Points gap = unpack(g_, laws);
    for (const FunctionsOfSearch& search : searches)
      if (!take_pushing(search)) take_deepest(search, gap, 0);
  }

  std::optional<EnforcementResult> solve(double h, std::vector<ContactBody>& bodies,
                                         ImpulseMemory& memory) {
    constexpr int most_rounds = 60;
    // A share of the deepest: as far as a residual of contact's solution is felt
    constexpr double closed = 1e-9;
    const double deepest = g_.lpNorm<Eigen::Infinity>();
    for (int round = 0; round < most_rounds; ++round) {
      ContactList chosen;
      chosen.terms = list_.terms;
      std::vector<PointLaw> laws;
      std::vector<Index> places;
      for (std::size_t i = 0; i < laws_.size(); ++i) {
        if (is_taken_[i] == 0) continue;
        chosen.points.push_back(list_.points[i]);
        laws.push_back(laws_[i]);
        places.push_back(static_cast<Index>(i));
      }
      memory.solver.emplace(gap_response(chosen, laws, bodies), laws, false);
      const ContactSolution solution = memory.solver->solve(
          pack(gaps(chosen), laws), pack(Points(guess_(places, Eigen::all)), laws));
      memory.moves.push(chosen, laws, solution.p, bodies);
      Vector gap = g_;
      memory.moves.add_to_gaps(list_, laws_, gap);
      EnforcementResult result{Points::Zero(guess_.rows(), 3), unpack(gap, laws_),
                               solution.residual, solution.fallback};
      result.p(places, Eigen::all) = unpack(solution.p, laws);
      if (!gap.allFinite()) return result;
      bool more = false;
      for (const FunctionsOfSearch& search : searches_)
        more |= take_deepest(search, result.gap, closed * deepest);
      if (more) continue;
      memory.h = h;
      memory.moves.give(bodies);
      for (const FunctionsOfSearch& search : searches_)
        result.n_unknowns.push_back(
            std::count(is_taken_.begin() + static_cast<std::ptrdiff_t>(search.first),
                       is_taken_.begin() + static_cast<std::ptrdiff_t>(search.last), 1));
      return result;
    }
    return std::nullopt;
  }

 private:
  // Those that pushed most in the last step: where more did, others can hold as well.
  bool take_pushing(const FunctionsOfSearch& search) {
    constexpr std::size_t most = 6;
    std::vector<std::size_t> pushing;
    for (std::size_t i = search.first; i < search.last; ++i)
      if (guess_(static_cast<Index>(i), 0) > 0) pushing.push_back(i);
    const auto end = pushing.begin() + static_cast<std::ptrdiff_t>(std::min(most, pushing.size()));
    std::partial_sort(pushing.begin(), end, pushing.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(-guess_(static_cast<Index>(a), 0), a) <
             std::pair(-guess_(static_cast<Index>(b), 0), b);
    });
    std::for_each(pushing.begin(), end, [&](std::size_t i) { is_taken_[i] = 1; });
    return !pushing.empty();
  }

  // The deepest point of a search that is not taken, and the one that is deep and far from it.
  bool take_deepest(const FunctionsOfSearch& search, const Points& gap, double closed) {
    const std::size_t none = search.last;
    const auto find = [&](const auto& weight) {
      std::size_t best = none;
      double most = 0;
      for (std::size_t i = search.first; i < search.last; ++i) {
        const double depth = -gap(static_cast<Index>(i), 0);
        if (is_taken_[i] != 0 || !(depth > closed) || !(depth * weight(i) > most)) continue;
        best = i;
        most = depth * weight(i);
      }
      return best;
    };
    const std::size_t first = find([](std::size_t) { return 1.0; });
    if (first == none) return false;
    is_taken_[first] = 1;
    const std::size_t second =
        find([&](std::size_t i) { return (place(i) - place(first)).norm(); });
    if (second != none) is_taken_[second] = 1;
    return true;
  }

  Vector3 place(std::size_t i) const { return slave_position(list_, list_.points[i], bodies_); }

  const ContactList& list_;
  const std::vector<PointLaw>& laws_;
  const Points& guess_;
  const std::vector<FunctionsOfSearch>& searches_;
  const std::vector<ContactBody>& bodies_;
  const Vector g_;
  std::vector<char> is_taken_;
};

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
    if (auto result = PointByPoint(list, laws, guess, searches, bodies).solve(h, bodies, memory)) {
      memory.rows = ContactList();
      spread_impulses(list, laws, result->p, bodies);
      return std::move(*result);
    }
  }
  ContactUnknowns unknowns = choose_unknowns(list, laws, searches);
  if (unknowns.reduced)
    return enforce_in_functions(list, laws, searches, std::move(unknowns), h, bodies, memory);
  ImpulseStep step{list, laws, pack(gaps(list), laws), pack(guess, laws), {}, {}, 0, false, false};
  const bool stands = memory.solver && memory.h == h && !memory.unknowns.reduced;
  memory.unknowns = ContactUnknowns();
  if (stands && !any_turns(list, bodies) && same_laws(laws, memory.laws) &&
      same_rows(list, memory.rows, laws, same_row_tolerance)) {
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
