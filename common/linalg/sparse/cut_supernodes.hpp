// SPDX-License-Identifier: GPL-3.0-or-later
// Wide supernodes cut into narrow ones, for less memory.
#pragma once

#include <vector>

#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

// The arrays of a SupernodalFactor (n_super + 1 entries each, `rows` as many as pi says), without
// values.
struct SupernodePattern {
  std::vector<Index> super, pi, px, rows;
};

// Splits supernodes of more than `widest` columns into pieces of nearly the same width. A supernode
// is a rectangle with an unused half of its diagonal block: for wide separators of solids a third
// more memory. Each piece is a supernode that begins with its own rows of the shared list. The
// factor of the pattern is the same. `boundary`: a column at which a supernode begins, whatever its
// width.
SupernodePattern cut_supernodes(const SupernodalFactor& factor, Index widest, Index boundary = 0);

// The supernodes of the first n columns alone, where one ends there: without px, as their values
// stay where they are.
SupernodePattern leading_pattern(const SupernodalFactor& factor, Index n);

}  // namespace cbr
