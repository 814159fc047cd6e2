// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's cradle: a bar strikes a row of equal ones at rest. Waves go through joints that are
// closed and pressed as if they were not there; each bar stops when the wave in it has come back,
// and the last leaves with the speed of the first.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/bars.hpp"

namespace cbr::cradle_test {
namespace {

using test::Bar;
using test::BarScene;
using test::Ran;

constexpr double v = 1e-3;

struct Outcome {
  // errors of speeds as shares of v, of the centres of mass as a share of v 2 L / c
  double last, others, centres;
};

Outcome strike(bool mesh, const std::string& enforcement, double gap, Index n) {
  BarScene scene;
  for (int i = 0; i < 5; ++i) {
    Bar bar;
    bar.mesh = mesh;
    bar.n = n;
    bar.start = i * (1.0 + gap);
    scene.bars.push_back(bar);
  }
  scene.bars[0].velocity = v;
  scene.enforcement = enforcement;
  if (enforcement == "penalty") scene.step = "{cfl: 0.5}";
  scene.end = 1.2;
  scene.every = 0.01;
  const Ran ran = run(scene);
  EXPECT_LT(test::energy_residual(ran.result), 1e-10);
  const auto exact = test::waves(scene.bars, 0.01, scene.end);
  Outcome e{};
  double momentum = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    e.centres += test::error_of(ran.result, ran.body(test::name_of(i)).center_of_mass,
                                exact.centre[i], exact.dt, v * 0.2) /
                 5;
    (i < 4 ? e.others : e.last) =
        std::max(i < 4 ? e.others : 0, std::abs(test::speed_of(ran, i) / v - (i < 4 ? 0 : 1)));
    momentum += test::speed_of(ran, i) / v;
  }
  EXPECT_NEAR(momentum, 1, 1e-10);
  EXPECT_NEAR((exact.centre[4].back() - exact.centre[4][exact.centre[4].size() - 2]) / exact.dt, v,
              1e-9 * v);
  return e;
}

void expect_convergence(const char* name, bool mesh, const std::string& enforcement, double gap,
                        double order, double finest) {
  std::vector<double> h, last, centres;
  Outcome e{};
  for (const Index n : {10, 20, 40}) {
    e = strike(mesh, enforcement, gap, n);
    h.push_back(1 / double(n));
    last.push_back(e.last);
    centres.push_back(e.centres);
  }
  const double orders[] = {test::observed_order(h, last), test::observed_order(h, centres)};
  std::printf(
      "%-22s n 40: last bar's speed %.1e (order %.2f), the others' %.1e, centres %.1e (%.2f)\n",
      name, e.last, orders[0], e.others, e.centres, orders[1]);
  EXPECT_GT(std::min(orders[0], orders[1]), order) << name;
  EXPECT_LT(std::max({e.last, e.others, e.centres}), finest) << name;
}

TEST(Cradle, LastBarLeavesWithTheSpeedOfTheFirst) {
  expect_convergence("touching, mesh", true, "impulse", 0, 0.6, 0.03);
  expect_convergence("apart, mesh", true, "impulse", 0.1 * v, 0.6, 0.06);
  expect_convergence("touching, superelement", false, "impulse", 0, 0.6, 0.04);
  expect_convergence("apart, superelement", false, "impulse", 0.1 * v, 0.4, 0.08);
  expect_convergence("touching, penalty", true, "penalty", 0, 0.2, 0.03);
}

}  // namespace
}  // namespace cbr::cradle_test
