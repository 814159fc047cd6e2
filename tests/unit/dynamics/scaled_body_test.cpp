// SPDX-License-Identifier: GPL-3.0-or-later
// Modal mass scaling against all modes, one by one: frequencies above the clip set to it, their rows scaled by clip / omega.
#include "dynamics/bodies/scaled_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <numeric>
#include <random>

#include "common/error.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace cbr {
namespace {

using test::lattice;
using test::Lattice;

enum class Shape { free, held, hinged };

struct Case {
  Shape shape = Shape::free;
  bool mirrored = false;
  Index k = 10;
  double clip = 0.4;  // of the highest frequency
};

const Lattice& block() {
  static const Lattice body = lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  return body;
}

Placement oblique(bool mirrored) {
  Placement placement;
  placement.T = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  if (mirrored) placement.T = (placement.T * Vector3(1, -1, 1).asDiagonal()).eval();
  placement.position = Vector3(0.3, -0.2, 1.1);
  placement.velocity = Vector3(2, -1, 0.5);
  return placement;
}

Points random_points(std::mt19937& random, Index n, double size) {
  std::normal_distribution<double> normal;
  return Points::NullaryExpr(n, 3, [&] { return size * normal(random); });
}

std::vector<HeldDirection> held_directions(Shape shape) {
  std::vector<HeldDirection> held;
  if (shape == Shape::held) {
    for (const Index node : {0, 2, 4}) held.push_back({node, Vector3(1, 1, 0).normalized()});
    held.push_back({2, Vector3(0, 0, 1)}), held.push_back({0, Vector3(1, -1, 0).normalized()});
    held.push_back({7, Vector3(0, 0, 1)}), held.push_back({4, Vector3(0, 0, 1)});
  }
  if (shape == Shape::hinged) {
    for (const Index node : {0, 2})
      for (int c = 0; c < 3; ++c) held.push_back({node, Vector3::Unit(c)});
  }
  return held;
}

test::Model model_of(const Case& c) {
  test::Model m = test::model(test::reduce(block(), test::x_nodes(block(), true, true), c.k));
  if (c.shape != Shape::free)
    m.form = std::make_shared<DiagonalForm>(held_diagonal_form(*m.superelement, held_directions(c.shape), "test"));
  return m;
}

// All modes, those above the clip slowed down one by one.
std::shared_ptr<const DiagonalForm> slowed(const DiagonalForm& form, double clip) {
  auto slow = std::make_shared<DiagonalForm>(form);
  for (Index j = 0; j < form.omega.size(); ++j) {
    const double scale = form.omega[j] > clip ? clip / form.omega[j] : 1;
    slow->omega[j] *= scale, slow->V.col(j) *= scale, slow->E.row(j) *= scale;
  }
  return slow;
}

double energy(const Body& body) { return body.state().kinetic_energy + body.state().strain_energy; }

double difference(const Points& a, const Points& b) { return (a - b).cwiseAbs().maxCoeff(); }

// The same loads, impulses and steps for both; what they answer is equal.
void expect_equal_motion(Body& body, Body& reference, double h, int steps, double tolerance) {
  std::mt19937 random(7);
  const std::vector<Index> some{3, 0, 7, 12}, others{12, 5};
  Index sets[2][2], means[2];
  Body* const both[] = {&body, &reference};
  const Points force = random_points(random, body.n_nodes(), 4.0);
  for (int b = 0; b < 2; ++b) {
    sets[b][0] = both[b]->track(some), sets[b][1] = both[b]->track(others);
    means[b] = both[b]->track_mean({1, 2, 3, 9});
    both[b]->add_force(force, {{0.0, 0.013, 0.041, 0.3}, {1.0, 3.0, -2.0, 0.5}});
    both[b]->add_gravity(Vector3(1, -3, -9.81), {});
  }
  if (auto* scaled = dynamic_cast<ScaledBody*>(&body)) scaled->scale(reference.largest_frequency());
  for (const int set : {0, 1}) {
    const Matrix S = body.response(sets[0][set], h).dense(), S_all = reference.response(sets[1][set], h).dense();
    EXPECT_LT((S - S_all).norm(), tolerance * S_all.norm());
  }
  Points x, x_all, v, v_all, u, u_all;
  double start[2] = {energy(body), energy(reference)}, largest = start[1];
  EXPECT_NEAR(start[0], start[1], tolerance * start[1]);
  for (int step = 0; step < steps; ++step) {
    const Points p = random_points(random, 4, 0.4), rub = random_points(random, 2, 0.1);
    for (int b = 0; b < 2; ++b) {
      both[b]->predict(step * h, h);
      if (step % 3 == 0) both[b]->add_impulses(sets[b][0], p);
      if (step % 4 == 0) both[b]->add_impulses(sets[b][1], rub, ImpulseKind::friction);
    }
    body.predicted_positions(sets[0][0], x), reference.predicted_positions(sets[1][0], x_all);
    ASSERT_LT(difference(x, x_all), tolerance * std::max(1.0, x_all.cwiseAbs().maxCoeff())) << step;
    body.accept(), reference.accept();
    body.positions(sets[0][1], x), reference.positions(sets[1][1], x_all);
    ASSERT_LT(difference(x, x_all), tolerance * std::max(1.0, x_all.cwiseAbs().maxCoeff())) << step;
    largest = std::max(largest, energy(reference));
    const double work[2] = {body.work().external + body.work().contact + body.work().friction,
                            reference.work().external + reference.work().contact + reference.work().friction};
    ASSERT_LT(std::abs(energy(body) - start[0] - work[0]), 1e-12 * largest) << step;
  }
  EXPECT_NEAR(energy(body), energy(reference), tolerance * largest);
  EXPECT_NEAR(body.work().contact, reference.work().contact, tolerance * largest);
  EXPECT_NEAR(body.work().friction, reference.work().friction, tolerance * largest);
  const BodyState state = body.state(), all = reference.state();
  EXPECT_LT((state.momentum - all.momentum).norm(), tolerance * std::max(50.0, all.momentum.norm()));
  EXPECT_LT((state.angular_momentum - all.angular_momentum).norm(),
            tolerance * std::max(100.0, all.center_of_mass.norm() * all.momentum.norm()));
  EXPECT_LT((state.center_of_mass - all.center_of_mass).norm(), tolerance * std::max(1.0, all.center_of_mass.norm()));
  EXPECT_NEAR(state.rotation, all.rotation, tolerance * 10 * std::max(1.0, all.rotation));
  Vector3 position, velocity, position_all, velocity_all;
  body.mean_motion(means[0], position, velocity), reference.mean_motion(means[1], position_all, velocity_all);
  EXPECT_LT((position - position_all).norm(), tolerance * std::max(1.0, position_all.norm()));
  EXPECT_LT((velocity - velocity_all).norm(), tolerance * velocity_all.norm() * 10);
  body.displacements(u, v), reference.displacements(u_all, v_all);
  EXPECT_LT(difference(u, u_all), tolerance * std::max(1.0, u_all.norm()));
  EXPECT_LT(difference(v, v_all), tolerance * v_all.norm());
  Vector q, rates, q_all, rates_all;
  body.coordinates(q, rates), reference.coordinates(q_all, rates_all);
  EXPECT_LT((q - q_all).norm(), tolerance * q_all.norm());
  EXPECT_LT((rates - rates_all).norm(), tolerance * rates_all.norm());
}

// From the matrices alone, without all modes; a block with some more coordinates.
void compare_ways(Shape shape, Index k, double share, bool mirrored) {
  const Lattice large = lattice({5, 6, 7}, 0.1, 2e3, 0.5);
  test::Model m = test::model(test::reduce(large, test::x_nodes(large, true, true), k));
  const auto held = held_directions(shape);
  if (shape != Shape::free) m.form = std::make_shared<DiagonalForm>(held_diagonal_form(*m.superelement, held, "test"));
  const auto from_matrices = scaled_model(m.superelement, held, "test");
  const double highest = m.form->omega.maxCoeff(), clip = share * highest;
  EXPECT_NEAR(from_matrices->largest_frequency(), highest, 2e-6 * highest);
  const auto modes = from_matrices->clipped(clip), all = scaled_model(m.superelement, m.form)->clipped(clip);
  EXPECT_EQ(modes->method, "block lanczos");
  ASSERT_EQ(modes->n_kept(), all->n_kept());
  EXPECT_EQ(modes->n_rigid, all->n_rigid);
  EXPECT_EQ(modes->n_scaled, all->n_scaled);
  EXPECT_NEAR(modes->lowest_scaled, all->lowest_scaled, 1e-10 * highest);
  EXPECT_LT((modes->omega - all->omega).norm(), 1e-10 * highest);
  std::vector<Index> nodes(m.superelement->node_ids.size());
  std::iota(nodes.rbegin(), nodes.rend(), Index{0});
  const Matrix &S = *modes->node_rows(nodes)->S, &S_all = *all->node_rows(nodes)->S;
  EXPECT_LT((S - S_all).norm(), 1e-11 * S_all.norm());
  EXPECT_EQ((S - S.transpose()).norm(), 0);
  const Matrix F =
      Matrix::NullaryExpr(m.superelement->n(), 3, [](Index i, Index j) { return std::cos(double(3 * i * i + 5 * j)); });
  EXPECT_LT((modes->part->times(F) - all->part->times(F)).norm(), 1e-11 * all->part->times(F).norm());
  ScaledBody body("body", from_matrices, oblique(mirrored));
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), oblique(mirrored), Scheme::exact);
  expect_equal_motion(body, reference, 1.9 / clip, 100, 1e-9);
}

