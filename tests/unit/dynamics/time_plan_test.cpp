// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/simulation/time_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::time_plan_test {
namespace {

void expect_consistent(const TimePlan& plan, double h_max, double every, double end) {
  EXPECT_LE(plan.h, h_max * (1 + 1e-8));
  EXPECT_LE(plan.h_rest, plan.h * (1 + 1e-8));
  EXPECT_DOUBLE_EQ(plan.time(plan.n_steps()), end);
  double reached = 0;
  for (Index step = 0; step < plan.n_steps(); ++step) {
    EXPECT_NEAR(plan.time(step), reached, 1e-12 * end);
    reached += plan.step_length(step);
  }
  EXPECT_NEAR(reached, end, 1e-12 * end);
  Index outputs = 0;
  for (Index step = 0; step < plan.n_steps(); step = plan.next_output(step)) {
    EXPECT_TRUE(plan.is_output(step));
    if (every > 0) {
      EXPECT_DOUBLE_EQ(plan.time(step), static_cast<double>(outputs) * every);
    }
    ++outputs;
  }
  if (every > 0) {
    EXPECT_EQ(outputs, static_cast<Index>(std::ceil(end / every - 1e-9)));
  }
}

TEST(TimePlan, StepsFitOutputsAndTheEnd) {
  for (const double h : {0.0371, 0.1, 0.0999999999999, 0.3, 1.0, 7.0})
    for (const double every : {0.1, 0.25, 1.0, 3.0})
      for (const double end : {1.0, 2.5, 0.7, 3.0})
        expect_consistent(fit_steps(h, std::min(every, end), end), h, std::min(every, end), end);
  expect_consistent(fit_steps(0.3, 0, 1), 0.3, 0, 1);
}

TEST(TimePlan, AutomaticStepsAndTheCriticalOne) {
  test::Part part;
  for (const bool mesh : {false, true}) {
    part.mesh = mesh;
    Geometry geometry;
    std::vector<std::unique_ptr<Body>> bodies;
    bodies.push_back(test::make_body("body", part, geometry));
    const double critical = 2 / bodies[0]->largest_frequency();
    TimeOptions options;
    options.end = 1;
    const TimePlan plan = plan_time(options, 0, bodies, {ContactKind::hard});
    EXPECT_LE(plan.h, (mesh ? 0.9 : 1.0) * critical * (1 + 1e-9));
    EXPECT_GT(plan.h, 0.8 * critical);
    options.step = 0.99 * critical;
    EXPECT_NO_THROW(plan_time(options, 0, bodies, {ContactKind::hard}));
    EXPECT_NO_THROW(plan_time(options, 0, bodies, {ContactKind::penalty}));
    options.step = critical;
    options.end = 100 * critical;
    EXPECT_NO_THROW(plan_time(options, 0, bodies, {ContactKind::hard}));
    // springs of no stiffness
    EXPECT_THROW(plan_time(options, 0, bodies, {ContactKind::penalty}), InputError);
    options.step = 1.05 * critical;
    options.end = 100 * 1.05 * critical;
    EXPECT_THROW(plan_time(options, 0, bodies, {ContactKind::hard}), InputError);
    options.force_step = true;
    EXPECT_NEAR(plan_time(options, 0, bodies, {ContactKind::hard}).h, 1.05 * critical,
                1e-9 * critical);
    options.force_step = false;
    if (!mesh) {
      // exact and in no contact: any step
      EXPECT_NO_THROW(plan_time(options, 0, bodies, {ContactKind::none}));
    }
  }
}

TEST(TimePlan, NewmarkTakesAnyStep) {
  test::Part part;
  part.scheme = Scheme::newmark;
  Geometry geometry;
  std::vector<std::unique_ptr<Body>> bodies;
  bodies.push_back(test::make_body("body", part, geometry));
  part.material.youngs_modulus *= 4;  // twice the frequencies
  bodies.push_back(test::make_body("stiff", part, geometry));
  const double critical = 2 / bodies[1]->largest_frequency();
  const std::vector<ContactKind> hard(2, ContactKind::hard);
  TimeOptions options;
  options.end = 1000 * critical;
  options.alpha = -0.1;
  EXPECT_EQ(critical_step(*bodies[1], true), 0);
  // auto: a thousandth of the end
  EXPECT_NEAR(plan_time(options, 0, bodies, hard).h, critical, 1e-9 * critical);
  EXPECT_NEAR(plan_time(options, 40 * critical, bodies, hard).h, 40 * critical, 1e-9 * critical);
  for (const double x : {0.01, 0.5, 10.0, 100.0}) {
    options.cfl = x;
    const TimePlan plan = plan_time(options, 0, bodies, hard);
    EXPECT_NEAR(plan.h, x * critical, 1e-9 * critical);
    EXPECT_NEAR(plan.critical, critical, 1e-12 * critical);
    EXPECT_EQ(plan.newmark_alpha, -0.1);
    EXPECT_SAYS(plan.limit, "stiff");
  }
  options.cfl = 10;
  // fits the outputs
  EXPECT_NEAR(plan_time(options, 25 * critical, bodies, hard).h, 25.0 / 3 * critical,
              1e-9 * critical);
  EXPECT_SAYS(plan_time(options, 25 * critical, bodies, hard).limit, "stiff");
  // a step passes no output
  EXPECT_EQ(plan_time(options, 5 * critical, bodies, hard).limit, "output.every");
  options.cfl.reset();
  options.step = 123 * critical;
  EXPECT_EQ(plan_time(options, 0, bodies, hard).limit, "time.step");
  EXPECT_EQ(plan_time(options, 40 * critical, bodies, hard).limit, "output.every");
  EXPECT_NEAR(plan_time(options, 0, bodies, hard).h, 1000.0 / 9 * critical, 1e-9 * critical);
  options.step = 1e-30;
  EXPECT_THROW(plan_time(options, 0, bodies, hard), InputError);
}

TEST(TimePlan, StepsThatCannotBeCountedAreRefused) {
  TimeOptions options;
  options.end = 1;
  options.step = 1e-30;
  EXPECT_THROW(plan_time(options, 0.1, {}, {}), InputError);
  options.step = 1e-10;
  EXPECT_THROW(plan_time(options, 0, {}, {}), InputError);  // each of them an output
  EXPECT_NO_THROW(plan_time(options, 0.1, {}, {}));
  options.step.reset();
  EXPECT_THROW(plan_time(options, 1e-25, {}, {}), InputError);
}

TEST(TimePlan, OutputsThatHoldTheStepBackAreNamed) {
  Geometry geometry;
  std::vector<std::unique_ptr<Body>> bodies;
  bodies.push_back(test::make_body("block", test::Part{}, geometry));
  const double critical = critical_step(*bodies[0], true);
  TimeOptions options;
  options.end = 100 * critical;
  for (const double every : {0.5, 3.0}) {
    const TimePlan plan = plan_time(options, every * critical, bodies, {ContactKind::hard});
    EXPECT_EQ(plan.limit == "output.every", every < 1) << plan.limit;
  }
}

TEST(TimePlan, CentralDifferencesAreBoundedJustBelowTheCriticalStep) {
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    test::Part part;
    part.mesh = true;
    part.mass = mass;
    for (const double share : {0.99, 1.01}) {
      Geometry geometry;
      const auto body = test::make_body("body", part, geometry);
      const Index set = body->track({0, 3});
      const double h = share * 2 / body->largest_frequency();
      Points p(2, 3);
      p << 1, 2, 3, -3, 1, 2;
      for (int step = 0; step < 4000; ++step) {
        body->predict(step * h, h);
        if (step == 0) body->add_impulses(set, p);
        body->accept();
      }
      const BodyState state = body->state();
      const double change =
          std::abs(state.kinetic_energy + state.strain_energy - body->work().contact) /
          body->work().contact;
      if (share < 1) {
        EXPECT_LT(change, 1e-10);
      } else {
        // the critical step is not underestimated by as much as a percent
        EXPECT_FALSE(change < 1e3);
      }
    }
  }
}

}  // namespace
}  // namespace cbr::time_plan_test
