// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>
#include <random>

#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_test {
namespace {

using test::full_scene;
using test::read_text;
using test::refusal;
using test::replaced;
using test::TemporaryFolder;
using test::written;

TEST(Scene, everyKeyArrives) {
  const TemporaryFolder folder;
  const Scene scene = read_text(folder, full_scene);
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials.at("steel").youngs_modulus, 5.17e12);
  EXPECT_EQ(scene.materials.at("soft stuff").poissons_ratio, -0.25);
  EXPECT_EQ(scene.materials.at("steel").density, 7836);
  const Component& block = scene.components.at("block");
  EXPECT_EQ(block.mesh, folder / "meshes/block.msh");
  EXPECT_EQ(block.material, "steel");
  EXPECT_EQ(block.blocks.at("core").material, "soft stuff");
  EXPECT_EQ(block.blocks.at("core").element, Hex8Formulation::full);
  EXPECT_EQ(block.blocks.at("true").material, "");
  EXPECT_EQ(block.element, Hex8Formulation::hourglass);
  EXPECT_EQ(block.mass, MassKind::consistent);
  ASSERT_TRUE(block.reduction);
  EXPECT_EQ(block.reduction->interface_sets, (std::vector<std::string>{"contact", "two words"}));
  EXPECT_EQ(block.reduction->modes, 80);
  EXPECT_FALSE(block.reduction->cutoff_hz);
  EXPECT_EQ(block.reduction->pick, Pick::participation);
  EXPECT_EQ(block.reduction->domains, 3);
  EXPECT_TRUE(block.reduction->recovery);
  EXPECT_EQ(block.reduction->superelement, (folder.path().parent_path() / "out/block.h5"));
  EXPECT_EQ(block.source.text(), (folder / "impact.yaml").string() + ":5");
  const Component& plate = scene.components.at("plate");
  EXPECT_EQ(plate.mesh, "/elsewhere/plate.e");
  EXPECT_EQ(plate.element, Hex8Formulation::incompatible);
  EXPECT_FALSE(plate.mass.has_value()) << "by use and element";
  EXPECT_EQ(plate.reduction->cutoff_hz, 2e6);
  EXPECT_EQ(plate.reduction->domains, 2);
  EXPECT_EQ(plate.reduction->second_cutoff_hz, 1.5e6);
  EXPECT_FALSE(plate.reduction->second_modes);
  EXPECT_EQ(plate.reduction->pick, Pick::frequency);
  EXPECT_EQ(plate.reduction->interface_sets, std::vector<std::string>{"contact"});
  EXPECT_EQ(plate.reduction->superelement, folder / "plate.cbr.h5");
  EXPECT_FALSE(scene.components.at("bare").reduction);
}

