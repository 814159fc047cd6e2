// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/enforce_static.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/contact/enforce/static_system.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// Gaps per unit motion of `floating`: a column for each of `columns`, ascending. Round-off of R is
// none: it would close gaps by motions without end along a face.
Matrix floating_rows(const ContactList& list, const std::vector<PointLaw>& laws,
                     const std::vector<FloatingNodes>& floating,
                     const std::vector<Index>& columns) {
  constexpr double round_off = 1e-11;
  Matrix B = Matrix::Zero(first_rows(laws).back(), static_cast<Index>(columns.size()));
  Vector sizes = Vector::Zero(B.cols());  // largest displacement of each motion
  Index row = 0;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    const Index n = n_rows(laws[i].law);
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      const FloatingNodes& body = floating[term.body];
      if (body.R.cols() == 0) continue;
      const Index at =
          std::lower_bound(columns.begin(), columns.end(), body.first) - columns.begin();
      const auto R = body.R.middleRows(3 * term.node, 3);
      B.block(row, at, n, R.cols()) += term.coefficient * point.frame.topRows(n) * R;
      auto size = sizes.segment(at, R.cols());
      size = size.cwiseMax(R.colwise().norm().transpose());
    }
    row += n;
  }
  return (B.array().abs() > round_off * sizes.transpose().array().replicate(B.rows(), 1))
      .select(B, 0);
}

// Amplitudes of all columns.
Vector of_columns(const Matrix& motions, const Vector& a) {
  return motions.size() > 0 ? Vector(motions * a) : a;
}

// Relative violation; 0 below the round-off of gaps, which are differences of positions.
double share_of_gaps(double violation, double scale, const ContactList& list,
                     const std::vector<ContactBody>& bodies) {
  constexpr double round_off = 1e-15;
  double reach = 0;
  for (const ContactTerm& term : list.terms)
    reach = std::max(reach, bodies[term.body].end.row(term.node).lpNorm<Eigen::Infinity>());
  return violation > round_off * reach ? violation / scale : 0;
}

// One set of points and loads, for any unknowns on them.
class StaticStep {
 public:
  StaticStep(const ContactList& list, const std::vector<PointLaw>& laws,
             const std::vector<FloatingNodes>& floating, const std::vector<Index>& columns,
             const Matrix& motions, const std::vector<ContactBody>& bodies, StaticMemory& memory)
      : list_(list),
        laws_(laws),
        floating_(floating),
        columns_(columns),
        motions_(motions),
        bodies_(bodies),
        memory_(memory) {}

  // p and gap: of the points.
  StaticSystem::Solution solve(const ContactUnknowns& unknowns, const Vector& g, const Vector& c,
                               const Vector& guess, double largest_force, double most_way) {
    form(unknowns, std::max(largest_force, c.size() > 0 ? c.lpNorm<Eigen::Infinity>() : 0),
         most_way);
    if (!unknowns.reduced) return memory_.system->solve(g, c, guess, largest_force, most_way);
    StaticSystem::Solution solution = memory_.system->solve(
        unknowns.A.transpose() * g, c, unknowns.guess(laws_, guess), largest_force, most_way);
    x_ = solution.p;
    solution.p = unknowns.A * x_;
    solution.gap = g + moved(solution.moves);
    BodyMoves moves;
    moves.push(list_, laws_, solution.p, bodies_);
    moves.add_to_gaps(list_, laws_, solution.gap);
    return solution;
  }
  const Vector& of_unknowns() const { return x_; }
  // Takes the functions of rigid bodies away: no depth says which of their points close.
  bool drop_rigid(const ContactUnknowns& unknowns, std::vector<FunctionsOfSearch>& searches) const {
    std::vector<char> moves(searches.size(), 0);
    const std::vector<Index> first = first_rows(unknowns.laws);
    for (std::size_t u = 0; u < unknowns.keys.size(); ++u)
      if (memory_.diagonal[first[u]] > 0) moves[unknowns.keys[u].search] = 1;
    bool any = false;
    for (const UnknownKey& key : unknowns.keys) {
      const auto s = static_cast<std::size_t>(key.search);
      if (moves[s] != 0 || searches[s].functions == nullptr) continue;
      searches[s].functions = nullptr;
      any = true;
    }
    return any;
  }
  // Gaps by floating motions.
  Vector moved(const Vector& moves) const {
    if (moves.size() == 0) return Vector::Zero(first_rows(laws_).back());
    return floating_rows(list_, laws_, floating_, columns_) * of_columns(motions_, moves);
  }

