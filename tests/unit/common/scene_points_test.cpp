// SPDX-License-Identifier: GPL-3.0-or-later
// Points of components and of the interface, links, and superelements without a mesh.
#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"
#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_points_test {
namespace {

using test::full_scene;
using test::read_text;
using test::refusal;
using test::replaced;
using test::TemporaryFolder;
using test::written;

TEST(Scene, PointsOfTheInterfaceArrive) {
  const TemporaryFolder folder, elsewhere;
  const std::string text =
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\n"
      "components: {p: {mesh: p.msh, material: m, points: {tip: {surface: x_max, coupling: rigid}, "
      "base: {surface: x_min}}, reduction: {points: tip, modes: 3}}}\n"
      "instances: {a: {component: p}}\n";
  const Scene scene = read_text(folder, text);
  const ReductionOptions& reduction = *scene.components.at("p").reduction;
  EXPECT_EQ(reduction.interface_points, std::vector<std::string>{"tip"});
  EXPECT_TRUE(reduction.interface_sets.empty());
  EXPECT_EQ(written(read_text(elsewhere, written(scene))), written(scene));
  const auto refused = [&](const std::string& old, const std::string& by, const std::string& says) {
    EXPECT_SAYS(refusal(folder, replaced(text, old, by)), says);
  };
  refused("points: tip,", "", "missing key 'interface'");
  refused("points: tip", "points: tap", "unknown point 'tap', did you mean 'tip'?");
  refused("points: tip", "points: base", "whose coupling is average");
  refused("points: tip", "points: tip, domains: 2", "not available with domains above 1");
  refused("points: tip", "points: tip, loads: x_max", "not available with loads");
  refused("points: tip", "points: tip, basis: massless", "not available with basis: massless");
}

TEST(Scene, staticsPointsAndLinksArrive) {
  const TemporaryFolder folder, elsewhere;
  const std::string text =
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\n"
      "components: {p: {mesh: p.msh, material: m, points: {tip: {surface: x_max, at: [1, 2, 3]}, "
      "base: {surface: x_min, "
      "coupling: rigid, mass: 2.5, inertia: [4, 5, 6, 1, 0, 0.5]}}}}\n"
      "instances: {a: {component: p}, b: {component: p}}\n"
      "loads:\n  - {instance: a, point: tip, moment: [1, 0, 0]}\n  - {instance: a, point: base, "
      "force: [2, 0, 0]}\n"
      "contact:\n  - {between: [a.u, b.u], pretension: {force: 7}}\n  - {between: [a.v, b.v], "
      "pretension: {shortening: 0.5}}\n"
      "  - {between: [a.w, b.w], overlap: resolve}\n"
      "links:\n  - {between: [a.tip, b.base], fix: [x, rz], axes: [[0, 1, 0], [0, 0, 1]]}\n  - "
      "{between: [a.tip, ground]}\n"
      "  - {between: [a.base, ground], stiffness: [7, 0, 0, 0, 0, 8], damping: [[0, 0, 0, 0, 0, "
      "0], [0, 3, 0, 0, 1, 0], [0, 0, 0, "
      "0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 4, 0], [0, 0, 0, 0, 0, 0]], force: {x: [[-1, "
      "-2], [0.5, "
      "3]], rz: [[0, 0], [1, 6]]}, friction: {rx: 9}}\n"
      "  - {between: [b.base, ground], velocity: [1, 0, 0], angular_velocity: [0, 2, 0], history: "
      "{time: [0, 1], value: [0, 1]}}\n"
      "walls:\n  w: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}, velocity: [1, 2, 3], history: "
      "{time: [0, 5], value: [1, 0]}}\n"
      "time: {end: 1, static: true, preload: 3}\n";
  const Scene scene = read_text(folder, text);
  EXPECT_EQ(scene.components.at("p").points.at("tip").at, Vector3(1, 2, 3));
  EXPECT_TRUE(scene.loads[0].on_point && scene.loads[0].kind == Load::Kind::moment);
  EXPECT_TRUE(scene.contact[0].tied && scene.contact[0].pretension_force == 7.0 &&
              scene.contact[1].shortening == 0.5);
  EXPECT_TRUE(scene.contact[2].resolves_overlap);
  EXPECT_EQ(scene.links[0].fix, (std::array<bool, 6>{true, false, false, false, false, true}));
  EXPECT_EQ(scene.links[0].axes.row(2).transpose(), Vector3(1, 0, 0));
  EXPECT_TRUE(scene.links[1].second.is_wall() && scene.time->is_static);
  const Component::Point& base = scene.components.at("p").points.at("base");
  EXPECT_TRUE(base.rigid && base.mass == 2.5 && base.inertia(0, 1) == 1 &&
              base.inertia(1, 2) == 0 && base.inertia(2, 0) == 0.5);
  EXPECT_EQ(scene.links[2].fix, (std::array<bool, 6>{}));
  EXPECT_TRUE(scene.links[2].stiffness(5, 5) == 8 && scene.links[2].damping(4, 1) == 1);
  EXPECT_EQ(scene.links[2].force[0].force, (std::vector<double>{-2, 3}));
  EXPECT_EQ(scene.links[2].force[5].at, (std::vector<double>{0, 1}));
  EXPECT_EQ(scene.links[2].friction[3], 9);
  EXPECT_TRUE(scene.links[3].motion == SupportMotion::velocity &&
              scene.links[3].turn == Vector3(0, 2, 0) && scene.links[3].value[0] == 1);
  EXPECT_TRUE(scene.walls[0].motion == SupportMotion::velocity &&
              scene.walls[0].value == Vector3(1, 2, 3));
  EXPECT_EQ(scene.walls[0].history.value, (std::vector<double>{1, 0}));
  EXPECT_EQ(preload_steps(scene), 3);
  EXPECT_EQ(written(read_text(elsewhere, written(scene))), written(scene));
  const auto refused = [&](const std::string& old, const std::string& by, const std::string& says) {
    EXPECT_SAYS(refusal(folder, replaced(text, old, by)), says);
  };
  refused("static: true", "static: true, integrator: exact", "static: true computes equilibrium");
  const Scene on_set =
      read_text(folder, replaced(text, "point: tip, moment", "surface: u, moment"));
  EXPECT_TRUE(!on_set.loads[0].on_point && on_set.loads[0].kind == Load::Kind::moment);
  EXPECT_EQ(written(read_text(elsewhere, written(on_set))), written(on_set));
  refused("[a.tip, ground]", "[a.top, ground]", "which is no point");
  refused("at: [1, 2, 3]", "coupling: stiff", "average, rigid");
  refused("force: 7}", "force: 7}, friction: 0.1", "tied surfaces do not slide");
  refused("force: 7}", "force: -7}", "found '-7', expected a number from 0");
}

TEST(Scene, aSuperelementAloneArrives) {
  const TemporaryFolder folder;
  const Scene scene = read_text(folder, test::alone_scene);
  const Component& part = scene.components.at("part");
  EXPECT_FALSE(part.has_mesh);
  EXPECT_TRUE(scene.materials.empty());
  EXPECT_EQ(part.reduction->superelement, std::filesystem::absolute(folder / "parts/given.cbr.h5"));
  EXPECT_EQ(scene.instances[0].as, InstanceKind::superelement);
  const std::string text = written(scene);
  EXPECT_EQ(text.find("mesh:"), std::string::npos) << text;
  const Scene again = read_text(folder, text);
  EXPECT_EQ(written(again), text);
  EXPECT_FALSE(again.components.at("part").has_mesh);
  // Two components may use one file, and stand beside others
  EXPECT_EQ(refusal(folder, replaced(test::alone_scene, "instances:",
                                     "  twin: {superelement: parts/given.cbr.h5}\ninstances:")),
            "no error");
  const std::string beside =
      replaced(full_scene, "  bare:", "  part: {superelement: given.cbr.h5}\n  bare:");
  EXPECT_EQ(written(read_text(folder, written(read_text(folder, beside)))),
            written(read_text(folder, beside)));
}

TEST(Scene, nothingStandsBesideASuperelementAlone) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& old, const std::string& text) {
    return refusal(folder, replaced(test::alone_scene, old, text));
  };
  for (const std::string key :
       {"mesh: a.msh", "material: steel", "reduction: {interface: a, modes: 1}", "element: hex8",
        "mass: lumped", "blocks: {a: {material: steel}}"}) {
    const std::string message = with("{superelement:", "{" + key + ", superelement:");
    EXPECT_TRUE(message.starts_with("impact.yaml:2: components.part." +
                                    key.substr(0, key.find(':')) +
                                    ": not allowed beside 'superelement'"))
        << message;
    EXPECT_SAYS(message, "remove one of the two");
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  const std::string as_mesh = with("component: part,", "component: part, as: mesh,");
  EXPECT_TRUE(as_mesh.starts_with(
      "impact.yaml:4: instances.left.as: component 'part' is a superelement file without a mesh"))
      << as_mesh;
  EXPECT_SAYS(as_mesh, "use as: superelement");
  EXPECT_SAYS(
      refusal(folder,
              replaced(full_scene, "  bare:", "  part: {superelement: ../out/block.h5}\n  bare:")),
      "is also that of component 'block': give each a file of its own");
  const std::string no_materials =
      with("instances:", "  bare: {mesh: a.msh, material: steel}\ninstances:");
  EXPECT_SAYS(no_materials, "missing key 'materials'");
}

}  // namespace
}  // namespace cbr::scene_points_test
