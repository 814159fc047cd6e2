// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/field_grids.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/fem/stress_values.hpp"
#include "common/mesh/face_weights.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {
namespace {

// All surface faces of one kind, without repetition, and the elements that they belong to.
IndexTable faces_of_kind(const Geometry& geometry, FaceKind kind, std::vector<Index>& element) {
  std::set<std::vector<Index>> seen;
  std::vector<std::vector<Index>> faces;
  element.clear();
  for (const auto& [name, surface] : geometry.surfaces) {
    for (Index f = 0; f < surface.n_faces(); ++f) {
      std::vector<Index> nodes = nodes_of_face(surface, f), key = nodes;
      if (static_cast<int>(nodes.size()) != n_nodes(kind)) continue;
      std::sort(key.begin(), key.end());
      if (!seen.insert(key).second) continue;
      faces.push_back(std::move(nodes));
      element.push_back(surface.element[f]);
    }
  }
  IndexTable table(static_cast<Index>(faces.size()), n_nodes(kind));
  for (Index f = 0; f < table.rows(); ++f)
    for (Index a = 0; a < table.cols(); ++a) table(f, a) = faces[f][a];
  return table;
}

Points placed(const Points& X, const Placement& placement) {
  return (X * placement.T.transpose()).rowwise() + placement.position.transpose();
}

bool is_stress_wanted(const Scene& scene) {
  const auto& fields = scene.output.fields;
  return std::any_of(fields.begin(), fields.end(), is_stress);
}

void add_interface_grids(const BuiltScene::OfInstance& of, const FieldGrid& empty,
                         std::vector<FieldGrid>& grids) {
  using enum ElementType;
  for (const ElementType type : {tri3, quad4, tri6, quad8, quad9}) {
    FieldGrid grid = empty;
    grid.cells =
        faces_of_kind(*of.geometry, static_cast<FaceKind>(n_nodes(type)), grid.element_ids);
    grid.name = of.name + ".interface";
    grid.topology = xdmf_words.at(type);
    if (grid.cells.rows() > 0) grids.push_back(std::move(grid));
  }
}

void add_block_grids(const BuiltScene::OfInstance& of, FieldGrid grid,
                     const std::vector<Block>& blocks, std::vector<FieldGrid>& grids) {
  const std::string part =
      grid.part >= 0 && of.parts.size() > 1 ? ".domain" + std::to_string(grid.part + 1) : "";
  for (const Block& block : blocks) {
    if ((of.mesh && !is_structure(block)) || block.connectivity.rows() == 0) continue;
    grid.name = of.name + part + "." + block.name;
    grid.topology = xdmf_words.at(block.type);
    grid.block = &block;
    grid.element_ids = block.element_ids;
    grid.cells = vtk_order(block.connectivity, block.type);
    if (of.mesh)
      grid.cells = grid.cells.unaryExpr([&](Index node) { return of.body_node[node]; }).eval();
    grids.push_back(grid);
  }
}

// Adds the recovered interiors of all parts.
void add_recovered_grids(const BuiltScene::OfInstance& of, FieldGrid grid,
                         std::vector<FieldGrid>& grids) {
  for (std::size_t p = 0; p < of.parts.size(); ++p) {
    const Superelement& s = *of.parts[p].superelement;
    const Superelement::Recovery& recovery = s.recovery.front();
    Points X(s.coordinates.rows() + recovery.coordinates.rows(), 3);
    X << s.coordinates, recovery.coordinates;
    grid.part = static_cast<Index>(p);
    grid.points = placed(X, of.placement);
    grid.node_ids = s.node_ids;
    grid.node_ids.insert(grid.node_ids.end(), recovery.node_ids.begin(), recovery.node_ids.end());
    add_block_grids(of, grid, recovery.blocks, grids);
  }
}

void add_instance_grids(const Scene& scene, const BuiltScene& built, Index i, Report& report,
                        std::vector<FieldGrid>& grids) {
  const auto& of = built.instances[i];
  FieldGrid grid;
  grid.instance = i;
  // Rotation nodes, which follow all others, have no position
  const auto n =
      of.geometry->coordinates.rows() - static_cast<Index>(of.geometry->rotations.size());
  grid.points = built.simulation.bodies[i]->reference_positions().topRows(n);
  grid.node_ids.assign(of.geometry->node_ids.begin(), of.geometry->node_ids.begin() + n);
  if (of.mesh) add_block_grids(of, grid, of.mesh->blocks, grids);
  const bool is_recovered = !of.mesh && !of.parts.front().superelement->recovery.empty();
  if (!of.mesh) add_interface_grids(of, grid, grids);
  if (is_recovered) add_recovered_grids(of, grid, grids);
  if (is_stress_wanted(scene) && !of.mesh && !is_recovered)
    report.line("note: no stress of '" + of.name +
                "': its superelement has no recovery data (reduction.recovery: true)");
}

}  // namespace

IndexTable vtk_order(const IndexTable& nodes, ElementType type) {
  const Index corners = n_corners(type), n = corners / 2, first = corners + n;
  if (corners < 6 || n_nodes(type) == corners) return nodes;
  IndexTable out = nodes.leftCols(first + 2 * n);
  out.middleCols(first, n) = nodes.middleCols(first + n, n);
  out.rightCols(n) = nodes.middleCols(first, n);
  return out;
}

std::vector<std::string> datasets_of(const std::string& field, bool is_shell) {
  if (!is_stress(field)) return {field};
  std::vector<std::string> names;
  for (const std::string face : {"_", "_top_", "_bottom_"})
    for (const std::string_view name : stress_names)
      if (is_shell || face == "_") names.push_back(field + face + std::string(name));
  return names;
}

bool is_stress(const std::string& field) { return field == "stress" || field == "nodal_stress"; }

std::vector<FieldGrid> field_grids(const Scene& scene, const BuiltScene& built, Report& report) {
  std::vector<FieldGrid> grids;
  for (Index i = 0; i < static_cast<Index>(built.instances.size()); ++i)
    add_instance_grids(scene, built, i, report, grids);
  return grids;
}

}  // namespace cbr
