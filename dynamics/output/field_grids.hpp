// SPDX-License-Identifier: GPL-3.0-or-later
// Grids of the field output: cells of meshes and recovered interiors, and faces of superelements.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// XDMF's words of cells. A hex27 is shown by its first 20 nodes.
inline const std::map<ElementType, std::string> xdmf_words = {
    {ElementType::tri3, "Triangle"},         {ElementType::tri6, "Triangle_6"},
    {ElementType::quad4, "Quadrilateral"},   {ElementType::quad8, "Quadrilateral_8"},
    {ElementType::quad9, "Quadrilateral_9"}, {ElementType::tet4, "Tetrahedron"},
    {ElementType::tet10, "Tetrahedron_10"},  {ElementType::pyramid5, "Pyramid"},
    {ElementType::wedge6, "Wedge"},          {ElementType::wedge15, "Wedge_15"},
    {ElementType::hex8, "Hexahedron"},       {ElementType::hex20, "Hexahedron_20"},
    {ElementType::hex27, "Hexahedron_20"}};

// Cells (e x n) from Exodus' order of nodes to VTK's, and back: Exodus has the upright mid-edges of
// hexes and wedges before the upper ones.
IndexTable vtk_order(const IndexTable& nodes, ElementType type);

// One grid of the file: part of an instance with one kind of cell. Points are undeformed positions
// in the scene's axes; displacement is relative to them.
struct FieldGrid {
  std::string name;
  std::string topology;  // XDMF's name: Hexahedron, Quadrilateral, ...
  Index instance = 0;
  IndexTable cells;                // e x n, VTK's order of nodes
  Points points;                   // p x 3
  std::vector<Index> node_ids;     // p, of the mesh
  std::vector<Index> element_ids;  // e, of the mesh; for faces the element of each
  // with recovery data: points are [interface; interior] of this part of a superelement
  Index part = -1;
  // For stress, which needs the element; otherwise null
  const Block* block = nullptr;
  std::vector<Index> groups;  // of InstanceElements: one, of shells top and bottom; none: no stress
  bool is_shell() const { return block != nullptr && dimension(block->type) != 3; }
};

// Datasets of a field of the scene: for stresses the columns of stress_values(), each with its own
// name; of shells those of the face with the larger von Mises stress, of the top and of the bottom.
// "stress" has cell values, the others nodal values.
std::vector<std::string> datasets_of(const std::string& field, bool is_shell = false);
bool is_stress(const std::string& field);

// Grids of all instances, in order. Reports instances for which stress is not available.
std::vector<FieldGrid> field_grids(const Scene& scene, const BuiltScene& built, Report& report);

}  // namespace cbr
