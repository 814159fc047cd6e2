// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/few_unknowns.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

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

bool any_turns(const ContactList& list, const std::vector<ContactBody>& bodies) {
  return std::any_of(list.terms.begin(), list.terms.end(),
                     [&](const ContactTerm& term) { return bodies[term.body].turn.has_value(); });
}

EnforcementResult enforce_in_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                                       const std::vector<FunctionsOfSearch>& searches,
                                       ContactUnknowns unknowns, double h,
                                       std::vector<ContactBody>& bodies, ImpulseMemory& memory) {
  const Vector g_points = pack(gaps(list), laws);
  Vector g = unknowns.A.transpose() * g_points;
  keep_depths(list, laws, searches, unknowns, g);
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
  EnforcementResult result{unpack(p, laws),
                           unpack(gap, laws),
                           solution.residual,
                           solution.fallback,
                           memory.unknowns.of_searches(),
                           held_points(memory.unknowns, memory.x)};
  // Faces of second order alone have no fewer unknowns than they must
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
