// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene does not need is not computed, and nothing changes by that: counts of work, and runs
// that skip against runs that look at every pair in every step.
#include <gtest/gtest.h>

#include <sstream>

#include "dynamics/contact/surfaces/pair_memory.hpp"
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

// A bar between two walls: it flies, hits, and flies on with its oscillations.
struct BetweenWalls {
  std::string what, material, contact, wall, loads, time;
};

std::string scene(const BetweenWalls& of, const std::string& reduction) {
  return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1" + of.material +
         "}}\ncomponents:\n"
         "  bar: {mesh: bar.exo, material: m, reduction: {interface: [x_min, x_max], modes: 12" +
         reduction +
         "}}\ninstances:\n"
         "  a: {component: bar, as: superelement, velocity: [0.02, 0.002, 0]}\n"
         "walls:\n  right: {plane: {point: [1.01, 0, 0], normal: [-1, 0, 0]}" +
         of.wall +
         "}\n  left: {plane: {point: [-0.01, 0, 0], normal: [1, 0, 0]}}\n"
         "contact:\n  - {between: [a.x_max, right]" +
         of.contact + "}\n  - {between: [a.x_min, left]" + of.contact + "}\n" + of.loads +
         "time: {end: 7" + of.time + "}\noutput: {every: 0.5, history: [a.x_max]}\n";
}

TEST(Skipping, AJumpAgesTheMemoryOfForces) {
  PairMemory memory;
  for (int i = 0; i < 4; ++i) memory.forces[i].setConstant(1, 3, i + 1.0);
  pass_without_force(3, memory);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(memory.forces[i](0, 0), i < 3 ? 0 : 1) << i;
}

// Near a wall a search finds points without contact. Jumps leave these steps out too.
TEST(Skipping, JumpsBeginAndEndNearWalls) {
  const BetweenWalls cases[] = {
      {"alone", "", "", "", "", ""},
      {"friction", "", ", friction: 0.3", "", "", ""},
      {"friction over slip", "", ", friction: {static: 0.3, kinetic: 0.1, decay: 100}", "", "", ""},
      {"gravity", "", "", "",
       "loads:\n  - {gravity: [0.01, 0, -0.02], history: {time: [0, 0.7, 30], value: [0, 1, "
       "-1]}}\n",
       ""},
      {"traction", ", damping: {beta: 0.02}", "", "",
       "loads:\n  - {instance: a, surface: x_max, traction: [0.01, 0, 0], history: {time: [0, 4, "
       "8], value: [0, 1, 0]}}\n",
       ""},
      {"damping", ", damping: {beta: 0.02}", "", "", "", ""},
      {"adjust", "", ", adjust: 0.002", "", "", ""},
      {"moving wall", "", "", ", velocity: [-0.001, 0, 0], history: {time: [0, 9], value: [0, 1]}",
       "", ""},
      {"long steps", "", "", "", "", ", step: {cfl: 2}"},
  };
  for (const std::string basis : {"", ", basis: characteristic", ", basis: massless"})
    for (const BetweenWalls& of : cases) {
      if (!of.time.empty() && basis != "") continue;
      SCOPED_TRACE(of.what + basis);
      const std::string text = scene(of, basis);
      const RunResult with = ran(text).result, without = ran(text, false).result;
      EXPECT_LT(difference(without, with), 1e-9);
      const double scale = without.total.front();
      EXPECT_NEAR(with.work_friction.back(), without.work_friction.back(), 1e-9 * scale);
      // A jump books the work of loads on the residual compliance, and of its damping, by its ends:
      // their sum is that of the steps
      const auto sum = [](const RunResult& of_run) {
        return of_run.work_contact.back() + of_run.work_damping.back() +
               of_run.work_external.back();
      };
      EXPECT_NEAR(sum(with), sum(without), 1e-9 * scale);
      if (of.what != "traction") {
        EXPECT_NEAR(with.work_contact.back(), without.work_contact.back(), 1e-9 * scale);
        EXPECT_NEAR(with.work_damping.back(), without.work_damping.back(), 1e-9 * scale);
      }
      const auto &x = with.monitors[0].mean_velocity.values,
                 &y = without.monitors[0].mean_velocity.values;
      double v = 0;
      for (std::size_t i = 0; i < x.size(); ++i) v = std::max(v, std::abs(x[i] - y[i]));
      EXPECT_LT(v, 1e-9 * 0.02);
      EXPECT_LT(with.steps, 6 * without.steps / 10);
    }
}

}  // namespace
}  // namespace cbr::skipping_test
