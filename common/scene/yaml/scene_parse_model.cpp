// SPDX-License-Identifier: GPL-3.0-or-later
// Materials, components, instances: what there is.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/scene/points_of_file.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

template <typename Value>
std::vector<std::string> keys_of(const std::map<std::string, Value>& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

Vector3 positive_vector(const SceneNode& node) {
  const Vector3 value = node.vector3();
  if (!(value.minCoeff() > 0))
    node.fail("found a number that is not positive, expected three positive ones");
  return value;
}

// E_1 E_2 E_3, nu_12 nu_23 nu_13, G_12 G_23 G_13, and two axes of the material, the second made
// normal to the first.
Orthotropy parse_orthotropy(const SceneMap& map) {
  Orthotropy of{.youngs_moduli = positive_vector(map.at("youngs_modulus")),
                .poissons_ratios = map.at("poissons_ratio").vector3(),
                .shear_moduli = positive_vector(map.at("shear_modulus"))};
  const Matrix3 normal = normal_stiffness(of);
  if (!(normal(0, 0) > 0 && normal.topLeftCorner<2, 2>().determinant() > 0 &&
        normal.determinant() > 0))
    map.at("poissons_ratio")
        .fail(
            "with these moduli strains exist that would give energy: expected nu_12^2 below E_1 / "
            "E_2, "
            "nu_23^2 below E_2 / E_3, nu_13^2 below E_1 / E_3, and all three small enough "
            "together");
  const SceneNode* axes = map.find("axes");
  if (axes == nullptr) return of;
  const std::vector<SceneNode> rows = axes->list();
  if (rows.size() != 2)
    axes->fail(
        "expected two lists of three numbers: the material's axes 1 and 2, in those of the mesh");
  // What is orthonormal to round-off stays as it is: a scene that is passed on means the same
  // material to the last bit.
  constexpr double round_off = 1e-14, parallel = 1e-6;
  const auto unit = [](const Vector3& v) {
    return std::abs(v.norm() - 1) < round_off ? v : Vector3(v / v.norm());
  };
  const Vector3 first = unit(rows[0].vector3()), given = unit(rows[1].vector3());
  const double along = first.dot(given);
  if (!(std::abs(along) < 1 - parallel))
    axes->fail("are zero or parallel, expected two directions");
  const Vector3 second = std::abs(along) < round_off ? given : unit(given - along * first);
  of.axes << first.transpose(), second.transpose(), first.cross(second).transpose();
  return of;
}

Material parse_material(const SceneNode& node) {
  const SceneMap map =
      node.map({"youngs_modulus", "poissons_ratio", "shear_modulus", "axes", "density", "damping"});
  if (map.find("shear_modulus") != nullptr) {
    const Orthotropy orthotropy = parse_orthotropy(map);
    return {.youngs_modulus = orthotropy.youngs_moduli.mean(),
            .density = map.at("density").positive(),
            .orthotropy = orthotropy};
  }
  if (const auto* axes = map.find("axes"))
    axes->fail(
        "needs shear_modulus, and three numbers under each modulus and ratio: an isotropic "
        "material has no axes");
  const SceneNode& modulus = map.at("youngs_modulus");
  if (modulus.is_list())
    modulus.fail(
        "found a list, expected a number; three numbers need shear_modulus beside them "
        "(orthotropic)");
  return {.youngs_modulus = modulus.positive(),
          .poissons_ratio = map.at("poissons_ratio").in_open_range(-1, 0.5),
          .density = map.at("density").positive()};
}

MaterialDamping parse_material_damping(const SceneNode& node) {
  const SceneMap map = node.map({"alpha", "beta", "loss_factor"});
  MaterialDamping damping;
  if (const auto* alpha = map.find("alpha")) damping.alpha = alpha->not_negative();
  if (const auto* beta = map.find("beta")) damping.beta = beta->not_negative();
  if (const auto* loss = map.find("loss_factor")) damping.loss_factor = loss->not_negative();
  return damping;
}

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

// Reads the value of one key of the table.
struct ReadValue {
  const SceneNode& node;
  ReductionOptions& reduction;

  template <typename Value>
  void operator()(const OneWord<Value>& v) const {
    v.field(reduction) = node.one_of(v.words);
  }
  void operator()(const WholeNumber& v) const { v.field(reduction) = node.index(v.least); }
  void operator()(const WholeNumberOrNone& v) const { v.field(reduction) = node.index(v.least); }
  void operator()(const NumberOrNone& v) const {
    v.field(reduction) =
        std::isfinite(v.below) ? node.in_open_range(v.above, v.below) : node.positive();
  }
  void operator()(const TrueOrFalse& v) const { v.field(reduction) = node.boolean(); }
  void operator()(const NameList& v) const {
    const bool is_none = v.none != nullptr && node.is_scalar() && node.text() == "none";
    if (v.none != nullptr) v.none(reduction) = is_none;
    if (!is_none) v.field(reduction) = node.names();
    if (v.none != nullptr && !is_none && v.field(reduction).empty())
      node.fail("is empty, expected sidesets of the interface, or none");
  }
  void operator()(const NamesOrTrue& v) const {
    if (node.is_scalar()) {
      v.field(reduction) = node.boolean();
      return;
    }
    v.names(reduction) = node.names();
    if (v.names(reduction).empty())
      node.fail("is empty, expected sets or element blocks of the mesh, or true");
    v.field(reduction) = true;
  }
};

// Keys with a dot are those of a map of their own.
std::vector<std::string> read_reduction_keys(const SceneMap& map, ReductionOptions& reduction) {
  std::vector<std::string> given;
  for (const ReductionKey& key : reduction_keys()) {
    const auto dot = key.key.find('.');
    const SceneNode* node = map.find(key.key.substr(0, dot));
    if (node == nullptr) continue;
    if (!key.goes_with(reduction.basis))
      node->fail("requires basis: " + word_of(basis_words, *key.only_with));
    if (dot == std::string::npos) {
      std::visit(ReadValue{*node, reduction}, key.value);
    } else {
      const SceneMap inside = node->map(keys_of_reduction(key.key.substr(0, dot)));
      const SceneNode* value = inside.find(key.key.substr(dot + 1));
      if (value == nullptr) continue;
      std::visit(ReadValue{*value, reduction}, key.value);
    }
    given.push_back(key.key);
  }
  return given;
}

// What the keys mean for each other.
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
    second->map(keys_of_reduction("second_reduction"))
        .exactly_one(keys_of_reduction("second_reduction"));
  }
  if (!reduction.recovery_sets.empty() && reduction.is_decomposed())
    map.at("recovery").fail("of some sets requires domains: 1; or give true");
  if (const auto* loads = map.find("loads"); loads != nullptr && reduction.is_decomposed())
    loads->fail("requires domains: 1; or add the sets to the interface");
}

