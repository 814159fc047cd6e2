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

inline bool same_laws(const std::vector<PointLaw>& a, const std::vector<PointLaw>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PointLaw& x, const PointLaw& y) {
                      return x.law == y.law && x.friction == y.friction;
                    });
}

// Rows that differ by round-off give the same impulses to round-off.
constexpr double same_row_tolerance = 1e-11;

}  // namespace cbr
