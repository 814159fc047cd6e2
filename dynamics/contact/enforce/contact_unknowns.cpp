// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/contact_unknowns.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/laws/friction_law.hpp"
#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/contact/response/packing.hpp"
#include "dynamics/contact/response/response.hpp"

namespace cbr {
namespace {

// Times the mean depth of a cell. A node of smaller predicted depth may open while the mean stays
// closed.
constexpr double least_depth = 0.2;
// Times the deepest gap of a search: points with larger gaps get no impulse.
constexpr double reach_of_points = 0.5;
// Cosine to the first normal of a cell: beyond 30 degrees its nodes touch different sides.
constexpr double same_way = 0.866;
// Points in addition to the functions of a search: W grows by one row each, by three with friction.
// A patch of no more closing points than few_points, and than half of the face, has points alone:
// functions of the part of a face that lands tilted had 30 % of the momentum wrong. Nor are there
// functions where more than half as many unknowns as points would remain: they saved no time.
// Beyond most_points functions are whole: more points cost more than they mend
// (docs/decisions/pressures.md).
constexpr std::size_t few_points = 100, most_points = 400, most_points_with_friction = 150;

// Times the root of a function's area. flat_enough: largest difference of gaps among its nodes;
// single nodes penetrate by about half of it. closed_enough: largest gap at which a function
// starts. All of its nodes must be closed then, as later impacts of open nodes lost energy.
constexpr double flat_enough = 0.03, closed_enough = 1e-4;

// Rotation about the normals from the tangents of one point to those of another. Frames with equal
// normals are equal; others differ by a rotation, near -z by any angle.
struct Turn {
  double cosine = 1, sine = 0;
};

Turn turn_between(const ContactPoint& to, const ContactPoint& from, const PointLaw& law) {
  constexpr double none = 1e-12;
  if (n_rows(law.law) == 1 || to.frame == from.frame) return {};
  const Eigen::Matrix2d M = to.frame.bottomRows<2>() * from.frame.bottomRows<2>().transpose();
  const double cosine = M(0, 0) + M(1, 1), sine = M(1, 0) - M(0, 1);
  const double length = std::hypot(cosine, sine);
  if (!(std::abs(sine) > none * length)) return {};
  return {cosine / length, sine / length};
}

// Calls entry(row, d, factor) for row d of a function's frame, expressed in the rows of a point
// that begin at `first`.
template <typename Entry>
void rows_of_turn(const Turn& turn, Index first, Index d, const Entry& entry) {
  if (d == 0 || turn.sine == 0) return entry(first + d, 1.0);
  entry(first + 1, d == 1 ? turn.cosine : -turn.sine);
  entry(first + 2, d == 1 ? turn.sine : turn.cosine);
}

// Predicted state of the cells of one surface.
class Cells {
 public:
  Cells(const ContactList& list, const FunctionsOfSearch& search)
      : list_(list), functions_(*search.functions) {
    const std::size_t m = functions_.nodes.size(), k = static_cast<std::size_t>(functions_.size());
    point_.assign(m, none);
    for (auto i = search.first; i < search.last; ++i) {
      const ContactPoint& point = list.points[i];
      if (point.slot < 0 || point.n_slave_terms != 1) continue;
      Index& at = point_[point.slot];
      at = at == none ? static_cast<Index>(i) : several;
    }
    mean_.assign(k, 0);
    most_.assign(k, -HUGE_VAL);
    normal_.assign(k, Vector3::Zero());
    count_.assign(k, 0);
    closed_.assign(k, 1);
    visit([&](Index a, Index slot) { look(static_cast<std::size_t>(a), slot); });
    for (std::size_t a = 0; a < k; ++a)
      if (count_[a] == 0) closed_[a] = 0;
    is_possible_ = closed_;
    for (std::size_t a = 0; a < k; ++a)
      if (!(most_[a] < least_depth * mean_[a] / count_[a])) closed_[a] = 0;
  }

  // Cells with an impulse in the last step remain as they were, until all of their nodes slide.
  void keep(const ChosenCells& before, const PairMemory& memory,
            const std::vector<PointLaw>& laws) {
    std::vector<char> acts(closed_.size(), 0), all_slid(closed_.size(), 1);
    visit([&](Index a, Index slot) {
      const Index at = point_of(slot);
      if (at >= 0 && acted(list_.points[at], memory)) acts[a] = 1;
      if (at >= 0 && !slid(list_.points[at], laws[at], memory)) all_slid[a] = 0;
    });
    for (std::size_t a = 0; a < acts.size(); ++a)
      if (acts[a] != 0)
        closed_[a] = is_possible_[a] != 0 &&
                     (all_slid[a] != 0 || (!before.closed.empty() && before.closed[a] != 0));
  }

