// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/points_of_file.hpp"

#include "common/base/error.hpp"
#include "common/superelement/superelement_group.hpp"

namespace cbr {
namespace {

Superelement sets_in(const std::filesystem::path& file) try {
  if (!std::filesystem::exists(file) || is_superelement_group(file)) return {};
  return read_superelement(file, {false, false, false});
} catch (const InputError&) {
  return {};
}

}  // namespace

void add_points_of_file(Component& component) {
  const Superelement s = sets_in(component.reduction->superelement);
  std::vector<char> turns(s.node_ids.size(), 0);
  for (std::size_t i = 0; i < s.dof_node.size(); ++i)
    if (s.dof_component[i] > 2) turns[s.dof_node[i]] = 1;
  for (const auto& [name, nodes] : s.nodesets) {
    if (nodes.size() != 1 || turns[nodes.front()] == 0) continue;
    Component::Point& point = component.points[name];
    point.nodes = name;
    point.rigid = true;
    point.source = component.source;
    component.reduction->interface_points.push_back(name);
  }
}

}  // namespace cbr
