// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic with the statics of the faces that touch, from reduction to run: pressed
// bodies carry what statics says, impacts lose what they should, and nothing depends on axes,
// units, partners or restarts.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/files/state_archive.hpp"
#include "common/superelement/superelement.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::statics_test {
namespace {

using test::Ran;
using test::SceneFolder;
using test::text;

// A block whose lowest corner is the origin. Both ends are kept; statics are of those that the
// scene's contact names.
struct Block {
  std::string reduction = "basis: characteristic, modes: 20", integrator = "exact", step = "auto",
              more, instance, loads;
  std::string contact = "between: [b.x_min, floor]",
              walls = "floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}";
  double end = 1, every = 0.01, nu = 0.3;
  std::array<Index, 3> n{12, 4, 4};
  Vector3 size{1, 0.5, 0.5};
};

std::string yaml(const Block& p) {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: " + text(p.nu) +
         ", density: 1}}\ncomponents: {block: {mesh: block.exo, material: m, reduction: {" +
         p.reduction + ", interface: [x_min, x_max]}}}\ninstances: {b: {component: block" +
         p.instance + "}}\nwalls: {" + p.walls + "}\nloads: [" + p.loads + "]\ncontact: [{" +
         p.contact + "}]\ntime: {end: " + text(p.end) + ", step: " + p.step +
         ", integrator: " + p.integrator + "}\noutput: {every: " + text(p.every) +
         ", history: [b.x_min, b.x_max]}\n" + p.more;
}

Ran run(const Block& p, const RunOptions& options = {}) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({p.n, p.size}));
  return folder.run(yaml(p), options);
}

std::string ramp(double traction, double time) {
  return "{instance: b, surface: x_max, traction: [" + text(-traction) +
         ", 0, 0], history: {time: [0, " + text(time) + "], value: [0, 1]}}";
}

std::size_t last(const Ran& ran) { return ran.result.time.size() - 1; }

// Of all outputs, what is beyond the first one's and the work of loads, as a share of the largest
// total.
double largest_gain(const Ran& ran) {
  double gain = 0, largest = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    gain = std::max(gain, ran.result.total[i] - ran.result.total[0] - ran.result.work_external[i]);
    largest = std::max(largest, ran.result.total[i]);
  }
  return gain / largest;
}

TEST(Statics, APressedBarHasTheForceAndTheCompressionOfStatics) {
  for (const char* integrator : {"exact", "central-difference", "newmark"}) {
    Block p;
    p.integrator = integrator;
    p.nu = 0;
    if (p.integrator == "newmark") p.step = "1.0e-3";
    p.loads = ramp(10, 2);
    p.end = 3;
    const Ran ran = run(p);
    // sigma L / E = 0.01, less the swinging that the corner of the ramp leaves
    EXPECT_NEAR(test::at(ran.monitor("b.x_max").mean_position, last(ran))[0], 1 - 0.01, 1e-4)
        << integrator;
    EXPECT_NEAR(test::at(ran.monitor("b.x_min").force, last(ran))[0], 10 * 0.25, 0.02 * 10 * 0.25)
        << integrator;
    EXPECT_LT(std::abs(test::at(ran.monitor("b.x_min").mean_position, last(ran))[0]), 1e-13)
        << integrator;
    EXPECT_LT(test::energy_residual(ran.result), 1e-10) << integrator;
    // Ten shapes, and whatever the floor does to 25 nodes
    EXPECT_LT(ran.built.simulation.bodies[0]->n_dofs(), 20 + 6 + 30);
  }
}

