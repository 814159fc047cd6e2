// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/refusal.hpp"
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
  EXPECT_EQ(block.blocks.at("core").element, HexFormulation::full);
  EXPECT_EQ(block.blocks.at("true").material, "");
  EXPECT_EQ(block.element, HexFormulation::hourglass);
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
  EXPECT_FALSE(plate.element) << "by the mesh file";
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
  EXPECT_EQ(scene.contact[0].friction.at_rest, 0.25);
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
  EXPECT_EQ(scene.contact[2].friction.at_rest, 0.375);
  EXPECT_EQ(scene.contact[2].adjust, 1e-5);
  EXPECT_TRUE(scene.contact[3].tied);
  EXPECT_EQ(scene.contact[3].formulation, Formulation::mortar);
  EXPECT_FALSE(scene.contact[3].all || scene.contact[3].adjust);
  EXPECT_TRUE(scene.contact[4].all);
  EXPECT_EQ(scene.contact[4].adjust, 0);
  EXPECT_EQ(scene.contact[4].friction.at_rest, 0.5);
  EXPECT_EQ(scene.contact[4].friction.kinetic, 0.125);
  EXPECT_EQ(scene.contact[4].friction.decay, 8);
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
  EXPECT_EQ(scene.contact[0].friction.at_rest, 0);
  EXPECT_EQ(scene.contact[0].formulation, Formulation::automatic);
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
    EXPECT_SAYS(once, value) << value;
  }
}

TEST(Scene, anyDoubleAndAnyNameSurviveWriting) {
  const TemporaryFolder folder, elsewhere;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-300, 300), sign(-1, 1);
  const std::vector<std::string> names = {
      "null",  "~",   "1e5",  "a: b", "- x", "#c", "\"q\" \\ '", "\xc3\xa9l\xc3\xa9ment",
      " lead", "[x]", "{y}",  "*z",   "&z",  "!t", "%d",         "@e",
      "`f",    "on",  "a, b", "|",    ">",   "?"};
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

}  // namespace
}  // namespace cbr::scene_test
