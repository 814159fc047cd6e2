// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/interface_sets.hpp"

#include <algorithm>
#include <unordered_map>

#include "common/base/error.hpp"
#include "common/scene/limits.hpp"
#include "common/scene/scene_uses.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

bool all_kept(const std::vector<Index>& nodes, const std::vector<Index>& place) {
  return !nodes.empty() &&
         std::all_of(nodes.begin(), nodes.end(), [&](Index node) { return place[node] >= 0; });
}

bool on_volumes(const Mesh& mesh, const Sideset& sideset) {
  return std::all_of(sideset.sides.begin(), sideset.sides.end(),
                     [&](const Side& side) { return is_structure(mesh.blocks[side.block]); });
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
    for (Index& node : surface.faces.reshaped()) node = place[node];
    s.surfaces.push_back(std::move(surface));
  }
  for (const auto& nodeset : mesh.nodesets) {
    if (!all_kept(nodeset.nodes, place)) continue;
    auto& nodes = s.nodesets[nodeset.name];
    for (const Index node : nodeset.nodes) nodes.push_back(place[node]);
  }
}

namespace {

// A name becomes that of a dataset.
bool is_plain(const std::string& name) {
  return !name.empty() &&
         std::none_of(name.begin(), name.end(), [](unsigned char c) { return c == '/' || c < 32; });
}

std::vector<char> marked_nodes(const Mesh& mesh, const std::vector<std::string>& names) {
  std::vector<char> marked(mesh.node_ids.size(), 0);
  for (const std::string& name : names) {
    if (find_block(mesh, name) >= 0) continue;
    for (const Index node : set_nodes(mesh, name)) marked[node] = 1;
  }
  return marked;
}

bool is_named(const std::vector<std::string>& names, const Block& block) {
  return std::find(names.begin(), names.end(), block.name) != names.end();
}

}  // namespace

void check_recovery_sets(const Mesh& mesh, const ReductionOptions& reduction) {
  for (const std::string& name : reduction.recovery_sets) {
    if (find_block(mesh, name) >= 0) continue;
    try {
      set_nodes(mesh, name);
    } catch (const InputError& error) {
      throw InputError(reduction.source.text() +
                       ": reduction.recovery: no element block is named '" + name + "', and " +
                       error.what());
    }
  }
}

void keep_elements_at(const Mesh& mesh, const std::vector<std::string>& names,
                      const std::vector<Index>& place, Superelement::Recovery& recovery) {
  const std::vector<char> marked = marked_nodes(mesh, names);
  const auto n = static_cast<Index>(recovery.node_ids.size());
  const Index n_interface = *std::max_element(place.begin(), place.end()) + 1 - n;
  std::vector<char> is_at(n_interface + n, 0), is_needed = is_at;
  for (std::size_t node = 0; node < place.size(); ++node)
    if (place[node] >= 0) is_at[place[node]] = marked[node];
  for (Block& block : recovery.blocks) {
    const bool whole = is_named(names, block);
    std::vector<Index> rows, ids;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const auto nodes = block.connectivity.row(e);
      if (!whole &&
          std::none_of(nodes.begin(), nodes.end(), [&](Index i) { return is_at[i] != 0; }))
        continue;
      rows.push_back(e);
      ids.push_back(block.element_ids[e]);
      for (const Index i : nodes) is_needed[i] = 1;
    }
    block.connectivity = IndexTable(block.connectivity(rows, Eigen::all));
    block.element_ids = ids;
  }
  std::vector<Index> new_place(is_needed.size()), nodes, dofs, ids;
  for (Index i = 0; i < n_interface; ++i) new_place[i] = i;
  for (Index i = 0; i < n; ++i) {
    if (is_needed[n_interface + i] == 0) continue;
    new_place[n_interface + i] = n_interface + static_cast<Index>(nodes.size());
    nodes.push_back(i);
    dofs.insert(dofs.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    ids.push_back(recovery.node_ids[i]);
  }
  for (Block& block : recovery.blocks)
    for (Index& i : block.connectivity.reshaped()) i = new_place[i];
  std::vector<Index> rotations;
  for (std::size_t i = 0; i < recovery.rotations.size(); ++i) {
    if (is_needed[recovery.rotations[i]] == 0) continue;
    rotations.push_back(new_place[recovery.rotations[i]]);
    const Index row = 3 * (n + static_cast<Index>(i));
    dofs.insert(dofs.end(), {row, row + 1, row + 2});
  }
  recovery.rotations = rotations;
  recovery.node_ids = ids;
  recovery.coordinates = Points(recovery.coordinates(nodes, Eigen::all));
  recovery.Psi = Matrix(recovery.Psi(dofs, Eigen::all));
  recovery.Phi = Matrix(recovery.Phi(dofs, Eigen::all));
}