// At the critical step, a tenth and a thousandth of it: the rebound is that of the full interface,
// and energy never rises.
TEST(Statics, AFlatImpactLosesWhatItShould) {
  Block p;
  p.n = {8, 3, 3};
  p.instance = ", position: [0.01, 0, 0], velocity: [-1, 0, 0]";
  p.end = 0.12;
  p.every = 0.005;
  const auto rebound = [](const Ran& ran) {
    return test::at(ran.body("b").momentum, last(ran))[0] / -test::at(ran.body("b").momentum, 0)[0];
  };
  Block full = p;
  full.reduction = "modes: 20";
  const double expected = rebound(run(full));
  for (const char* integrator : {"exact", "central-difference", "newmark"}) {
    p.integrator = integrator;
    for (const double share : {1.0, 0.1, 0.001}) {
      p.step = "{cfl: " + text(share) + "}";
      const Ran ran = run(p);
      std::printf(
          "%-18s %g of the critical step: %ld steps, rebound %.4f (full interface %.4f), energy "
          "kept %.4f, gain %.1e\n",
          integrator, share, long(ran.result.steps), rebound(ran), expected,
          ran.result.total.back() / ran.result.total[0], largest_gain(ran));
      EXPECT_NEAR(rebound(ran), expected, 0.02) << integrator << share;
      EXPECT_LT(largest_gain(ran), 1e-3) << integrator << share;
      EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator << share;
    }
  }
}

// Blocks that strike each other, of every pair of kinds, node on face and mortar: momentum is kept,
// energy does not rise.
TEST(Statics, MeetsEveryKindOfBody) {
  const std::vector<std::string> kinds = {
      "reduction: {basis: characteristic, interface: [x_min, x_max], modes: 20}",
      "reduction: {basis: massless, interface: [x_min, x_max], modes: 60}",
      "reduction: {interface: [x_min, x_max], modes: 60}", ""};
  for (const char* integrator : {"exact", "central-difference", "newmark"}) {
    for (std::size_t b = 0; b < kinds.size(); ++b) {
      if (b == 1 && std::string(integrator) == "newmark") continue;
      for (const char* how : {"[{between: [a.x_max, b.x_min]}]",
                              "[{between: [a.x_max, b.x_min], formulation: mortar}]", "all"}) {
        SceneFolder folder;
        folder.add("a.exo", test::block_mesh({{10, 2, 2}, {1, 0.4, 0.4}}));
        folder.add("b.exo", test::block_mesh({{10, 3, 3}, {1, 0.4, 0.4}}));
        const auto component = [&](const char* name, const std::string& kind) {
          return std::string("  ") + name + ": {mesh: " + name + ".exo, material: m" +
                 (kind.empty() ? "" : ", " + kind) + "}\n";
        };
        const bool newmark = std::string(integrator) == "newmark";
        const Ran ran = folder.run(
            "materials: {m: {youngs_modulus: 100, poissons_ratio: 0, density: 1}}\ncomponents:\n" +
            component("a", kinds[0]) + component("b", kinds[b]) +
            "instances:\n  a: {component: a, velocity: [1, 0, 0]}\n  b: {component: b, position: "
            "[1.05, 0, "
            "0]}\ncontact: " +
            how + "\ntime: {end: 0.5, integrator: " + integrator +
            (newmark ? ", step: 1.0e-3" : "") +
            "}\noutput: {every: 0.01, history: [a.x_max, b.x_min]}\n");
        const std::string name = std::string(integrator) + " " + std::to_string(b) + " " + how;
        EXPECT_LT(test::energy_residual(ran.result), 1e-9) << name;
        double drift = 0;
        for (std::size_t i = 0; i < ran.result.time.size(); ++i)
          drift = std::max(drift, (test::at(ran.body("a").momentum, i) +
                                   test::at(ran.body("b").momentum, i) - Vector3(0.16, 0, 0))
                                      .norm());
        EXPECT_LT(drift, 1e-12) << name;
        const double left = test::at(ran.body("a").momentum, last(ran))[0] / 0.16,
                     right = test::at(ran.body("b").momentum, last(ran))[0] / 0.16;
        std::printf("%-70s speeds after the impact %.4f %.4f, energy %.4f\n", name.c_str(), left,
                    right, ran.result.total.back() / ran.result.total.front());
        EXPECT_NEAR(left, 0, 0.1) << name;
        EXPECT_NEAR(right, 1, 0.1) << name;
        EXPECT_LT(largest_gain(ran), b == 1 ? 0.01 : 1e-3) << name;
      }
    }
  }
}

