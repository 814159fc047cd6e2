// SPDX-License-Identifier: GPL-3.0-or-later
// Components, instances and materials.

#include <algorithm>

#include "common/scene/points_of_file.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// {ratio: 0.02}, or {frequency_hz: [...], ratio: [...]}.
void read_damping(const SceneNode& node, const SceneReading&, ModalDamping& damping) {
  const SceneMap map = node.map({"ratio", "frequency_hz"});
  const SceneNode& ratio = map.at("ratio");
  const SceneNode* frequencies = map.find("frequency_hz");
  if (ratio.is_scalar() && frequencies == nullptr) {
    damping.frequency_hz = {0};
    damping.ratio = {ratio.number(not_negative)};
    return;
  }
  for (const SceneNode& item : ratio.list()) damping.ratio.push_back(item.number(not_negative));
  for (const SceneNode& item : map.at("frequency_hz").list()) {
    const double hz = item.number(not_negative);
    if (!damping.frequency_hz.empty() && hz <= damping.frequency_hz.back())
      item.fail("not above the frequency before it, frequencies must ascend");
    damping.frequency_hz.push_back(hz);
  }
  if (damping.ratio.empty()) ratio.fail("is empty, expected at least one ratio");
  if (damping.ratio.size() != damping.frequency_hz.size())
    ratio.fail("has " + std::to_string(damping.ratio.size()) +
               " entries, expected as many as 'frequency_hz' has: " +
               std::to_string(damping.frequency_hz.size()));
}

void read_material_name(const SceneNode& node, const SceneReading& reading, std::string& name) {
  name = node.text();
  if (!reading.scene.materials.contains(name))
    require_known(node, "material", name, keys_of(reading.scene.materials));
}

Own material_name(std::string& member) {
  return {member, read_material_name,
          [](const std::string& name) { return name.empty() ? "" : yaml_word(name); }};
}

// A map of maps, on lines of their own.
template <typename Value>
std::string lines_of(std::map<std::string, Value> maps) {
  std::string text;
  for (auto& [name, value] : maps)
    text += "\n      " + yaml_word(name) + ": " + flow_map(scene_keys(value));
  return text;
}

std::string damping_text(const ModalDamping& damping) {
  if (damping.empty()) return "";
  return "{frequency_hz: " + yaml_numbers(damping.frequency_hz) +
         ", ratio: " + yaml_numbers(damping.ratio) + "}";
}

// The file alone: it holds all that a run needs, and nothing here could change it.
void parse_superelement_alone(const SceneMap& map, const SceneReading& reading,
                              Component& component) {
  for (const auto& [key, value] : map.entries()) {
    if (key == "superelement") continue;
    value.fail(
        "not allowed beside 'superelement', a file that is used as it is: remove one of the two; "
        "the file that cbr-reduce writes is reduction.superelement");
  }
  component.has_mesh = false;
  component.reduction.emplace();
  component.reduction->source = component.source;
  component.reduction->superelement = resolve_path(map.at("superelement"), reading.folder);
  add_points_of_file(component);
}

void read_blocks(const SceneNode& node, const SceneReading& reading, Component& component) {
  const SceneMap entries = node.map_of_any();
  for (const auto& [name, options] : entries.entries()) {
    Component::BlockOptions& block = component.blocks[name];
    block.source = options.source();
    read_keys(options, scene_keys(block), reading);
    if (component.material.empty() && block.material.empty() && !may_hold_materials(component.mesh))
      options.fail("missing key 'material', and the component names no material for all blocks");
  }
}

Component parse_component(const SceneNode& node, const std::string& name,
                          const SceneReading& reading) {
  Component component;
  component.name = name;
  component.source = node.source();
  const std::vector<SceneKey> keys = scene_keys(component);
  const SceneMap map = node.map_of(keys);
  require_plain_name(node, "a component", name);
  if (map.find("superelement") != nullptr) {
    parse_superelement_alone(map, reading, component);
    return component;
  }
  if (const SceneNode* mesh = map.find("mesh"); mesh != nullptr && mesh->is_scalar()) {
    component.mesh = resolve_path(*mesh, reading.folder);
    add_points_of_deck(component);
  }
  read_keys(node, keys, reading);
  if (component.blocks.empty() && component.material.empty() && !may_hold_materials(component.mesh))
    node.fail("missing key 'material': for all blocks, or for each under 'blocks'");
  return component;
}

