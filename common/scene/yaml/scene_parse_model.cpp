// SPDX-License-Identifier: GPL-3.0-or-later
// Components and instances: what there is.
#include <algorithm>

#include "common/scene/points_of_file.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// {ratio: 0.02}, or {frequency_hz: [...], ratio: [...]}.
ModalDamping parse_modal_damping(const SceneNode& node) {
  const SceneMap map = node.map({"ratio", "frequency_hz"});
  ModalDamping damping;
  const SceneNode& ratio = map.at("ratio");
  const SceneNode* frequencies = map.find("frequency_hz");
  if (ratio.is_scalar() && frequencies == nullptr) {
    damping.frequency_hz = {0};
    damping.ratio = {ratio.not_negative()};
    return damping;
  }
  for (const SceneNode& item : ratio.list()) damping.ratio.push_back(item.not_negative());
  for (const SceneNode& item : map.at("frequency_hz").list()) {
    const double hz = item.not_negative();
    if (!damping.frequency_hz.empty() && hz <= damping.frequency_hz.back())
      item.fail("not above the frequency before it, frequencies must ascend");
    damping.frequency_hz.push_back(hz);
  }
  if (damping.ratio.empty()) ratio.fail("is empty, expected at least one ratio");
  if (damping.ratio.size() != damping.frequency_hz.size())
    ratio.fail("has " + std::to_string(damping.ratio.size()) +
               " entries, expected as many as 'frequency_hz' has: " +
               std::to_string(damping.frequency_hz.size()));
  return damping;
}

std::string parse_material_name(const SceneNode& node, const Scene& scene) {
  const std::string name = node.text();
  if (!scene.materials.contains(name))
    require_known(node, "material", name, keys_of(scene.materials));
  return name;
}

Component::BlockOptions parse_block(const SceneNode& node, const Scene& scene) {
  const SceneMap map = node.map({"material", "element", "thickness"});
  Component::BlockOptions block;
  block.source = node.source();
  if (const auto* material = map.find("material"))
    block.material = parse_material_name(*material, scene);
  if (const auto* element = map.find("element")) block.element = element->one_of(hex8_words);
  if (const auto* thickness = map.find("thickness")) block.thickness = thickness->positive();
  return block;
}

// The file alone: it holds all that a run needs, and nothing here could change it.
void parse_superelement_alone(const SceneMap& map, const std::filesystem::path& folder,
                              Component& component) {
  for (const auto& [key, value] : map.entries()) {
    if (key == "superelement") continue;
    value.fail(
        "not allowed beside 'superelement', a file that is used as it is: remove one of the two; "
        "the file that cbr-reduce "
        "writes is reduction.superelement");
  }
  component.has_mesh = false;
  component.reduction.emplace();
  component.reduction->source = component.source;
  component.reduction->superelement = resolve_path(map.at("superelement"), folder);
  add_points_of_file(component);
}

Component parse_component(const SceneNode& node, const std::string& name,
                          const std::filesystem::path& folder, const Scene& scene) {
  const SceneMap map = node.map(
      {"mesh", "material", "blocks", "element", "mass", "reduction", "superelement", "points"});
  require_plain_name(node, "a component", name);
  Component component;
  component.name = name;
  component.source = node.source();
  if (map.find("superelement") != nullptr) {
    parse_superelement_alone(map, folder, component);
    return component;
  }
  component.mesh = resolve_path(map.at("mesh"), folder);
  if (const auto* material = map.find("material"))
    component.material = parse_material_name(*material, scene);
  if (const auto* blocks = map.find("blocks")) {
    const SceneMap entries = blocks->map_of_any();
    for (const auto& [block, options] : entries.entries()) {
      component.blocks[block] = parse_block(options, scene);
      if (component.material.empty() && component.blocks[block].material.empty() &&
          !may_hold_materials(component.mesh)) {
        options.fail("missing key 'material', and the component names no material for all blocks");
      }
    }
  } else if (component.material.empty() && !may_hold_materials(component.mesh)) {
    node.fail("missing key 'material': for all blocks, or for each under 'blocks'");
  }
  if (const auto* element = map.find("element")) component.element = element->one_of(hex8_words);
  if (const auto* mass = map.find("mass")) {
    component.mass = mass->one_of(mass_words);
  }
  if (const auto* points = map.find("points")) parse_points(*points, component);
  if (const auto* reduction = map.find("reduction")) parse_reduction(*reduction, folder, component);
  return component;
}

