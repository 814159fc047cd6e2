// SPDX-License-Identifier: GPL-3.0-or-later
// L L^T by supernodes, front by front on all threads.
#pragma once

#include "common/linalg/fronts.hpp"

namespace cbr {

enum class Factored { done, not_definite, foreign };

// Fills x (px[n_super] numbers, laid out as the tree's factor says) with P A P^T = L L^T. `foreign`: A has an entry where the
// tree's factor has none. What x holds is of no use unless done. Beside x it takes front_bytes() a thread at the most.
Factored factor_supernodes(const SupernodeTree& tree, const ShiftedMatrix& A, double* x, const Progress& progress = {});

}  // namespace cbr
