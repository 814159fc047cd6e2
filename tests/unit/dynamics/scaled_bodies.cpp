// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/scaled_bodies.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cbr::test {

const Lattice& block() {
  static const Lattice body = lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  return body;
}

std::vector<HeldDirection> held_directions(Shape shape) {
  std::vector<HeldDirection> held;
  if (shape == Shape::held) {
    for (const Index node : {0, 2, 4}) held.push_back({node, Vector3(1, 1, 0).normalized()});
    held.push_back({2, Vector3(0, 0, 1)});
    held.push_back({0, Vector3(1, -1, 0).normalized()});
    held.push_back({7, Vector3(0, 0, 1)});
    held.push_back({4, Vector3(0, 0, 1)});
  }
  if (shape == Shape::hinged) {
    for (const Index node : {0, 2})
      for (int c = 0; c < 3; ++c) held.push_back({node, Vector3::Unit(c)});
  }
  return held;
}

Model model_of(const Case& c) {
  Model m = model(reduce(block(), x_nodes(block(), true, true), c.k));
  if (c.shape != Shape::free)
    m.form = std::make_shared<DiagonalForm>(
        held_diagonal_form(*m.superelement, held_directions(c.shape), "test"));
  return m;
}

std::shared_ptr<const DiagonalForm> slowed(const DiagonalForm& form, double clip) {
  auto slow = std::make_shared<DiagonalForm>(form);
  for (Index j = 0; j < form.omega.size(); ++j) {
    const double scale = form.omega[j] > clip ? clip / form.omega[j] : 1;
    slow->omega[j] *= scale;
    slow->V.col(j) *= scale;
    slow->E.row(j) *= scale;
  }
  return slow;
}

void expect_equal_motion(Body& body, Body& reference, double h, int steps, double tolerance,
                         double contact_step) {
  std::mt19937 random(7);
  const std::vector<Index> some{3, 0, 7, 12}, others{12, 5};
  Index sets[2][2], means[2];
  Body* const both[] = {&body, &reference};
  const Points force = random_points(random, body.n_nodes(), 4.0);
  for (int b = 0; b < 2; ++b) {
    sets[b][0] = both[b]->track(some);
    sets[b][1] = both[b]->track(others);
    means[b] = both[b]->track_mean({1, 2, 3, 9});
    both[b]->prepare(
        {.loads = {force_load(force, {{0.0, 0.013, 0.041, 0.3}, {1.0, 3.0, -2.0, 0.5}}),
                   gravity_load(Vector3(1, -3, -9.81))},
         .contact_step = contact_step,
         .clip = reference.largest_frequency()});
  }
  for (const int set : {0, 1}) {
    const Matrix S = body.response(sets[0][set], h).dense(),
                 S_all = reference.response(sets[1][set], h).dense();
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
    body.predicted_positions(sets[0][0], x);
    reference.predicted_positions(sets[1][0], x_all);
    ASSERT_LT(difference(x, x_all), tolerance * std::max(1.0, x_all.cwiseAbs().maxCoeff())) << step;
    body.accept();
    reference.accept();
    body.positions(sets[0][1], x);
    reference.positions(sets[1][1], x_all);
    ASSERT_LT(difference(x, x_all), tolerance * std::max(1.0, x_all.cwiseAbs().maxCoeff())) << step;
    largest = std::max(largest, energy(reference));
    const double work[2] = {
        body.work().external + body.work().contact + body.work().friction,
        reference.work().external + reference.work().contact + reference.work().friction};
    ASSERT_LT(std::abs(energy(body) - start[0] - work[0]), 1e-12 * largest) << step;
  }
  EXPECT_NEAR(energy(body), energy(reference), tolerance * largest);
  EXPECT_NEAR(body.work().contact, reference.work().contact, tolerance * largest);
  EXPECT_NEAR(body.work().friction, reference.work().friction, tolerance * largest);
  const BodyState state = body.state(), all = reference.state();
  EXPECT_LT((state.momentum - all.momentum).norm(),
            tolerance * std::max(50.0, all.momentum.norm()));
  EXPECT_LT((state.angular_momentum - all.angular_momentum).norm(),
            tolerance * std::max(100.0, all.center_of_mass.norm() * all.momentum.norm()));
  EXPECT_LT((state.center_of_mass - all.center_of_mass).norm(),
            tolerance * std::max(1.0, all.center_of_mass.norm()));
  EXPECT_NEAR(state.rotation, all.rotation, tolerance * 10 * std::max(1.0, all.rotation));
  Vector3 position, velocity, position_all, velocity_all;
  body.mean_motion(means[0], position, velocity);
  reference.mean_motion(means[1], position_all, velocity_all);
  EXPECT_LT((position - position_all).norm(), tolerance * std::max(1.0, position_all.norm()));
  EXPECT_LT((velocity - velocity_all).norm(), tolerance * velocity_all.norm() * 10);
  body.displacements(u, v);
  reference.displacements(u_all, v_all);
  EXPECT_LT(difference(u, u_all), tolerance * std::max(1.0, u_all.norm()));
  EXPECT_LT(difference(v, v_all), tolerance * v_all.norm());
  Vector q, rates, q_all, rates_all;
  body.coordinates(q, rates);
  reference.coordinates(q_all, rates_all);
  EXPECT_LT((q - q_all).norm(), tolerance * q_all.norm());
  EXPECT_LT((rates - rates_all).norm(), tolerance * rates_all.norm());
}

}  // namespace cbr::test
