// SPDX-License-Identifier: GPL-3.0-or-later
// output.stress and histories inside superelements: those of the mesh with all modes, and those of
// the fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "common/base/error.hpp"
#include "common/fem/stress_values.hpp"
#include "common/files/hdf5_file.hpp"
#include "dynamics/output/fields.hpp"
#include "dynamics/output/results.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::test::stress_output_test {
namespace {

constexpr std::array<Index, 3> cells = {5, 3, 4};
constexpr Index interior = 3 * 4 * 4 * 5;  // dofs between x_min and x_max

// Two blocks of different materials, and sets inside.
Mesh part() {
  Mesh mesh =
      block_mesh({cells, Vector3(1, 0.6, 0.8), [](const Vector3& x) {
                    return Vector3(x[0], x[1] * (1 + 0.1 * x[0]), x[2] + 0.05 * x[0] * x[1]);
                  }});
  Nodeset middle{"middle", 1, {}}, point{"sensor", 2, {}};
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    const double x = mesh.coordinates(i, 0);
    if (std::abs(x - 0.4) < 1e-9 && mesh.coordinates(i, 1) > 0.5) middle.nodes.push_back(i);
    if (std::abs(x - 0.6) < 1e-9 && mesh.coordinates(i, 1) < 1e-9) point.nodes.push_back(i);
  }
  mesh.nodesets = {middle, point};
  // The elements from x = 0.4 on are of a block of their own
  Block& whole = mesh.blocks[0];
  Block stiff = whole, soft = whole;
  std::vector<Index> rows[2];
  for (Index e = 0; e < whole.connectivity.rows(); ++e)
    rows[mesh.coordinates(whole.connectivity(e, 0), 0) > 0.3].push_back(e);
  std::vector<Side> places(whole.connectivity.rows());
  for (std::size_t b = 0; b < 2; ++b) {
    Block& block = b == 0 ? stiff : soft;
    block.name = b == 0 ? "stiff" : "soft";
    block.id = static_cast<Index>(b) + 1;
    block.connectivity = IndexTable(whole.connectivity(rows[b], Eigen::all));
    block.element_ids.clear();
    for (std::size_t e = 0; e < rows[b].size(); ++e) {
      block.element_ids.push_back(whole.element_ids[rows[b][e]]);
      places[rows[b][e]] = {static_cast<Index>(b), static_cast<Index>(e), 1};
    }
  }
  for (Sideset& set : mesh.sidesets)
    for (Side& side : set.sides) {
      const Side& place = places[side.element];
      side = {place.block, place.element, side.side};
    }
  mesh.blocks = {stiff, soft};
  return mesh;
}

struct Options {
  std::string as = "superelement", integrator = "central-difference",
              reduction = ", recovery: true";
  Index modes = interior;
  std::string stress =
      "[a.middle, a.x_min, {instance: a, elements: [7, 31], worst: 3, envelope: true}]";
  std::string history = "[a.x_max, a.sensor]";
  bool turns = false;  // else one end is held
};

std::string yaml(const Options& o) {
  return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}, n: "
         "{youngs_modulus: 60, poissons_ratio: 0.2, "
         "density: 2}}\n"
         "components:\n  part:\n    mesh: part.exo\n    mass: lumped\n    blocks: {stiff: "
         "{material: m}, soft: {material: n}}\n"
         "    reduction: {interface: [x_min, x_max], modes: " +
         std::to_string(o.modes) + o.reduction + "}\n" +
         "instances:\n  a: {component: part, as: " + o.as +
         ", mirror: y, position: [0.97, 2.61, 0.013], rotation: [10, 0, 30]" +
         (o.turns ? ", angular_velocity: [3, 5, -2]}\n"
                  : "}\nboundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n") +
         "loads: [{instance: a, surface: x_max, traction: [2, -1, 3]}]\n"
         "time: {end: 0.1, step: 1.0e-3, integrator: " +
         o.integrator + (o.turns ? ", rotations: large" : "") +
         "}\noutput: {every: 0.02, history: " + o.history +
         (o.stress.empty() ? "" : ", stress: " + o.stress) + ", fields: [stress, nodal_stress]}\n";
}

class StressOutput : public testing::Test {
 protected:
  StressOutput() { folder_.add("part.exo", part()); }