void compare(const Case& c) {
  const test::Model m = model_of(c);
  const double clip = c.clip * m.form->omega.maxCoeff();
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(c.mirrored));
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), oblique(c.mirrored), Scheme::exact);
  expect_equal_motion(body, reference, 1.9 / clip, 150, 1e-11);
}

TEST(ScaledBody, FreeMovesAsAllModesSlowedOneByOne) {
  for (const bool mirrored : {false, true}) compare({Shape::free, mirrored});
}

TEST(ScaledBody, HeldMovesAsAllModesSlowedOneByOne) {
  for (const bool mirrored : {false, true}) compare({Shape::held, mirrored});
}

TEST(ScaledBody, HingedMovesAsAllModesSlowedOneByOne) { compare({Shape::hinged, true}); }

TEST(ScaledBody, WithoutModalCoordinates) {
  compare({Shape::free, false, 0});
  compare({Shape::held, true, 0});
}

TEST(ScaledBody, FromTheMatricesAlone) {
  compare_ways(Shape::free, 12, 0.35, false);
  compare_ways(Shape::free, 0, 0.3, true);
  compare_ways(Shape::held, 12, 0.3, true);
  compare_ways(Shape::held, 0, 0.3, false);
  compare_ways(Shape::hinged, 12, 0.3, false);
}

