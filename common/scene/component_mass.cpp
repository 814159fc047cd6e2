// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/component_mass.hpp"

#include <algorithm>

namespace cbr {

MassKind mass_of_mesh(const Component& component) {
  return component.mass.value_or(MassKind::lumped);
}

MassKind mass_of_superelement(const Component& component, const Mesh& mesh) {
  if (component.mass) return *component.mass;
  const bool spoilt = std::any_of(mesh.blocks.begin(), mesh.blocks.end(), [](const Block& block) {
    return is_structure(block) && is_spoilt_by_lumping(std::string(name(block.type)));
  });
  return spoilt ? MassKind::consistent : MassKind::lumped;
}

bool is_spoilt_by_lumping(const std::string& element) {
  return element.starts_with("hex20") || element == "tet10" || element.starts_with("wedge15") ||
         element == "tri3" || element == "quad4";
}

}  // namespace cbr
