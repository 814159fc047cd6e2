// SPDX-License-Identifier: GPL-3.0-or-later
// Which functions and points are the unknowns of a step.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "dynamics/contact/enforce/closing_cells.hpp"
#include "dynamics/contact/laws/friction_law.hpp"
#include "dynamics/contact/response/packing.hpp"

namespace cbr {
namespace {

// Times the deepest gap of a search: points with larger gaps get no impulse.
constexpr double reach_of_points = 0.5;
// Points in addition to the functions of a search: W grows by one row each, by three with friction.
// A patch of no more closing points than few_points, and than half of the face, has points alone:
// functions of the part of a face that lands tilted had 30 % of the momentum wrong. Nor are there
// functions where more than half as many unknowns as points would remain: they saved no time. Whole
// ones count for that if half of the cells close: else they lost 2 % of a momentum.
// Beyond most_points functions are whole: more points cost more than they mend. With friction, the
// deepest few suffice beside them (docs/decisions/pressures.md).
constexpr std::size_t few_points = 100, most_points = 400, most_points_with_friction = 150,
                      deepest_with_friction = 40;

// Times the root of a function's area. flat_enough: largest difference of gaps among its nodes;
// single nodes penetrate by about half of it. closed_enough: largest gap at which a function
// starts. All of its nodes must be closed then, as later impacts of open nodes lost energy.
constexpr double flat_enough = 0.03, closed_enough = 1e-4;

// The cells of the last step, if the pair began in equilibrium and still acts; else null.
const ChosenCells* lasting(const FunctionsOfSearch& search) {
  const PairMemory* memory = search.memory;
  const bool lasts =
      memory != nullptr && memory->begins_in_equilibrium && !memory->impulse.isZero(0);
  return lasts ? &memory->cells : nullptr;
}

void take_friction_factors(const ContactUnknowns* before, ContactUnknowns& unknowns) {
  unknowns.friction_factors.setOnes(unknowns.size());
  if (before == nullptr || before->friction_factors.size() != before->size()) return;
  const std::vector<Index> from = match(unknowns.keys, before->keys);
  for (Index u = 0; u < unknowns.size(); ++u) {
    if (from[u] < 0) continue;
    unknowns.friction_factors[u] = before->friction_factors[from[u]];
    unknowns.laws[u].friction *= unknowns.friction_factors[u];
  }
}

class Chooser {
 public:
  // before: unknowns of the last step; null: corner functions are used wherever possible
  Chooser(const ContactList& list, const std::vector<PointLaw>& laws, const ContactUnknowns* before,
          const std::vector<std::size_t>& wanted)
      : list_(list), laws_(laws), before_(before), wanted_(wanted), first_(first_rows(laws)) {
    unknowns_.is_held.assign(laws.size(), 0);
  }

  // column: first one of the search in function_matrix()
  void add(const FunctionsOfSearch& search, Index number, Index column) {
    std::vector<std::size_t> all(search.last - search.first);
    std::iota(all.begin(), all.end(), search.first);
    ChosenCells& chosen = unknowns_.cells.emplace_back();
    if (search.functions != nullptr)
      chosen.closed.assign(static_cast<std::size_t>(search.functions->size()), 0);
    if (search.functions == nullptr || all.empty()) return add_points(all, search, number);
    const ChosenCells* before = lasting(search);
    // Load steps are few, so that they may have as many points with friction as without
    const bool friction =
        laws_[search.first].law == ContactLaw::coulomb && before_ != nullptr && before == nullptr;
    const std::size_t most = friction ? most_points_with_friction : most_points;
    const bool has_functions =
        before != nullptr &&
        (before->whole || std::count(before->closed.begin(), before->closed.end(), 1) > 0);
    const std::size_t few = std::min(few_points, search.functions->nodes.size() / 2);
    if (!has_functions && n_closing(search) <= few) return add_patch(all, search, number);
    Cells cells(list_, search);
    if (before != nullptr) cells.keep(*before, *search.memory, laws_);
    std::vector<std::size_t> points = points_beside(cells, search, before != nullptr);
    const auto n_functions =
        static_cast<std::size_t>(std::count(cells.closed().begin(), cells.closed().end(), 1));
    const auto n_cells = static_cast<std::size_t>(search.functions->size());
    const std::size_t deepest = friction ? deepest_with_friction : most;
    const bool is_whole = points.size() > most && 2 * n_functions >= n_cells;
    const std::size_t n_unknowns = is_whole ? n_cells + deepest : n_functions + points.size();
    if (before == nullptr && all.size() > few_points && 2 * n_unknowns > all.size())
      return add_patch(all, search, number);
    chosen.whole = points.size() > most || (before != nullptr && before->whole);
    if (chosen.whole) {
      cells.close_means();
      points = points_beside(cells, search, before != nullptr);
      if (before != nullptr && before->whole)
        points = points_of(before->slots, cells);
      else
        keep_deepest(deepest, points);
      for (const std::size_t i : points) chosen.slots.push_back(list_.points[i].slot);
    }
    chosen.closed = cells.closed();
    add_functions(cells, *search.functions, number, column, chosen.whole);
    add_points(points, search, number);
  }

