// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/geometry.hpp"

#include "common/base/error.hpp"

namespace cbr {
namespace {

std::string names(const Geometry& geometry, bool with_nodesets) {
  std::vector<std::string> list;
  for (const auto& [name, surface] : geometry.surfaces) list.push_back(name);
  for (const auto& [name, nodes] : geometry.nodesets)
    if (with_nodesets) list.push_back(name);
  return list.empty() ? "none" : join(list);
}

[[noreturn]] void missing(const Geometry& geometry, const std::string& instance,
                          const std::string& name, const SourceLine& source, bool with_nodesets) {
  std::vector<std::string> list;
  for (const auto& [known, surface] : geometry.surfaces) list.push_back(known);
  std::string message = source.text() + ": instance '" + instance + "' has no " +
                        (with_nodesets ? "surface or node set" : "surface") + " '" + name +
                        "' (available: " + names(geometry, with_nodesets) + ")" +
                        nearest_name(name, list);
  if (geometry.reduced && geometry.has_mesh)
    message +=
        ": if the mesh has it, add it to the component's reduction.interface and run cbr-reduce "
        "again";
  throw InputError(message);
}

[[noreturn]] void refuse_without_recovery(const SetUse& use, const Geometry& geometry) {
  throw InputError(
      place_of(use) +
      "the superelement has no recovery data of this set, from which stress follows (it has: " +
      (geometry.recovered.empty() ? "none"
                                  : join({geometry.recovered.begin(), geometry.recovered.end()})) +
      ")" +
      (geometry.has_mesh ? ": give reduction: {recovery: [" + use.set +
                               "]}, or recovery: true, and run cbr-reduce --force"
                         : ""));
}

}  // namespace

Geometry geometry_of(const Superelement& superelement) {
  Geometry geometry;
  geometry.reduced = true;
  geometry.node_ids = superelement.node_ids;
  geometry.coordinates = superelement.coordinates;
  for (const Surface& surface : superelement.surfaces) geometry.surfaces[surface.name] = surface;
  geometry.nodesets = superelement.nodesets;
  for (const auto& [name, nodes] : superelement.recovered_sets) geometry.recovered.insert(name);
  if (!superelement.fixed.any()) return geometry;
  for (Index i = 0; i < geometry.coordinates.rows(); ++i)
    for (int c = 0; c < 3; ++c) geometry.fixed.emplace(i, c);
  for (std::size_t i = 0; i < superelement.dof_node.size(); ++i)
    geometry.fixed.erase({superelement.dof_node[i], superelement.dof_component[i]});
  return geometry;
}

Geometry geometry_of(const Mesh& mesh, const FiniteElementModel& model) {
  Geometry geometry;
  geometry.coordinates = mesh.coordinates(model.nodes, Eigen::all);
  for (const Index node : model.nodes) geometry.node_ids.push_back(mesh.node_ids[node]);
  for (Index i = model.n_translations(); i < static_cast<Index>(model.nodes.size()); ++i)
    geometry.rotations[model.row[model.nodes[i]]] = i;
  for (const Sideset& sideset : mesh.sidesets) {
    Surface surface = extract_surface(mesh, sideset);
    for (Index i = 0; i < surface.faces.size(); ++i)
      surface.faces.data()[i] = model.row[surface.faces.data()[i]];
    geometry.surfaces[sideset.name] = std::move(surface);
  }
  for (const Nodeset& nodeset : mesh.nodesets) {
    std::vector<Index>& nodes = geometry.nodesets[nodeset.name];
    for (const Index node : nodeset.nodes)
      if (model.row[node] >= 0) nodes.push_back(model.row[node]);
  }
  return geometry;
}

Index node_of_point(const Geometry& geometry, const std::string& point, const std::string& set) {
  for (const std::string* name : {&point, &set}) {
    if (name == &point && !geometry.reduced) continue;  // a mesh may have another set of this name
    const auto found = geometry.nodesets.find(*name);
    if (found == geometry.nodesets.end() || found->second.size() != 1) continue;
    const Index node = found->second.front();
    if (geometry.rotations.count(node) > 0) return node;
  }
  return -1;
}

bool is_inside(const Geometry& geometry, const std::string& set) {
  return geometry.surfaces.count(set) == 0 && geometry.nodesets.count(set) == 0 &&
         geometry.recovered.count(set) > 0;
}

const Surface& find_surface(const Geometry& geometry, const std::string& instance,
                            const std::string& name, const SourceLine& source) {
  const auto it = geometry.surfaces.find(name);
  if (it == geometry.surfaces.end() || it->second.n_faces() == 0)
    missing(geometry, instance, name, source, false);
  return it->second;
}

void check_uses(const std::vector<SetUse>& uses, const Geometry& geometry) {
  for (const SetUse& use : uses) {
    if (use.may_be_inside && geometry.recovered.count(use.set) > 0) continue;
    if (use.is_of_stress && geometry.reduced) refuse_without_recovery(use, geometry);
    if (use.needs_faces) find_surface(geometry, use.instance, use.set, use.source);
    if (!use.needs_faces) find_nodes(geometry, use.instance, use.set, use.source);
  }
}

void check_uses(const std::vector<SetUse>& uses, const Mesh& mesh) {
  Geometry names;
  for (const Sideset& sideset : mesh.sidesets) names.surfaces[sideset.name];
  for (const Nodeset& nodeset : mesh.nodesets) names.nodesets[nodeset.name];
  for (const SetUse& use : uses) {
    const bool is_there = names.surfaces.count(use.set) > 0 ||
                          (!use.needs_faces && names.nodesets.count(use.set) > 0);
    if (!is_there) missing(names, use.instance, use.set, use.source, !use.needs_faces);
  }
}

std::vector<Index> find_nodes(const Geometry& geometry, const std::string& instance,
                              const std::string& name, const SourceLine& source) {
  if (const auto it = geometry.surfaces.find(name); it != geometry.surfaces.end())
    return surface_nodes(it->second);
  const auto it = geometry.nodesets.find(name);
  if (it == geometry.nodesets.end() || it->second.empty())
    missing(geometry, instance, name, source, true);
  return it->second;
}

}  // namespace cbr