  // Counts cells with a negative mean gap as closed.
  void close_means() {
    for (std::size_t a = 0; a < closed_.size(); ++a)
      closed_[a] = is_possible_[a] != 0 && mean_[a] < 0;
  }

  const std::vector<char>& closed() const { return closed_; }
  bool is_closed(Index cell) const { return closed_[cell] != 0; }
  // Its nodes have one point each, of similar normals, or none beside the other face.
  bool is_possible(Index cell) const { return is_possible_[cell] != 0; }
  Index point_of(Index slot) const { return point_[slot]; }
  // The point whose frame the function uses.
  const ContactPoint* reference(const PressureFunctions& functions, Index a) const {
    for (SparseMatrix::InnerIterator it(functions.N, a); it; ++it)
      if (const Index at = point_of(it.row()); at >= 0) return &list_.points[at];
    return nullptr;
  }
  // The slots of closed cells.
  std::vector<char> covered() const {
    std::vector<char> is(point_.size(), 0);
    visit([&](Index a, Index slot) {
      if (is_closed(a)) is[slot] = 1;
    });
    return is;
  }

 private:
  static constexpr Index none = -1, several = -2;

  // Each cell with its own nodes.
  template <typename Visit>
  void visit(const Visit& visit) const {
    std::size_t entry = 0;
    for (Index a = 0; a < functions_.size(); ++a)
      for (SparseMatrix::InnerIterator it(functions_.N, a); it; ++it, ++entry)
        if (functions_.entry_cell[entry] == a) visit(a, it.row());
  }

  void look(std::size_t cell, Index slot) {
    const Index at = point_of(slot);
    if (at == none) return;
    if (at == several) {
      closed_[cell] = 0;
      return;
    }
    const ContactPoint& point = list_.points[at];
    if (count_[cell] == 0) normal_[cell] = point.normal();
    if (!(normal_[cell].dot(point.normal()) > same_way)) closed_[cell] = 0;
    ++count_[cell];
    mean_[cell] += point.gap[0];
    most_[cell] = std::max(most_[cell], point.gap[0]);
  }

