// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/few_unknowns.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/contact/enforce/rotating_slip.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// For each unknown the one of the last step with equal key and law, or -1.
std::vector<Index> match(const ContactUnknowns& unknowns, const ContactUnknowns& old) {
  std::vector<Index> from = match(unknowns.keys, old.keys);
  for (std::size_t i = 0; i < from.size(); ++i)
    if (from[i] >= 0 && unknowns.laws[i].law != old.laws[from[i]].law) from[i] = -1;
  return from;
}

// Impulses of the last step for matching unknowns, 0 for others.
Vector guess_of(const ContactUnknowns& unknowns, const std::vector<Index>& from,
                const ImpulseMemory& memory) {
  const std::vector<Index> first = first_rows(unknowns.laws),
                           old_first = first_rows(memory.unknowns.laws);
  Vector guess = Vector::Zero(first.back());
  if (memory.x.size() != old_first.back()) return guess;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from[i] < 0) continue;
    const Index n = n_rows(unknowns.laws[i].law);
    guess.segment(first[i], n) = memory.x.segment(old_first[from[i]], n);
  }
  return guess;
}

bool same_column(const SparseMatrix& a, Index i, const SparseMatrix& b, Index j) {
  SparseMatrix::InnerIterator x(a, i), y(b, j);
  for (; x && y; ++x, ++y)
    if (x.row() != y.row() || x.value() != y.value()) return false;
  return !x && !y;
}

// Restricts match() to unknowns with equal columns of A, others become -1; returned as rows.
std::vector<Index> keep_same(const ContactUnknowns& unknowns, const ContactUnknowns& old,
                             std::vector<Index>& from) {
  const std::vector<Index> first = first_rows(unknowns.laws), old_first = first_rows(old.laws);
  std::vector<Index> rows(static_cast<std::size_t>(first.back()), -1);
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from[i] < 0) continue;
    const Index shift = old_first[from[i]] - first[i];
    bool same = true;
    for (Index row = first[i]; row < first[i + 1]; ++row)
      same = same && same_column(unknowns.A, row, old.A, row + shift);
    if (!same) from[i] = -1;
    for (Index row = first[i]; same && row < first[i + 1]; ++row) rows[row] = row + shift;
  }
  return rows;
}

// Means of gaps let single nodes penetrate, which may become unknowns or a part of other functions.
// Pushing them out at once would add energy. So an unknown acts at the depth that it starts with,
// less a share of the way that it would go in without impulses. As long as it has the same points,
// it keeps that depth until it comes out. `from`: unknowns of the last step in `old`, or -1.
Vector kept_depths(const ContactList& list, const std::vector<PointLaw>& laws,
                   const std::vector<FunctionsOfSearch>& searches, const ContactUnknowns& unknowns,
                   const std::vector<Index>& from, const ContactUnknowns& old) {
  const std::vector<Index> first = first_rows(laws), first_unknown = first_rows(unknowns.laws),
                           first_old = first_rows(old.laws);
  Matrix gaps = Matrix::Zero(first.back(), 2);  // at the start, and without impulses at the end
  for (std::size_t i = 0; i < laws.size(); ++i)
    gaps.row(first[i]) << list.points[i].start_gap, list.points[i].gap[0];
  Vector depths = Vector::Zero(unknowns.size());
  for (Index u = 0; u < depths.size(); ++u) {
    const auto number = static_cast<std::size_t>(unknowns.keys[u].search);
    const FunctionsOfSearch& search = searches[number];
    if (!search.has_any()) continue;
    const Index row = first_unknown[u], before = from[u];
    const Eigen::RowVector2d gap = unknowns.A.col(row).transpose() * gaps;
    depths[u] = std::min(0.0, gap[0] + search.correction * std::max(0.0, gap[0] - gap[1]));
    // Which functions of corners serve depends on depths: with memory, round-off decided
    if (before >= 0 && search.corners == nullptr && old.pairs[number] == search.pair &&
        same_column(unknowns.A, row, old.A, first_old[before]))
      depths[u] = std::max(depths[u], old.depths[before]);
  }
  return depths;
}

