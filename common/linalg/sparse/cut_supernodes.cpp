// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/cut_supernodes.hpp"

#include <algorithm>

namespace cbr {

SupernodePattern cut_supernodes(const SupernodalFactor& factor, Index widest, Index boundary) {
  SupernodePattern made{{0}, {0}, {0}, {}};
  for (Index s = 0; s < factor.n_super; ++s) {
    const Index columns = factor.columns(s), height = factor.height(s);
    const Index *rows = factor.rows + factor.pi[s], *end = rows + height;
    const auto cut = [&](Index begin, Index count) {
      const Index pieces = (count + widest - 1) / widest;
      for (Index piece = 0; piece < pieces; ++piece) {
        const Index first = begin + count * piece / pieces,
                    last = begin + count * (piece + 1) / pieces;
        made.rows.insert(made.rows.end(), rows + first, end);
        made.super.push_back(factor.first(s) + last);
        made.pi.push_back(static_cast<Index>(made.rows.size()));
        made.px.push_back(made.px.back() + (last - first) * (height - first));
      }
    };
    const Index before = std::clamp<Index>(boundary - factor.first(s), 0, columns);
    cut(0, before);
    cut(before, columns - before);
  }
  return made;
}

SupernodePattern leading_pattern(const SupernodalFactor& factor, Index n) {
  SupernodePattern made{{0}, {0}, {}, {}};
  for (Index s = 0; s < factor.n_super && factor.first(s) < n; ++s) {
    const Index *rows = factor.rows + factor.pi[s], *end = rows + factor.height(s);
    made.rows.insert(made.rows.end(), rows, std::lower_bound(rows, end, n));
    made.super.push_back(factor.super[s + 1]);
    made.pi.push_back(static_cast<Index>(made.rows.size()));
  }
  return made;
}

}  // namespace cbr
