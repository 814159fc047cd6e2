// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact_faces.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace cbr {
namespace {

using Seen = std::set<std::vector<Index>>;

// The faces that are not in `seen` yet, which they are added to.
Surface unseen(const Surface& surface, Seen& seen) {
  Surface fresh;
  fresh.kind = surface.kind;
  std::vector<Index> rows;
  for (Index f = 0; f < surface.n_faces(); ++f) {
    std::vector<Index> nodes(surface.faces.row(f).begin(), surface.faces.row(f).end());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());  // a triangle among quads is that of a surface of triangles
    if (seen.insert(std::move(nodes)).second) rows.push_back(f);
  }
  fresh.faces = surface.faces(rows, Eigen::all);
  return fresh;
}

}  // namespace

IndexTable contact_faces(const Surface& surface) {
  Seen seen;
  return linear_faces(unseen(surface, seen)).faces;
}

IndexTable all_faces(const Geometry& geometry) {
  Seen seen;
  std::vector<IndexTable> parts;
  Index n = 0;
  for (const auto& [name, surface] : geometry.surfaces) {
    parts.push_back(linear_faces(unseen(surface, seen)).faces);
    n += parts.back().rows();
  }
  IndexTable faces(n, 4);
  n = 0;
  for (const IndexTable& part : parts) {
    faces.middleRows(n, part.rows()) = part;
    n += part.rows();
  }
  return faces;
}

bool has_faces(const Geometry& geometry) {
  return std::any_of(geometry.surfaces.begin(), geometry.surfaces.end(), [](const auto& s) { return s.second.n_faces() > 0; });
}

void turn_over(IndexTable& faces) {
  for (Index f = 0; f < faces.rows(); ++f) {
    auto row = faces.row(f);
    if (row(2) == row(3)) {
      std::swap(row(1), row(2));
      row(3) = row(2);
    } else {
      std::swap(row(1), row(3));
    }
  }
}

void join_faces(const IndexTable& faces, IndexTable& all) {
  Seen seen;
  Surface both;
  both.faces.resize(all.rows() + faces.rows(), 4);
  both.faces << all, faces;
  all = unseen(both, seen).faces;
}

std::vector<Index> nodes_of(const IndexTable& faces) {
  std::vector<Index> nodes(faces.data(), faces.data() + faces.size());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace cbr
