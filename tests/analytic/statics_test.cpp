// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic with the statics of the faces that touch, from reduction to run: pressed
// bodies carry what statics says, impacts lose what they should, and nothing depends on axes,
// units, partners or restarts.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/superelement/superelement.hpp"
#include "tests/support/pressed_bar.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::statics_test {
namespace {

using test::PressedBar;
using test::Ran;
using test::SceneFolder;
using test::text;

// Both ends are kept; statics are of those that the scene's contact names.
const PressedBar block{.reduction = "basis: characteristic, modes: 20",
                       .nu = 0.3,
                       .n = {12, 4, 4},
                       .size = {1, 0.5, 0.5}};

std::size_t last(const Ran& ran) { return ran.result.time.size() - 1; }

// At the critical step, a tenth and a thousandth of it: the rebound is that of the full interface,
// and energy never rises.
TEST(Statics, AFlatImpactLosesWhatItShould) {
  PressedBar p = block;
  p.n = {8, 3, 3};
  p.instance = ", position: [0.01, 0, 0], velocity: [-1, 0, 0]";
  p.end = 0.12;
  p.every = 0.005;
  const auto rebound = [](const Ran& ran) {
    return test::at(ran.body("b").momentum, last(ran))[0] / -test::at(ran.body("b").momentum, 0)[0];
  };
  PressedBar full = p;
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
          ran.result.total.back() / ran.result.total[0], test::largest_gain(ran));
      EXPECT_NEAR(rebound(ran), expected, 0.02) << integrator << share;
      EXPECT_LT(test::largest_gain(ran), 1e-3) << integrator << share;
      EXPECT_LT(test::energy_residual(ran.result), 1e-9) << integrator << share;
    }
  }
}

// From a checkpoint in the middle of contact a run goes on bit for bit.
TEST(Statics, GoOnFromACheckpointBitForBit) {
  PressedBar p = block;
  p.n = {6, 3, 3};
  p.loads = test::ramp(10, 0.5);
  p.end = 0.4;
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({p.n, p.size}));
  const test::RestartedRun runs = test::restarted(folder, yaml(p), 0.2);
  ASSERT_GT(test::at(runs.whole.monitor("b.x_min").force, last(runs.whole))[0], 0);
  test::expect_same_bits(runs);
}

struct Slid {
  // along the wall, of the speed along it before; of friction, of the energy before
  double momentum, work;
};

// A block is thrown on a wall and along it.
Slid thrown(const std::string& reduction, double share, Index refined) {
  PressedBar p = block;
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
  EXPECT_LT(test::largest_gain(ran), 1e-3) << reduction << share;
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
  PressedBar p = block;
  p.n = {4, 3, 3};
  p.end = 0.01;
  p.contact += ", friction: 0.3";
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({p.n, p.size}));
  folder.run(yaml(p));
  const auto file = folder.folder() / "bar.cbr.h5";
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