// Combinations of functions and points for the unknowns. A truncated function is given by its
// remaining points, or as the whole function minus the other points, whichever are fewer. n: single
// rows are completed to groups of so many.
Combinations combine(const ContactUnknowns& unknowns, const SparseMatrix& N, Index n) {
  Combinations of;
  std::vector<Eigen::Triplet<double, Index>> shares, rest;
  for (Index u = 0; u < unknowns.A.cols(); ++u) {
    const Index column = unknowns.column[u];
    const Index left = unknowns.A.col(u).nonZeros();
    const Index whole = column < 0 ? 0 : N.col(column).nonZeros();
    SparseMatrix::InnerIterator own(unknowns.A, u);
    if (2 * left < whole || column < 0) {
      for (; own; ++own) rest.emplace_back(own.row(), u, own.value());
      continue;
    }
    const double share = unknowns.share[u];
    shares.emplace_back(column, u, share);
    for (SparseMatrix::InnerIterator it(N, column); it; ++it) {
      if (own && own.row() == it.row()) {
        ++own;
      } else if (it.value() != 0) {
        rest.emplace_back(it.row(), u, -share * it.value());
      }
    }
  }
  for (const auto& entry : rest)
    for (Index d = 0; d < n; ++d) of.rows.push_back(entry.row() - entry.row() % n + d);
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

// Lumped nodes make W sparse, and so cheap to form anew.
bool any_lumped(const ContactList& list, const std::vector<ContactBody>& bodies) {
  return std::any_of(list.terms.begin(), list.terms.end(), [&](const ContactTerm& term) {
    return bodies[term.body].response.is_diagonal();
  });
}

// Functions of `rows` and their responses, unless lumped nodes make W sparse.
void start_standing(const std::vector<FunctionsOfSearch>& searches,
                    const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  memory.standing.clear();
  if (any_lumped(memory.rows, bodies)) return;
  memory.N = function_matrix(memory.rows, memory.laws, searches);
  if (!memory.rotates) return memory.standing.start(memory.rows, memory.laws, bodies, memory.N);
  const std::vector<PointLaw> three(memory.laws.size(), {ContactLaw::tied, 0});
  memory.standing.start(memory.rows, three, bodies, function_matrix(memory.rows, three, searches),
                        true);
}

// Points or functions of `n` rows each, along axes T (rows) of the body: three rows each instead.
SparseMatrix along_body(Index count, Index n, const Matrix3& T) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index i = 0; i < count; ++i)
    for (Index d = 0; d < n; ++d)
      for (Index c = 0; c < 3; ++c) entries.emplace_back(3 * i + c, n * i + d, T(d, c));
  SparseMatrix all(3 * count, n * count);
  all.setFromTriplets(entries.begin(), entries.end());
  return all;
}

Combinations combine(const ContactUnknowns& unknowns, const ImpulseMemory& memory) {
  if (!memory.rotates) return combine(unknowns, memory.N, 1);
  const Index n = n_rows(memory.laws.front().law);
  Combinations of = combine(unknowns, memory.N, n);
  of.Y = along_body(of.Y.rows() / n, n, memory.axes) * of.Y;
  of.Z = along_body(of.Z.rows() / n, n, memory.axes) * of.Z;
  std::vector<Index> rows;
  for (std::size_t i = 0; i < of.rows.size(); i += static_cast<std::size_t>(n))
    for (Index c = 0; c < 3; ++c) rows.push_back(3 * (of.rows[i] / n) + c);
  of.rows = std::move(rows);
  return of;
}

// Restores the state from before a checkpoint.
void keep_again(const std::vector<FunctionsOfSearch>& searches,
                const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (!memory.standing.empty()) return;
  start_standing(searches, bodies, memory);
  if (memory.standing.empty()) return;
  memory.standing.take(combine(memory.unknowns, memory),
                       std::vector<Index>(static_cast<std::size_t>(memory.unknowns.A.cols()), -1));
}