TEST(ScaledBody, FromTheMatricesWithAClipBelowAllElasticModes) {
  compare_ways(Shape::free, 12, 1e-3, true);
  compare_ways(Shape::held, 5, 1e-3, true);
}

TEST(ScaledBody, FromTheMatricesWithAHighClipTakesAllModes) {
  for (const Shape shape : {Shape::free, Shape::held}) {
    const test::Model m = model_of({shape});
    const double highest = m.form->omega.maxCoeff();
    const auto model = scaled_model(m.superelement, held_directions(shape), "test");
    for (const double share : {0.8, 1.1}) {
      const auto modes = model->clipped(share * highest);
      EXPECT_EQ(modes->method, "all modes");
      EXPECT_EQ(modes->part != nullptr, share < 1);
      EXPECT_LT((modes->omega - m.form->omega.head(modes->n_kept())).norm(), 1e-9 * highest);
    }
  }
}

TEST(ScaledBody, ClipBelowAllElasticModesAndAboveAll) {
  for (const double clip : {1e-3, 1.0}) {
    compare({Shape::free, false, 10, clip});
    compare({Shape::held, true, 10, clip});
  }
}

TEST(ScaledBody, ClipAboveAllModesScalesNothing) {
  const test::Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(false));
  const Index set = body.track({0, 4});
  const double highest = body.largest_frequency();
  body.scale(1.5 * highest);
  EXPECT_FALSE(body.is_scaled());
  EXPECT_EQ(body.n_scaled(), 0);
  EXPECT_EQ(body.largest_frequency(), highest);
  SuperelementBody exact("body", m.superelement, m.form, oblique(false), Scheme::exact);
  const Index same = exact.track({0, 4});
  std::mt19937 random(3);
  const Points p = random_points(random, 2, 1);
  Points x, x_exact;
  for (int i = 0; i < 5; ++i) {
    body.predict(0.01 * i, 0.01), exact.predict(0.01 * i, 0.01);
    body.add_impulses(set, p), exact.add_impulses(same, p);
    body.accept(), exact.accept();
  }
  body.positions(set, x), exact.positions(same, x_exact);
  EXPECT_LT(difference(x, x_exact), 1e-13);
}