  // The points, each with the gap that it would have without the force of its own unknown. Open
  // ones are far away: they become unknowns once they penetrate.
  ContactList without_own_forces(const ContactUnknowns& unknowns, const Vector& p,
                                 const Vector& gap) const {
    // Relative to the largest gap, and to the depths
    constexpr double touches = 1e-9, far = 10;
    const std::vector<Index> first = first_rows(laws_), first_unknown = first_rows(unknowns.laws);
    Vector depth = Vector::Zero(gap.size());
    for (std::size_t u = 0; u < unknowns.laws.size(); ++u) {
      const Index row = first_unknown[u];
      for (SparseMatrix::InnerIterator it(unknowns.A, row); it; ++it)
        depth[it.row()] = std::max(depth[it.row()], memory_.diagonal[row] * x_[row]);
    }
    double largest = 0, deepest = depth.maxCoeff();
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      if (laws_[i].law == ContactLaw::tied) continue;
      largest = std::max(largest, std::abs(gap[first[i]]));
      deepest = std::max(deepest, -gap[first[i]]);
    }
    const double least = -touches * largest, open = far * deepest;
    ContactList points = list_;
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      const Index row = first[i];
      points.points[i].gap[0] = p[row] > 0 || gap[row] < least ? gap[row] - depth[row] : open;
    }
    return points;
  }

 private:
  // Forces of unresisted motions are round-off: `force`, the largest, scales their springs
  void form(const ContactUnknowns& unknowns, double force, double most_way) {
    if (memory_.system && memory_.columns == columns_ &&
        memory_.motions.cols() == motions_.cols() && memory_.motions == motions_ &&
        laws_ == memory_.laws && same_rows(list_, memory_.rows, laws_, 0) &&
        same_matrix(unknowns.A, memory_.A))
      return;
    const SparseMatrix* A = unknowns.reduced ? &unknowns.A : nullptr;
    GapResponse W = gap_response(list_, laws_, bodies_, &ContactBody::response, A);
    if (W.is_sparse) W.dense = W.sparse;
    Matrix B = floating_rows(list_, laws_, floating_, columns_);
    if (motions_.size() > 0) B = (B * motions_).eval();
    if (A != nullptr) B = (A->transpose() * B).eval();
    memory_.diagonal = W.dense.diagonal();
    memory_.system = std::make_shared<StaticSystem>(std::move(W.dense), std::move(B),
                                                    unknowns.reduced ? unknowns.laws : laws_,
                                                    force > 0 ? rigid_share * most_way / force : 1);
    memory_.rows = list_;
    memory_.laws = laws_;
    memory_.columns = columns_;
    memory_.motions = motions_;
    memory_.A = unknowns.A;
  }

  const ContactList& list_;
  const std::vector<PointLaw>& laws_;
  const std::vector<FloatingNodes>& floating_;
  const std::vector<Index>& columns_;
  const Matrix& motions_;
  const std::vector<ContactBody>& bodies_;
  StaticMemory& memory_;
  Vector x_;
};