TEST(Scene, everyKeyOfARunArrives) {
  const TemporaryFolder folder;
  const Scene scene = read_text(folder, full_scene);
  ASSERT_EQ(scene.instances.size(), 3u);
  const Instance& right = scene.instances[0];
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(right.as, InstanceKind::mesh);
  EXPECT_EQ(right.position, Vector3(0.0381, 0, 0));
  EXPECT_EQ(right.rotation_degrees, Vector3(10, -20.5, 1e-3));
  EXPECT_EQ(right.mirror, "x");
  EXPECT_EQ(right.velocity, Vector3(-1, 0.1, 3810));
  EXPECT_EQ(right.angular_velocity, Vector3(1, 2, -3));
  EXPECT_EQ(scene.instances[1].as, InstanceKind::superelement);
  EXPECT_EQ(scene.instances[2].as, InstanceKind::mesh);
  EXPECT_EQ(&component_of(scene, right), &scene.components.at("block"));
  EXPECT_EQ(scene.skin->thickness, 2.5e-10);
  EXPECT_EQ(scene.skin->mesh, folder / "skins/skinned.msh");
  EXPECT_EQ(scene.boundary.at(0).fix, (std::array<bool, 3>{true, false, true}));
  EXPECT_EQ(scene.boundary[0].fix_rotations, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(scene.components.at("block").blocks.at("core").thickness, 0.0025);
  EXPECT_TRUE(scene.components.at("plate").reduction->condenses_rotations);
  EXPECT_EQ(scene.boundary[0].motion, SupportMotion::velocity);
  EXPECT_EQ(scene.boundary[0].value, Vector3(0.5, 0, 2));
  EXPECT_EQ(scene.boundary[0].history.value, (std::vector<double>{0, 1, 0}));
  EXPECT_EQ(scene.boundary[0].turn, Vector3(0, 3, 0));
  EXPECT_EQ(scene.boundary[0].about, Vector3(1, 2, 3));
  ASSERT_EQ(scene.loads.size(), 3u);
  EXPECT_EQ(scene.loads[0].history.value, (std::vector<double>{0, 6.9e8, 0}));
  EXPECT_EQ(scene.loads[1].kind, Load::Kind::force);
  EXPECT_EQ(scene.loads[1].surface, "tip.end");
  EXPECT_EQ(scene.loads[2].kind, Load::Kind::gravity);
  EXPECT_EQ(scene.loads[2].value, Vector3(0, 0, -9.81));
  ASSERT_EQ(scene.contact.size(), 5u);
  EXPECT_EQ(scene.contact[0].enforcement, Enforcement::penalty);
  EXPECT_EQ(scene.contact[0].friction, 0.25);
  EXPECT_EQ(scene.contact[1].second.instance, "right");
  EXPECT_EQ(scene.contact[1].second.surface, "a.b");
  EXPECT_EQ(scene.time->end, 1.2e-5);
  EXPECT_EQ(scene.time->step, 1e-8);
  EXPECT_TRUE(scene.time->force_step);
  EXPECT_EQ(scene.time->rotations, Rotations::large);
  EXPECT_EQ(scene.time->integrator, Integrator::newmark);
  EXPECT_EQ(scene.time->alpha, -0.125);
  EXPECT_EQ(scene.output.every, 1e-7);
  EXPECT_EQ(scene.output.history.at(1).text(), "right.contact");
  ASSERT_EQ(scene.output.reactions.size(), 1u);
  EXPECT_EQ(scene.output.reactions[0].text(), "left.clamp");
  ASSERT_EQ(scene.output.stress.size(), 2u);
  EXPECT_EQ(scene.output.stress[0].instance + " " + scene.output.stress[0].set, "left root");
  EXPECT_EQ(scene.output.stress[1].elements, (std::vector<Index>{3, 17}));
  EXPECT_EQ(scene.output.stress[1].worst, 5);
  EXPECT_TRUE(scene.output.stress[1].envelope);
  EXPECT_EQ(scene.sweep->to_hz, 2125);
  EXPECT_TRUE(scene.sweep->is_logarithmic);
  EXPECT_EQ(scene.output.fields,
            (std::vector<std::string>{"displacement", "stress", "contact_pressure"}));
  EXPECT_EQ(scene.output.format, FieldFormat::exodus);
  EXPECT_EQ(scene.output.checkpoint->every, 2.5e-7);
  EXPECT_FALSE(scene.output.checkpoint->every_steps || scene.output.checkpoint->every_minutes);
  EXPECT_EQ(scene.output.checkpoint->file, std::filesystem::absolute(folder / "keep/impact.h5"));
}

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
    const std::string message = refusal(folder, replaced(text, old, by));
    EXPECT_NE(message.find(says), std::string::npos) << message;
  };
  refused("points: tip,", "", "missing key 'interface'");
  refused("points: tip", "points: tap", "unknown point 'tap', did you mean 'tip'?");
  refused("points: tip", "points: base", "whose coupling is average");
  refused("points: tip", "points: tip, domains: 2", "not available with domains above 1");
  refused("points: tip", "points: tip, loads: x_max", "not available with loads");
  refused("points: tip", "points: tip, basis: massless", "not available with basis: massless");
}

TEST(Scene, checkpointsArrive) {
  const TemporaryFolder folder;
  for (const std::string given :
       {"{every_steps: 500}", "{every_minutes: 0.5}", "{every: 1.0e-6}"}) {
    const Scene scene =
        read_text(folder, replaced(full_scene, "{every: 2.5e-7, file: keep/impact.h5}", given));
    EXPECT_EQ(scene.output.checkpoint->every_steps.value_or(0), given[7] == 's' ? 500 : 0) << given;
    EXPECT_EQ(scene.output.checkpoint->every_minutes.value_or(0), given[7] == 'm' ? 0.5 : 0)
        << given;
    EXPECT_TRUE(scene.output.checkpoint->file.empty());
    EXPECT_EQ(written(read_text(folder, written(scene))), written(scene));
  }
}

