// SPDX-License-Identifier: GPL-3.0-or-later
// Modal mass scaling against all modes, one by one: frequencies above the clip set to it, their
// rows scaled by clip / omega.
#include "dynamics/motion/scaled/scaled_body.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>
#include <stdexcept>

#include "common/base/error.hpp"
#include "tests/unit/dynamics/scaled_bodies.hpp"

namespace cbr::test::scaled_body_test {
namespace {

void compare(const Case& c) {
  const Model m = model_of(c);
  const double clip = c.clip * m.form->omega.maxCoeff();
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(c.mirrored));
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), oblique(c.mirrored),
                             Scheme::exact);
  expect_equal_motion(body, reference, 1.9 / clip, 150, 1e-11);
}

TEST(ScaledBody, FreeMovesAsAllModesSlowedOneByOne) {
  for (const bool mirrored : {false, true}) compare({Shape::free, mirrored});
}

TEST(ScaledBody, HeldMovesAsAllModesSlowedOneByOne) {
  for (const bool mirrored : {false, true}) compare({Shape::held, mirrored});
}

TEST(ScaledBody, HingedMovesAsAllModesSlowedOneByOne) { compare({Shape::hinged, true}); }

// With the gain of impulses too, which is taken of the frequencies as they are after scaling.
TEST(ScaledBody, MovesAsAllModesSlowedOneByOneWithContactGain) {
  for (const Case& c :
       {Case{Shape::free, true}, Case{Shape::held, false}, Case{Shape::held, true, 10, 1e-3}}) {
    const Model m = model_of(c);
    const double clip = c.clip * m.form->omega.maxCoeff(), h = 1.9 / clip;
    ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(c.mirrored));
    SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), oblique(c.mirrored),
                               Scheme::exact);
    expect_equal_motion(body, reference, h, 150, 1e-11, h);
  }
}

TEST(ScaledBody, WithoutModalCoordinates) {
  compare({Shape::free, false, 0});
  compare({Shape::held, true, 0});
}

TEST(ScaledBody, ClipBelowAllElasticModesAndAboveAll) {
  for (const double clip : {1e-3, 1.0}) {
    compare({Shape::free, false, 10, clip});
    compare({Shape::held, true, 10, clip});
  }
}

TEST(ScaledBody, ClipAboveAllModesScalesNothing) {
  const Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(false));
  const Index set = body.track({0, 4});
  const double highest = body.largest_frequency();
  body.prepare({.clip = 1.5 * highest});
  EXPECT_FALSE(body.is_scaled());
  EXPECT_EQ(body.n_scaled(), 0);
  EXPECT_EQ(body.largest_frequency(), highest);
  SuperelementBody exact("body", m.superelement, m.form, oblique(false), Scheme::exact);
  const Index same = exact.track({0, 4});
  std::mt19937 random(3);
  const Points p = random_points(random, 2, 1);
  Points x, x_exact;
  for (int i = 0; i < 5; ++i) {
    body.predict(0.01 * i, 0.01);
    exact.predict(0.01 * i, 0.01);
    body.add_impulses(set, p);
    exact.add_impulses(same, p);
    body.accept();
    exact.accept();
  }
  body.positions(set, x);
  exact.positions(same, x_exact);
  EXPECT_LT(difference(x, x_exact), 1e-13);
}

TEST(ScaledBody, BodyThatNothingTouchesIsExact) {
  const Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(false));
  body.prepare({.clip = 0.2 * body.largest_frequency()});
  EXPECT_FALSE(body.is_scaled());
  body.predict(0, 3);
  body.accept();
  EXPECT_LT((body.state().center_of_mass - oblique(false).T * m.superelement->rigid_body.center -
             oblique(false).position - 3 * oblique(false).velocity)
                .norm(),
            1e-12);
}

