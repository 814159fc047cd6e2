// SPDX-License-Identifier: GPL-3.0-or-later
// Ten blocks upon each other on a rigid floor. Gravity grows slowly from nothing, so that they come
// to rest in their own sag, and stays for many steps: each joint bears the weight above it, nothing
// overlaps, drifts or gains energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/support/scene_run.hpp"

namespace cbr::stack_test {
namespace {

using test::at;
using test::Ran;
using test::text;

constexpr int n_blocks = 10;
constexpr double E = 1e9, rho = 1000, g = 10, c = 1000;  // cubes of 1: strains of 1e-4
constexpr double swing = 4 * n_blocks / c;               // the column's longest period

struct Way {
  const char* name;
  bool mesh;
  Index even, odd;  // elements along the edges of every other block
  std::string contact;
  double ramp;         // how long gravity grows, and then stays, in swings
  double overlap = 0;  // of neighbours at the start
};

struct Limits {
  double reactions, unrest, sideways, overlap, gain;
};

Ran stack(const Way& way) {
  const double ramp = way.ramp * swing;
  test::SceneFolder folder;
  folder.add("even.exo", test::block_mesh({{way.even, way.even, 2}}));
  folder.add("odd.exo", test::block_mesh({{way.odd, way.odd, 2}}));
  std::string scene =
      "materials: {m: {youngs_modulus: " + text(E) +
      ", poissons_ratio: 0.3, density: " + text(rho) +
      "}}\nwalls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\ncomponents:\n";
  for (const char* name : {"even", "odd"})
    scene +=
        std::string("  ") + name + ": {mesh: " + name + ".exo, material: m" +
        (way.mesh ? ""
                  : ", reduction: {basis: craig-bampton, interface: [z_min, z_max], modes: 6}") +
        "}\n";
  std::string instances = "instances:\n", contact = "contact:\n", history;
  for (int i = 0; i < n_blocks; ++i) {
    const std::string name = "b" + std::to_string(i);
    instances += "  " + name + ": {component: " + (i % 2 ? "odd" : "even") +
                 ", as: " + (way.mesh ? "mesh" : "superelement") +
                 ", position: " + text(Vector3(0, 0, i - (i + 1) * way.overlap)) + "}\n";
    contact += "  - {between: [" + name + ".z_min, " +
               (i == 0 ? "floor" : "b" + std::to_string(i - 1) + ".z_max") + "]" + way.contact +
               "}\n";
    history += (i > 0 ? ", " : "") + name + ".z_max";
  }
  scene += instances + contact + "loads: [{gravity: [0, 0, " + text(-g) +
           "], history: {time: [0, " + text(ramp) +
           "], value: [0, 1]}}]\ntime: {end: " + text(2 * ramp) +
           ", step: {cfl: 0.9}}\noutput: {every: " + text(swing / 80) + ", history: [" + history +
           "]}\n";
  return folder.run(scene);
}

double mean(const std::vector<double>& values, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t k = from; k < to; ++k) sum += values[k];
  return sum / double(to - from);
}

void expect_rest(const Way& way, const Limits& limits) {
  const Ran ran = stack(way);
  const RunResult& r = ran.result;
  EXPECT_LT(test::energy_residual(r), 1e-10);
  const std::size_t end = r.time.size();
  std::size_t first = 0;  // of full gravity
  while (r.time[first] < way.ramp * swing * (1 + 1e-9)) ++first;
  double reactions = 0, unrest = 0, overlap = 0, sideways = 0;
  for (int i = 0; i < n_blocks; ++i) {
    const double weight = (n_blocks - i) * rho * g, sag = 0.5 * rho * g * n_blocks * n_blocks / E;
    Vector3 force = Vector3::Zero();
    for (std::size_t k = first; k < end; ++k) {
      force += at(r.pairs[i]["force"], k) / double(end - first);
      unrest = std::max(unrest, std::abs(at(r.pairs[i]["force"], k)[2] / weight - 1));
    }
    reactions = std::max(reactions, (force - Vector3(0, 0, weight)).norm() / weight);
    overlap = std::max(overlap, *std::max_element(r.pairs[i]["penetration"].values.begin(),
                                                  r.pairs[i]["penetration"].values.end()) /
                                    sag);
    const auto& x = r.monitors[i].mean_position;
    for (std::size_t k = 0; k < end; ++k)
      sideways = std::max(sideways, (at(x, k) - at(x, 0)).head<2>().norm() / sag);
  }
  // Gain of energy, that of the weight included, from the first to the last quarter of the time of
  // full gravity
  const std::size_t quarter = (end - first) / 4;
  const double gain =
      (mean(r.work_contact, end - quarter, end) - mean(r.work_contact, first, first + quarter)) /
      r.work_external.back();
  std::printf(
      "%-30s %5ld steps: reactions %.1e, unrest %.1e, sideways %.1e and overlap %.1e of the sag, "
      "energy gained %.1e\n",
      way.name, long(r.steps), reactions, unrest, sideways, overlap, gain);
  EXPECT_LT(reactions, limits.reactions) << way.name;
  EXPECT_LT(unrest, limits.unrest) << way.name;
  EXPECT_LT(sideways, limits.sideways) << way.name;
  EXPECT_LT(overlap, limits.overlap) << way.name;
  EXPECT_LT(gain, limits.gain) << way.name;
}

// Overlap is that of all nodes and edges. Constraints are linear in a step, and normals turn by the
// strain: that is of second order. Of meshes that do not match nodes go in between those that hold.
//
// Without friction the least sideways push would make the stack slide: a node on the corner of four
// faces that lean by about the strain must take no face's side.
TEST(Stack, TenBlocksRest) {
  expect_rest({"mesh", true, 2, 2, "", 12.5}, {3e-3, 0.07, 1e-8, 1e-5, 1e-9});
  expect_rest({"superelement", false, 2, 2, "", 12.5}, {3e-3, 0.07, 1e-8, 1e-5, 1e-3});
  expect_rest({"superelement, non-matching", false, 2, 3, "", 12.5},
              {3e-3, 0.07, 1e-8, 0.03, 1e-3});
  expect_rest({"mesh, penalty", true, 2, 2, ", enforcement: penalty", 12.5},
              {3e-3, 0.07, 1e-5, 1, 0.02});
}

// Overlaps, and gaps, at the start that count as closed change nothing.
TEST(Stack, AdjustedAtTheStart) {
  expect_rest({"overlap, adjusted", true, 2, 2, ", adjust: 1.0e-3", 12.5, 5e-4},
              {3e-3, 0.07, 1e-8, 1e-5, 1e-9});
  expect_rest({"gap, adjusted", false, 2, 3, ", adjust: 1.0e-3", 12.5, -5e-4},
              {3e-3, 0.07, 1e-8, 1e-5, 1e-3});
}

TEST(Stack, TenBlocksRestWithFriction) {
  expect_rest({"mesh, friction", true, 2, 2, ", friction: 0.3", 12.5},
              {3e-3, 0.07, 1e-7, 1e-5, 1e-9});
  expect_rest({"superelement, friction", false, 2, 2, ", friction: 0.3", 12.5},
              {3e-3, 0.07, 1e-7, 1e-5, 1e-3});
}

}  // namespace
}  // namespace cbr::stack_test