TEST(Scene, wallsAndContactArrive) {
  const TemporaryFolder folder;
  const Scene scene = read_text(folder, full_scene);
  ASSERT_EQ(scene.walls.size(), 3u);
  EXPECT_EQ(scene.walls[0].name, "floor");
  EXPECT_EQ(scene.walls[0].kind, WallOptions::Kind::plane);
  EXPECT_EQ(scene.walls[0].point, Vector3(0, 0, -0.25));
  EXPECT_TRUE(scene.walls[0].direction.isApprox(Vector3(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(scene.walls[1].name, "the ball");
  EXPECT_EQ(scene.walls[1].kind, WallOptions::Kind::sphere);
  EXPECT_EQ(scene.walls[1].point, Vector3(1, 2, 3));
  EXPECT_EQ(scene.walls[1].radius, 1.5e-3);
  EXPECT_TRUE(scene.walls[1].inside);
  EXPECT_EQ(scene.walls[2].kind, WallOptions::Kind::cylinder);
  EXPECT_EQ(scene.walls[2].point, Vector3(0, 0, 7));
  EXPECT_EQ(scene.walls[2].direction, Vector3(0, -1, 0));
  EXPECT_EQ(scene.walls[2].radius, 12);
  EXPECT_TRUE(scene.walls[2].inside);
  EXPECT_EQ(scene.contact[0].formulation, Formulation::two_way);
  EXPECT_EQ(scene.contact[0].damping, 0.125);
  // a wall is the second, wherever it stood
  EXPECT_EQ(scene.contact[2].first.text(), "left.contact");
  EXPECT_EQ(scene.contact[2].second.text(), "floor");
  EXPECT_TRUE(scene.contact[2].second.is_wall());
  EXPECT_EQ(scene.contact[2].friction, 0.375);
  EXPECT_EQ(scene.contact[2].adjust, 1e-5);
  EXPECT_TRUE(scene.contact[3].tied);
  EXPECT_EQ(scene.contact[3].formulation, Formulation::mortar);
  EXPECT_FALSE(scene.contact[3].all || scene.contact[3].adjust);
  EXPECT_TRUE(scene.contact[4].all);
  EXPECT_EQ(scene.contact[4].adjust, 0);
}

TEST(Scene, contactAllIsShortForAListOfIt) {
  const TemporaryFolder folder;
  const auto begin = full_scene.find("contact:\n"), end = full_scene.find("time: {end");
  const auto with = [&](const std::string& contact) {
    return written(read_text(folder, std::string(full_scene).replace(begin, end - begin, contact)));
  };
  EXPECT_EQ(with("contact: all\n"), with("contact: [{between: all}]\n"));
}

TEST(Scene, directionsAreMadeUnitWhateverTheirLength) {
  const TemporaryFolder folder;
  for (const char* normal : {"[0, 0, 1e-320]", "[0, 0, 1e300]", "[0, 0, 1]"}) {
    EXPECT_EQ(read_text(folder, replaced(full_scene, "[0, 3, 4]", normal)).walls[0].direction,
              Vector3(0, 0, 1))
        << normal;
  }
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> sign(-1, 1), exponent(-300, 300);
  for (int trial = 0; trial < 100; ++trial) {
    std::ostringstream normal;
    normal << "[" << sign(random) << ", " << sign(random) << ", "
           << sign(random) * std::pow(10, trial % 2 ? exponent(random) : 0) << "]";
    const Scene scene = read_text(folder, replaced(full_scene, "[0, 3, 4]", normal.str()));
    EXPECT_NEAR(scene.walls[0].direction.norm(), 1, 1e-15) << normal.str();
    EXPECT_EQ(read_text(folder, written(scene)).walls[0].direction, scene.walls[0].direction)
        << normal.str();
  }
}

TEST(Scene, defaultsAreThoseOfTheContract) {
  const TemporaryFolder folder;
  const Scene scene = read_text(
      folder,
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\n"
      "components: {a: {mesh: a.msh, material: m, reduction: {interface: [], modes: 0}}}\n"
      "instances: {i: {component: a}, j: {component: a, as: mesh}}\n"
      "contact: [{between: [i.s, j.s]}]\n"
      "time: {end: 1}\n");
  EXPECT_EQ(scene.instances[0].as, InstanceKind::superelement);
  EXPECT_EQ(scene.contact[0].enforcement, Enforcement::impulse);
  EXPECT_EQ(scene.contact[0].friction, 0);
  EXPECT_EQ(scene.contact[0].formulation, Formulation::node_face);
  EXPECT_EQ(scene.contact[0].damping, 0);
  EXPECT_FALSE(scene.contact[0].all || scene.contact[0].tied || scene.contact[0].adjust);
  EXPECT_TRUE(scene.walls.empty());
  EXPECT_FALSE(scene.time->step || scene.time->cfl || scene.time->force_step);
  EXPECT_EQ(scene.time->integrator, Integrator::exact);
  EXPECT_EQ(scene.output.every, 0);
  EXPECT_TRUE(scene.output.fields.empty());
  EXPECT_FALSE(scene.output.checkpoint);
  EXPECT_EQ(scene.components.at("a").reduction->domains, 1);
  EXPECT_TRUE(scene.components.at("a").reduction->interface_sets.empty());
}

TEST(Scene, aThirdAsManyShapesAsModesWithinBounds) {
  EXPECT_EQ(default_shapes({}), 10);  // a cutoff or a tolerance: the number is not known yet
  EXPECT_EQ(default_shapes(20), 10);
  EXPECT_EQ(default_shapes(60), 20);
  EXPECT_EQ(default_shapes(500), 40);
}

TEST(Scene, anchorsAndMergeKeysAreFollowed) {
  const TemporaryFolder folder;
  const Scene scene =
      read_text(folder,
                "materials:\n  m: &base {youngs_modulus: 1, poissons_ratio: 0, density: 1}\n"
                "  n: {<<: *base, density: 2}\n  o: {density: 3, <<: [{youngs_modulus: 7}, "
                "*base]}\n  p: *base\n"
                "components: {a: {mesh: a.msh, material: m}}\n");
  EXPECT_EQ(scene.materials.at("n").density, 2);
  EXPECT_EQ(scene.materials.at("n").youngs_modulus, 1);
  EXPECT_EQ(scene.materials.at("o").density, 3);
  EXPECT_EQ(scene.materials.at("o").youngs_modulus, 7);
  EXPECT_EQ(scene.materials.at("p").density, 1);
}

TEST(Scene, writtenAndReadIsTheSameScene) {
  const TemporaryFolder folder, elsewhere;
  for (const auto& text : {full_scene, replaced(full_scene, "step: 1.0e-8", "step: {cfl: 0.9}"),
                           replaced(full_scene, "step: 1.0e-8, ", "")}) {
    const std::string once = written(read_text(folder, text));
    EXPECT_EQ(written(read_text(elsewhere, once)), once);
  }
  // What is written is what was read, too: the full scene says nothing by default, so every value
  // stands in the text.
  const std::string modes =
      replaced(full_scene, "second_reduction: {cutoff_hz: 1.5e6}", "second_reduction: {modes: 40}");
  EXPECT_EQ(read_text(elsewhere, written(read_text(folder, modes)))
                .components.at("plate")
                .reduction->second_modes,
            40);
  const std::string once = written(read_text(folder, full_scene));
  for (const char* value : {"5.17e+12",
                            "-0.25",
                            "hex8-hourglass",
                            "consistent",
                            "\"two words\"",
                            "modes: 80",
                            "participation",
                            "domains: 3",
                            "recovery: true",
                            "cutoff_hz: 2e+06",
                            "-20.5",
                            "mirror: x",
                            "3810",
                            "2.5e-10",
                            "[x, z]",
                            "6.9e+08",
                            "-9.81",
                            "penalty",
                            "nodal",
                            "friction: 0.25",
                            "newmark",
                            "force: true",
                            "right.contact",
                            "stress",
                            "\"true\"",
                            "two-way",
                            "mortar",
                            "damping: 0.125",
                            "adjust: 1e-05",
                            "tied: true",
                            "inside: true",
                            "radius: 0.0015",
                            "between: all",
                            "\"the ball\"",
                            "axis: [0, -1, 0]",
                            "left.root",
                            "elements: [3, 17]",
                            "worst: 5",
                            "envelope: true",
                            "from_hz: 12.5",
                            "points: 57",
                            "spacing: log",
                            "modes: 43"}) {
    EXPECT_NE(once.find(value), std::string::npos) << value;
  }
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
      "0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 4, 0], [0, 0, 0, 0, 0, 0]]}\n"
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
  EXPECT_TRUE(scene.walls[0].motion == SupportMotion::velocity &&
              scene.walls[0].value == Vector3(1, 2, 3));
  EXPECT_EQ(scene.walls[0].history.value, (std::vector<double>{1, 0}));
  EXPECT_EQ(preload_steps(scene), 3);
  EXPECT_EQ(written(read_text(elsewhere, written(scene))), written(scene));
  const auto refused = [&](const std::string& old, const std::string& by, const std::string& says) {
    const std::string message = refusal(folder, replaced(text, old, by));
    EXPECT_NE(message.find(says), std::string::npos) << message;
  };
  refused("static: true", "static: true, integrator: exact", "static: true computes equilibrium");
  const Scene on_set =
      read_text(folder, replaced(text, "point: tip, moment", "surface: u, moment"));
  EXPECT_TRUE(!on_set.loads[0].on_point && on_set.loads[0].kind == Load::Kind::moment);
  EXPECT_EQ(written(read_text(elsewhere, written(on_set))), written(on_set));
  refused("[a.tip, ground]", "[a.top, ground]", "which is no point");
  refused("at: [1, 2, 3]", "coupling: stiff", "average, rigid");
  refused("pretension: {force: 7}", "pretension: {force: 7}, friction: 0.1",
          "tied surfaces do not slide");
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
            "");
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
    EXPECT_NE(message.find("remove one of the two"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  const std::string as_mesh = with("component: part,", "component: part, as: mesh,");
  EXPECT_TRUE(as_mesh.starts_with(
      "impact.yaml:4: instances.left.as: component 'part' is a superelement file without a mesh"))
      << as_mesh;
  EXPECT_NE(as_mesh.find("use as: superelement"), std::string::npos) << as_mesh;
  const std::string replacing = refusal(
      folder, replaced(full_scene, "  bare:", "  part: {superelement: ../out/block.h5}\n  bare:"));
  EXPECT_NE(replacing.find("is also that of component 'block': give each a file of its own"),
            std::string::npos)
      << replacing;
  const std::string no_materials =
      with("instances:", "  bare: {mesh: a.msh, material: steel}\ninstances:");
  EXPECT_NE(no_materials.find("missing key 'materials'"), std::string::npos) << no_materials;
}

TEST(Scene, anyDoubleAndAnyNameSurviveWriting) {
  const TemporaryFolder folder, elsewhere;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-300, 300), sign(-1, 1);
  const std::vector<std::string> names = {
      "null",  "~",         "1e5",        "a: b",
      "- x",   "#c",        "\"q\" \\ '", "\xc3\xa9l\xc3\xa9ment",
      " lead", "tab\there", "[x]",        "{y}",
      "*z",    "&z",        "!t",         "%d",
      "@e",    "`f",        "on",         "multi\nline",
      "a, b",  "|",         ">",          "?"};
  for (const auto& name : names) {
    Scene scene = read_text(folder, full_scene);
    scene.materials[name] = {std::pow(10, exponent(random)), 0.3, std::pow(10, exponent(random))};
    scene.components.at("block").blocks[name].material = name;
    scene.components.at("block").mesh = folder / name;
    scene.instances[0].position =
        Vector3(sign(random), sign(random) * std::pow(10, exponent(random)), -0.0);
    const Scene again = read_text(elsewhere, written(scene));
    EXPECT_EQ(again.materials.at(name).youngs_modulus, scene.materials.at(name).youngs_modulus)
        << name;
    EXPECT_EQ(again.components.at("block").mesh, scene.components.at("block").mesh) << name;
    EXPECT_EQ(again.instances[0].position, scene.instances[0].position);
    EXPECT_EQ(written(again), written(scene));
  }
}

TEST(Transformation, isMirrorThenRotationsAboutTheFixedAxes) {
  Instance instance;
  instance.rotation_degrees = Vector3(31, -47, 112);
  for (const char* mirror : {"", "x", "y", "z"}) {
    instance.mirror = mirror;
    const double degree = std::numbers::pi / 180;
    Vector3 scale = Vector3::Ones();
    if (*mirror) scale(*mirror - 'x') = -1;
    const Matrix3 expected = (Eigen::AngleAxisd(112 * degree, Vector3::UnitZ()) *
                              Eigen::AngleAxisd(-47 * degree, Vector3::UnitY()) *
                              Eigen::AngleAxisd(31 * degree, Vector3::UnitX()))
                                 .toRotationMatrix() *
                             scale.asDiagonal();
    const Matrix3 T = instance.transformation();
    EXPECT_LT((T - expected).norm(), 1e-14);
    EXPECT_NEAR(T.determinant(), *mirror ? -1 : 1, 1e-14);
  }
}

TEST(Transformation, isExactForRightAngles) {
  Instance instance;
  instance.rotation_degrees = Vector3(0, 0, 90);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(-2, 1, 3));
  instance.rotation_degrees = Vector3(90, 0, 0);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(1, -3, 2));
  instance.rotation_degrees = Vector3(0, -270, 360);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(3, 2, -1));
  instance.rotation_degrees = Vector3(180, -180, 540);
  EXPECT_EQ(instance.transformation() * Vector3(1, 2, 3), Vector3(1, 2, 3));
}