TEST(ScaledBody, StaticsAreThoseOfAllModes) {
  const Model m = model_of({Shape::held});
  std::mt19937 random(11);
  const std::vector<Index> nodes{1, 3, 5};
  const auto model = scaled_model(m.superelement, m.form);
  const auto shared = model->clipped(0.1 * m.form->omega.maxCoeff());
  const ScaledModes& modes = *shared;
  ASSERT_GT(modes.n_scaled, 20);
  // u(t) = int_0^t S(t - s) ds f of a constant force: its static part is V_lo omega^-2 V_lo^T + S /
  // clip^2
  const auto rows = modes.node_rows(nodes);
  const Matrix statics =
      rows->Vt.transpose() * modes.omega.cwiseAbs2().cwiseInverse().asDiagonal() * rows->Vt +
      *rows->S / (modes.clip * modes.clip);
  Matrix all = Matrix::Zero(9, 9);
  Matrix V(9, m.form->omega.size());
  for (Index i = 0; i < 9; ++i)
    V.row(i) = m.form->V.row(displacement_rows(*m.superelement)(nodes[i / 3], i % 3));
  all = V * m.form->omega.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose();
  EXPECT_LT((statics - all).norm(), 1e-12 * all.norm());
  // A force that grows so slowly that nothing swings
  ScaledBody slow("body", model, Placement{});
  const Index same = slow.track(nodes);
  Points force = Points::Zero(slow.n_nodes(), 3);
  for (const Index node : nodes) force.row(node) = random_points(random, 1, 1).row(0);
  const double end = 1e7 / m.form->omega[0];
  slow.prepare(
      {.loads = {force_load(force, {{0, end}, {0, 1}})}, .clip = 0.1 * m.form->omega.maxCoeff()});
  slow.predict(0, end);
  slow.accept();
  Points x;
  slow.positions(same, x);
  const Points u = x - slow.reference_positions()(nodes, Eigen::all), f = force(nodes, Eigen::all);
  const Vector expected = all * Eigen::Map<const Vector>(f.data(), 9);
  EXPECT_LT((Eigen::Map<const Vector>(u.data(), 9) - expected).norm(), 1e-6 * expected.norm());
}

TEST(ScaledBody, ImpulsesChangeMomentumByTheirSum) {
  std::mt19937 random(1);
  for (const bool mirrored : {false, true}) {
    const Model m = model_of({});
    ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(mirrored));
    const Index set = body.track({0, 3, 5, 8, 9, 13});
    body.prepare({.clip = 0.3 * body.largest_frequency()});
    const double h = 1.9 / body.largest_frequency();
    Vector3 momentum = body.state().momentum, angular = body.state().angular_momentum;
    const Vector3 center = body.state().center_of_mass;  // undeformed
    Points X = body.reference_positions()(std::vector<Index>{0, 3, 5, 8, 9, 13}, Eigen::all);
    double scale = momentum.norm(), angular_scale = angular.norm();
    for (int step = 0; step < 200; ++step) {
      const Points p = random_points(random, 6, step % 10 == 0 ? 0.3 : 0.0);
      const Vector3 drift = body.state().center_of_mass - center;
      for (Index i = 0; i < 6; ++i)
        angular += Vector3(X.row(i).transpose() + drift).cross(Vector3(p.row(i).transpose()));
      momentum += p.colwise().sum().transpose();
      body.predict(step * h, h);
      body.add_impulses(set, p);
      body.accept();
      scale = std::max(scale, momentum.norm());
      angular_scale = std::max(angular_scale, angular.norm());
    }
    EXPECT_LT((body.state().momentum - momentum).norm(), 1e-13 * scale);
    EXPECT_LT((body.state().angular_momentum - angular).norm(), 1e-12 * angular_scale);
    EXPECT_GT(body.scaled_energy(), 0);
    EXPECT_LT(body.scaled_energy(), energy(body));
  }
}