TEST(ScaledBody, BodyThatNothingTouchesIsExact) {
  const test::Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(false));
  body.scale(0.2 * body.largest_frequency());
  EXPECT_FALSE(body.is_scaled());
  body.predict(0, 3), body.accept();
  EXPECT_LT((body.state().center_of_mass - oblique(false).T * m.superelement->rigid_body.center - oblique(false).position -
             3 * oblique(false).velocity)
                .norm(),
            1e-12);
}

TEST(ScaledBody, StaticsAreThoseOfAllModes) {
  const test::Model m = model_of({Shape::held});
  std::mt19937 random(11);
  const std::vector<Index> nodes{1, 3, 5};
  const auto model = scaled_model(m.superelement, m.form);
  const auto shared = model->clipped(0.1 * m.form->omega.maxCoeff());
  const ScaledModes& modes = *shared;
  ASSERT_GT(modes.n_scaled, 20);
  // u(t) = int_0^t S(t - s) ds f of a constant force: its static part is V_lo omega^-2 V_lo^T + S / clip^2
  const auto rows = modes.node_rows(nodes);
  const Matrix statics =
      rows->Vt.transpose() * modes.omega.cwiseAbs2().cwiseInverse().asDiagonal() * rows->Vt + *rows->S / (modes.clip * modes.clip);
  Matrix all = Matrix::Zero(9, 9);
  Matrix V(9, m.form->omega.size());
  for (Index i = 0; i < 9; ++i) V.row(i) = m.form->V.row(displacement_rows(*m.superelement)(nodes[i / 3], i % 3));
  all = V * m.form->omega.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose();
  EXPECT_LT((statics - all).norm(), 1e-12 * all.norm());
  // A force that grows so slowly that nothing swings
  ScaledBody slow("body", model, Placement{});
  const Index same = slow.track(nodes);
  Points force = Points::Zero(slow.n_nodes(), 3);
  for (const Index node : nodes) force.row(node) = random_points(random, 1, 1).row(0);
  const double end = 1e7 / m.form->omega[0];
  slow.add_force(force, {{0, end}, {0, 1}});
  slow.scale(0.1 * m.form->omega.maxCoeff());
  slow.predict(0, end), slow.accept();
  Points x;
  slow.positions(same, x);
  const Points u = x - slow.reference_positions()(nodes, Eigen::all), f = force(nodes, Eigen::all);
  const Vector expected = all * Eigen::Map<const Vector>(f.data(), 9);
  EXPECT_LT((Eigen::Map<const Vector>(u.data(), 9) - expected).norm(), 1e-6 * expected.norm());
}

