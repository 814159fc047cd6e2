// SPDX-License-Identifier: GPL-3.0-or-later
// Cells of a face: which of them close in a step.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/contact/enforce/contact_unknowns.hpp"

namespace cbr {

// Cosine to the first normal of a cell: beyond 30 degrees its nodes touch different sides.
inline constexpr double same_way = 0.866;

// Rotation about the normals from the tangents of one point to those of another. Frames with equal
// normals are equal; others differ by a rotation, near -z by any angle.
struct Turn {
  double cosine = 1, sine = 0;
};

inline Turn turn_between(const ContactPoint& to, const ContactPoint& from, const PointLaw& law) {
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
  // Times the mean depth of a cell. A node of smaller predicted depth may open while the mean stays
  // closed.
  static constexpr double least_depth = 0.2;

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

// Columns of function_matrix() before those of each search.
std::vector<Index> first_columns(const std::vector<PointLaw>& laws,
                                 const std::vector<FunctionsOfSearch>& searches);

}  // namespace cbr
