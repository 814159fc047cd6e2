// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/face_graph.hpp"

#include <algorithm>
#include <array>

namespace cbr {
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
          face.corners[static_cast<std::size_t>(4 - n + a)] =
              block.connectivity(e, side_nodes(block.type, side)[static_cast<std::size_t>(a)]);
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
  std::vector<std::vector<Index>> neighbours(static_cast<std::size_t>(elements.size()));
  const std::vector<Face> faces = sorted_faces(mesh);
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].corners == faces[i].corners) ++end;
    // More than two elements on a face is a fault of the mesh, but no reason to stop here.
    for (std::size_t a = i; a < end; ++a) {
      for (std::size_t b = i; b < end; ++b) {
        if (faces[a].element != faces[b].element)
          neighbours[static_cast<std::size_t>(faces[a].element)].push_back(faces[b].element);
      }
    }
    i = end;
  }
  Graph graph;
  for (Index e = 0; e < elements.size(); ++e) {
    auto& of = neighbours[static_cast<std::size_t>(e)];
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
    graph.neighbours.insert(graph.neighbours.end(), of.begin(), of.end());
    graph.first.push_back(static_cast<Index>(graph.neighbours.size()));
    graph.weight.push_back(static_cast<Index>(elements.of(e).size()));
  }
  return graph;
}

}  // namespace cbr