TEST(ScaledBody, ImpulsesChangeMomentumByTheirSum) {
  std::mt19937 random(1);
  for (const bool mirrored : {false, true}) {
    const test::Model m = model_of({});
    ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(mirrored));
    const Index set = body.track({0, 3, 5, 8, 9, 13});
    body.scale(0.3 * body.largest_frequency());
    const double h = 1.9 / body.largest_frequency();
    Vector3 momentum = body.state().momentum, angular = body.state().angular_momentum;
    const Vector3 center = body.state().center_of_mass;  // undeformed
    Points X = body.reference_positions()(std::vector<Index>{0, 3, 5, 8, 9, 13}, Eigen::all);
    double scale = momentum.norm(), angular_scale = angular.norm();
    for (int step = 0; step < 200; ++step) {
      const Points p = random_points(random, 6, step % 10 == 0 ? 0.3 : 0.0);
      const Vector3 drift = body.state().center_of_mass - center;
      for (Index i = 0; i < 6; ++i) angular += Vector3(X.row(i).transpose() + drift).cross(Vector3(p.row(i).transpose()));
      momentum += p.colwise().sum().transpose();
      body.predict(step * h, h);
      body.add_impulses(set, p);
      body.accept();
      scale = std::max(scale, momentum.norm()), angular_scale = std::max(angular_scale, angular.norm());
    }
    EXPECT_LT((body.state().momentum - momentum).norm(), 1e-13 * scale);
    EXPECT_LT((body.state().angular_momentum - angular).norm(), 1e-12 * angular_scale);
    EXPECT_GT(body.scaled_energy(), 0);
    EXPECT_LT(body.scaled_energy(), energy(body));
  }
}

TEST(ScaledBody, ResponseIsWhatImpulsesDoAndIsShared) {
  std::mt19937 random(2);
  const test::Model m = model_of({});
  const auto shared = scaled_model(m.superelement, m.form);
  ScaledBody one("one", shared, oblique(false)), two("two", shared, oblique(true));
  for (ScaledBody* body : {&one, &two}) {
    body->track({0, 3, 5, 11});
    body->scale(0.4 * shared->largest_frequency());
    const double h = 1.9 / body->largest_frequency();
    const NodeResponse S = body->response(0, h);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix>(S.dense()).eigenvalues().minCoeff(), 0);
    Points before, after;
    body->predict(0, h);
    body->predicted_positions(0, before);
    const Points p = random_points(random, 4, 1);
    body->add_impulses(0, p);
    body->predicted_positions(0, after);
    const Points moved = after - before;
    const Vector expected = S.dense() * Eigen::Map<const Vector>(p.data(), p.size());
    EXPECT_LT((Eigen::Map<const Vector>(moved.data(), 12) - expected).norm(), 1e-12 * expected.norm());
  }
  const double h = 1.9 / one.largest_frequency();
  EXPECT_EQ(one.response(0, h).block.get(), two.response(0, h).block.get());
}

TEST(ScaledBody, MovesThatAreKnownNeedNoProduct) {
  std::mt19937 random(9);
  for (const Shape shape : {Shape::free, Shape::hinged}) {
    const test::Model m = model_of({shape});
    const auto model = scaled_model(m.superelement, m.form);
    ScaledBody known("known", model, oblique(true)), plain("plain", model, oblique(true));
    for (ScaledBody* body : {&known, &plain}) {
      body->track({0, 3, 5, 11});
      body->add_gravity(Vector3(0, 3, -9), {{0, 0.1, 0.2}, {0, 1, -1}});
      body->scale(0.3 * m.form->omega.maxCoeff());
    }
    const double h = 2 / known.largest_frequency(), start = energy(known);
    double largest = start;
    Points x, y;
    for (int step = 0; step < 100; ++step) {
      known.predict(step * h, h), plain.predict(step * h, h);
      const Points p = random_points(random, 4, 0.5);
      const Points rub = step % 3 == 0 ? random_points(random, 4, 0.1) : Points(Points::Zero(4, 3));
      Points move = Points::Zero(4, 3);
      known.response(0, h).add_product(p + rub, move);
      known.add_answered_impulses(0, p, rub, move);
      plain.add_impulses(0, p), plain.add_impulses(0, rub, ImpulseKind::friction);
      known.predicted_positions(0, x), plain.predicted_positions(0, y);
      EXPECT_LT(difference(x, y), 1e-12);
      known.accept(), plain.accept();
      largest = std::max(largest, energy(known));
      const BodyWork work = known.work();
      EXPECT_LT(std::abs(energy(known) - start - work.external - work.contact - work.friction), 1e-12 * largest) << step;
    }
    EXPECT_NEAR(known.work().friction, plain.work().friction, 1e-12 * largest);
    EXPECT_NEAR(known.scaled_energy(), plain.scaled_energy(), 1e-12 * largest);
  }
}

