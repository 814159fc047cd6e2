// SPDX-License-Identifier: GPL-3.0-or-later
// Grids of the field output: cells of meshes and recovered interiors, and faces of superelements.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

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
  BlockProperties properties;
  Index material = 0;  // of InstanceElements, for nodal stress
};

// Datasets of a field of the scene: for stresses the columns of stress_values(), each with its own
// name. "stress" has cell values, the others nodal values.
std::vector<std::string> datasets_of(const std::string& field);
bool is_stress(const std::string& field);

// Grids of all instances, in order. Reports instances for which stress is not available.
std::vector<FieldGrid> field_grids(const Scene& scene, const BuiltScene& built, Report& report);

}  // namespace cbr