// Forms W of the unknowns; reuses rows of the last step in the same space. False: nothing changed.
bool form_few(const ContactList& list, const std::vector<PointLaw>& laws,
              const ContactUnknowns& unknowns, bool same_space, std::vector<Index> from,
              const std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  if (!same_space) std::fill(from.begin(), from.end(), -1);
  const std::vector<Index> rows = keep_same(unknowns, memory.unknowns, from);
  const auto n = static_cast<Index>(rows.size());
  Index kept = 0;
  while (kept < n && rows[kept] == kept) ++kept;
  if (kept == n && n == memory.unknowns.A.cols()) return false;
  ++memory.n_formed;
  GapResponse W;
  if (memory.standing.empty()) {
    W = gap_response(list, laws, bodies, &ContactBody::response, &unknowns.A);
  } else {
    memory.standing.take(combine(unknowns, memory), rows);
    W.dense = memory.standing.form(rows, same_space ? &memory.solver->W().dense : nullptr);
  }
  ContactSolver solver(std::move(W), unknowns.laws);
  if (memory.solver) solver.begin_as(*memory.solver);
  memory.solver = std::move(solver);
  return true;
}

// Whether all points have the same axes and one body alone, which has large rotation.
bool rotates_alone(const ContactList& list, const std::vector<PointLaw>& laws,
                   const std::vector<ContactBody>& bodies) {
  const Index body = list.terms.front().body;
  const Matrix3& frame = list.points.front().frame;
  return bodies[body].turn && !bodies[body].response.is_diagonal() &&
         std::all_of(laws.begin(), laws.end(),
                     [&](const PointLaw& law) { return law.law == laws.front().law; }) &&
         std::all_of(list.terms.begin(), list.terms.end(),
                     [&](const ContactTerm& term) { return term.body == body; }) &&
         std::all_of(list.points.begin(), list.points.end(),
                     [&](const ContactPoint& point) { return point.frame == frame; });
}

// The same points along the axes of their body.
ContactList in_body_axes(ContactList list) {
  for (ContactPoint& point : list.points) point.frame.setIdentity();
  return list;
}