std::string reduction_text(const Component& component) {
  std::string text;
  ReductionOptions of = component.reduction.value_or(ReductionOptions());
  if (component.reduction)
    for (const auto& [key, value] : written(scene_keys(of)))
      text += "\n      " + key + ": " + value;
  return text;
}

std::string superelement_text(const Component& component) {
  return yaml_path(component.reduction ? component.reduction->superelement
                                       : std::filesystem::path());
}

void read_component_name(const SceneNode& node, const SceneReading& reading, Instance& instance) {
  instance.component = node.text();
  const auto& components = reading.scene.components;
  const auto found = components.find(instance.component);
  if (found == components.end())
    require_known(node, "component", instance.component, keys_of(components));
  instance.as = found->second.reduction ? InstanceKind::superelement : InstanceKind::mesh;
}

// Limits that follow from its component.
void read_kind(const SceneNode& node, const SceneReading& reading, Instance& instance) {
  const Component& component = reading.scene.components.at(instance.component);
  instance.as = instance_words[node.choice(texts_of(instance_words))].second;
  if (instance.as == InstanceKind::superelement && !component.reduction)
    node.fail("component '" + instance.component +
              "' has no 'reduction': add one, or use the instance 'as: mesh'");
  if (instance.as != InstanceKind::superelement && !component.has_mesh)
    node.fail("component '" + instance.component +
              "' is a superelement file without a mesh: use as: superelement, or give the "
              "component 'mesh' and 'material'");
}

}  // namespace

std::vector<SceneKey> scene_keys(Component::BlockOptions& block) {
  return {{"material", material_name(block.material)},
          {"element", OneWord{block.element, hex_words}},
          {"thickness", Number{block.thickness, positive}}};
}

std::vector<SceneKey> scene_keys(Component& c) {
  const auto blocks = [](const Component& of) { return lines_of(of.blocks); };
  const auto points = [](const Component& of) { return lines_of(of.points); };
  return {{"mesh", File{c.mesh}, c.has_mesh, true},
          {"material", material_name(c.material)},
          {"blocks", Own{c, read_blocks, blocks}},
          {"element", OneWord{c.element, hex_words}, c.has_mesh},
          {"mass", OneWord{c.mass, mass_words}, c.has_mesh},
          {"points", Own{c, read_points, points}, c.has_mesh},
          {"reduction", Own{c, read_reduction, reduction_text}, c.has_mesh},
          {"superelement", Own{c, superelement_text}, !c.has_mesh}};
}

std::vector<SceneKey> scene_keys(Instance& i) {
  const auto component = [](const Instance& of) { return yaml_word(of.component); };
  const auto kind = [](const Instance& of) { return word_of(instance_words, of.as); };
  return {{"component", Own{i, read_component_name, component}, true, true},
          {"as", Own{i, read_kind, kind}},
          {"position", ThreeNumbers{i.position}},
          {"place.on", Text{i.place.on}, !i.place.on.empty(), true},
          {"place.gap", Number{i.place.gap, not_negative}, !i.place.on.empty()},
          {"rotation", ThreeNumbers{i.rotation_degrees}},
          {"mirror", OneWord{i.mirror, mirror_words}, !i.mirror.empty()},
          {"velocity", ThreeNumbers{i.velocity}},
          {"damping", Own{i.damping, read_damping, damping_text}},
          {"angular_velocity", ThreeNumbers{i.angular_velocity}, !i.angular_velocity.isZero(0)}};
}