TEST(BlockProperties, followTheBlocksOfTheMesh) {
  const TemporaryFolder folder;
  const Scene scene =
      read_text(folder, replaced(full_scene, "      \"true\": {element: hex8-hourglass}\n", ""));
  Mesh mesh;
  mesh.blocks.resize(3);
  mesh.blocks[0].name = "other", mesh.blocks[1].name = "core", mesh.blocks[2].name = "skin",
  mesh.blocks[2].type = ElementType::quad4;
  const auto properties = block_properties(scene, scene.components.at("block"), mesh);
  ASSERT_EQ(properties.size(), 3u);
  EXPECT_EQ(properties[0].material.density, 7836);
  EXPECT_EQ(properties[0].hex8, Hex8Formulation::hourglass);
  EXPECT_EQ(properties[1].material.density, 0.1);
  EXPECT_EQ(properties[1].hex8, Hex8Formulation::full);
  // 'bare' gives a material to block 'all' only.
  // the mesh has no block 'all'
  EXPECT_THROW(block_properties(scene, scene.components.at("bare"), mesh), InputError);
  mesh.blocks[0].name = "all";
  // 'core' is a volume without a material
  EXPECT_THROW(block_properties(scene, scene.components.at("bare"), mesh), InputError);
  mesh.blocks.erase(mesh.blocks.begin() + 1);
  // 'skin' needs none
  EXPECT_EQ(block_properties(scene, scene.components.at("bare"), mesh).size(), 2u);
}

// As in Exodus meshes without names.
TEST(BlockProperties, knowUnnamedBlocksByTheirNumber) {
  Scene scene;
  scene.materials = {{"light", {1, 0, 1}}, {"dense", {1, 0, 2}}};
  Component component;
  component.material = "light";
  component.blocks["20"].material = "dense";
  Mesh mesh;
  mesh.blocks.resize(2);
  mesh.blocks[0].name = "block_10", mesh.blocks[1].name = "block_20";
  const auto properties = block_properties(scene, component, mesh);
  EXPECT_EQ(properties[0].material.density, 1);
  EXPECT_EQ(properties[1].material.density, 2);
  component.blocks["block_20"].material = "light";
  EXPECT_THROW(block_properties(scene, component, mesh), InputError);  // twice
  component.blocks.erase("block_20");
  component.blocks["30"].material = "light";
  EXPECT_THROW(block_properties(scene, component, mesh), InputError);  // there is none
}

}  // namespace
}  // namespace cbr::scene_test
