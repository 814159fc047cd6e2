// SPDX-License-Identifier: GPL-3.0-or-later
// A component's mesh in the place of an instance, and meshes put together.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// x_scene = T x + position. A mirrored mesh gets its elements reordered and its sides renumbered:
// volumes stay positive and faces look outwards.
Mesh place(Mesh mesh, const Instance& instance);

// Without the elements and sidesets, and with the given nodes (ascending) only; nodesets keep those
// of their nodes that stay.
Mesh keep_nodes(const Mesh& mesh, const std::vector<Index>& nodes);

// Puts meshes into one. Blocks and sets of the parts are called PART.NAME; shells of the parts are
// left out.
class SystemMesh {
 public:
  // Returns how much was added to the part's node ids and element ids: 0 where they are free.
  struct Offsets {
    Index nodes = 0, elements = 0;
  };
  Offsets add(const Mesh& part, const std::string& name);
  // Index in the system mesh of the part's node 0; the part's others follow.
  Index first_node() const { return first_node_; }
  Mesh& mesh() { return mesh_; }

 private:
  Mesh mesh_;
  std::set<Index> node_ids_, element_ids_;
  Index first_node_ = 0;
};

}  // namespace cbr