namespace {

Instance parse_instance(const SceneNode& node, const std::string& name,
                        const SceneReading& reading) {
  Instance instance;
  instance.name = name;
  instance.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(instance), reading);
  require_plain_name(node, "an instance", name);
  if (const auto* damping = map.find("damping")) {
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

void parse_components(const SceneNode& node, SceneReading& reading) {
  Scene& scene = reading.scene;
  const SceneMap map = node.map_of_any();
  std::map<std::filesystem::path, std::string> owner;
  const auto refuse = [](const SceneNode& place, const Component& component,
                         const std::string& other) {
    place.fail("superelement file '" + component.reduction->superelement.string() +
               "' is also that of component '" + other + "': give each a file of its own");
  };
  for (const auto& [name, value] : map.entries()) {
    const Component& component = scene.components[name] = parse_component(value, name, reading);
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

bool needs_no_materials(const SceneNode& node, const std::filesystem::path& folder) {
  if (!node.is_map()) return false;
  const SceneMap map = node.map_of_any();
  return std::all_of(map.entries().begin(), map.entries().end(), [&](const auto& entry) {
    if (!entry.second.is_map()) return false;
    const SceneMap component = entry.second.map_of_any();
    if (component.find("superelement") != nullptr) return true;
    const SceneNode* mesh = component.find("mesh");
    const bool is_file = mesh != nullptr && mesh->is_scalar();
    return is_file && may_hold_materials(resolve_path(*mesh, folder)) &&
           component.find("material") == nullptr;
  });
}

void parse_instances(const SceneNode& node, SceneReading& reading) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    reading.scene.instances.push_back(parse_instance(value, name, reading));
    reading.instances.insert(name);
  }
}

namespace {

void read_material_axes(const SceneNode& node, const SceneReading&, Matrix3& axes) {
  const std::vector<SceneNode> rows = node.list();
  if (rows.size() != 2)
    node.fail(
        "expected two lists of three numbers: the material's axes 1 and 2, in those of the mesh");
  const std::optional<Matrix3> found = material_axes(rows[0].vector3(), rows[1].vector3());
  if (!found) node.fail("are zero or parallel, expected two directions");
  axes = *found;
}

// E_1 E_2 E_3 and G_12 G_23 G_13
void read_moduli(const SceneNode& node, const SceneReading&, Vector3& moduli) {
  moduli = node.vector3();
  if (!(moduli.minCoeff() > 0))
    node.fail("found a number that is not positive, expected three positive ones");
}

void check_orthotropy(const SceneMap& map, const Orthotropy& of) {
  if (!is_definite(of))
    map.at("poissons_ratio")
        .fail(
            "with these moduli strains exist that would give energy: expected nu_12^2 below E_1 / "
            "E_2, nu_23^2 below E_2 / E_3, nu_13^2 below E_1 / E_3, and all three small enough "
            "together");
}

// By the keys that are given, which then are read otherwise.
void begin_material(const SceneMap& map, Material& material) {
  if (map.find("shear_modulus") != nullptr) {
    material.orthotropy.emplace();
    return;
  }
  if (const auto* axes = map.find("axes"))
    axes->fail(
        "needs shear_modulus, and three numbers under each modulus and ratio: an isotropic "
        "material has no axes");
  if (const auto* modulus = map.find("youngs_modulus"); modulus != nullptr && modulus->is_list())
    modulus->fail(
        "found a list, expected a number; three numbers need shear_modulus beside them "
        "(orthotropic)");
}

std::vector<SceneKey> elastic_keys(Material& m) {
  if (!m.orthotropy)
    return {{"youngs_modulus", Number{m.youngs_modulus, positive}, true, true},
            {"poissons_ratio", Number{m.poissons_ratio, {.low = -1, .high = 0.5}}, true, true},
            {"shear_modulus", Retired{}},
            {"axes", Retired{}}};
  Orthotropy& of = *m.orthotropy;
  return {{"youngs_modulus", Own{of.youngs_moduli, read_moduli, yaml_vector}, true, true},
          {"poissons_ratio", ThreeNumbers{of.poissons_ratios}, true, true},
          {"shear_modulus", Own{of.shear_moduli, read_moduli, yaml_vector}, true, true},
          {"axes", Own{of.axes, read_material_axes, yaml_rows}}};
}

}  // namespace

std::vector<SceneKey> scene_keys(Material& m, MaterialDamping& damping) {
  std::vector<SceneKey> keys = elastic_keys(m);
  const bool is_damped = damping != MaterialDamping();
  keys.push_back({"density", Number{m.density, positive}, true, true});
  keys.push_back({"damping.alpha", Number{damping.alpha, not_negative}, is_damped});
  keys.push_back({"damping.beta", Number{damping.beta, not_negative}, is_damped});
  keys.push_back({"damping.loss_factor", Number{damping.loss_factor, not_negative}, is_damped});
  return keys;
}

void parse_materials(const SceneNode& node, SceneReading& reading) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    Material& material = reading.scene.materials[name];
    MaterialDamping damping;
    begin_material(value.map_of(scene_keys(material, damping)), material);
    const SceneMap keys = read_keys(value, scene_keys(material, damping), reading);
    if (material.orthotropy) {
      check_orthotropy(keys, *material.orthotropy);
      material.youngs_modulus = material.orthotropy->youngs_moduli.mean();
    }
    if (damping != MaterialDamping()) reading.scene.damping[name] = damping;
  }
}

}  // namespace cbr
