// SPDX-License-Identifier: GPL-3.0-or-later
// What fields are shown on: the cells of meshes and recovered interiors, and the faces of
// superelements.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// One grid of the file: part of an instance with one kind of cell. Points are the undeformed ones
// in the scene's axes; displacement is relative to them.
struct FieldGrid {
  std::string name;
  std::string topology;  // XDMF's name: Hexahedron, Quadrilateral, ...
  Index instance = 0;
  IndexTable cells;                // e x n, VTK's order of nodes
  Points points;                   // p x 3
  std::vector<Index> node_ids;     // p, of the mesh
  std::vector<Index> element_ids;  // e, of the mesh; of faces the element that each is a side of
  // with recovery data: points are [interface; interior] of this part of a superelement
  Index part = -1;
  // For stress, which needs the element: empty type list otherwise
  const Block* block = nullptr;
  BlockProperties properties;
  Index material = 0;  // of InstanceElements, for nodal stress
};

// Fields as the file has them, by the scene's name: a stress is the columns of stress_values(),
// each under a name of its own. "stress" is of cells, the others of nodes.
std::vector<std::string> datasets_of(const std::string& field);
bool is_stress(const std::string& field);

// Of all instances, in their order. Says on the report of which no stress can be shown.
std::vector<FieldGrid> field_grids(const Scene& scene, const BuiltScene& built, Report& report);

}  // namespace cbr