TEST(ScaledBody, ResponseIsWhatImpulsesDoAndIsShared) {
  std::mt19937 random(2);
  const Model m = model_of({});
  const auto shared = scaled_model(m.superelement, m.form);
  ScaledBody one("one", shared, oblique(false)), two("two", shared, oblique(true));
  for (ScaledBody* body : {&one, &two}) {
    body->track({0, 3, 5, 11});
    body->prepare({.clip = 0.4 * shared->largest_frequency()});
    const double h = 1.9 / body->largest_frequency();
    const NodeResponse S = body->response(0, h);
    EXPECT_GT(symmetric_eigenvalues(S.dense()).minCoeff(), 0);
    Points before, after;
    body->predict(0, h);
    body->predicted_positions(0, before);
    const Points p = random_points(random, 4, 1);
    body->add_impulses(0, p);
    body->predicted_positions(0, after);
    const Points moved = after - before;
    const Vector expected = S.dense() * Eigen::Map<const Vector>(p.data(), p.size());
    EXPECT_LT((Eigen::Map<const Vector>(moved.data(), 12) - expected).norm(),
              1e-12 * expected.norm());
  }
  const double h = 1.9 / one.largest_frequency();
  EXPECT_EQ(one.response(0, h).block.get(), two.response(0, h).block.get());
}

TEST(ScaledBody, MovesThatAreKnownNeedNoProduct) {
  std::mt19937 random(9);
  for (const Shape shape : {Shape::free, Shape::hinged}) {
    const Model m = model_of({shape});
    const auto model = scaled_model(m.superelement, m.form);
    ScaledBody known("known", model, oblique(true)), plain("plain", model, oblique(true));
    for (ScaledBody* body : {&known, &plain}) {
      body->track({0, 3, 5, 11});
      body->prepare({.loads = {gravity_load(Vector3(0, 3, -9), {{0, 0.1, 0.2}, {0, 1, -1}})},
                     .clip = 0.3 * m.form->omega.maxCoeff()});
    }
    const double h = 2 / known.largest_frequency(), start = energy(known);
    double largest = start;
    Points x, y;
    for (int step = 0; step < 100; ++step) {
      known.predict(step * h, h);
      plain.predict(step * h, h);
      const Points p = random_points(random, 4, 0.5);
      const Points rub = step % 3 == 0 ? random_points(random, 4, 0.1) : Points(Points::Zero(4, 3));
      Points move = Points::Zero(4, 3);
      const Vector still;
      known.response(0, h).add_product(p + rub, move);
      known.take_impulses(0, {p, rub, &move, &still});
      plain.add_impulses(0, p);
      plain.add_impulses(0, rub, ImpulseKind::friction);
      known.predicted_positions(0, x);
      plain.predicted_positions(0, y);
      EXPECT_LT(difference(x, y), 1e-12);
      known.accept();
      plain.accept();
      largest = std::max(largest, energy(known));
      const BodyWork work = known.work();
      EXPECT_LT(std::abs(energy(known) - start - work.external - work.contact - work.friction),
                1e-12 * largest)
          << step;
    }
    EXPECT_NEAR(known.work().friction, plain.work().friction, 1e-12 * largest);
    EXPECT_NEAR(known.scaled_energy(), plain.scaled_energy(), 1e-12 * largest);
  }
}

TEST(ScaledBody, MotionBoundHoldsTheMotion) {
  std::mt19937 random(5);
  for (const bool loaded : {false, true}) {
    const Model m = model_of({loaded ? Shape::hinged : Shape::free});
    ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(loaded));
    const Index set = body.track({0, 2, 6, 9});
    BodyPlan plan{.clip = 0.2 * body.largest_frequency()};
    if (loaded)
      plan.loads.push_back(
          force_load(random_points(random, body.n_nodes(), 5.0), {{0, 0.2, 0.4}, {0, 1, -1}}));
    body.prepare(plan);
    body.predict(0, 0.01);
    body.add_impulses(set, random_points(random, 4, 0.2));
    body.accept();
    const MotionBound bound = body.motion_bound(set);
    for (int step = 1; step <= 200; ++step) {
      const double t = 0.002 * step;
      body.predict(0.01 + t - 0.002, 0.002);
      body.accept();
      Points x;
      body.positions(set, x);
      const Vector3 spread = bound.growth * t + 0.5 * t * t * bound.acceleration;
      for (Index i = 0; i < 4; ++i) {
        EXPECT_TRUE((x.row(i).transpose().array() <=
                     (bound.upper + t * bound.upper_speed + spread).array() + 1e-12)
                        .all());
        EXPECT_TRUE((x.row(i).transpose().array() >=
                     (bound.lower + t * bound.lower_speed - spread).array() - 1e-12)
                        .all());
      }
    }
  }
}