ReductionOptions parse_reduction(const SceneNode& node, const std::filesystem::path& folder,
                                 const std::string& component) {
  std::vector<std::string> allowed = keys_of_reduction();
  allowed.push_back("superelement");
  const SceneMap map = node.map(allowed);
  ReductionOptions reduction;
  reduction.source = node.source();
  if (map.find("points") == nullptr) map.at("interface");
  const std::vector<std::string> given = read_reduction_keys(map, reduction);
  check_reduction(map, reduction);
  complete(reduction, given);
  check_massless(reduction, node.source().text() + ": " + node.path());
  check_characteristic(reduction, node.source().text() + ": " + node.path());
  const auto* file = map.find("superelement");
  reduction.superelement =
      file != nullptr ? resolve_path(*file, folder) : folder / (component + ".cbr.h5");
  return reduction;
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
  if (const auto* reduction = map.find("reduction")) {
    component.reduction = parse_reduction(*reduction, folder, name);
    const SceneMap keys = reduction->map_of_any();
    if (const auto* on_interface = keys.find("points"))
      check_interface_points(*on_interface, component);
  }
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
  if (reduction.massless_modes != MasslessModes::fixed && reduction.pick == Pick::participation)
    refuse("pick: participation of free modes", "take massless_modes: fixed, or pick: frequency");
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

std::filesystem::path resolve_path(const SceneNode& node, const std::filesystem::path& folder) {
  const std::string text = node.text();
  if (text.find('\0') != std::string::npos) node.fail("a file name holds a null character");
  return (folder / text).lexically_normal();
}

void parse_materials(const SceneNode& node, Scene& scene) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    scene.materials[name] = parse_material(value);
    const SceneMap keys = value.map_of_any();
    if (const auto* damping = keys.find("damping")) {
      const MaterialDamping of = parse_material_damping(*damping);
      if (of != MaterialDamping()) scene.damping[name] = of;
    }
  }
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
