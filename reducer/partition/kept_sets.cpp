// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/kept_sets.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/scene/scene_uses.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
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
      refuse_traction_on_nodes(load);
  }
}

// What recovery data cover.
bool is_recovered(const SetUse& use, const ReductionOptions& reduction) {
  const std::vector<std::string>& sets = reduction.recovery_sets;
  return use.may_be_inside && reduction.recovery &&
         (sets.empty() || std::find(sets.begin(), sets.end(), use.set) != sets.end());
}

// ", or name the point 'left' that moves it"
std::string point_instead(const SetUse& use, const Component& component) {
  for (const auto& [name, point] : component.points)
    if (point.nodes == use.set && is_interface_point(component, name))
      return ", or name the point '" + name + "' that moves it";
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
    is_kept[static_cast<std::size_t>(model.nodes[static_cast<std::size_t>(i)])] = 1;
  for (const SetUse& use : uses) {
    if (!use.needs_faces && is_interface_point(component, use.set)) continue;
    const std::vector<Index> nodes = nodes_of(use, mesh);
    if (!nodes.empty() && is_recovered(use, *component.reduction)) continue;
    if (use.is_of_stress) refuse_without_recovery(use, component);
    const auto n_kept = std::count_if(nodes.begin(), nodes.end(), [&](Index node) {
      return is_kept[static_cast<std::size_t>(node)] != 0;
    });
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