  ContactUnknowns finish() {
    unknowns_.reduced = true;
    unknowns_.values.resize(static_cast<Index>(laws_.size()), unknowns_.size());
    unknowns_.values.setFromTriplets(values_.begin(), values_.end());
    unknowns_.areas = Eigen::Map<const Vector>(areas_.data(), unknowns_.size());
    unknowns_.A = Eigen::Map<const SparseMatrix>(first_.back(), row_, begin_.back(), begin_.data(),
                                                 point_rows_.data(), weights_.data());
    unknowns_.share = Eigen::Map<const Vector>(share_.data(), row_);
    return std::move(unknowns_);
  }

 private:
  std::size_t n_closing(const FunctionsOfSearch& search) const {
    const auto first = list_.points.begin();
    return static_cast<std::size_t>(
        std::count_if(first + static_cast<std::ptrdiff_t>(search.first),
                      first + static_cast<std::ptrdiff_t>(search.last),
                      [](const ContactPoint& point) { return point.gap[0] < 0; }));
  }

  double deepest_of(const FunctionsOfSearch& search) const {
    double deepest = 0;
    for (auto i = search.first; i < search.last; ++i)
      deepest = std::max(deepest, -list_.points[i].gap[0]);
    return deepest;
  }

  // Adds the points of a small patch except those unlikely to close. A corner function needs all of
  // its points if one may close.
  void add_patch(std::vector<std::size_t> points, const FunctionsOfSearch& search, Index number) {
    const double reach = reach_of_points * deepest_of(search);
    const auto may_close = [&](std::size_t i) {
      return list_.points[i].gap[0] < reach ||
             std::binary_search(wanted_.begin(), wanted_.end(), i);
    };
    std::vector<char> needed(search.functions->nodes.size(), 0);  // by slot
    if (search.corners != nullptr) {
      std::vector<char> closes(needed.size(), 0);
      for (const std::size_t i : points)
        if (list_.points[i].slot >= 0 && may_close(i)) closes[list_.points[i].slot] = 1;
      const SparseMatrix& N = search.corners->N;
      for (Index a = 0; a < N.cols(); ++a) {
        bool any = false;
        for (SparseMatrix::InnerIterator it(N, a); it; ++it) any = any || closes[it.row()] != 0;
        for (SparseMatrix::InnerIterator it(N, a); any && it; ++it) needed[it.row()] = 1;
      }
    }
    const auto hardly_closes = [&](std::size_t i) {
      const Index slot = list_.points[i].slot;
      return !may_close(i) && (slot < 0 || needed[slot] == 0);
    };
    std::copy_if(points.begin(), points.end(), std::back_inserter(unknowns_.left_out),
                 hardly_closes);
    std::erase_if(points, hardly_closes);
    add_points(points, search, number);
  }

  std::vector<std::size_t> points_beside(const Cells& cells, const FunctionsOfSearch& search,
                                         bool lasts) const {
    const std::vector<char> covered = cells.covered();
    const double reach = lasts ? 0 : reach_of_points * deepest_of(search);
    std::vector<std::size_t> points;
    for (auto i = search.first; i < search.last; ++i) {
      const ContactPoint& point = list_.points[i];
      const bool by_function =
          point.slot >= 0 && cells.point_of(point.slot) >= 0 && covered[point.slot] != 0;
      const bool may_act = point.gap[0] < reach || (lasts && acted(point, *search.memory));
      if (!by_function && may_act) points.push_back(i);
    }
    return points;
  }

  static std::vector<std::size_t> points_of(const std::vector<Index>& slots, const Cells& cells) {
    std::vector<std::size_t> points;
    for (const Index slot : slots)
      if (slot >= 0 && cells.point_of(slot) >= 0)
        points.push_back(static_cast<std::size_t>(cells.point_of(slot)));
    return points;
  }

  void keep_deepest(std::size_t most, std::vector<std::size_t>& points) const {
    if (points.size() <= most) return;
    std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(most),
                     points.end(), [&](std::size_t a, std::size_t b) {
                       return std::pair(list_.points[a].gap[0], a) <
                              std::pair(list_.points[b].gap[0], b);
                     });
    points.resize(most);
    std::sort(points.begin(), points.end());
  }

