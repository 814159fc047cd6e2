// SPDX-License-Identifier: GPL-3.0-or-later
// Sets that a scene names: loads on nodesets, and names that are refused before the work of either
// program.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <fstream>
#include <string>

#include "common/files/hdf5_file.hpp"
#include "reducer/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::scene_sets_test {
namespace {

// A bar with two nodesets of a few nodes: three at the end x = 2, two in its middle.
Mesh bar() {
  Mesh mesh = block_mesh({{4, 2, 2}, Vector3(2, 0.6, 0.8)});
  Nodeset tip{"tip", 1, {}}, middle{"middle", 2, {}};
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    const Vector3 x = mesh.coordinates.row(i);
    if (x[0] > 1.9 && x[1] + x[2] < 0.5) tip.nodes.push_back(i);
    if (std::abs(x[0] - 1) < 0.1 && x[1] < 0.1 && x[2] > 0.3) middle.nodes.push_back(i);
  }
  mesh.nodesets = {tip, middle};
  return mesh;
}

std::string scene(const std::string& reduction, const std::string& as, const std::string& more) {
  return "materials: {m: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}\n"
         "components: {part: {mesh: part.exo, material: m, reduction: {modes: 8, " +
         reduction + "}}}\ninstances: {a: {component: part, as: " + as + "}}\n" + more;
}
const std::string run_time = "time: {end: 0.02, integrator: newmark, step: 1.0e-4}\n";

class SceneSets : public ::testing::Test {
 protected:
  SceneSets() { folder_.add("part.exo", bar()); }

  void write(const std::string& yaml) const {
    std::ofstream(folder_.folder() / "scene.yaml") << yaml;
  }
  std::string refused_by_reduce(const std::string& yaml) const {
    write(yaml);
    ReduceCommand command;
    command.input = (folder_.folder() / "scene.yaml").string();
    Report report("cbr-reduce", Verbosity::quiet);
    return refusal_of([&] { run_reduce(command, nullptr, report); });
  }
  std::string refused_by_dyn(const std::string& yaml) const {
    write(yaml);
    Report report("cbr-dyn", Verbosity::quiet);
    return refusal_of(
        [&] { build(read_scene((folder_.folder() / "scene.yaml").string()), report); });
  }
  bool has_superelement() const {
    return std::filesystem::exists(folder_.folder() / "part.cbr.h5");
  }

  SceneFolder folder_;
};

void expect_in(const std::string& text, const std::vector<std::string>& words) {
  for (const auto& word : words) EXPECT_SAYS(text, word) << word << " in: " << text;
}

// Momentum and angular momentum that the free part has from the force: F t, and sum over the nodes
// of x_i cross F / n times t.
TEST_F(SceneSets, AForceOnANodesetIsSpreadEquallyOverItsNodes) {
  const Mesh mesh = bar();
  const std::vector<Index>& nodes = mesh.nodesets[0].nodes;
  ASSERT_EQ(nodes.size(), 3u);
  const Vector3 F(0.3, -0.2, 0.5), centre = mesh.coordinates(nodes, Eigen::all).colwise().mean();
  for (const std::string as : {"mesh", "superelement"}) {
    const Ran ran = folder_.run(scene("interface: [x_min, tip]", as,
                                      "loads: [{instance: a, surface: tip, force: " + text(F) +
                                          "}]\n" + run_time + "output: {every: 0.01}\n"));
    const std::size_t last = ran.result.time.size() - 1;
    EXPECT_LT((at(ran.body("a").momentum, last) - 0.02 * F).norm(), 1e-10 * 0.02 * F.norm()) << as;
    const Vector3 L = 0.02 * centre.cross(F);
    // The part has moved a little by then
    EXPECT_LT((at(ran.body("a").angular_momentum, last) - L).norm(), 1e-3 * L.norm()) << as;
  }
}

TEST_F(SceneSets, AForceOnNodesThatAreNotKeptIsRefusedWithOneCureByBothPrograms) {
  const std::string load = "loads: [{instance: a, surface: middle, force: [0, 0, 1]}]\n",
                    good = "interface: [x_min, tip]";
  const std::string reduce = refused_by_reduce(scene(good, "superelement", load + run_time));
  expect_in(reduce, {"nodeset 'middle'", "reduction.interface"});
  EXPECT_FALSE(has_superelement());
  folder_.prepare(scene(good, "superelement", run_time));
  expect_in(refused_by_dyn(scene(good, "superelement", load + run_time)),
            {"'middle'", "reduction.interface", "nodeset"});
  // What they say to do does it
  const Ran ran = folder_.run(scene("interface: [x_min, middle]", "superelement", load + run_time));
  EXPECT_GT(at(ran.body("a").momentum, 1)[2], 0);
}