// The points by the forces of the last solution alone: closed ones 1 deep, the others 1 apart. All
// points of a search without forces are closed.
ContactList by_forces(const ContactList& list, const std::vector<FunctionsOfSearch>& searches,
                      const Points& forces) {
  ContactList points = list;
  for (const FunctionsOfSearch& of : searches) {
    if (of.last == of.first) continue;
    const auto normal =
        forces.col(0).segment(static_cast<Index>(of.first), static_cast<Index>(of.last - of.first));
    const bool has_any = normal.maxCoeff() > 0;
    for (auto i = of.first; i < of.last; ++i)
      points.points[i].gap[0] = has_any && !(forces(static_cast<Index>(i), 0) > 0) ? 1 : -1;
  }
  return points;
}

}  // namespace

StaticResult enforce_static(const ContactList& list, const std::vector<PointLaw>& laws,
                            const Points& guess, const std::vector<FloatingNodes>& floating,
                            const std::vector<Index>& columns, const Matrix& motions,
                            const Vector& forces, double largest_force, double most_way,
                            std::vector<ContactBody>& bodies,
                            const std::vector<FunctionsOfSearch>& searches, StaticMemory& memory) {
  Vector c = forces(columns);
  if (motions.size() > 0) c = (motions.transpose() * c).eval();
  if (list.empty()) {
    const Vector left = of_columns(motions, c);
    const auto n = static_cast<Index>(columns.size());
    return {{.p = Points(0, 3), .gap = Points(0, 3)},
            unheld_moves(left, Matrix::Identity(n, n), largest_force, most_way),
            left,
            largest_force};
  }
  // Rounds in which the functions may still change. After them points are the unknowns, or the last
  // choice is kept where these are too many.
  constexpr int most_rounds = 12;
  std::vector<FunctionsOfSearch> used = searches;
  StaticStep step(list, laws, floating, columns, motions, bodies, memory);
  Vector g = pack(gaps(list), laws), moves = Vector::Zero(c.size());
  StaticSystem::Solution solution;
  solution.p = pack(guess, laws);
  ContactUnknowns unknowns;
  ContactList state = by_forces(list, searches, guess);
  for (int round = 0;; ++round) {
    if (round == most_rounds) {
      if (g.size() > most_rows_of_points) break;
      for (FunctionsOfSearch& of : used) of.functions = nullptr;
    }
    ContactUnknowns chosen = choose_unknowns(state, laws, used, nullptr);
    const bool stands = chosen.keys == unknowns.keys && same_matrix(chosen.A, unknowns.A);
    if (round > 0 && chosen.reduced && (chosen.size() == 0 || stands)) break;
    unknowns = std::move(chosen);
    solution = step.solve(unknowns, g, c, solution.p, largest_force, most_way);
    moves += solution.moves;
    if (!unknowns.reduced || !solution.gap.allFinite()) break;
    g += step.moved(solution.moves);
    if (step.drop_rigid(unknowns, used)) continue;
    state = step.without_own_forces(unknowns, solution.p, solution.gap);
  }
  unknowns.remember_cells(used);
  StaticResult result;
  if (unknowns.reduced) {
    result.of_points.held = held_points(unknowns, step.of_unknowns());
    result.of_points.n_unknowns = unknowns.of_searches();
    for (std::size_t s = 0; s < used.size(); ++s)
      if (used[s].functions == nullptr) result.of_points.n_unknowns[s] = 0;
  }
  result.of_points.p = unpack(solution.p, laws);
  result.of_points.gap = unpack(solution.gap, laws);
  memory.gap = std::max(memory.gap, solution.scale);
  // Without forces all gaps of an iteration may be round-off
  const double scale = solution.p.isZero(0) ? memory.gap : solution.scale;
  result.of_points.residual = share_of_gaps(solution.violation, scale, list, bodies);
  result.of_points.fallback = solution.fallback;
  result.moves = of_columns(motions, moves);
  result.left = of_columns(motions, solution.left);
  result.largest_force = solution.largest_force;
  spread_impulses(list, laws, result.of_points.p, bodies);
  return result;
}

}  // namespace cbr
