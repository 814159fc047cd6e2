// SPDX-License-Identifier: GPL-3.0-or-later
// The volume elements of a mesh as a graph, cut into parts of about the same weight. The only code
// that includes metis.h is graph_partition.cpp.
#pragma once

#include <span>
#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

// Neighbours of vertex v: neighbours[first[v]] ... neighbours[first[v + 1] - 1], each pair of
// vertices in both directions.
struct Graph {
  std::vector<Index> first = {0}, neighbours;
  std::vector<Index> weight;  // of the vertices
  Index n_vertices() const { return static_cast<Index>(first.size()) - 1; }
};

// How METIS cuts: both ways are tried, as neither is always the better one.
enum class GraphCut { bisections, k_way };

// Per vertex its part, 0 .. n - 1 (METIS 5: Karypis, Kumar 1998, doi 10.1137/S1064827595287997).
// Small total of cut edges; parts may be empty or consist of pieces. The same graph and seed give
// the same parts. Not from several threads at a time: METIS draws from the C library's random
// numbers.
std::vector<Index> partition_graph(const Graph& graph, Index n, GraphCut cut, int seed);

// Nodes of the volume elements, in the order of the mesh's blocks.
struct ElementNodes {
  std::vector<Index> first = {0}, nodes;
  Index size() const { return static_cast<Index>(first.size()) - 1; }
  std::span<const Index> of(Index element) const {
    const auto e = static_cast<std::size_t>(element);
    return {nodes.data() + first[e], static_cast<std::size_t>(first[e + 1] - first[e])};
  }
};
ElementNodes element_nodes(const Mesh& mesh);

// Elements as vertices, joined where two have the same corner nodes on a face: the same in a mesh
// of one type and of several. Weight: the element's number of nodes.
Graph face_graph(const Mesh& mesh);

}  // namespace cbr
