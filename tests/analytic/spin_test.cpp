// SPDX-License-Identifier: GPL-3.0-or-later
// What a spin does to the elastic coordinates of a superelement that turns: the stretch of a
// spinning bar, energy, order of the splitting, and what is told of a superelement that does not
// know its moments.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::spin_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

constexpr double length = 0.4, E = 1e5, density = 2;

std::string scene(const std::string& time, const std::string& instance, double poisson,
                  const std::string& output, const std::string& reduction = "modes: 12",
                  const std::string& mass = "consistent", double youngs_modulus = E) {
  return "materials: {m: {youngs_modulus: " + text(youngs_modulus) +
         ", poissons_ratio: " + text(poisson) + ", density: " + text(density) +
         "}}\ncomponents: {bar: {mesh: bar.exo, material: m, mass: " + mass +
         ", reduction: {interface: [x_min, x_max], " + reduction +
         "}}}\ninstances: {b: {component: bar, " + instance + "}}\ntime: " + time +
         "\noutput: {every: " + output + ", history: [b.x_min, b.x_max]}\n";
}

double stretch(const Ran& ran) {
  const auto last = ran.result.time.size() - 1;
  return (at(ran.monitor("b.x_max").mean_position, last) -
          at(ran.monitor("b.x_min").mean_position, last))
             .norm() -
         length;
}

// Once damping has taken the swing each half of a bar of length 2 a is longer by rho w^2 a^3 / (3
// E); of lumped masses with the square of the elements' length (a consistent mass is exact at the
// nodes of a bar).
TEST(Spin, ABarStretches) {
  std::vector<double> h, error;
  constexpr double w = 2, a = length / 2;
  const double expected = 2 * density * w * w * a * a * a / (3 * E);
  for (const Index n : {4, 8, 16}) {
    SceneFolder folder;
    folder.add("bar.exo", test::block_mesh({{n, 1, 1}, Vector3(length, 0.02, 0.02)}));
    const Ran ran =
        folder.run(scene("{end: 0.5, rotations: large}",
                         "damping: {ratio: 0.2}, rotation: [0, 0, 30], angular_velocity: [0, 0, 2]",
                         0, "0.1", "modes: 9", "lumped"));
    h.push_back(1.0 / static_cast<double>(n));
    error.push_back(std::abs(stretch(ran) / expected - 1));
    std::printf("%d elements: stretch %.6e, off by %.2e\n", static_cast<int>(n), stretch(ran),
                error.back());
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  }
  EXPECT_LT(error.back(), 0.01);
  EXPECT_NEAR(test::observed_order(h, error), 2, 0.1);
}

// A bar that tumbles about no axis of its own. Energy and angular momentum stay; what the splitting
// leaves of the energy, and how far the end of the bar is from where shorter steps take it, fall
// with the square of the step.
TEST(Spin, TheSplittingIsOfSecondOrder) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{4, 1, 1}, Vector3(length, 0.05, 0.06)}));
  RunOptions every_step;
  every_step.jumps = false;
  const auto tumble = [&](double step) {
    return folder.run(
        scene("{end: 0.1, step: " + text(step) + ", rotations: large}",
              "angular_velocity: [4, 5, 6]", 0.3, "0.01", "modes: 12", "consistent", 4000),
        every_step);
  };
  const Ran fine = tumble(0.000003125);
  const auto last = fine.result.time.size() - 1;
  std::vector<double> h, place, left;
  for (const double step : {0.0001, 0.00005, 0.000025}) {
    const Ran ran = tumble(step);
    const RunResult& r = ran.result;
    double most = 0, momentum = 0;
    for (std::size_t k = 0; k <= last; ++k) {
      most = std::max(most, std::abs(r.work_numerical[k]));
      momentum = std::max(
          momentum,
          (at(r.bodies[0].angular_momentum, k) - at(r.bodies[0].angular_momentum, 0)).norm());
    }
    h.push_back(step);
    left.push_back(most / r.total[0]);
    place.push_back((at(ran.monitor("b.x_max").mean_position, last) -
                     at(fine.monitor("b.x_max").mean_position, last))
                        .norm());
    std::printf("step %.0e: place %.2e, energy left %.2e, momentum %.0e\n", step, place.back(),
                left.back(), momentum);
    EXPECT_LT(momentum, 1e-14);
    EXPECT_LT(test::energy_residual(r), 1e-14);
  }
  EXPECT_GT(test::observed_order(h, place), 1.9);
  EXPECT_GT(test::observed_order(h, left), 1.9);
}

// Fields and histories are in the scene's axes: the pull rho w^2 a^2 / 2 in the middle of the bar
// goes round with it.
TEST(Spin, StressTurnsWithTheBody) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{8, 1, 1}, Vector3(length, 0.02, 0.02)}));
  const Ran ran =
      folder.run(scene("{end: 0.9, rotations: large}",
                       "damping: {ratio: 0.2}, rotation: [0, 0, 30], angular_velocity: [0, 0, 2]",
                       0, "0.1, stress: [b.y_min]", "modes: 12, recovery: true"));
  const auto last = ran.result.time.size() - 1;
  const std::size_t m = ran.result.watches[0].size() / (last + 1);
  double most = 0, aside = 0;
  for (std::size_t k = last - 5; k <= last; ++k) {
    const Vector3 axis =
        (at(ran.monitor("b.x_max").mean_position, k) - at(ran.monitor("b.x_min").mean_position, k))
            .normalized();
    for (std::size_t i = k * m; i < (k + 1) * m; i += 6) {
      const double* s = ran.result.watches[0].data() + i;
      Matrix3 S;
      S << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
      const double along = axis.dot(S * axis);
      most = std::max(most, along);
      aside = std::max(aside, (S - along * axis * axis.transpose()).norm());
    }
  }
  const double expected = density * 4 * (length / 2) * (length / 2) / 2;
  std::printf("stress %.4f of the closed form, aside %.1e\n", most / expected, aside / expected);
  EXPECT_NEAR(most / expected, 1, 0.05);
  EXPECT_LT(aside, 5e-3 * expected);  // across: (thickness / length)^2 of it
}

// Basis massless has no moments: it turns, and says what it lacks.
TEST(Spin, WithoutMomentsABodyTurnsAndSaysSo) {
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{4, 1, 1}, Vector3(length, 0.02, 0.05)}));
  const auto notes = [&](const std::string& reduction) {
    std::string all;
    const std::string yaml =
        scene("{end: 0.1, rotations: large}", "angular_velocity: [0, 0, 1]", 0.3, "0.1", reduction);
    for (const std::string& note : folder.prepare(yaml).built.notes) all += note + "\n";
    return all;
  };
  EXPECT_EQ(notes("modes: 4"), "");
  EXPECT_SAYS(notes("modes: 4, basis: massless"), "' turns without the forces of its spin");
}

}  // namespace
}  // namespace cbr::spin_test
