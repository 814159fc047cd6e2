// SPDX-License-Identifier: GPL-3.0-or-later
// Which boxes can meet: a uniform grid over the region that both sides share, so that what is far
// costs one comparison. The grid is built anew in each step: that was faster than to refit a tree
// of boxes from 1000 to 100000 faces where surfaces touch widely, and 1.5 times slower, of little,
// where they touch in a point (tests/benchmarks/broad_phase.cpp).
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

struct Box {
  Vector3 lower, upper;
  bool meets(const Box& other) const {
    return (lower.array() <= other.upper.array()).all() &&
           (other.lower.array() <= upper.array()).all();
  }
};

// Which targets each query box meets, as lists end to end: those of query i are target[first[i]] ..
// target[first[i + 1] - 1].
struct CandidateList {
  std::vector<Index> first, target;
};

// Workspace kept between steps.
struct BroadPhase {
  std::vector<Index> near_queries, near_targets;  // those that reach into the shared region
  std::vector<Index> cell_first, cell_target, stamp;
  CandidateList candidates;
};

// Fills grid.candidates; targets of a query ascend.
void find_candidates(const std::vector<Box>& queries, const std::vector<Box>& targets,
                     BroadPhase& grid);

}  // namespace cbr