  // With fields in results.fields.h5
  Ran run(const Options& options) {
    Ran ran = folder_.prepare(yaml(options));
    Report report("test", Verbosity::quiet);
    FieldWriter writer(ran.scene, ran.built, folder_.folder() / "results.h5", report);
    RunOptions how;
    how.on_output = [&](Index, double t) { writer.add(t); };
    ran.result = cbr::run(ran.built.simulation, how);
    writer.commit();
    write_results(folder_.folder() / "results.h5", ran.built.simulation, ran.result,
                  Report("test", Verbosity::quiet));
    return ran;
  }
  void expect_refused(const Options& options, const std::string& word) {
    const std::string message = refusal_of([&] { run(options); });
    EXPECT_SAYS(message, word);
  }
  Hdf5Reader results() const { return Hdf5Reader(folder_.folder() / "results.h5"); }
  Hdf5Reader fields() const { return Hdf5Reader(folder_.folder() / "results.fields.h5"); }

  SceneFolder folder_;
};

void expect_same(const std::vector<double>& a, const std::vector<double>& b, double share) {
  ASSERT_EQ(a.size(), b.size());
  double scale = 0;
  for (const double v : a) scale = std::max(scale, std::abs(v));
  ASSERT_GT(scale, 0);
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], share * scale) << i;
}

void expect_same(const RunResult& a, const RunResult& b) {
  ASSERT_EQ(a.watches.size(), b.watches.size());
  for (std::size_t w = 0; w < a.watches.size(); ++w) expect_same(a.watches[w], b.watches[w], 1e-9);
  for (std::size_t m = 0; m < a.monitors.size(); ++m) {
    expect_same(a.monitors[m].mean_position.values, b.monitors[m].mean_position.values, 1e-9);
    expect_same(a.monitors[m].mean_velocity.values, b.monitors[m].mean_velocity.values, 1e-9);
    expect_same(a.monitors[m].mean_acceleration.values, b.monitors[m].mean_acceleration.values,
                1e-9);
  }
  expect_same(a.scans.at(0).worst_stress, b.scans.at(0).worst_stress, 1e-9);
}

// With all modes the superelement is the mesh, at nodes, in elements and inside; whatever recovers
// it and moves it.
TEST_F(StressOutput, OfASuperelementWithAllModesIsThatOfTheMesh) {
  for (const char* integrator : {"central-difference", "newmark"}) {
    const Ran mesh = run({"mesh", integrator});
    const Ran reduced = run({"superelement", integrator});
    expect_same(mesh.result, reduced.result);
    expect_same(mesh.result,
                run({"superelement", integrator, ", recovery: true, domains: 3", 100000}).result);
    folder_.diagonal_limit = 0;
    expect_same(
        mesh.result,
        run({"superelement", integrator, ", recovery: true, superelement: dense.h5"}).result);
    folder_.diagonal_limit.reset();
  }
}

// Of named sets alone: a smaller file, the same stress.
TEST_F(StressOutput, OfSomeSetsIsThatOfAll) {
  Options some;
  some.integrator = "exact";
  some.modes = 12;
  some.stress = "[a.middle, a.x_min, {instance: a, elements: [1]}]";
  const Ran whole = run(some);
  const auto size = std::filesystem::file_size(folder_.folder() / "part.cbr.h5");
  for (const char* basis : {"", ", basis: characteristic"}) {
    Options all = some, few = some;
    all.reduction = std::string(basis) + ", recovery: true, superelement: all.h5";
    few.reduction =
        std::string(basis) + ", recovery: [middle, x_min, sensor], superelement: few.h5";
    const Ran a = run(all), b = run(few);
    ASSERT_EQ(a.result.watches.size(), 3u);
    for (std::size_t w = 0; w < 3; ++w)
      expect_same(a.result.watches[w], b.result.watches[w], 1e-12);
    expect_same(a.monitor("a.sensor").mean_velocity.values,
                b.monitor("a.sensor").mean_velocity.values, 1e-12);
  }
  EXPECT_LT(std::filesystem::file_size(folder_.folder() / "few.h5"), size);
}

