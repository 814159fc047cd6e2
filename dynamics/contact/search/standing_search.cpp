// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/standing_search.hpp"

#include <algorithm>

namespace cbr {
namespace {

// sum of coefficient x position over the point's terms
Vector3 separation_of(const ContactList& list, const ContactPoint& point, Index slave_body,
                      const Points& slave, const Points& master) {
  Vector3 r = Vector3::Zero();
  for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
    const ContactTerm& term = list.terms[t];
    r += term.coefficient * (term.body == slave_body ? slave : master).row(term.node).transpose();
  }
  return r;
}

// Points of the other side's nodes and of edges stand without overlaps alone.
double offset_of(const StandingSearch& standing, std::size_t point, const PairMemory& memory) {
  return point < standing.n_nodes ? memory.offset[standing.list.points[point].slot] : 0;
}

// Longest path of a node relative to the translation `common`.
double longest_way(const ContactSurface& surface, const Points& now, const Points& then,
                   const Eigen::RowVector3d& common) {
  double longest2 = 0;
  for (std::size_t i = 0; i < surface.nodes.size(); ++i)
    longest2 = std::max(
        longest2,
        (now.row(surface.nodes[i]) - then.row(static_cast<Index>(i)) - common).squaredNorm());
  return std::sqrt(longest2);
}

// Whether no node without a point can have come within the reach of the search.
bool others_stay_away(const ContactSurface& slave, const ContactBody& slave_body,
                      const ContactSurface& master, const ContactBody& master_body,
                      const StandingSearch& standing) {
  if (standing.has_all) return true;
  const Eigen::RowVector3d common =
      slave_body.end.row(slave.nodes.front()) - standing.slave_at.row(0);
  return longest_way(slave, slave_body.end, standing.slave_at, common) +
             longest_way(master, master_body.end, standing.master_at, common) <=
         standing.extra;
}

}  // namespace

bool take_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const DetectionOptions& options, const PairMemory& memory, ContactList& list) {
  const StandingSearch& standing = memory.standing;
  if (standing.list.empty() || !memory.has_points) return false;
  const double limit = options.standing_slip * master.size;
  const std::size_t first = list.points.size();
  const Index shift = static_cast<Index>(list.terms.size());
  list.points.insert(list.points.end(), standing.list.points.begin(), standing.list.points.end());
  for (std::size_t i = 0; i < standing.list.points.size(); ++i) {
    ContactPoint& point = list.points[first + i];
    const auto row = static_cast<Index>(i);
    const Vector3 r =
        separation_of(standing.list, point, slave.body, slave_body.end, master_body.end);
    const Vector3 moved = point.frame * (r - standing.separation.row(row).transpose());
    if (!(moved.tail<2>().squaredNorm() <= limit * limit)) {
      list.points.resize(first);
      return false;
    }
    const double gap = standing.distance[row] - offset_of(standing, i, memory);
    point.gap = Vector3(gap + moved[0], 0, 0);
    const Vector3 before =
        separation_of(standing.list, point, slave.body, slave_body.start, master_body.start);
    point.start_gap = gap + point.normal().dot(before - standing.separation.row(row).transpose());
    point.first_term += shift;
  }
  if (!others_stay_away(slave, slave_body, master, master_body, standing)) {
    list.points.resize(first);
    return false;
  }
  list.terms.insert(list.terms.end(), standing.list.terms.begin(), standing.list.terms.end());
  return true;
}

void keep_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const ContactList& list, std::size_t first, std::size_t nodes, std::size_t both,
                   PairMemory& memory) {
  StandingSearch& standing = memory.standing;
  standing = StandingSearch();
  standing.n_nodes = nodes - first;
  standing.n_both = both - first;
  if (first == list.points.size()) return;
  const Index shift = list.points[first].first_term;
  standing.list.points.assign(list.points.begin() + static_cast<std::ptrdiff_t>(first),
                              list.points.end());
  standing.list.terms.assign(list.terms.begin() + shift, list.terms.end());
  const auto n = static_cast<Index>(standing.list.points.size());
  standing.distance.resize(n);
  standing.separation.resize(n, 3);
  std::vector<char> has(slave.nodes.size(), 0);
  for (Index i = 0; i < n; ++i) {
    ContactPoint& point = standing.list.points[i];
    point.first_term -= shift;
    standing.distance[i] = point.gap[0] + offset_of(standing, static_cast<std::size_t>(i), memory);
    standing.separation.row(i) =
        separation_of(standing.list, point, slave.body, slave_body.end, master_body.end)
            .transpose();
    if (i < static_cast<Index>(standing.n_nodes)) has[point.slot] = 1;
  }
  standing.has_all = std::find(has.begin(), has.end(), 0) == has.end();
  if (standing.has_all) return;
  standing.extra = memory.extra_reach;
  standing.slave_at = slave_body.end(slave.nodes, Eigen::all);
  standing.master_at = master_body.end(master.nodes, Eigen::all);
}

}  // namespace cbr
