// SPDX-License-Identifier: GPL-3.0-or-later
// The forces that a scene may put on a superelement's nodes, whose static answer is kept.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// A surface that may touch, and whether forces along it count as well as normal ones.
struct TouchingSurface {
  const Surface* surface = nullptr;
  bool all_directions = false;
};

// Of the superelement's surfaces those that a scene's contact names, or all of them where it names
// a set that is none. `everywhere`: in all directions whatever the contact is.
std::vector<TouchingSurface> touching_surfaces(const InterfaceNeeds& needs, const Superelement& s,
                                               bool everywhere = false);

// Of the scene's loads on the interface those that neither kept nodes nor the statics of faces that
// touch answer already, by the names of sets.
std::map<std::string, LoadKinds> loads_beside_statics(const CharacteristicOptions& options,
                                                      const InterfaceNeeds& needs);

// Nodes of the superelement's sets that the scene's loads act on.
std::vector<Index> loaded_nodes(const InterfaceNeeds& needs, const Superelement& s);

// Nodes and unit directions of the forces, by node; no F. is_kept: nodes without any, by node of s;
// empty: none. loaded: nodes with all directions.
StaticShare static_forces(const std::vector<TouchingSurface>& touching,
                          const std::vector<char>& is_kept, const Superelement& s,
                          const std::vector<Index>& loaded = {});

}  // namespace cbr