TEST_F(SceneSets, ATractionOnANodesetIsRefusedWithOneMessage) {
  const std::string load = "loads: [{instance: a, surface: tip, traction: [0, 0, 1]}]\n",
                    interface = "interface: [x_min, tip]";
  const std::string reduce = refused_by_reduce(scene(interface, "superelement", load + run_time));
  expect_in(reduce, {"scene.yaml:", "tip", "traction does not go with a nodeset", "give force"});
  folder_.prepare(scene(interface, "superelement", run_time));
  EXPECT_EQ(refused_by_dyn(scene(interface, "superelement", load + run_time)), reduce);
  EXPECT_EQ(refused_by_dyn(scene(interface, "mesh", load + run_time)), reduce);
}

TEST_F(SceneSets, SetsThatNoInterfaceKeepsAreRefusedBeforeTheReduction) {
  const std::string interface = "interface: [x_min]",
                    yaml = scene(interface, "superelement", run_time);
  const std::vector<std::string> uses = {
      "output: {every: 0.01, history: [a.y_max]}\n",
      "boundary: [{instance: a, nodes: y_max, fix: [x]}]\n",
      "walls: {w: {plane: {point: [0, 2, 0], normal: [0, -1, 0]}}}\n"
      "contact: [{between: [a.y_max, w]}]\n"};
  for (const std::string& use : uses) {
    expect_in(refused_by_reduce(yaml + use),
              {"scene.yaml:", "'a.y_max'", "keeps 3 of its 15 nodes", "reduction.interface"});
    EXPECT_FALSE(has_superelement());
  }
  expect_in(refused_by_reduce(yaml + "output: {every: 0.01, history: [a.y_mex]}\n"),
            {"scene.yaml:5", "y_mex", "y_max"});
}

TEST_F(SceneSets, SetsThatAreNotThereAreRefusedBeforeMatricesAreRead) {
  const std::string yaml = scene("interface: [x_min]", "superelement", run_time);
  folder_.prepare(yaml);
  const auto file = folder_.folder() / "part.cbr.h5", whole = folder_.folder() / "whole.h5";
  std::filesystem::rename(file, whole);
  {
    Hdf5Writer damaged(file, whole);
    damaged.remove("/matrices/K_cc");
    damaged.remove("/diagonal/V");
    damaged.commit();
  }
  expect_in(refused_by_dyn(yaml), {"part.cbr.h5", "missing"});
  expect_in(refused_by_dyn(yaml + "output: {every: 0.01, history: [a.y_max]}\n"),
            {"scene.yaml:5", "no surface or node set 'y_max'"});
}

// By default a superelement of tet10 has consistent mass, and the full mesh lumped.
TEST_F(SceneSets, AComponentOfTwoMassesIsTold) {
  Mesh mesh = box_mesh(ElementType::tet10, {3, 1, 1}, Vector3(3, 1, 1));
  Nodeset end{"x_max", 1, {}};
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (mesh.coordinates(i, 0) > 2.9) end.nodes.push_back(i);
  mesh.nodesets = {end};
  folder_.add("part.exo", mesh);
  const auto told = [&](const std::string& mass) {
    const std::string yaml =
        "materials: {m: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}\n"
        "components: {part: {mesh: part.exo, material: m, " +
        mass +
        "reduction: {interface: [x_max], modes: 8}}}\n"
        "instances: {a: {component: part, as: superelement}, b: {component: part, as: mesh}}\n";
    EXPECT_EQ(refused_by_reduce(yaml + run_time), "no error");
    testing::internal::CaptureStderr();
    EXPECT_EQ(refused_by_dyn(yaml + run_time), "no error");
    return testing::internal::GetCapturedStderr();
  };
  expect_in(told(""),
            {"component 'part'", "its mesh is lumped and that of its superelement consistent",
             "mass: lumped"});
  EXPECT_EQ(told("mass: lumped, ").find("its mesh is lumped"), std::string::npos);
}

}  // namespace
}  // namespace cbr::test::scene_sets_test
