// SPDX-License-Identifier: GPL-3.0-or-later
// Points as rows of tables, and as rows of W.
#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/contact/response/response.hpp"

namespace cbr {

// Rows of a points x 3 table as the solver has them, and back.
inline Vector pack(const Points& table, const std::vector<PointLaw>& laws) {
  const std::vector<Index> first = first_rows(laws);
  Vector rows(first.back());
  for (Index i = 0; i < table.rows(); ++i)
    rows.segment(first[i], n_rows(laws[i].law)) = table.row(i).head(n_rows(laws[i].law));
  return rows;
}

inline Points unpack(const Vector& rows, const std::vector<PointLaw>& laws) {
  const std::vector<Index> first = first_rows(laws);
  Points table = Points::Zero(static_cast<Index>(laws.size()), 3);
  for (Index i = 0; i < table.rows(); ++i)
    table.row(i).head(n_rows(laws[i].law)) = rows.segment(first[i], n_rows(laws[i].law));
  return table;
}

inline Points gaps(const ContactList& list) {
  Points g(static_cast<Index>(list.points.size()), 3);
  for (Index i = 0; i < g.rows(); ++i) g.row(i) = list.points[i].gap.transpose();
  return g;
}

// Whatever the coefficients of friction are.
inline bool same_laws(const std::vector<PointLaw>& a, const std::vector<PointLaw>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PointLaw& x, const PointLaw& y) { return x.law == y.law; });
}

// For each key its place among the old ones, or -1. Both are in the same order, so that most follow
// each other.
template <typename Key>
std::vector<Index> match(const std::vector<Key>& keys, const std::vector<Key>& old) {
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

// Rows that differ by round-off give the same impulses to round-off.
constexpr double same_row_tolerance = 1e-11;

}  // namespace cbr