  const ContactList& list_;
  const PressureFunctions& functions_;
  std::vector<Index> point_;  // by slot
  std::vector<double> mean_, most_;
  std::vector<Vector3> normal_;
  std::vector<int> count_;
  std::vector<char> closed_, is_possible_;
};

// The cells of the last step, if the pair began in equilibrium and still acts; else null.
const ChosenCells* lasting(const FunctionsOfSearch& search) {
  const PairMemory* memory = search.memory;
  const bool lasts =
      memory != nullptr && memory->begins_in_equilibrium && !memory->impulse.isZero(0);
  return lasts ? &memory->cells : nullptr;
}

// Columns of function_matrix() before those of each search.
std::vector<Index> first_columns(const std::vector<PointLaw>& laws,
                                 const std::vector<FunctionsOfSearch>& searches) {
  std::vector<Index> first{0};
  for (const FunctionsOfSearch& search : searches) {
    const bool has = search.functions != nullptr && search.last > search.first;
    first.push_back(first.back() +
                    (has ? search.functions->size() * n_rows(laws[search.first].law) : 0));
  }
  return first;
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
    if (before == nullptr && all.size() > few_points &&
        2 * (n_functions + points.size()) > all.size())
      return add_patch(all, search, number);
    chosen.whole = points.size() > most || (before != nullptr && before->whole);
    if (chosen.whole) {
      cells.close_means();
      points = points_beside(cells, search, before != nullptr);
      if (before != nullptr && before->whole)
        points = points_of(before->slots, cells);
      else
        keep_deepest(most, points);
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

void keep_state(StateArchive& archive, UnknownKey& key) {
  archive(key.search, key.function, key.slot, key.ordinal);
}

std::vector<Index> ContactUnknowns::of_searches() const {
  std::vector<Index> n(pairs.size(), 0);
  for (const UnknownKey& key : keys) ++n[key.search];
  return n;
}

void ContactUnknowns::keep_state(StateArchive& archive) {
  archive(reduced, A, laws, keys, pairs, column, share, values, areas, is_held, depths,
          friction_factors);
}

Vector ContactUnknowns::guess(const std::vector<PointLaw>& of_points, const Vector& p) const {
  const std::vector<Index> first = first_rows(laws), first_of_points = first_rows(of_points);
  // Of the functions at each row of a point, whose force they share; points keep theirs
  Vector all = Vector::Zero(p.size());
  std::vector<char> is_own(static_cast<std::size_t>(p.size()), 0);
  for (Index row = 0; row < A.cols(); ++row)
    for (SparseMatrix::InnerIterator it(A, row); it; ++it) {
      if (share[row] > 0)
        all[it.row()] += std::abs(it.value()) / share[row];
      else
        is_own[it.row()] = 1;
    }
  Vector x = Vector::Zero(A.cols());
  for (std::size_t u = 0; u < laws.size(); ++u)
    for (Index row = first[u]; row < first[u + 1]; ++row) {
      if (areas[static_cast<Index>(u)] > 0) {
        for (SparseMatrix::InnerIterator it(values, static_cast<Index>(u)); it; ++it)
          x[row] += it.value() * p[first_of_points[it.row()] + row - first[u]];
        continue;
      }
      for (SparseMatrix::InnerIterator it(A, row); it; ++it) {
        if (share[row] == 0)
          x[row] += it.value() * p[it.row()];
        else if (is_own[it.row()] == 0)
          x[row] += it.value() / share[row] / all[it.row()] * p[it.row()];
      }
    }
  return x;
}

void ContactUnknowns::remember_cells(const std::vector<FunctionsOfSearch>& searches) const {
  for (std::size_t s = 0; s < searches.size(); ++s) {
    if (searches[s].memory != nullptr)
      searches[s].memory->cells = reduced ? cells[s] : ChosenCells();
  }
}

bool same_matrix(const SparseMatrix& a, const SparseMatrix& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || a.nonZeros() != b.nonZeros()) return false;
  return std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.cols() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
         std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

SparseMatrix function_matrix(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<FunctionsOfSearch>& searches) {
  const std::vector<Index> rows = first_rows(laws), columns = first_columns(laws, searches);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t s = 0; s < searches.size(); ++s) {
    if (columns[s + 1] == columns[s]) continue;
    const Cells cells(list, searches[s]);
    const Index n = n_rows(laws[searches[s].first].law);
    const SparseMatrix& N = searches[s].functions->N;
    for (Index a = 0; a < N.cols(); ++a) {
      const ContactPoint* reference = cells.reference(*searches[s].functions, a);
      for (SparseMatrix::InnerIterator it(N, a); it; ++it) {
        if (cells.point_of(it.row()) < 0) continue;
        const auto at = static_cast<std::size_t>(cells.point_of(it.row()));
        const Turn turn = turn_between(list.points[at], *reference, laws[at]);
        for (Index d = 0; d < n; ++d)
          rows_of_turn(turn, rows[at], d, [&](Index row, double factor) {
            entries.emplace_back(row, columns[s] + n * a + d, factor * it.value());
          });
      }
    }
  }
  SparseMatrix matrix(rows.back(), columns.back());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
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

HeldPoints held_points(const ContactUnknowns& unknowns, const Vector& x) {
  HeldPoints of;
  if (unknowns.areas.size() == 0 || !(unknowns.areas.maxCoeff() > 0)) return of;
  const std::vector<Index> first = first_rows(unknowns.laws);
  of.pressure.setZero(unknowns.values.rows());
  of.area.setZero(of.pressure.size());
  for (std::size_t i = 0; i < unknowns.is_held.size(); ++i)
    if (unknowns.is_held[i] == 0) of.pressure[static_cast<Index>(i)] = -1;
  for (Index u = 0; u < unknowns.areas.size(); ++u) {
    const double area = unknowns.areas[u], impulse = x[first[u]];
    if (!(area > 0 && impulse > 0)) continue;
    const double all = unknowns.values.col(u).sum();
    for (SparseMatrix::InnerIterator it(unknowns.values, u); it; ++it) {
      of.pressure[it.row()] += it.value() * impulse / area;
      of.area[it.row()] += it.value() * area / all;
    }
  }
  return of;
}

}  // namespace cbr
