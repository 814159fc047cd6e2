// SPDX-License-Identifier: GPL-3.0-or-later
// A damped step in closed form against many small steps of a Taylor series in long double; rates;
// the gain of contact.
#include "dynamics/motion/damping.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "dynamics/motion/modal/forms/modal_propagator.hpp"

namespace cbr::damping_test {
namespace {

// eta, v, f, f', integral of eta.
using State = std::array<long double, 5>;

State rate(const State& y, long double x, long double d) {
  return {y[1], y[2] - x * x * y[0] - d * y[1], y[3], 0, y[0]};
}

// Over the time 1, by Taylor series of order 12 in steps of at most 0.02 of the fastest rate.
State flow(State y, long double x, long double d) {
  const int n = 1 + static_cast<int>(50 * (x + d));
  const long double h = 1.0L / n;
  for (int step = 0; step < n; ++step) {
    State term = y, sum = y;
    for (int k = 1; k <= 12; ++k) {
      const State next = rate(term, x, d);
      for (std::size_t i = 0; i < 5; ++i) {
        term[i] = next[i] * h / k;
        sum[i] += term[i];
      }
    }
    y = sum;
  }
  return y;
}

TEST(Damping, StepIsThatOfManySmallOnes) {
  for (const double x : {0.0, 1e-4, 0.3, 0.999, 1.0, 2.0, 7.0, 40.0})
    for (const double d : {0.0, 1e-7, 0.1, 1.9, 2.0, 3.99, 4.1, 14.0, 90.0}) {
      const ModalPropagator step =
          damped_propagator(Vector::Constant(1, x), Vector::Constant(1, d), 1, true);
      const State u = flow({1, 0, 0, 0, 0}, x, d), v = flow({0, 1, 0, 0, 0}, x, d);
      const State f0 = flow({0, 0, 1, -1, 0}, x, d), f1 = flow({0, 0, 0, 1, 0}, x, d);
      const double tolerance = 2e-14 * (1 + x + d);
      const auto near = [&](const Vector& found, long double expected, const char* what) {
        EXPECT_NEAR(found[0], static_cast<double>(expected),
                    tolerance * (1 + std::abs(static_cast<double>(expected))))
            << what << " x " << x << " d " << d;
      };
      near(step.c, u[0], "c");
      near(step.back, u[1], "back");
      near(step.j0, u[4], "j0");
      near(step.s, v[0], "s");
      near(step.stay, v[1], "stay");
      near(step.j1, v[4], "j1");
      near(step.a0, f0[0], "a0");
      near(step.b0, f0[1], "b0");
      near(step.i0, f0[4], "i0");
      near(step.a1, f1[0], "a1");
      near(step.b1, f1[1], "b1");
      near(step.i1, f1[4], "i1");
    }
}

TEST(Damping, RatesAddUp) {
  Damping damping;
  damping.material = {.alpha = 0.5, .beta = 1e-3, .loss_factor = 0.01};
  damping.modal = {.frequency_hz = {10, 20}, .ratio = {0.02, 0.04}};
  const double at = 2 * std::numbers::pi;
  const Vector omega = (Vector(4) << 0, 5 * at, 15 * at, 40 * at).finished();
  const Vector ratio = (Vector(4) << 0.02, 0.02, 0.03, 0.04).finished();
  const ModalRates rates = damping.rates(omega);
  for (Index j = 0; j < 4; ++j)
    EXPECT_DOUBLE_EQ(rates.c[j],
                     0.5 + 1e-3 * omega[j] * omega[j] + (2 * ratio[j] + 0.01) * omega[j]);
  EXPECT_NE(rates.hash, 0u);
  EXPECT_EQ(Damping().rates(omega).hash, 0u);
}

// What the gain is for: impulses F h at each step's start end in the deflection F / omega^2.
TEST(Damping, GainMakesALastingForceDeflectAsItShould) {
  for (const double x : {0.01, 0.5, 1.0, 2.0})
    for (const double d : {0.0, 0.02, 1.0, 5.0}) {
      const Vector omega = Vector::Constant(1, x), c = Vector::Constant(1, d);
      const double gain = contact_gain(omega, c, 0, 1)[0];
      if (d == 0) {
        EXPECT_NEAR(gain, contact_gain(omega, 1)[0], 1e-13);
      }
      const ModalPropagator step = damped_propagator(omega, c, 1, false);
      // eta = c eta + s w, w = v + gain, v = back eta + stay w
      const double w_per_eta = (1 - step.c[0]) / step.s[0];
      const double eta = gain / (w_per_eta * (1 - step.stay[0]) - step.back[0]);
      EXPECT_NEAR(eta, 1 / (x * x), 1e-10 / (x * x)) << x << " " << d;
    }
  EXPECT_EQ(contact_gain(Vector::Constant(1, 0.0), Vector::Constant(1, 3.0), 1, 1)[0], 1);
}

// z^2 - (2 - g - d) z + (1 - d) = 0 of u+ - 2 u + u- = -g u - d (u - u-): at the limit one root is
// -1.
TEST(Damping, CriticalFrequencyIsTheLimitOfLateDamping) {
  for (const double zeta : {0.0, 0.01, 0.3, 2.0}) {
    const double omega = 7, beta = 2 * zeta / omega, h = 2 / critical_frequency(omega, beta);
    const double g = omega * omega * h * h, d = beta * omega * omega * h;
    EXPECT_NEAR(g + 2 * d, 4, 1e-12);
  }
}

}  // namespace
}  // namespace cbr::damping_test
