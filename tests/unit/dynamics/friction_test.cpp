// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks that strike each other obliquely: Coulomb's law, friction's work, conservation; and
// contact damping.
#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/output/summary/summary.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::friction_test {
namespace {

using test::Part;
using test::row;
using test::two_bodies;

struct Strike {
  Part a, b;
};

// Non-matching faces; a flies into b with a tangential velocity.
Strike strike(bool mesh_a, bool mesh_b, const Vector3& velocity) {
  Strike s;
  s.a.n = {3, 4, 4};
  s.b.n = {3, 3, 2};
  s.b.size = Vector3(1, 0.7, 0.7);
  s.a.mesh = mesh_a;
  s.b.mesh = mesh_b;
  s.a.modes = s.b.modes = 30;
  s.a.placement.velocity = velocity;
  s.b.placement.position = Vector3(1.0001, -0.1, -0.1);
  s.b.face = "x_min";
  return s;
}

Simulation with_friction(const Strike& s, Enforcement enforcement, double mu, double share = 0.45) {
  Simulation sim = two_bodies(s.a, s.b, enforcement, 0.5, 0.01, share);
  sim.pairs[0].law = {ContactLaw::coulomb, mu};
  return sim;
}

constexpr std::array enforcements{Enforcement::impulse, Enforcement::penalty};

TEST(Friction, SlidingForceIsMuTimesTheNormalForceAgainstTheSlip) {
  const double mu = 0.3;
  for (const Enforcement enforcement : enforcements) {
    for (const bool mesh : {false, true}) {
      // Slides all the time: the tangential speed is far above what friction takes
      const Strike s = strike(mesh, false, Vector3(1e-3, 3e-3, 4e-3));
      Simulation sim = with_friction(s, enforcement, mu);
      const RunResult result = run(sim);
      const Balance b = balance(result);
      EXPECT_LT(b.energy, 1e-11);
      EXPECT_LT(b.momentum, 1e-12);
      Vector3 total = Vector3::Zero();
      for (std::size_t i = 1; i < result.time.size(); ++i)
        total += row(result.pairs[0]["force"], i);
      ASSERT_LT(total[0], 0);
      // The slip's direction is (0, 3, 4) / 5 but for what the faces do themselves
      // The springs of a penalty stretch a little before they give way
      EXPECT_NEAR(total.tail<2>().norm() / -total[0], mu,
                  (enforcement == Enforcement::penalty ? 0.05 : 2e-3) * mu);
      EXPECT_NEAR(total[1] / total.tail<2>().norm(), -0.6, 0.03);
      EXPECT_NEAR(total[2] / total.tail<2>().norm(), -0.8, 0.03);
      EXPECT_LT(result.work_friction.back(), 0);
      double risen = 0;
      for (std::size_t i = 1; i < result.time.size(); ++i)
        risen += std::max(0.0, result.work_friction[i] - result.work_friction[i - 1]);
      EXPECT_LT(risen, 1e-12 * result.total[0]);
    }
  }
}

TEST(Friction, NoneIsTheLimitOfLittle) {
  const Strike s = strike(false, true, Vector3(1e-3, 1e-3, 0));
  Simulation rough = with_friction(s, Enforcement::impulse, 1e-9),
             smooth = with_friction(s, Enforcement::impulse, 0);
  smooth.pairs[0].law = {};
  const RunResult r = run(rough), f = run(smooth);
  EXPECT_LT(
      (row(r.bodies[1].momentum, r.time.size() - 1) - row(f.bodies[1].momentum, f.time.size() - 1))
          .norm(),
      1e-10);
}

// With much friction and little tangential speed the faces stick: both bodies leave turned by the
// same tangential impulse, and friction takes no energy (impulse: no slip at all; penalty: what the
// springs still hold).
TEST(Friction, StickingTakesNoEnergy) {
  const Strike s = strike(false, false, Vector3(1e-3, 1e-5, 0));
  Simulation sim = with_friction(s, Enforcement::impulse, 20);
  const RunResult result = run(sim);
  EXPECT_LT(balance(result).energy, 1e-11);
  EXPECT_LE(std::abs(result.work_friction.back()), 0.02 * result.total[0]);
  double tangential = 0;
  for (std::size_t i = 1; i < result.time.size(); ++i)
    tangential = std::max(tangential, row(result.pairs[0]["force"], i).tail<2>().norm());
  EXPECT_GT(tangential, 0);
}

TEST(Damping, TakesEnergyFromABounce) {
  double before = 2;
  for (const double damping : {0.0, 0.2, 1.0}) {
    const Strike s = strike(false, false, Vector3(1e-3, 0, 0));
    Simulation sim = two_bodies(s.a, s.b, Enforcement::penalty, 0.5, 0.01, 0.45);
    sim.pairs[0].penalty.damping = damping;
    const RunResult result = run(sim);
    EXPECT_LT(balance(result).energy, 1e-11);
    EXPECT_LT(balance(result).momentum, 1e-12);
    const double kept = result.total.back() / result.total.front();
    EXPECT_LT(kept, before) << damping;
    before = kept;
  }
  EXPECT_LT(before, 0.99);
}

}  // namespace
}  // namespace cbr::friction_test
