// SPDX-License-Identifier: GPL-3.0-or-later
// Materials: isotropic or orthotropic, and their damping.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

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

}  // namespace

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

}  // namespace cbr