  void start_unknown(const UnknownKey& key, const PointLaw& law, Index column, double share) {
    unknowns_.keys.push_back(key);
    if (unknowns_.keys.size() > 1) {
      UnknownKey before = unknowns_.keys[unknowns_.keys.size() - 2];
      const Index ordinal = std::exchange(before.ordinal, 0);
      if (before == key) unknowns_.keys.back().ordinal = ordinal + 1;
    }
    unknowns_.laws.push_back(law);
    areas_.push_back(0);
    for (int d = 0; d < n_rows(law.law); ++d) {
      unknowns_.column.push_back(column < 0 ? -1 : column + d);
      share_.push_back(share);
    }
  }

  // Completes an unknown from the shares of its points, which sum to 1: friction is their mean.
  void end_unknown(Index n) {
    const auto by_point = [](const Share& a, const Share& b) { return a.point < b.point; };
    if (!std::is_sorted(shares_.begin(), shares_.end(), by_point))
      std::sort(shares_.begin(), shares_.end(), by_point);
    // To the bit where it is the same at all points
    double& mu = unknowns_.laws.back().friction;
    const double first_mu = mu;
    for (const Share& of : shares_) mu += of.share * (laws_[of.point].friction - first_mu);
    for (Index d = 0; d < n; ++d) {
      for (const Share& of : shares_) {
        rows_of_turn(of.turn, first_[of.point], d, [&](Index row, double factor) {
          point_rows_.push_back(row);
          weights_.push_back(factor * of.share);
        });
      }
      begin_.push_back(static_cast<Index>(weights_.size()));
    }
    row_ += n;
    shares_.clear();
  }

  void add_point(std::size_t point, Index number) {
    start_unknown({number, -1, list_.points[point].slot, 0}, laws_[point], -1, 0);
    shares_.push_back({point, 1, {}});
    end_unknown(n_rows(laws_[point].law));
  }

  // Adds points, ascending, or the corner functions that replace them.
  void add_points(const std::vector<std::size_t>& points, const FunctionsOfSearch& search,
                  Index number) {
    if (search.corners != nullptr) add_corners(points, search, number);
    for (const std::size_t i : points)
      if (unknowns_.is_held[i] == 0) add_point(i, number);
  }

  void add_corners(const std::vector<std::size_t>& points, const FunctionsOfSearch& search,
                   Index number) {
    const PressureFunctions& corners = *search.corners;
    constexpr Index none = -1, several = -2;
    std::vector<Index> point(corners.nodes.size(), none);
    for (const std::size_t i : points) {
      if (list_.points[i].slot < 0 || list_.points[i].n_slave_terms != 1) continue;
      Index& at = point[list_.points[i].slot];
      at = at == none ? static_cast<Index>(i) : several;
    }
    const Index others = search.functions != nullptr ? search.functions->size() : 0;
    const bool anywhere =
        before_ == nullptr ||
        (search.memory != nullptr && search.memory->begins_in_equilibrium && before_->keys.empty());
    std::vector<char> served(static_cast<std::size_t>(corners.size()), anywhere);
    for (std::size_t u = 0; before_ != nullptr && u < before_->keys.size(); ++u) {
      const UnknownKey& key = before_->keys[u];
      if (key.search == number && key.function >= others) served[key.function - others] = 1;
    }
    for (Index a = 0; a < corners.size(); ++a) {
      if (!can_serve(corners, a, point, anywhere, served[a] != 0)) continue;
      const auto point_of = [&](Index slot) { return point[slot]; };
      const double area = corners.N.col(a).sum();
      SparseMatrix::InnerIterator first(corners.N, a);
      const PointLaw& law = laws_[point_of(first.row())];
      const ContactPoint& reference = list_.points[point_of(first.row())];
      start_unknown({number, others + a, -1, 0}, law, -1, 0);
      areas_.back() = area;
      for (SparseMatrix::InnerIterator it(corners.N, a); it; ++it) {
        const auto at = static_cast<std::size_t>(point_of(it.row()));
        shares_.push_back({at, it.value() / area, turn_between(list_.points[at], reference, law)});
        unknowns_.is_held[at] = 1;
      }
      for (SparseMatrix::InnerIterator it(corners.Psi, a); it; ++it)
        values_.emplace_back(point_of(it.row()), unknowns_.size() - 1, it.value());
      end_unknown(n_rows(law.law));
    }
  }