// Held at one end, where no statics are: what is pressed at the other has the force and the strain
// of statics.
TEST(Statics, HeldNodesStayAndCarry) {
  Block p;
  p.nu = 0;
  p.contact = "between: [b.x_max, ceiling]";
  p.walls = "ceiling: {plane: {point: [1.005, 0, 0], normal: [-1, 0, 0]}}";
  p.more = "boundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\n";
  p.loads =
      "{instance: b, surface: x_max, traction: [20, 0, 0], history: {time: [0, 2], value: [0, 1]}}";
  p.end = 3;
  const Ran ran = run(p);
  EXPECT_LT(test::at(ran.monitor("b.x_min").mean_position, last(ran)).cwiseAbs()[0], 1e-13);
  EXPECT_NEAR(test::at(ran.monitor("b.x_max").mean_position, last(ran))[0], 1.005, 1e-12);
  // 20 of traction, of which E 0.005 / L = 5 strains the bar
  EXPECT_NEAR(test::at(ran.monitor("b.x_max").force, last(ran))[0], -15 * 0.25, 0.02 * 15 * 0.25);
  EXPECT_LT(test::energy_residual(ran.result), 1e-10);
}

// Turned, mirrored, in other units: the same to round-off.
TEST(Statics, DoNotDependOnAxesAndUnits) {
  const auto fall = [](const std::string& turn, const Matrix3& T, double metre, double kilogram) {
    SceneFolder folder;
    folder.add("block.exo", test::block_mesh({{4, 3, 2}, metre * Vector3(1, 0.7, 0.5)}));
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: " + text(1000 * kilogram / metre) +
        ", poissons_ratio: 0.3, density: " + text(kilogram / (metre * metre * metre)) +
        "}}\ncomponents: {c: {mesh: block.exo, material: m, reduction: {basis: characteristic, "
        "interface: [z_min], modes: 15}}}\n"
        "instances: {b: {component: c, " +
        turn + ", position: " + text(Vector3(T * Vector3(0, 0, 0.01 * metre))) +
        ", velocity: " + text(Vector3(T * Vector3(0.3, 0, -1) * metre)) +
        "}}\nwalls: {floor: {plane: {point: [0, 0, 0], normal: " + text(Vector3(T.col(2))) +
        "}}}\ncontact: [{between: [b.z_min, floor]}]\ntime: {end: 0.09, step: 1.0e-4}\n"
        "output: {every: 0.01, history: [b.z_min]}\n");
    std::vector<Vector3> positions;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      positions.push_back(T.transpose() * test::at(ran.monitor("b.z_min").mean_position, i) /
                          metre);
    return positions;
  };
  Instance instance;
  instance.rotation_degrees = {10, -35, 70};
  const Matrix3 turn = instance.transformation(), mirror = Vector3(-1, 1, 1).asDiagonal(),
                one = Matrix3::Identity();
  const auto plain = fall("rotation: [0, 0, 0]", one, 1, 1);
  const auto turned = fall("rotation: [10, -35, 70]", turn, 1, 1),
             mirrored = fall("mirror: x", mirror, 1, 1),
             units = fall("rotation: [0, 0, 0]", one, 1e3, 1e-3);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_LT((turned[i] - plain[i]).norm(), 1e-9) << i;
    EXPECT_LT((mirrored[i] - plain[i]).norm(), 1e-9) << i;
    EXPECT_LT((units[i] - plain[i]).norm(), 1e-9) << i;
  }
}

// From a checkpoint in the middle of contact a run goes on bit for bit.
TEST(Statics, GoOnFromACheckpointBitForBit) {
  Block p;
  p.n = {6, 3, 3};
  p.loads = ramp(10, 0.5);
  p.end = 0.4;
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({p.n, p.size}));
  std::vector<Index> words;
  RunOptions keep;
  Index steps = 0;
  keep.is_checkpoint = [&](Index, double t) { return steps == 0 && t > 0.2; };
  keep.on_checkpoint = [&](Index step, double, const StateArchive& of) {
    steps = step;
    words = of.words();
  };
  const Ran whole = folder.run(yaml(p), keep);
  ASSERT_GT(steps, 0);
  ASSERT_GT(test::at(whole.monitor("b.x_min").force, last(whole))[0], 0);
  StateArchive restart(words, "checkpoint");
  RunOptions from;
  from.restart = &restart;
  const Ran rest = folder.run(yaml(p), from);
  EXPECT_EQ(rest.monitor("b.x_min").mean_position.values,
            whole.monitor("b.x_min").mean_position.values);
  EXPECT_EQ(rest.monitor("b.x_min").force.values, whole.monitor("b.x_min").force.values);
  EXPECT_EQ(rest.result.total, whole.result.total);
}