TEST(ScaledBody, EveryDofHeldStandsStill) {
  Model m = model(reduce(block(), x_nodes(block(), false, true), 0));
  std::vector<HeldDirection> held;
  for (Index node = 0; node < m.superelement->coordinates.rows(); ++node)
    for (int c = 0; c < 3; ++c) held.push_back({node, Vector3::Unit(c)});
  auto form = std::make_shared<DiagonalForm>();
  form->V.resize(m.superelement->n(), 0);
  form->E.resize(0, 6);
  ScaledBody body("body", scaled_model(m.superelement, form), oblique(true));
  const Index set = body.track({0, 1});
  body.prepare({.loads = {gravity_load(Vector3(0, 0, -9))}, .clip = 100});
  body.predict(0, 0.1);
  body.add_impulses(set, Points::Ones(2, 3));
  body.accept();
  Points x;
  body.positions(set, x);
  EXPECT_EQ(difference(x, body.reference_positions().topRows(2)), 0);
  EXPECT_EQ(energy(body), 0);
  EXPECT_EQ(body.response(set, 0.1).block->norm(), 0);
}

TEST(ScaledBody, OneNodeIsTouched) {
  const Model m = model_of({});
  const double clip = 0.3 * m.form->omega.maxCoeff();
  ScaledBody body("body", scaled_model(m.superelement, m.form), Placement{});
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), Placement{},
                             Scheme::exact);
  body.track({6});
  reference.track({6});
  body.prepare({.clip = clip});
  Points p(1, 3), x, x_all;
  p << 1, -2, 3;
  for (int i = 0; i < 20; ++i) {
    body.predict(0, 1 / clip);
    reference.predict(0, 1 / clip);
    if (i % 5 == 0) {
      body.add_impulses(0, p);
      reference.add_impulses(0, p);
    }
    body.accept();
    reference.accept();
  }
  body.positions(0, x);
  reference.positions(0, x_all);
  EXPECT_LT(difference(x, x_all), 1e-12);
  Vector q, rates, q_all, rates_all;
  body.coordinates(q, rates);
  reference.coordinates(q_all, rates_all);
  EXPECT_LT((q - q_all).norm(), 1e-11 * q_all.norm());
}

TEST(ScaledBody, RefusesWhatNeedsNodalMasses) {
  const Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), Placement{});
  body.track({1});
  body.prepare({.clip = 10});
  EXPECT_THROW(body.nodal_masses(0), InputError);
}

TEST(ScaledBody, ItsPlanComesOnceAfterItsSetsAndBeforeItsSteps) {
  const Model m = model_of({});
  const auto model = scaled_model(m.superelement, m.form);
  ScaledBody planned("planned", model, Placement{}), moved("moved", model, Placement{});
  EXPECT_THROW(planned.state(), std::logic_error);
  planned.prepare({});
  EXPECT_THROW(planned.prepare({}), std::logic_error);
  EXPECT_THROW(planned.track({1}), std::logic_error);
  EXPECT_THROW(planned.track_mean({1}), std::logic_error);
  moved.predict(0, 0.1);
  EXPECT_THROW(moved.prepare({}), std::logic_error);
}

}  // namespace
}  // namespace cbr::test::scaled_body_test
