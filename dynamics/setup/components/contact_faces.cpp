// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/contact_faces.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/scene/scene_uses.hpp"

namespace cbr {
namespace {

using Seen = std::set<std::vector<Index>>;

// The faces that are not in `seen`; adds them to it.
Surface unseen(const Surface& surface, Seen& seen) {
  Surface fresh;
  fresh.kind = surface.kind;
  std::vector<Index> rows;
  for (Index f = 0; f < surface.n_faces(); ++f) {
    std::vector<Index> nodes(surface.faces.row(f).begin(), surface.faces.row(f).end());
    std::sort(nodes.begin(), nodes.end());
    // a triangle among quads has the same nodes as in a surface of triangles
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (seen.insert(std::move(nodes)).second) rows.push_back(f);
  }
  fresh.faces = surface.faces(rows, Eigen::all);
  return fresh;
}

// f x 9, see whole_faces.
IndexTable whole(const Surface& surface) {
  IndexTable faces = IndexTable::Constant(surface.n_faces(), 9, -1);
  for (Index f = 0; f < faces.rows(); ++f) {
    const std::vector<Index> nodes = nodes_of_face(surface, f);
    const std::size_t n = nodes.size() % 3 == 0 && nodes.size() < 9 ? 3 : 4;
    for (std::size_t a = 0; a < 4; ++a) faces(f, static_cast<Index>(a)) = nodes[std::min(a, n - 1)];
    for (std::size_t a = n; a < nodes.size(); ++a)
      faces(f, static_cast<Index>(4 + a - n)) = nodes[a];
  }
  return faces;
}

// Faces of all surfaces without repetition, as returned by `table`.
template <typename Table>
IndexTable joined_faces(const Geometry& geometry, const Table& table) {
  Seen seen;
  std::vector<IndexTable> parts;
  Index n = 0;
  for (const auto& [name, surface] : geometry.surfaces) {
    parts.push_back(table(unseen(surface, seen)));
    n += parts.back().rows();
  }
  IndexTable faces(n, parts.empty() ? 4 : parts.front().cols());
  n = 0;
  for (const IndexTable& part : parts) {
    faces.middleRows(n, part.rows()) = part;
    n += part.rows();
  }
  return faces;
}

}  // namespace

IndexTable contact_faces(const Surface& surface) {
  Seen seen;
  return linear_faces(unseen(surface, seen)).faces;
}

IndexTable whole_faces(const Surface& surface) {
  Seen seen;
  return whole(unseen(surface, seen));
}

IndexTable all_faces(const Geometry& geometry) {
  return joined_faces(geometry, [](const Surface& surface) { return linear_faces(surface).faces; });
}

IndexTable all_whole_faces(const Geometry& geometry) { return joined_faces(geometry, whole); }

std::vector<Surface> distinct_surfaces(const std::vector<const Surface*>& surfaces) {
  Seen seen;
  std::vector<Surface> distinct;
  for (const Surface* surface : surfaces) {
    distinct.push_back(unseen(*surface, seen));
    if (distinct.back().n_faces() == 0) distinct.pop_back();
  }
  return distinct;
}

std::vector<const Surface*> all_surfaces(const Geometry& geometry) {
  std::vector<const Surface*> all;
  for (const auto& [name, surface] : geometry.surfaces) all.push_back(&surface);
  return all;
}

bool is_second_order(const Surface& surface) {
  return n_nodes(surface.kind) > n_corners(surface.kind);
}

bool has_faces(const Geometry& geometry) {
  return std::any_of(geometry.surfaces.begin(), geometry.surfaces.end(),
                     [](const auto& s) { return s.second.n_faces() > 0; });
}

void turn_over(IndexTable& faces) {
  for (Index f = 0; f < faces.rows(); ++f) {
    auto row = faces.row(f);
    if (row(2) == row(3)) {
      std::swap(row(1), row(2));
      row(3) = row(2);
      if (row.size() == 9) std::swap(row(4), row(6));
    } else {
      std::swap(row(1), row(3));
      if (row.size() == 9) {
        std::swap(row(4), row(7));
        std::swap(row(5), row(6));
      }
    }
  }
}

void join_faces(const IndexTable& faces, IndexTable& all) {
  Seen seen;
  Surface both;
  both.faces.resize(all.rows() + faces.rows(), 4);
  if (all.rows() > 0) both.faces.topRows(all.rows()) = all;
  if (faces.rows() > 0) both.faces.bottomRows(faces.rows()) = faces;
  all = unseen(both, seen).faces;
}

std::vector<Index> nodes_of(const IndexTable& faces) {
  std::vector<Index> nodes(faces.data(), faces.data() + faces.size());
  sort_uniquely(nodes);
  return nodes;
}

IndexTable skin_faces(const Scene& scene, const std::string& instance, const Geometry& geometry) {
  IndexTable faces(0, 4);
  if (!skin_acts(scene)) return faces;
  for (const auto& [name, surface] : geometry.surfaces) {
    const bool named = std::any_of(scene.skin->surfaces.begin(), scene.skin->surfaces.end(),
                                   [&, &its_name = name](const auto& s) {
                                     return s == its_name || s == instance + "." + its_name;
                                   });
    if (named) join_faces(contact_faces(surface), faces);
  }
  return faces;
}

ShellModel skin_shells(const Scene& scene, const std::string& instance, const Geometry& geometry) {
  const SkinOptions& skin = *scene.skin;
  const Material material{skin.youngs_modulus, skin.poissons_ratio, skin.density};
  try {
    return assemble_shells(skin_faces(scene, instance, geometry), geometry.coordinates,
                           {material, skin.thickness});
  } catch (const InputError& error) {
    throw InputError(skin.source.text() + ": skin: instance '" + instance + "': " + error.what());
  }
}

}  // namespace cbr
