// SPDX-License-Identifier: GPL-3.0-or-later
// Elements of a mesh that are translates of each other share one stiffness: their forces need no
// matrix in memory.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/fem/assembly.hpp"

namespace cbr {

// The stiffness of a box of eight nodes whose edges lie along x, y and z. Corner b is at the far
// end of x, y, z where bits 0, 1, 2 of b are set. In Walsh functions of the corners (w(b) =
// (-1)^popcount(w & b)) the mirror symmetries of the box leave eight 3 x 3 blocks: block s couples
// component c of function s ^ (1 << c), c = x, y, z. Row-major, and divided by 8, so that f = H^T
// (blocks) H u with H of entries +-1.
using BoxStiffness = std::array<std::array<double, 9>, 8>;

// Elements by `lanes` at a time. Nodes are numbered so that those of neighbours along a line of
// elements follow each other: lane k of corner b is node base + k + offset[b].
struct SharedElements {
  static constexpr int lanes = 8;
  struct Pattern {
    std::array<std::int32_t, 8> offset;
    std::int32_t stiffness;
  };
  struct Batch {
    std::int32_t base, low, high;  // low, high: its first and its last node, of all lanes
    std::int32_t pattern;
    std::uint32_t used;  // bit k: lane k is an element
  };
  // node of the model per internal number; empty when no element is shared
  std::vector<Index> order;
  std::vector<BoxStiffness> stiffness;
  std::vector<Pattern> patterns;
  std::vector<Batch> batches;  // ascending by low
  Index reach = 0;             // largest high - low
  Index n_elements = 0;
  // per block of the mesh: the volume elements that are in no batch
  std::vector<std::vector<Index>> rest;
};

// hex8 elements equal up to the round-off of their coordinates, in lines long enough to fill the
// lanes.
SharedElements share_elements(const FiniteElementModel& model, const Mesh& mesh,
                              const std::vector<BlockProperties>& properties);

}  // namespace cbr
