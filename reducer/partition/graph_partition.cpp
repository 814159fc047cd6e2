// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/graph_partition.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <limits>

#include "common/base/error.hpp"

namespace cbr {
namespace {

std::vector<idx_t> narrowed(const std::vector<Index>& values) {
  std::vector<idx_t> narrow;
  narrow.reserve(values.size());
  for (const Index value : values) narrow.push_back(static_cast<idx_t>(value));
  return narrow;
}

}  // namespace

std::vector<Index> partition_graph(const Graph& graph, Index n, GraphCut cut, int seed) {
  const auto size = static_cast<std::size_t>(graph.n_vertices());
  if (n <= 1 || size == 0) return std::vector<Index>(size, 0);
  if (graph.neighbours.size() > static_cast<std::size_t>(std::numeric_limits<idx_t>::max())) {
    throw InputError(
        "the mesh has too many elements to be cut into domains by METIS: at most about 3e8 are "
        "allowed");
  }
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = seed;
  if (cut == GraphCut::k_way) options[METIS_OPTION_CONTIG] = 1;
  std::vector<idx_t> first = narrowed(graph.first), neighbours = narrowed(graph.neighbours),
                     weight = narrowed(graph.weight);
  std::vector<idx_t> part(size);
  auto n_vertices = static_cast<idx_t>(size), n_constraints = idx_t{1},
       n_parts = static_cast<idx_t>(n), edges = idx_t{0};
  const auto method = cut == GraphCut::k_way ? METIS_PartGraphKway : METIS_PartGraphRecursive;
  const int result =
      method(&n_vertices, &n_constraints, first.data(), neighbours.data(), weight.data(), nullptr,
             nullptr, &n_parts, nullptr, nullptr, options.data(), &edges, part.data());
  if (result != METIS_OK)
    throw RunError("METIS failed to cut the mesh into domains, with code " +
                   std::to_string(result));
  return {part.begin(), part.end()};
}

}  // namespace cbr
