// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

std::map<Index, Index> separate_rotations(Superelement& s) {
  const auto n = static_cast<Index>(s.node_ids.size());
  std::map<Index, Index> rotations;
  for (std::size_t i = 0; i < s.dof_node.size(); ++i) {
    if (s.dof_component[i] < 3) continue;
    const auto next = n + static_cast<Index>(rotations.size());
    s.dof_node[i] = rotations.try_emplace(s.dof_node[i], next).first->second;
  }
  const auto more = static_cast<Index>(rotations.size());
  if (more == 0) return rotations;
  s.coordinates.conservativeResize(n + more, Eigen::NoChange);
  s.node_ids.resize(static_cast<std::size_t>(n + more));
  for (const auto& [node, rotation] : rotations) {
    s.coordinates.row(rotation) = s.coordinates.row(node);
    s.node_ids[rotation] = s.node_ids[node];
  }
  // Recovery data number interior nodes after the interface's last
  const auto shift = [&](Index& place) { place += place >= n ? more : 0; };
  for (Superelement::Recovery& recovery : s.recovery) {
    for (Index& place : recovery.rotations) shift(place);
    for (Block& block : recovery.blocks)
      for (Index& place : block.connectivity.reshaped()) shift(place);
  }
  for (auto& [name, nodes] : s.recovered_sets)
    for (Index& place : nodes) shift(place);
  return rotations;
}

}  // namespace cbr
