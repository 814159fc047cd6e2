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

namespace {

struct Face {
  std::array<Index, 4> corners;  // ascending; a triangle's begin with -1
  Index element;
};

std::vector<Face> sorted_faces(const Mesh& mesh) {
  std::vector<Face> faces;
  Index element = 0;
  for (const Block& block : mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e, ++element) {
      for (int side = 1; side <= n_sides(block.type); ++side) {
        Face face{{-1, -1, -1, -1}, element};
        const int n = n_corners(side_kind(block.type, side));
        for (int a = 0; a < n; ++a) {
          face.corners[4 - n + a] = block.connectivity(e, side_nodes(block.type, side)[a]);
        }
        std::sort(face.corners.begin(), face.corners.end());
        faces.push_back(face);
      }
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.element < b.element;
  });
  return faces;
}

}  // namespace

ElementNodes element_nodes(const Mesh& mesh) {
  ElementNodes elements;
  for (const Block& block : mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (Index a = 0; a < block.connectivity.cols(); ++a)
        elements.nodes.push_back(block.connectivity(e, a));
      elements.first.push_back(static_cast<Index>(elements.nodes.size()));
    }
  }
  return elements;
}

Graph face_graph(const Mesh& mesh) {
  const ElementNodes elements = element_nodes(mesh);
  std::vector<std::vector<Index>> neighbours(elements.size());
  const std::vector<Face> faces = sorted_faces(mesh);
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].corners == faces[i].corners) ++end;
    // More than two elements on a face is a fault of the mesh, but no reason to stop here.
    for (std::size_t a = i; a < end; ++a) {
      for (std::size_t b = i; b < end; ++b) {
        if (faces[a].element != faces[b].element)
          neighbours[faces[a].element].push_back(faces[b].element);
      }
    }
    i = end;
  }
  Graph graph;
  for (Index e = 0; e < elements.size(); ++e) {
    auto& of = neighbours[e];
    sort_uniquely(of);
    graph.neighbours.insert(graph.neighbours.end(), of.begin(), of.end());
    graph.first.push_back(static_cast<Index>(graph.neighbours.size()));
    graph.weight.push_back(static_cast<Index>(elements.of(e).size()));
  }
  return graph;
}

}  // namespace cbr