TEST(ScaledBody, MotionBoundHoldsTheMotion) {
  std::mt19937 random(5);
  for (const bool loaded : {false, true}) {
    const test::Model m = model_of({loaded ? Shape::hinged : Shape::free});
    ScaledBody body("body", scaled_model(m.superelement, m.form), oblique(loaded));
    const Index set = body.track({0, 2, 6, 9});
    if (loaded) body.add_force(random_points(random, body.n_nodes(), 5.0), {{0, 0.2, 0.4}, {0, 1, -1}});
    body.scale(0.2 * body.largest_frequency());
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
        EXPECT_TRUE((x.row(i).transpose().array() <= (bound.upper + t * bound.upper_speed + spread).array() + 1e-12).all());
        EXPECT_TRUE((x.row(i).transpose().array() >= (bound.lower + t * bound.lower_speed - spread).array() - 1e-12).all());
      }
    }
  }
}

TEST(ScaledBody, EveryDofHeldStandsStill) {
  test::Model m = test::model(test::reduce(block(), test::x_nodes(block(), false, true), 0));
  std::vector<HeldDirection> held;
  for (Index node = 0; node < m.superelement->coordinates.rows(); ++node)
    for (int c = 0; c < 3; ++c) held.push_back({node, Vector3::Unit(c)});
  auto form = std::make_shared<DiagonalForm>();
  form->V.resize(m.superelement->n(), 0), form->E.resize(0, 6);
  ScaledBody body("body", scaled_model(m.superelement, form), oblique(true));
  const Index set = body.track({0, 1});
  body.add_gravity(Vector3(0, 0, -9), {});
  body.scale(100);
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
  const test::Model m = model_of({});
  const double clip = 0.3 * m.form->omega.maxCoeff();
  ScaledBody body("body", scaled_model(m.superelement, m.form), Placement{});
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), Placement{}, Scheme::exact);
  body.track({6}), reference.track({6});
  body.scale(clip);
  Points p(1, 3), x, x_all;
  p << 1, -2, 3;
  for (int i = 0; i < 20; ++i) {
    body.predict(0, 1 / clip), reference.predict(0, 1 / clip);
    if (i % 5 == 0) body.add_impulses(0, p), reference.add_impulses(0, p);
    body.accept(), reference.accept();
  }
  body.positions(0, x), reference.positions(0, x_all);
  EXPECT_LT(difference(x, x_all), 1e-12);
  Vector q, rates, q_all, rates_all;
  body.coordinates(q, rates), reference.coordinates(q_all, rates_all);
  EXPECT_LT((q - q_all).norm(), 1e-11 * q_all.norm());
}

TEST(ScaledBody, RefusesWhatNeedsNodalMasses) {
  const test::Model m = model_of({});
  ScaledBody body("body", scaled_model(m.superelement, m.form), Placement{});
  const Index set = body.track({1});
  body.scale(10);
  EXPECT_THROW(body.nodal_masses(set), RunError);
  EXPECT_THROW(body.add_velocities(set, Points::Zero(1, 3), Vector3::Zero()), RunError);
}

}  // namespace
}  // namespace cbr
