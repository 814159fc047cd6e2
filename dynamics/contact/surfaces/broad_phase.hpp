// SPDX-License-Identifier: GPL-3.0-or-later
// Broad phase: pairs of boxes that meet, by a uniform grid over the region that both sides share.
// Distant surfaces cost one comparison. The grid is rebuilt in each step. That was faster than
// refitting a tree of boxes, from 1000 to 100000 faces in wide contact. For contact at a point it
// was 1.5 times slower, at a low cost (tests/benchmarks/broad_phase.cpp).
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

// Targets whose boxes meet each query box, in concatenated lists. Those of query i:
// target[first[i]] .. target[first[i + 1] - 1].
struct CandidateList {
  std::vector<Index> first, target;
};

// Workspace kept between steps.
struct BroadPhase {
  std::vector<Index> near_queries, near_targets;  // those that meet the shared region
  std::vector<Index> cell_first, cell_target, stamp;
  CandidateList candidates;
};

// Fills grid.candidates; targets of a query are ascending.
void find_candidates(const std::vector<Box>& queries, const std::vector<Box>& targets,
                     BroadPhase& grid);

}  // namespace cbr
