// SPDX-License-Identifier: GPL-3.0-or-later
// The volume elements of a mesh as one list, and who shares a face with whom.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "reducer/partition/graph_partition.hpp"

namespace cbr {

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
