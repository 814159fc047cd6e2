// SPDX-License-Identifier: GPL-3.0-or-later
// The bouncing bar of Doyen, Ern, Piperno (SIAM J. Sci. Comput. 33, 2011, doi 10.1137/100791440):
// an elastic bar of L = 10, E = 900, rho = 1 falls by 5 under g = 10 onto a rigid wall, and its
// motion repeats itself after T = 16/3. With c = 30 and z = (c s / L) mod 2 the end that touches is
// at (times within a period)
//   [0, 1]        5 - 5 t^2                                    falling, no strain
//   [1, 5/3]      0                                            the wave goes up and comes back
//   [5/3, 11/3]   5 - 5 (s - 1)^2 + (g L^2 / c^2) z (z - 2),   s = t - 5/3: flying, and swinging
//   about what gravity bent it to [11/3, 13/3]  0                                            the
//   first contact run backwards [13/3, 16/3]  5 - 5 (t - 16/3)^2
// The force in the first contact grows linearly from 300 to 500 per area: an impulse of 800 / 3.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/bars.hpp"

namespace cbr::bouncing_bar_test {
namespace {

using test::Bar;
using test::BarScene;
using test::Ran;

constexpr double period = 16.0 / 3, height = 5, gravity = 10;

double end_position(double time) {
  const double t = std::fmod(time, period);
  if (t < 1) return height - 5 * t * t;
  if (t < 5.0 / 3) return 0;
  if (t < 11.0 / 3) {
    const double s = t - 5.0 / 3, z = std::fmod(3 * s, 2.0);
    return height - 5 * (s - 1) * (s - 1) + 10.0 / 9 * z * (z - 2);
  }
  if (t < 13.0 / 3) return 0;
  return height - 5 * (t - period) * (t - period);
}

struct Way {
  const char* name;
  bool mesh;
  const char *integrator, *enforcement;
  Index modes = -1;
};

struct Outcome {
  double first, ten;   // rms error of the end over one period and ten, as a share of the height
  double impulse;      // relative error of the first impact's
  double lost_first;   // energy, in one period
  double energy_kept;  // after ten periods
  double penetration;  // largest, as a share of the height
};

Outcome drop(const Way& way, Index n) {
  BarScene scene;
  Bar bar;
  bar.length = 10;
  bar.youngs_modulus = 900;
  bar.n = n;
  bar.width = 0.5;
  bar.start = height;
  bar.mesh = way.mesh;
  bar.modes = way.modes;
  scene.bars = {bar};
  scene.integrator = way.integrator;
  if (std::string(way.enforcement) == "penalty") scene.step = "{cfl: 0.5}";
  scene.end = 10 * period;
  scene.every = period / 160;
  scene.extra =
      "walls: {floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\nloads: [{gravity: [-10, 0, "
      "0]}]\n"
      "contact: [{between: [b0.x_min, floor], enforcement: " +
      std::string(way.enforcement) + "}]\n";
  const Ran ran = run(scene);
  EXPECT_LT(test::energy_residual(ran.result), 1e-10);
  Outcome outcome{};
  const auto& x = ran.monitor("b0.x_min").mean_position;
  std::size_t n_first = 0, n_all = ran.result.time.size();
  double sum = 0;
  const Vector3 P0 = test::at(ran.body("b0").momentum, 0);
  for (std::size_t i = 0; i < n_all; ++i) {
    sum += std::pow((test::at(x, i)[0] - end_position(ran.result.time[i])) / height, 2);
    if (ran.result.time[i] > period * (1 + 1e-9)) continue;
    n_first = i + 1;
    outcome.lost_first = -ran.result.work_contact[i] / (bar.mass() * gravity * height);
    outcome.first = std::sqrt(sum / double(n_first));
    // Between the contacts momentum is the impulse less what gravity took
    if (std::abs(ran.result.time[i] - 8.0 / 3) < 1e-9)
      outcome.impulse =
          (test::at(ran.body("b0").momentum, i) - P0)[0] / bar.area() + gravity * 10 * 8 / 3;
  }
  outcome.impulse = std::abs(outcome.impulse / (800.0 / 3) - 1);
  outcome.ten = std::sqrt(sum / double(n_all));
  outcome.energy_kept = 1 + ran.result.work_contact.back() / (bar.mass() * gravity * height);
  for (const double p : ran.result.pairs[0]["penetration"].values)
    outcome.penetration = std::max(outcome.penetration, p / height);
  return outcome;
}

struct Series {
  std::vector<double> h;
  std::vector<Outcome> outcome;
  double order(double Outcome::*error) const {
    std::vector<double> e;
    for (const Outcome& o : outcome) e.push_back(o.*error);
    return test::observed_order(h, e);
  }
};

Series refine(const Way& way) {
  Series series;
  for (const Index n : {20, 40, 80}) {
    const Outcome o = drop(way, n);
    series.h.push_back(10.0 / double(n));
    series.outcome.push_back(o);
    std::printf(
        "%-12s %-8s n %2ld: end, one period %.2e, ten %.2e; impulse %.1e; energy lost in one "
        "period %.4f, kept after ten %.4f; "
        "penetration %.1e\n",
        way.name, way.enforcement, long(n), o.first, o.ten, o.impulse, o.lost_first, o.energy_kept,
        o.penetration);
  }
  return series;
}

// Whatever touches stops, and its mass with it: the end node's kinetic energy is lost whenever it
// lands, a share that falls with h. Over ten periods of two landings each that is much: the bar
// with mass on its end comes to rest on coarse meshes.
TEST(BouncingBar, ImpulseLosesTheEnergyOfTheEndAlone) {
  for (const Way& way : {Way{"mesh", true, "central-difference", "impulse"},
                         Way{"superelement", false, "exact", "impulse"}}) {
    const Series s = refine(way);
    EXPECT_GT(s.order(&Outcome::first), 0.6);  // fronts: 2/3, see the bars that strike each other
    EXPECT_GT(s.order(&Outcome::lost_first), 0.8);
    EXPECT_LT(s.outcome[2].first, 0.015);
    EXPECT_LT(s.outcome[2].impulse, 2e-3);
    EXPECT_LT(s.outcome[2].lost_first, 0.012);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LT(s.outcome[i].penetration, 1e-12);
      EXPECT_LT(s.outcome[i].energy_kept, 1);
    }
    EXPECT_GT(s.outcome[1].energy_kept, s.outcome[0].energy_kept);
    EXPECT_GT(s.outcome[2].energy_kept, s.outcome[1].energy_kept);
  }
}

// A spring loses nothing, but gives way.
TEST(BouncingBar, PenaltyKeepsTheEnergyAndPenetrates) {
  for (const Way& way : {Way{"mesh", true, "central-difference", "penalty"},
                         Way{"superelement", false, "exact", "penalty"}}) {
    const Series s = refine(way);
    EXPECT_GT(s.order(&Outcome::first), 0.6);
    EXPECT_GT(s.order(&Outcome::penetration), 0.8);  // k grows as 1 / h
    EXPECT_LT(s.outcome[2].first, 0.03);
    EXPECT_NEAR(s.outcome[2].energy_kept, 1, 0.05);
  }
}

TEST(BouncingBar, MoreModesAreNearer) {
  double last = 1;
  for (const Index modes : {10, 30, 60, -1}) {
    const Outcome o = drop({"", false, "exact", "impulse", modes}, 40);
    std::printf("%3ld modes: end, one period %.2e; energy lost in it %.4f\n", long(modes), o.first,
                o.lost_first);
    EXPECT_LT(o.first, last);
    last = o.first;
  }
}

}  // namespace
}  // namespace cbr::bouncing_bar_test
