// SPDX-License-Identifier: GPL-3.0-or-later
// Materials: isotropic or orthotropic, and their damping.
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
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