Instance parse_instance(const SceneNode& node, const std::string& name, const Scene& scene) {
  const SceneMap map = node.map({"component", "as", "position", "rotation", "mirror", "velocity",
                                 "angular_velocity", "damping"});
  require_plain_name(node, "an instance", name);
  Instance instance;
  instance.name = name;
  instance.source = node.source();
  instance.component = map.at("component").text();
  const auto component = scene.components.find(instance.component);
  if (component == scene.components.end())
    require_known(map.at("component"), "component", instance.component, keys_of(scene.components));
  const bool is_reduced = component->second.reduction.has_value();
  instance.as = is_reduced ? InstanceKind::superelement : InstanceKind::mesh;
  if (const auto* as = map.find("as")) {
    instance.as = as->one_of(instance_words);
    if (instance.as == InstanceKind::superelement && !is_reduced) {
      as->fail("component '" + instance.component +
               "' has no 'reduction': add one, or use the instance 'as: mesh'");
    }
    if (instance.as != InstanceKind::superelement && !component->second.has_mesh) {
      as->fail("component '" + instance.component +
               "' is a superelement file without a mesh: use as: superelement, or give the "
               "component 'mesh' and 'material'");
    }
  }
  if (const auto* position = map.find("position")) instance.position = position->vector3();
  if (const auto* rotation = map.find("rotation")) instance.rotation_degrees = rotation->vector3();
  if (const auto* mirror = map.find("mirror"))
    instance.mirror = mirror->one_of<std::string>({{"x", "x"}, {"y", "y"}, {"z", "z"}});
  if (const auto* velocity = map.find("velocity")) instance.velocity = velocity->vector3();
  if (const auto* spin = map.find("angular_velocity")) instance.angular_velocity = spin->vector3();
  if (const auto* damping = map.find("damping")) {
    instance.damping = parse_modal_damping(*damping);
    if (instance.as == InstanceKind::rigid)
      damping->fail("goes with as: superelement: a rigid body has no elastic modes");
    if (instance.as == InstanceKind::mesh)
      damping->fail(
          "goes with as: superelement: a mesh has no modes: give its material damping: {alpha: "
          "..., beta: ...}, or beta alone if it turns (time.rotations: large)");
  }
  return instance;
}

}  // namespace

void require_plain_name(const SceneNode& node, const std::string& kind, const std::string& name) {
  if (name.find_first_of("./") == std::string::npos) return;
  node.fail("the name of " + kind + " holds a dot or a slash: '" + name + "'");
}

std::filesystem::path resolve_path(const SceneNode& node, const std::filesystem::path& folder) {
  const std::string text = node.text();
  if (text.find('\0') != std::string::npos) node.fail("a file name holds a null character");
  return (folder / text).lexically_normal();
}

// One name for one file, whatever links lead to it.
std::filesystem::path one_name(const std::filesystem::path& file) {
  std::error_code error;
  auto name = std::filesystem::weakly_canonical(file, error);
  return error ? file : name;
}

void parse_components(const SceneNode& node, const std::filesystem::path& folder, Scene& scene) {
  const SceneMap map = node.map_of_any();
  std::map<std::filesystem::path, std::string> owner;
  const auto refuse = [](const SceneNode& place, const Component& component,
                         const std::string& other) {
    place.fail("superelement file '" + component.reduction->superelement.string() +
               "' is also that of component '" + other + "': give each a file of its own");
  };
  for (const auto& [name, value] : map.entries()) {
    const Component& component = scene.components[name] =
        parse_component(value, name, folder, scene);
    if (!component.reduction || !component.has_mesh) continue;
    const auto [other, is_new] = owner.emplace(one_name(component.reduction->superelement), name);
    if (!is_new) refuse(value, component, other->second);
  }
  // Any number of components may use one file as it is, but none that cbr-reduce would replace.
  for (const auto& [name, value] : map.entries()) {
    const Component& component = scene.components[name];
    if (component.has_mesh) continue;
    const auto other = owner.find(one_name(component.reduction->superelement));
    if (other != owner.end()) refuse(value, component, other->second);
  }
}

bool needs_no_materials(const SceneNode& node) {
  if (!node.is_map()) return false;
  const SceneMap map = node.map_of_any();
  return std::all_of(map.entries().begin(), map.entries().end(), [](const auto& entry) {
    if (!entry.second.is_map()) return false;
    const SceneMap component = entry.second.map_of_any();
    if (component.find("superelement") != nullptr) return true;
    const SceneNode* mesh = component.find("mesh");
    const bool is_file = mesh != nullptr && mesh->is_scalar();
    return is_file && may_hold_materials(mesh->text()) && component.find("material") == nullptr;
  });
}

void parse_instances(const SceneNode& node, Scene& scene, SceneNames& names) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    scene.instances.push_back(parse_instance(value, name, scene));
    names.instances.insert(name);
  }
}

}  // namespace cbr