// What is written without fields is what the fields have.
TEST_F(StressOutput, IsThatOfTheFields) {
  for (const auto& [as, turns] : {std::pair("superelement", false), std::pair("mesh", false),
                                  std::pair("superelement", true), std::pair("mesh", true)}) {
    Options options;
    options.as = as;
    options.integrator = "exact";
    options.modes = 12;
    options.turns = turns;
    const Ran ran = run(options);
    const Hdf5Reader results = this->results(), fields = this->fields();
    const Index n = ran.result.time.size();
    // By block id and node id, or element id, at each output
    std::map<std::array<Index, 3>, double> at_nodes;
    std::vector<std::map<Index, double>> of_elements(static_cast<std::size_t>(n));
    const std::map<std::string, Index> block_ids = {{"a.stiff", 1}, {"a.soft", 2}};
    for (const std::string& grid : fields.children("/grids")) {
      const auto block = block_ids.find(fields.read_string("/grids/" + grid, "name"));
      if (block == block_ids.end()) continue;
      const std::vector<Index> ids = fields.read_indices("/grids/" + grid + "/node_ids"),
                               elements = fields.read_indices("/grids/" + grid + "/element_ids");
      for (Index t = 0; t < n; ++t) {
        const std::string step = "/steps/" + std::to_string(t) + "/" + grid;
        const Matrix nodal = fields.read_matrix(step + "/nodal_stress_principal_1"),
                     cell = fields.read_matrix(step + "/stress_von_mises");
        for (std::size_t i = 0; i < ids.size(); ++i)
          at_nodes[{block->second, ids[i], t}] = nodal(static_cast<Index>(i), 0);
        for (std::size_t e = 0; e < elements.size(); ++e)
          of_elements[t][elements[e]] = cell(static_cast<Index>(e), 0);
      }
    }
    const std::vector<Index> nodes = results.read_indices("/stress/a.middle/node_id"),
                             blocks = results.read_indices("/stress/a.middle/block_id");
    const Matrix principal = results.read_matrix("/stress/a.middle/principal_1");
    ASSERT_EQ(nodes.size(), 10u) << "five nodes of two materials";
    for (Index t = 0; t < n; ++t)
      for (std::size_t i = 0; i < nodes.size(); ++i)
        EXPECT_NEAR(principal(t, static_cast<Index>(i)), at_nodes.at({blocks[i], nodes[i], t}),
                    1e-10)
            << as;
    // The worst, and the envelope
    const IndexTable worst = results.read_index_table("/stress/a/worst/element_id");
    const Matrix of_worst = results.read_matrix("/stress/a/worst/von_mises"),
                 of_seven = results.read_matrix("/stress/a/elements/von_mises");
    std::map<Index, double> largest;
    for (Index t = 0; t < n; ++t) {
      std::vector<double> sorted;
      for (const auto& [id, value] : of_elements[t]) {
        sorted.push_back(value);
        largest[id] = std::max(largest[id], value);
      }
      std::sort(sorted.rbegin(), sorted.rend());
      EXPECT_NEAR(of_seven(t, 0), of_elements[t].at(7), 1e-10);
      for (Index k = 0; k < 3; ++k) {
        EXPECT_NEAR(of_worst(t, k), sorted[k], 1e-10);
        EXPECT_NEAR(of_elements[t].at(worst(t, k)), of_worst(t, k), 1e-10);
      }
    }
    const std::vector<Index> ids = results.read_indices("/stress/a/envelope/elements/element_id");
    const Vector envelope = results.read_vector("/stress/a/envelope/elements/von_mises");
    ASSERT_EQ(ids.size(), 60u);
    for (std::size_t e = 0; e < ids.size(); ++e)
      EXPECT_NEAR(envelope[static_cast<Index>(e)], largest.at(ids[e]), 1e-10);
    std::map<std::array<Index, 2>, double> largest_nodal;
    for (const auto& [key, value] : at_nodes) {
      const auto [found, is_new] = largest_nodal.try_emplace({key[0], key[1]}, value);
      found->second = std::max(found->second, value);
    }
    const std::vector<Index> node_ids = results.read_indices("/stress/a/envelope/nodes/node_id"),
                             of_blocks = results.read_indices("/stress/a/envelope/nodes/block_id");
    const Vector nodal = results.read_vector("/stress/a/envelope/nodes/principal_1");
    ASSERT_EQ(node_ids.size(), static_cast<std::size_t>(6 * 4 * 5 + 4 * 5));
    for (std::size_t i = 0; i < node_ids.size(); ++i)
      EXPECT_NEAR(nodal[static_cast<Index>(i)], largest_nodal.at({of_blocks[i], node_ids[i]}),
                  1e-10);
  }
}

TEST_F(StressOutput, WhatCannotBeIsRefused) {
  Options options;
  options.reduction = "";
  options.history = "[a.x_max]";
  expect_refused(options, "recovery");
  options.reduction = ", recovery: [middle]";
  options.stress = "[a.sensor]";
  expect_refused(options, "recovery: [sensor]");
  options.reduction = ", recovery: [nowhere]";
  options.stress = "";
  expect_refused(options, "nowhere");
  options.reduction = ", recovery: true";
  options.stress = "[{instance: a, elements: [1000]}]";
  expect_refused(options, "1000");
  options.stress = "[{instance: a}]";
  expect_refused(options, "worst");
  options.reduction = ", recovery: [middle], domains: 2";
  options.stress = "";
  expect_refused(options, "domains: 1");
  options.reduction = "";
  options.history = "[a.sensor]";
  expect_refused(options, "reduction.recovery");
}

}  // namespace
}  // namespace cbr::test::stress_output_test
