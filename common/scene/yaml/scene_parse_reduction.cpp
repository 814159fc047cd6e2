// SPDX-License-Identifier: GPL-3.0-or-later
// A component's reduction: its keys by the table of reduction_keys.hpp, and their dependences on
// each other.

#include "common/base/error.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// The given keys, in the table's order: the basis first.
std::vector<std::string> read_reduction_keys(const SceneMap& map, const SceneReading& reading,
                                             ReductionOptions& reduction) {
  std::vector<std::string> given;
  const std::vector<SceneKey> keys = scene_keys(reduction);
  for (const ReductionKey& key : reduction_keys(reduction)) {
    const std::string& name = key.scene.key;
    const SceneNode* outer = map.find(name.substr(0, name.find('.')));
    if (outer == nullptr) continue;
    if (!key.goes_with(reduction.basis))
      outer->fail("requires basis: " + word_of(basis_words, *key.only_with));
    const std::optional<SceneNode> node = find_key(map, keys, key.scene);
    if (!node) continue;
    if (!key.retired.empty() && node->is_scalar() && node->text() == key.retired)
      node->fail("'" + key.retired + "' is retired: " + key.successor);
    read_value(key.scene, *node, reading);
    const auto* names = std::get_if<NameList>(&key.scene.value);
    if (names != nullptr && key.retired == "none" && names->names.empty())
      node->fail("is empty, expected sidesets of the interface");
    given.push_back(name);
  }
  return given;
}

// Keys that need or exclude each other.
void check_reduction(const SceneMap& map, const ReductionOptions& reduction) {
  const bool has_default = reduction.is_characteristic() && !reduction.modes &&
                           !reduction.cutoff_hz && !reduction.tolerance;
  if (!has_default) map.exactly_one({"modes", "cutoff_hz", "tolerance"});
  if (const auto* pick = map.find("pick"); pick != nullptr && reduction.tolerance)
    pick->fail("requires modes: with a tolerance the modes are chosen by participation");
  if (const auto* second = map.find("second_reduction")) {
    if (!reduction.is_decomposed())
      second->fail("needs 'domains' above 1: it reduces the domains once more, put together");
    if (reduction.tolerance)
      second->fail(
          "is not available with tolerance, which cannot bound its error: use modes or cutoff_hz "
          "instead");
    second->map({"modes", "cutoff_hz"}).exactly_one({"modes", "cutoff_hz"});
  }
  if (!reduction.recovery_sets.empty() && reduction.is_decomposed())
    map.at("recovery").fail("of some sets requires domains: 1; or give true");
  if (const auto* loads = map.find("loads"); loads != nullptr && reduction.is_decomposed())
    loads->fail("requires domains: 1; or add the sets to the interface");
}

// Points as nodes of the superelement.
void check_interface_points(const SceneNode& node, const Component& component) {
  const ReductionOptions& reduction = *component.reduction;
  if (reduction.interface_points.empty())
    node.fail("is empty, expected points of the component, or leave the key out");
  for (const std::string& name : reduction.interface_points) {
    const auto found = component.points.find(name);
    if (found == component.points.end())
      require_known(node, "point", name, keys_of(component.points));
    if (!found->second.rigid)
      node.fail("names '" + name + "' (line " + std::to_string(found->second.source.line) +
                "), whose coupling is average: a node of the superelement moves its set as a rigid "
                "body: give the point coupling: rigid, or keep its set by 'interface'");
  }
  const auto refuse = [&](const std::string& what) {
    node.fail("is not available with " + what +
              ": leave it out there, or keep the points' sets by 'interface'");
  };
  if (reduction.basis != Basis::craig_bampton)
    refuse("basis: " + word_of(basis_words, reduction.basis));
  if (reduction.is_decomposed()) refuse("domains above 1");
  if (!reduction.loads.empty()) refuse("loads");
}

// Dofs that the superelement does not have.
void check_fixed(const SceneNode& node, const Component& component) {
  const ReductionOptions& reduction = *component.reduction;
  const auto refuse = [&](const std::string& what) {
    node.fail("is not available with " + what +
              ": leave it out there, or keep the nodes by 'interface' and fix them under "
              "'boundary'");
  };
  if (reduction.is_decomposed()) refuse("domains above 1");
  if (!reduction.interface_points.empty()) refuse("points");
  for (const auto& [name, block] : component.blocks)
    if (block.thickness) refuse("shells (blocks." + name + ".thickness)");
}

}  // namespace

void read_fixed(const SceneNode& node, const SceneReading& reading, std::vector<FixedSet>& fixed) {
  node.for_each_item([&](const SceneNode& item) {
    FixedSet set;
    set.source = item.source();
    const SceneMap map = read_keys(item, scene_keys(set), reading);
    for (const FixedSet& other : fixed)
      if (other.nodes == set.nodes)
        map.at("nodes").fail("'" + set.nodes + "' is fixed on line " +
                             std::to_string(other.source.line) +
                             " already: give one entry with all of its axes");
    fixed.push_back(std::move(set));
  });
  if (fixed.empty()) node.fail("is empty, expected entries {nodes: SET, fix: [x]}");
}

std::string fixed_text(const std::vector<FixedSet>& fixed) {
  std::vector<std::string> items;
  for (FixedSet set : fixed) items.push_back(flow_map(scene_keys(set)));
  return items.empty() ? "" : yaml_list(items);
}

void read_reduction(const SceneNode& node, const SceneReading& reading, Component& component) {
  ReductionOptions& reduction = component.reduction.emplace();
  reduction.source = node.source();
  reduction.superelement = reading.folder / (component.name + ".cbr.h5");
  const SceneMap map = node.map_of(scene_keys(reduction));
  if (map.find("points") == nullptr) map.at("interface");
  const std::vector<std::string> given = read_reduction_keys(map, reading, reduction);
  check_reduction(map, reduction);
  complete(reduction, given);
  check_massless(reduction, node.source().text() + ": " + node.path());
  check_characteristic(reduction, node.source().text() + ": " + node.path());
  if (const auto* points = map.find("points")) check_interface_points(*points, component);
  if (const auto* fixed = map.find("fixed")) check_fixed(*fixed, component);
}

void check_massless(const ReductionOptions& reduction, const std::string& where) {
  if (!reduction.is_massless()) return;
  const auto refuse = [&](const std::string& what, const std::string& cure) {
    throw InputError(where + ": " + what + " is not available with basis: massless: " + cure +
                     ", or use basis: craig-bampton");
  };
  if (reduction.is_decomposed()) refuse("domains above 1", "reduce the component whole");
  if (reduction.recovery) refuse("recovery", "leave it out");
  if (reduction.tolerance) refuse("tolerance", "take modes or cutoff_hz");
  if (!reduction.loads.empty())
    refuse("loads inside the part", "take their sets into the interface");
  if (reduction.pick == Pick::participation) refuse("pick: participation", "pick: frequency");
}

void check_characteristic(const ReductionOptions& reduction, const std::string& where) {
  if (!reduction.is_characteristic()) return;
  const auto refuse = [&](const std::string& what, const std::string& cure) {
    throw InputError(where + ": " + what + " is not available with basis: characteristic: " + cure +
                     ", or use basis: craig-bampton");
  };
  if (reduction.is_decomposed()) refuse("domains above 1", "reduce the component whole");
  if (!reduction.loads.empty()) refuse("loads", "take the sets into the interface");
  if (reduction.tolerance)
    refuse("tolerance, which knows nothing of what the interface's shapes leave out,",
           "take modes or cutoff_hz");
}

}  // namespace cbr
