// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene does not need is not computed, and nothing changes by that: counts of work, and runs
// that skip against runs that look at every pair in every step.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/scene_run.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::skipping_test {
namespace {

using test::Ran;
using test::SceneFolder;

// Bars of one component: a flies into b; the others stand, or fly, around them, apart from each
// other.
std::string scene(int others, const std::string& velocity, double end, double every,
                  double gap = 0.05) {
  std::ostringstream text;
  text << "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
          "components:\n  bar: {mesh: bar.exo, material: m, reduction: {interface: [x_min, x_max], "
          "modes: 12}}\n"
          "instances:\n  a: {component: bar, as: superelement, velocity: [0.3, 0, 0]}\n"
          "  b: {component: bar, as: superelement, position: ["
       << 1 + gap << ", 0.01, 0.02]}\n";
  for (int i = 0; i < others; ++i)
    text << "  o" << i << ": {component: bar, as: superelement, position: [" << 1.7 * (i % 3 - 1)
         << ", " << 2 + i / 3 << ", 0], "
         << "velocity: " << velocity << "}\n";
  text << "contact: all\ntime: {end: " << end << "}\noutput: {every: " << every
       << ", history: [a.x_max, b.x_min]}\n";
  return text.str();
}

Ran ran(const std::string& text, bool jumps = true) {
  SceneFolder folder;
  folder.add("bar.exo", test::brick({4, 2, 2}, Vector3(1, 0.5, 0.5)));
  RunOptions options;
  options.jumps = jumps;
  return folder.run(text, options);
}

// Largest difference of momenta, centres of mass and energies, relative.
double difference(const RunResult& a, const RunResult& b) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const auto of = [](const std::vector<double>& x) {
      return Eigen::Map<const Vector>(x.data(), static_cast<Index>(x.size()));
    };
    const auto compare = [&](const std::vector<double>& x, const std::vector<double>& y) {
      worst = std::max(worst, (of(x) - of(y)).cwiseAbs().maxCoeff());
      scale = std::max(scale, of(x).cwiseAbs().maxCoeff());
    };
    compare(a.bodies[i].momentum.values, b.bodies[i].momentum.values);
    compare(a.bodies[i].center_of_mass.values, b.bodies[i].center_of_mass.values);
    compare(a.bodies[i].angular_momentum.values, b.bodies[i].angular_momentum.values);
    compare(a.bodies[i].strain_energy, b.bodies[i].strain_energy);
  }
  return worst / scale;
}

TEST(Skipping, BodiesThatStandAsideAreNotStepped) {
  const Ran two = ran(scene(0, "", 1, 0.05)), many = ran(scene(9, "[0, 0, 0]", 1, 0.05));
  ASSERT_EQ(many.result.pairs.size(), 55u);
  ASSERT_GT(two.result.contact_steps, 10);
  EXPECT_EQ(many.result.work.body_steps, two.result.work.body_steps);
  EXPECT_EQ(many.result.work.pair_searches, two.result.work.pair_searches);
  EXPECT_EQ(many.result.work.bounds, two.result.work.bounds);
  // One comparison for each of the others and body that is pushed, in steps with contact; each pair
  // at the start
  EXPECT_LE(many.result.work.pair_looks,
            two.result.work.pair_looks + 2 * 9 * two.result.steps + 55);
  Index written = 0;
  for (const auto& pair : many.result.pairs) written += !pair.empty();
  EXPECT_EQ(written, 1);
  for (const ContactPair& pair : many.built.simulation.pairs)
    EXPECT_EQ(pair.has_state(), pair.name == "a.all - b.all") << pair.name;
}

TEST(Skipping, BodiesThatFlyAsideAreAdvancedAtOutputs) {
  const Ran two = ran(scene(0, "", 1, 0.05)), many = ran(scene(9, "[0, 0.1, 0]", 1, 0.05));
  EXPECT_LE(many.result.work.body_steps, two.result.work.body_steps + 9 * 20);
  EXPECT_EQ(many.result.work.pair_searches, two.result.work.pair_searches);
}

TEST(Skipping, ChangesNothing) {
  // Into what stood aside: two of the others fly into a and b while these part, and one stands in
  // the way of b
  std::string text = scene(3, "[0, -1.2, 0]", 2.5, 0.05);
  text.replace(
      text.find(
          "o2: {component: bar, as: superelement, position: [1.7, 2, 0], velocity: [0, -1.2, 0]"),
      std::string(
          "o2: {component: bar, as: superelement, position: [1.7, 2, 0], velocity: [0, -1.2, 0]")
          .size(),
      "o2: {component: bar, as: superelement, position: [2.2, 0.02, 0.01]");
  const Ran with = ran(text), without = ran(text, false);
  EXPECT_LT(difference(without.result, with.result), 1e-10);
  EXPECT_LT(with.result.work.pair_searches, without.result.work.pair_searches / 3);
  EXPECT_LT(with.result.work.body_steps, without.result.work.body_steps);
  Index met = 0;
  for (const auto& pair : with.result.pairs)
    met += !pair.empty() &&
           *std::max_element(pair["active"].values.begin(), pair["active"].values.end()) > 0;
  EXPECT_GE(met, 2);
  for (const auto& pair : with.result.pairs) {
    if (pair.empty()) continue;
    EXPECT_EQ(pair["active"].values.size(), with.result.time.size());
  }
}

TEST(Skipping, InstancesHeldInTheSameWayShareADiagonalForm) {
  const auto blocks = [](const std::string& of_b) {
    const Ran held = ran(
        scene(0, "", 0.05, 0.05) +
        "boundary:\n  - {instance: a, nodes: x_min, fix: [x, y, z]}\n  - {instance: b, nodes: " +
        of_b + ", fix: [x, y, z]}\n");
    const Simulation& sim = held.built.simulation;
    return std::pair(sim.bodies[0]->response(sim.contact_nodes[0].set, 0.01).block,
                     sim.bodies[1]->response(sim.contact_nodes[1].set, 0.01).block);
  };
  const auto same = blocks("x_min"), other = blocks("x_max");
  EXPECT_EQ(same.first.get(), same.second.get());
  EXPECT_NE(other.first.get(), other.second.get());
}

TEST(Skipping, AFlightTenTimesAsLongTakesTheSameSteps) {
  // The same impact after a flight of the same time, and after one ten times as long
  const Ran brief = ran(scene(0, "", 1.4, 0.1, 0.06)),
            far = ran(scene(0, "", 1.4 + 1.8, 0.1, 0.06 + 0.54));
  ASSERT_GT(brief.result.contact_steps, 10);
  EXPECT_NEAR(static_cast<double>(far.result.contact_steps),
              static_cast<double>(brief.result.contact_steps), 2);
  // The outputs on the way, two bodies each, and some looks at the pair
  EXPECT_LE(far.result.work.body_steps, brief.result.work.body_steps + 2 * 18 + 12);
  EXPECT_LE(far.result.work.bounds, brief.result.work.bounds + 6);
}

}  // namespace
}  // namespace cbr::skipping_test
