// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/interface_sets.hpp"

#include <algorithm>

namespace cbr {
namespace {

bool all_kept(const std::vector<Index>& nodes, const std::vector<Index>& place) {
  return !nodes.empty() && std::all_of(nodes.begin(), nodes.end(), [&](Index node) {
    return place[static_cast<std::size_t>(node)] >= 0;
  });
}

bool on_volumes(const Mesh& mesh, const Sideset& sideset) {
  return std::all_of(sideset.sides.begin(), sideset.sides.end(), [&](const Side& side) {
    return is_structure(mesh.blocks[static_cast<std::size_t>(side.block)]);
  });
}

// A set is known by its own name and, in Exodus, by its bare number.
bool is_named(const std::vector<std::string>& named, const std::string& name, Index id) {
  return std::find(named.begin(), named.end(), name) != named.end() ||
         std::find(named.begin(), named.end(), std::to_string(id)) != named.end();
}

}  // namespace

void add_interface_sets(const Mesh& mesh, const std::vector<Index>& place,
                        const std::vector<std::string>& named, Superelement& s) {
  for (const auto& sideset : mesh.sidesets) {
    if (!on_volumes(mesh, sideset) && !is_named(named, sideset.name, sideset.id)) continue;
    if (sideset.sides.empty()) continue;
    Surface surface = extract_surface(mesh, sideset);
    if (!all_kept(surface_nodes(surface), place)) continue;
    for (Index& node : surface.faces.reshaped()) node = place[static_cast<std::size_t>(node)];
    s.surfaces.push_back(std::move(surface));
  }
  for (const auto& nodeset : mesh.nodesets) {
    if (!all_kept(nodeset.nodes, place)) continue;
    auto& nodes = s.nodesets[nodeset.name];
    for (const Index node : nodeset.nodes) nodes.push_back(place[static_cast<std::size_t>(node)]);
  }
}

}  // namespace cbr
