// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark's method and HHT-alpha on bodies under a smooth load, against the exact motion of the
// same spatial model: order 2.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::newmark_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A free bar, 1 x 0.25 x 0.25, c = 10: its slowest swing takes 0.2, and so does the pull at its
// end; then it is left alone.
constexpr double pull_time = 0.2, end = 0.5;

struct Way {
  std::string as = "superelement", mass = "consistent", integrator = "exact";
  double alpha = 0;
  std::string step = "auto";
  std::string reduction = "modes: 189";  // all
};

std::string scene(const Way& way) {
  std::string time, value;
  constexpr int n = 2000;
  for (int i = 0; i <= n; ++i) {
    const double s = double(i) / n;
    time += (i ? ", " : "") + text(s * pull_time);
    value += (i ? ", " : "") + text(std::pow(std::sin(std::numbers::pi * s), 2));
  }
  return "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}\ncomponents:\n"
         "  bar: {mesh: bar.exo, material: soft, mass: " +
         way.mass +
         (way.as == "mesh" ? ""
                           : ", reduction: {interface: [x_min, x_max], " + way.reduction + "}") +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as +
         "}\nloads:\n  - {instance: bar, surface: x_max, traction: [0.5, 0.1, 0.02], history: "
         "{time: [" +
         time + "], value: [" + value + "]}}\ntime: {end: " + text(end) + ", step: " + way.step +
         ", integrator: " + way.integrator + (way.alpha != 0 ? ", alpha: " + text(way.alpha) : "") +
         "}\noutput: {every: " + text(0.02) + ", history: [bar.x_min, bar.x_max]}\n";
}

void add_mesh(SceneFolder& folder) {
  folder.add("bar.exo", test::block_mesh({{8, 2, 2}, {1, 0.25, 0.25}}));
}

// Largest difference of the ends' positions and velocities over time, as shares of the largest
// displacement and velocity.
struct Difference {
  double position = 0, velocity = 0;
};
Difference difference(const Ran& a, const Ran& b) {
  Difference d;
  double x_scale = 0, v_scale = 0;
  for (const char* surface : {"bar.x_min", "bar.x_max"}) {
    const auto &m = a.monitor(surface), &n = b.monitor(surface);
    EXPECT_EQ(a.result.time.size(), b.result.time.size());
    for (std::size_t i = 0; i < a.result.time.size(); ++i) {
      d.position = std::max(d.position, (at(m.mean_position, i) - at(n.mean_position, i)).norm());
      d.velocity = std::max(d.velocity, (at(m.mean_velocity, i) - at(n.mean_velocity, i)).norm());
      x_scale = std::max(x_scale, (at(n.mean_position, i) - at(n.mean_position, 0)).norm());
      v_scale = std::max(v_scale, at(n.mean_velocity, i).norm());
    }
  }
  d.position /= x_scale;
  d.velocity /= v_scale;
  return d;
}

Way newmark(Way way, double alpha, const std::string& step) {
  way.integrator = "newmark";
  way.alpha = alpha;
  way.step = step;
  return way;
}

void expect_second_order(SceneFolder& folder, const Way& way, const Ran& exact) {
  for (const double alpha : {0.0, -0.1}) {
    std::vector<double> h, x, v;
    for (const int steps : {500, 1000, 2000}) {
      const Ran ran = folder.run(scene(newmark(way, alpha, text(end / steps * (1 + 1e-10)))));
      EXPECT_LT(test::energy_residual(ran.result), 1e-11);
      if (alpha == 0) {
        EXPECT_EQ(ran.result.work_numerical.back(), 0);
      } else {
        EXPECT_LT(ran.result.work_numerical.back(), 0);
      }
      const Difference d = difference(ran, exact);
      h.push_back(end / steps);
      x.push_back(d.position);
      v.push_back(d.velocity);
    }
    std::printf(
        "%-12s %-10s %-20s alpha %4.1f, h = T / 800: positions %.1e (order %.2f), velocities %.1e "
        "(%.2f)\n",
        way.as.c_str(), way.mass.c_str(), way.reduction.c_str(), alpha, x.back(),
        test::observed_order(h, x), v.back(), test::observed_order(h, v));
    EXPECT_GT(test::observed_order(h, x), 1.9);
    EXPECT_GT(test::observed_order(h, v), 1.9);
    EXPECT_LT(x.back(), 1e-3);
  }
}

TEST(Newmark, SuperelementIsOfSecondOrder) {
  SceneFolder folder;
  add_mesh(folder);
  for (const char* mass : {"consistent", "lumped"}) {
    SceneFolder own;
    add_mesh(own);
    const Way way{.mass = mass};
    expect_second_order(own, way, own.run(scene(way)));
  }
  const Way few{.reduction = "modes: 12"};
  expect_second_order(folder, few, folder.run(scene(few)));
}

// A mesh, and domains that keep all their modes, are the superelement with all of its: under
// Newmark too.
TEST(Newmark, MeshesAndGroupsAreTheSuperelement) {
  for (const char* mass : {"consistent", "lumped"}) {
    SceneFolder folder, parts;
    add_mesh(folder);
    add_mesh(parts);
    const Way whole{.mass = mass}, mesh{.as = "mesh", .mass = mass},
        group{.mass = mass, .reduction = "domains: 3, modes: 500"};
    const Ran exact = folder.run(scene(whole));
    expect_second_order(folder, mesh, exact);
    expect_second_order(parts, group, exact);
    for (const double alpha : {0.0, -0.1})
      for (const double steps : {100.0, 1000.0}) {
        const std::string h = text(end / steps * (1 + 1e-10));
        const Ran one = folder.run(scene(newmark(whole, alpha, h)));
        const Difference of_mesh = difference(folder.run(scene(newmark(mesh, alpha, h))), one),
                         of_group = difference(parts.run(scene(newmark(group, alpha, h))), one);
        std::printf("%s, alpha %4.1f, %4.0f steps: mesh %.1e, %.1e; group %.1e, %.1e\n", mass,
                    alpha, steps, of_mesh.position, of_mesh.velocity, of_group.position,
                    of_group.velocity);
        EXPECT_LT(std::max(of_mesh.position, of_mesh.velocity), 1e-9);
        EXPECT_LT(std::max(of_group.position, of_group.velocity), 1e-9);
      }
  }
}

}  // namespace
}  // namespace cbr::newmark_test