// Finds the active points one by one: those of the last step, then in each round those that would
// end deepest. None: too many rounds.
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
    // Points of the last step come first: a choice among equal depths would change from step to
    // step by round-off
    const Points gap = unpack(g_, laws);
    for (const FunctionsOfSearch& search : searches)
      if (!take_pushing(search)) take_deepest(search, gap, 0);
  }

  std::optional<EnforcementResult> solve(double h, std::vector<ContactBody>& bodies,
                                         ImpulseMemory& memory) {
    constexpr int most_rounds = 60;
    // Relative to the deepest gap: the effect of the residual of contact's solution
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
      memory.solver.emplace(gap_response(chosen, laws, bodies), laws);
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
  // Takes the largest impulses of the last step: if more points acted, a part of them suffices.
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

  // Takes the deepest free point of a search, and one that is deep and far from it.
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

bool any_turns(const ContactList& list, const std::vector<ContactBody>& bodies) {
  return std::any_of(list.terms.begin(), list.terms.end(),
                     [&](const ContactTerm& term) { return bodies[term.body].turn.has_value(); });
}

namespace {

// Solves for the unknowns; returns the gaps of the points' rows with the impulses.
Vector solve_few(const ContactList& list, const std::vector<PointLaw>& laws,
                 const std::vector<FunctionsOfSearch>& searches, const Vector& g_points,
                 const ContactUnknowns& unknowns, bool same_space,
                 const std::vector<ContactBody>& bodies, ImpulseMemory& memory,
                 ContactSolution& solution) {
  Vector g = unknowns.A.transpose() * g_points;
  const std::vector<Index> from = match(unknowns, memory.unknowns),
                           first = first_rows(unknowns.laws);
  const Vector depths = kept_depths(list, laws, searches, unknowns, from, memory.unknowns);
  for (Index u = 0; u < depths.size(); ++u) g[first[u]] -= depths[u];
  const Vector guess = guess_of(unknowns, from, memory);
  if (form_few(list, laws, unknowns, same_space, from, bodies, memory)) memory.unknowns = unknowns;
  memory.unknowns.laws = unknowns.laws;
  memory.unknowns.depths = depths;
  memory.unknowns.friction_factors = unknowns.friction_factors;
  memory.solver->take_friction(unknowns.laws);
  solution = memory.solver->solve(g, guess);
  const StaticAnswers known = memory.standing.statics(solution.p);
  memory.moves.push(list, laws, unknowns.A * solution.p, bodies, &known);
  memory.x = solution.p;
  Vector gap = g_points;
  memory.moves.add_to_gaps(list, laws, gap);
  return gap;
}

// Adds omitted points that penetrate to `wanted`.
bool want_more(const std::vector<PointLaw>& laws, const ContactUnknowns& unknowns,
               const Vector& g_points, const Vector& gap, std::vector<std::size_t>& wanted) {
  // Relative to the deepest gap: the effect of the residual of contact's solution
  constexpr double closed = 1e-9;
  if (unknowns.left_out.empty() || !gap.allFinite()) return false;
  const std::vector<Index> first = first_rows(laws);
  const double least = -closed * g_points.lpNorm<Eigen::Infinity>();
  const std::size_t before = wanted.size();
  for (const std::size_t i : unknowns.left_out)
    if (gap[first[i]] < least) wanted.push_back(i);
  std::sort(wanted.begin(), wanted.end());
  return wanted.size() > before;
}

}  // namespace

EnforcementResult enforce_in_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                                       const std::vector<FunctionsOfSearch>& searches,
                                       ContactUnknowns& unknowns, double h,
                                       std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  const Vector g_points = pack(gaps(list), laws);
  const bool rotates = rotates_alone(list, laws, bodies);
  const ContactList in_body = rotates ? in_body_axes(list) : ContactList();
  const ContactList& rows = rotates ? in_body : list;
  Matrix3 axes = Matrix3::Identity();
  if (rotates) axes = list.points.front().frame * bodies[list.terms.front().body].response.axes;
  const bool same_points = memory.solver && memory.h == h && memory.unknowns.reduced &&
                           (rotates || !any_turns(list, bodies)) && rotates == memory.rotates &&
                           same_laws(laws, memory.laws) &&
                           same_rows(rows, memory.rows, laws, same_row_tolerance);
  const bool same_space = same_points && axes == memory.axes;
  if (same_points) {
    keep_again(searches, bodies, memory);
  } else {
    memory.rows = rows;
    memory.laws = laws;
    memory.h = h;
    memory.rotates = rotates;
    start_standing(searches, bodies, memory);
  }
  memory.axes = axes;
  ContactSolution solution;
  std::vector<std::size_t> wanted;
  Vector gap =
      solve_few(list, laws, searches, g_points, unknowns, same_space, bodies, memory, solution);
  while (want_more(laws, unknowns, g_points, gap, wanted)) {
    unknowns = choose_unknowns(list, laws, searches, &memory.unknowns, wanted);
    gap = solve_few(list, laws, searches, g_points, unknowns, true, bodies, memory, solution);
  }
  memory.moves.give(bodies);
  memory.unknowns.friction_factors =
      friction_factors(memory.unknowns, list, laws, bodies, gap, memory.x);
  unknowns.remember_cells(searches);
  EnforcementResult result{unpack(unknowns.A * memory.x, laws),
                           unpack(gap, laws),
                           solution.residual,
                           solution.fallback,
                           unknowns.of_searches(),
                           held_points(unknowns, memory.x)};
  // Searches with second-order faces alone do not report reduced unknowns
  for (std::size_t s = 0; s < searches.size(); ++s)
    if (searches[s].functions == nullptr) result.n_unknowns[s] = 0;
  spread_impulses(list, laws, result.p, bodies);
  return result;
}

bool are_rigid(const ContactList& list, const std::vector<ContactBody>& bodies) {
  constexpr Index rigid_motions = 6;
  return std::all_of(list.terms.begin(), list.terms.end(), [&](const ContactTerm& term) {
    const auto& thin = bodies[term.body].response.thin;
    return thin && thin->A->rows() <= rigid_motions && thin->rows->size() == 0;
  });
}

std::optional<EnforcementResult> enforce_point_by_point(
    const ContactList& list, const std::vector<PointLaw>& laws, const Points& guess,
    const std::vector<FunctionsOfSearch>& searches, double h, std::vector<ContactBody>& bodies,
    ImpulseMemory& memory) {
  std::optional<EnforcementResult> result =
      PointByPoint(list, laws, guess, searches, bodies).solve(h, bodies, memory);
  if (!result) return result;
  memory.rows = ContactList();
  spread_impulses(list, laws, result->p, bodies);
  return result;
}

}  // namespace cbr