void add_recovered_sets(const Mesh& mesh, bool is_domain, Superelement& s) {
  if (s.recovery.empty()) return;
  std::unordered_map<Index, Index> place;
  for (const Index id : s.node_ids) place.emplace(id, static_cast<Index>(place.size()));
  for (const Index id : s.recovery.front().node_ids)
    place.emplace(id, static_cast<Index>(place.size()));
  const auto add = [&](const std::string& name) {
    if (!is_plain(name)) return;
    std::vector<Index> nodes;
    const std::vector<Index> all = set_nodes(mesh, name);
    for (const Index node : all)
      if (const auto found = place.find(mesh.node_ids[node]); found != place.end())
        nodes.push_back(found->second);
    if (!nodes.empty() && (is_domain || nodes.size() == all.size()))
      s.recovered_sets[name] = std::move(nodes);
  };
  for (const Sideset& sideset : mesh.sidesets) add(sideset.name);
  for (const Nodeset& nodeset : mesh.nodesets) add(nodeset.name);
}

namespace {

// cbr-dyn takes the nodes of a sideset or a nodeset; contact needs faces.
std::vector<Index> nodes_of(const SetUse& use, const Mesh& mesh) {
  if (use.needs_faces && find_sideset(mesh, use.set) < 0)
    throw InputError(place_of(use) +
                     "the mesh has no sideset of this name (available: " + set_names(mesh) + ")");
  try {
    return set_nodes(mesh, use.set);
  } catch (const InputError& error) {
    throw InputError(place_of(use) + error.what());
  }
}

void refuse_tractions_on_nodes(const Scene& scene, const Component& component, const Mesh& mesh) {
  for (const Load& load : scene.loads) {
    if (load.kind != Load::Kind::traction) continue;
    const bool is_of_component =
        std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
          return instance.name == load.instance && instance.component == component.name;
        });
    if (is_of_component && find_sideset(mesh, load.surface) < 0 &&
        find_nodeset(mesh, load.surface) >= 0)
      refuse(load, feature::nodeset);
  }
}

// True if the recovery data cover the set.
bool is_recovered(const SetUse& use, const ReductionOptions& reduction) {
  const std::vector<std::string>& sets = reduction.recovery_sets;
  return use.may_be_inside && reduction.recovery &&
         (sets.empty() || std::find(sets.begin(), sets.end(), use.set) != sets.end());
}

// ", or name the point 'left' that moves it"
std::string point_instead(const SetUse& use, const Component& component) {
  for (const auto& [name, point] : component.points) {
    if (point.nodes != use.set || !point.rigid) continue;
    return is_interface_point(component, name) ? ", or name the point '" + name + "' that moves it"
                                               : ", or '" + name + "' to reduction.points";
  }
  return "";
}

[[noreturn]] void refuse_without_recovery(const SetUse& use, const Component& component) {
  throw InputError(
      place_of(use) + "the superelement of component '" + component.name +
      "' has no recovery data there, from which stress follows: give reduction: {recovery: [" +
      use.set + "]}, or recovery: true");
}

}  // namespace

void check_kept_sets(const Scene& scene, const Component& component, const Mesh& mesh) {
  refuse_tractions_on_nodes(scene, component, mesh);
  const std::vector<SetUse> uses = set_uses(scene, component, InstanceKind::superelement);
  if (uses.empty()) return;
  const FiniteElementModel model = number_nodes(mesh);
  std::vector<char> is_kept(mesh.node_ids.size(), 0);
  for (const Index i : nodes_of_sets(mesh, model, *component.reduction))
    is_kept[model.nodes[i]] = 1;
  for (const SetUse& use : uses) {
    if (!use.needs_faces && is_interface_point(component, use.set)) continue;
    const std::vector<Index> nodes = nodes_of(use, mesh);
    if (!nodes.empty() && is_recovered(use, *component.reduction)) continue;
    if (use.is_of_stress) refuse_without_recovery(use, component);
    const auto n_kept =
        std::count_if(nodes.begin(), nodes.end(), [&](Index node) { return is_kept[node] != 0; });
    if (!nodes.empty() && n_kept == static_cast<std::ptrdiff_t>(nodes.size())) continue;
    throw InputError(
        place_of(use) + "the superelement of component '" + component.name + "' keeps " +
        std::to_string(n_kept) + " of its " + std::to_string(nodes.size()) +
        " nodes, expected all: add '" + use.set +
        "' to reduction.interface (it has: " + join(component.reduction->interface_sets) + ")" +
        (use.may_be_inside ? ", or to reduction.recovery" : "") + point_instead(use, component));
  }
}

void check_kept_sets(const Scene& scene, const Component& component, const Superelement& file) {
  const auto has_faces = [&](const std::string& name) {
    return std::any_of(file.surfaces.begin(), file.surfaces.end(),
                       [&](const Surface& s) { return s.name == name; });
  };
  const std::vector<SetUse> uses = set_uses(scene, component, InstanceKind::superelement);
  const bool all_kept = std::all_of(uses.begin(), uses.end(), [&](const SetUse& use) {
    if (use.may_be_inside && file.recovered_sets.count(use.set) > 0) return true;
    return !use.is_of_stress &&
           (has_faces(use.set) || (!use.needs_faces && file.nodesets.count(use.set) > 0));
  });
  const bool any_on_nodes =
      std::any_of(scene.loads.begin(), scene.loads.end(), [&](const Load& load) {
        return load.kind == Load::Kind::traction && file.nodesets.count(load.surface) > 0 &&
               !has_faces(load.surface);
      });
  if (!all_kept || any_on_nodes) check_kept_sets(scene, component, read_mesh(component));
}

}  // namespace cbr