  // point: of each slot, or below 0. anywhere: with any gaps. serves: the function was an unknown
  // in the last step.
  bool can_serve(const PressureFunctions& corners, Index a, const std::vector<Index>& point,
                 bool anywhere, bool serves) const {
    Vector3 normal = Vector3::Zero();
    double least = HUGE_VAL, most = -HUGE_VAL, farthest = -HUGE_VAL;
    for (SparseMatrix::InnerIterator it(corners.N, a); it; ++it) {
      const Index at = point[it.row()];
      if (at < 0) return false;
      const ContactPoint& its = list_.points[at];
      if (normal.isZero(0)) normal = its.normal();
      if (!(normal.dot(its.normal()) > same_way)) return false;
      least = std::min(least, its.start_gap);
      most = std::max(most, its.start_gap);
      farthest = std::max(farthest, std::min(its.start_gap, its.gap[0]));
    }
    const double size = std::sqrt(corners.N.col(a).sum());
    return anywhere ||
           (most - least <= flat_enough * size && (serves || farthest <= closed_enough * size));
  }

  // whole: functions are not truncated, and open cells keep theirs, so that the unknowns are the
  // same in each step.
  void add_functions(const Cells& cells, const PressureFunctions& functions, Index number,
                     Index column, bool whole) {
    std::size_t entry = 0;
    for (Index a = 0; a < functions.size(); ++a) {
      const std::size_t begin = entry;
      double sum = 0;
      const auto each = [&](const auto& action) {
        entry = begin;
        for (SparseMatrix::InnerIterator it(functions.N, a); it; ++it, ++entry)
          if (cells.point_of(it.row()) >= 0 &&
              (whole || cells.is_closed(functions.entry_cell[entry])))
            action(static_cast<std::size_t>(cells.point_of(it.row())), it.value());
      };
      std::size_t some = 0;
      each([&](std::size_t point, double weight) {
        sum += weight;
        some = point;
      });
      if (!(sum > 0) || (whole && !cells.is_possible(a))) continue;
      const Index n = n_rows(laws_[some].law);
      start_unknown({number, a, -1, 0}, laws_[some], column + n * a, 1 / sum);
      const ContactPoint& reference = *cells.reference(functions, a);
      each([&](std::size_t point, double weight) {
        shares_.push_back(
            {point, weight / sum, turn_between(list_.points[point], reference, laws_[some])});
      });
      end_unknown(n);
    }
  }

  const ContactList& list_;
  const std::vector<PointLaw>& laws_;
  const ContactUnknowns* before_;
  const std::vector<std::size_t>& wanted_;
  const std::vector<Index> first_;
  ContactUnknowns unknowns_;
  struct Share {
    std::size_t point = 0;
    double share = 0;
    Turn turn;  // to the point's tangents
  };
  std::vector<Share> shares_;  // of the unknown under construction
  // A by columns
  std::vector<Index> begin_{0}, point_rows_;
  std::vector<double> weights_;
  std::vector<Eigen::Triplet<double, Index>> values_;
  std::vector<double> share_, areas_;
  Index row_ = 0;
};

}  // namespace

bool acted(const ContactPoint& point, const PairMemory& memory) {
  return point.slot >= 0 && memory.impulse.rows() > 0 &&
         memory.impulse.row(point.slot).dot(point.normal()) > 0;
}

bool slid(const ContactPoint& point, const PointLaw& law, const PairMemory& memory) {
  if (law.law != ContactLaw::coulomb || memory.velocity.rows() == 0 || !acted(point, memory))
    return false;
  const Eigen::Vector2d velocity =
      point.frame.bottomRows<2>() * memory.velocity.row(point.slot).transpose();
  return velocity.squaredNorm() > 0 &&
         slides(point.frame * memory.impulse.row(point.slot).transpose(), law.friction);
}

ContactUnknowns choose_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                                const std::vector<FunctionsOfSearch>& searches,
                                const ContactUnknowns* before,
                                const std::vector<std::size_t>& wanted) {
  if (std::none_of(searches.begin(), searches.end(),
                   [](const FunctionsOfSearch& search) { return search.has_any(); }))
    return {};
  Chooser chooser(list, laws, before, wanted);
  const std::vector<Index> columns = first_columns(laws, searches);
  for (std::size_t s = 0; s < searches.size(); ++s)
    chooser.add(searches[s], static_cast<Index>(s), columns[s]);
  ContactUnknowns unknowns = chooser.finish();
  take_friction_factors(before, unknowns);
  for (const FunctionsOfSearch& search : searches) unknowns.pairs.push_back(search.pair);
  return unknowns;
}

}  // namespace cbr
