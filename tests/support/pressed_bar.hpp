// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of any basis that every test of a basis in contact has: a bar against a wall, bars that
// strike each other, a block that falls.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::test {

// A bar along x whose lowest corner is the origin; both ends are kept.
struct PressedBar {
  std::string reduction, integrator = "exact", step = "auto", contact = "between: [b.x_min, floor]",
                         instance = {}, loads = {}, more = {};
  std::string walls = "floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}";
  double end = 1, every = 0.01, nu = 0;
  std::array<Index, 3> n{16, 6, 6};
  Vector3 size{1, 0.25, 0.25};

  double area() const { return size[1] * size[2]; }
};

inline std::string yaml(const PressedBar& p) {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: " + text(p.nu) +
         ", density: 1}}\ncomponents: {bar: {mesh: bar.exo, material: m, reduction: {" +
         p.reduction + ", interface: [x_min, x_max]}}}\ninstances: {b: {component: bar" +
         p.instance + "}}\nwalls: {" + p.walls + "}\nloads: [" + p.loads + "]\ncontact: [{" +
         p.contact + "}]\ntime: {end: " + text(p.end) + ", step: " + p.step +
         ", integrator: " + p.integrator + "}\noutput: {every: " + text(p.every) +
         ", history: [b.x_min, b.x_max]}\n" + p.more;
}

inline Ran run(const PressedBar& p) {
  SceneFolder folder;
  folder.add("bar.exo", block_mesh({p.n, p.size}));
  return folder.run(yaml(p));
}

// A pressure that grows over many periods and stays.
inline std::string ramp(double traction, double time) {
  return "{instance: b, surface: x_max, traction: [" + text(-traction) +
         ", 0, 0], history: {time: [0, " + text(time) + "], value: [0, 1]}}";
}

inline double worst_residual(const Ran& ran) {
  double residual = 0;
  for (const auto& pair : ran.result.pairs)
    for (const double value : pair["residual"].values) residual = std::max(residual, value);
  return residual;
}

// Of all outputs, what is beyond the first one's and the work of loads, as a share of the largest
// total.
inline double largest_gain(const Ran& ran) {
  double gain = 0, largest = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    gain = std::max(gain, ran.result.total[i] - ran.result.total[0] - ran.result.work_external[i]);
    largest = std::max(largest, ran.result.total[i]);
  }
  return gain / largest;
}

// A bar a of length 1 flies into a bar b; kinds: what is in their components beside mesh and
// material.
struct Strike {
  std::string kind_a, kind_b, contact = "[{between: [a.x_max, b.x_min]}]", time = {};
  Index n = 20, across_a = 1, across_b = 2;
  double width = 0.2, nu = 0, every = 0.01;
};

struct Struck {
  Ran ran;
  double left = 0;  // speed of a afterwards
};

// Momentum stays at every output: the speed of b is 1 - left.
inline Struck run(const Strike& p, const std::string& name) {
  SceneFolder folder;
  folder.add("a.exo", block_mesh({{p.n, p.across_a, p.across_a}, {1, p.width, p.width}}));
  folder.add("b.exo", block_mesh({{p.n, p.across_b, p.across_b}, {1, p.width, p.width}}));
  const auto component = [](const std::string& of, const std::string& kind) {
    return "  " + of + ": {mesh: " + of + ".exo, material: m" + (kind.empty() ? "" : ", ") + kind +
           "}\n";
  };
  Struck struck{folder.run(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: " + text(p.nu) +
      ", density: 1}}\ncomponents:\n" + component("a", p.kind_a) + component("b", p.kind_b) +
      "instances:\n  a: {component: a, velocity: [1, 0, 0]}\n  b: {component: b, position: [1.05, "
      "0, 0]}\ncontact: " +
      p.contact + "\ntime: {end: 0.5" + p.time + "}\noutput: {every: " + text(p.every) +
      ", history: [a.x_max, b.x_min]}\n")};
  const RunResult& result = struck.ran.result;
  const double mass = p.width * p.width;
  const auto &a = struck.ran.body("a").momentum, &b = struck.ran.body("b").momentum;
  double drift = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i)
    drift = std::max(drift, (at(a, i) + at(b, i) - Vector3(mass, 0, 0)).norm());
  EXPECT_LT(drift, 2.5e-12 * mass) << name;
  struck.left = at(a, result.time.size() - 1)[0] / mass;
  return struck;
}

// A block that is thrown onto a floor at its z_min, as a whole turned by T (whose text is `turn`),
// in other units. contact: ", friction: 0.3", or nothing.
struct Fall {
  std::string reduction, contact = {}, turn = "rotation: [0, 0, 0]";
  Matrix3 T = Matrix3::Identity();
  double end = 0.09, metre = 1, kilogram = 1;
};

// The mean position of the lowest face at the outputs, turned and scaled back.
inline std::vector<Vector3> run(const Fall& p) {
  SceneFolder folder;
  folder.add("block.exo", block_mesh({{4, 3, 2}, p.metre * Vector3(1, 0.7, 0.5)}));
  const Ran ran = folder.run(
      "materials: {m: {youngs_modulus: " + text(1000 * p.kilogram / p.metre) +
      ", poissons_ratio: 0.3, density: " + text(p.kilogram / (p.metre * p.metre * p.metre)) +
      "}}\ncomponents: {c: {mesh: block.exo, material: m, reduction: {" + p.reduction +
      ", interface: [z_min]}}}\ninstances: {b: {component: c, " + p.turn +
      ", position: " + text(Vector3(p.T * Vector3(0, 0, 0.01 * p.metre))) +
      ", velocity: " + text(Vector3(p.T * Vector3(0.3, 0, -1) * p.metre)) +
      "}}\nwalls: {floor: {plane: {point: [0, 0, 0], normal: " + text(Vector3(p.T.col(2))) +
      "}}}\ncontact: [{between: [b.z_min, floor]" + p.contact + "}]\ntime: {end: " + text(p.end) +
      ", step: 1.0e-4}\noutput: {every: 0.01, history: [b.z_min]}\n");
  if (!p.contact.empty()) EXPECT_LT(ran.result.work_friction.back(), 0);
  std::vector<Vector3> positions;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i)
    positions.push_back(p.T.transpose() * at(ran.monitor("b.z_min").mean_position, i) / p.metre);
  return positions;
}

// Turned, mirrored, in other units: the same to round-off.
inline void expect_the_same_in_other_axes_and_units(const Fall& plain) {
  Instance turned;
  turned.rotation_degrees = {10, -35, 70};
  Fall turn = plain, mirror = plain, units = plain;
  turn.turn = "rotation: [10, -35, 70]";
  turn.T = turned.transformation();
  mirror.turn = "mirror: x";
  mirror.T = Vector3(-1, 1, 1).asDiagonal();
  units.metre = 1e3;
  units.kilogram = 1e-3;
  const std::vector<Vector3> expected = run(plain);
  for (const Fall& other : {turn, mirror, units}) {
    const std::vector<Vector3> found = run(other);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_LT((found[i] - expected[i]).norm(), 1e-9) << other.turn << " " << i;
  }
}

}  // namespace cbr::test