struct Slid {
  // along the wall, of the speed along it before; of friction, of the energy before
  double momentum, work;
};

// A block is thrown on a wall and along it.
Slid thrown(const std::string& reduction, double share, Index refined) {
  Block p;
  p.n = {6 * refined, 4 * refined, 3 * refined};
  p.size = Vector3(1, 0.8, 0.6);
  p.contact += ", friction: 0.3";
  p.instance = ", position: [0.01, 0, 0], velocity: [-1, 0.3, 0]";
  p.end = 0.12;
  p.every = 0.12;
  p.step = "{cfl: " + text(share) + "}";
  p.reduction = reduction;
  if (reduction.empty()) {
    p.reduction = "modes: 1";
    p.instance += ", as: mesh";
    p.integrator = "central-difference";
  }
  const Ran ran = run(p);
  EXPECT_LT(test::energy_residual(ran.result), 1e-9) << reduction << share;
  EXPECT_LT(largest_gain(ran), 1e-3) << reduction << share;
  const Slid slid{
      test::at(ran.body("b").momentum, last(ran))[1] / test::at(ran.body("b").momentum, 0)[1],
      -ran.result.work_friction.back() / ran.result.total[0]};
  std::printf(
      "%-36s %6.3f of the critical step, mesh %ld: momentum along the wall %.4f, work of friction "
      "%.4f\n",
      reduction.c_str(), share, long(refined), slid.momentum, slid.work);
  return slid;
}

// Of what they converge to, momentum is as near to that of a finer mesh as the full interface's on
// the same one.
TEST(Statics, FrictionConvergesWithTheStep) {
  const Slid finest = thrown("", 1, 3), full = thrown("modes: 20", 0.0625, 1);
  for (const char* reduction :
       {"basis: characteristic, modes: 20", "basis: characteristic, modes: 60"}) {
    const Slid coarse = thrown(reduction, 1, 1), fine = thrown(reduction, 0.0625, 1),
               finer = thrown(reduction, 0.03125, 1);
    EXPECT_NEAR(coarse.momentum, finer.momentum, 0.025) << reduction;
    EXPECT_NEAR(fine.momentum, finer.momentum, 0.003) << reduction;
    EXPECT_NEAR(fine.work, finer.work, 0.0015) << reduction;
    EXPECT_LT(std::abs(finer.momentum - finest.momentum),
              std::abs(full.momentum - finest.momentum) + 1e-3)
        << reduction;
  }
}

// Friction pulls along the face: without its statics there, the answer would be one of the shapes'
// choice.
TEST(Statics, FrictionNeedsThoseAlongTheFace) {
  Block p;
  p.n = {4, 3, 3};
  p.end = 0.01;
  p.contact += ", friction: 0.3";
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({p.n, p.size}));
  folder.run(yaml(p));
  const auto file = folder.folder() / "block.cbr.h5";
  Superelement s = read_superelement(file);
  StaticShare& statics = s.characteristic.statics;
  ASSERT_EQ(statics.node.size(), 3 * 16U);
  std::vector<Index> normals;
  for (Index i = 0; i < 48; ++i)
    if (std::abs(statics.direction(i, 0)) == 1) normals.push_back(i);
  std::vector<Index> node;
  for (const Index i : normals) node.push_back(statics.node[i]);
  statics = {node,
             Points(statics.direction(normals, Eigen::all)),
             Matrix(statics.F(normals, normals)),
             {}};
  write_superelement(s, file);
  const std::string message = test::refusal_of([&] { folder.run(yaml(p)); });
  EXPECT_SAYS(message, "friction on b.x_min", "run cbr-reduce");
}

}  // namespace
}  // namespace cbr::statics_test
