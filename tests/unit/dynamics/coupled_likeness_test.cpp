// SPDX-License-Identifier: GPL-3.0-or-later
// Coupled bodies against the bodies that they generalise, and against each other.
#include <gtest/gtest.h>

#include <random>

#include "common/linalg/dense.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "tests/unit/dynamics/bricks.hpp"
#include "tests/unit/dynamics/coupled_parts.hpp"

namespace cbr::coupled_likeness_test {
namespace {

using test::chain;
using test::Method;
using test::methods;
using test::oblique;
using test::ramp;
using test::random_points;
using test::shared;
using test::some_held;

void expect_equal_states(const Body& a, const Body& b, double tolerance) {
  const BodyState s = a.state(), r = b.state();
  const double energy = r.kinetic_energy + r.strain_energy;
  EXPECT_NEAR(s.kinetic_energy, r.kinetic_energy, tolerance * energy);
  EXPECT_NEAR(s.strain_energy, r.strain_energy, tolerance * energy);
  EXPECT_LT((s.center_of_mass - r.center_of_mass).norm(), tolerance);
  EXPECT_LT((s.momentum - r.momentum).norm(), tolerance * r.momentum.norm());
  EXPECT_LT((s.angular_momentum - r.angular_momentum).norm(),
            tolerance * (r.angular_momentum.norm() + r.momentum.norm()));
  EXPECT_NEAR(s.rotation, r.rotation, tolerance);
  EXPECT_NEAR(a.work().external, b.work().external, tolerance * energy);
  EXPECT_NEAR(a.work().contact, b.work().contact, tolerance * energy);
  EXPECT_NEAR(a.work().numerical, b.work().numerical, tolerance * energy);
  Points u, v, u_other, v_other;
  a.displacements(u, v);
  b.displacements(u_other, v_other);
  EXPECT_LT((u - u_other).norm(), tolerance * u.norm());
  EXPECT_LT((v - v_other).norm(), tolerance * v.norm());
}

// Impulses, loads, gravity and nodal velocities for both.
void move_alike(Body& a, Body& b, double share, double tolerance) {
  std::mt19937 random(11);
  const std::vector<Index> nodes{0, 3, 4, 7};
  Body* both[] = {&a, &b};
  const Points force = random_points(random, a.n_nodes(), 1);
  Index set = 0;
  for (Body* body : both) {
    set = body->track(nodes);
    body->prepare({.loads = {force_load(force, ramp), gravity_load(Vector3(0.1, 0.2, -1))}});
  }
  EXPECT_LT((a.nodal_masses(set) - b.nodal_masses(set)).norm(),
            tolerance * b.nodal_masses(set).norm());
  const double h = share / b.largest_frequency();
  for (int step = 0; step < 60; ++step) {
    const Points p = random_points(random, 4, 0.1);
    for (Body* body : both) {
      body->predict(step * h, h);
      if (step % 7 == 3) body->add_impulses(set, 1.1 * p);
      if (step % 11 == 5 && a.scheme() == Scheme::central_difference)
        body->add_velocities(set, 0.2 * p, p.colwise().sum().transpose());
      body->accept();
    }
    if (step % 10 == 9) expect_equal_states(a, b, tolerance);
  }
}

TEST(CoupledBody, OneSuperelementMovesAsModalBody) {
  const test::Lattice block = test::lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  for (const bool hold : {false, true}) {
    for (const Method& method : methods) {
      // nodal velocities at held nodes are not alike
      if (hold && method.scheme == Scheme::central_difference) continue;
      const auto held = hold ? some_held() : std::vector<HeldDirection>{};
      auto s =
          std::make_shared<Superelement>(test::reduce(block, test::x_nodes(block, true, true), 9));
      const auto body = coupled_body("b", shared(coupled_model(s)), oblique(true), held,
                                     method.scheme, {method.alpha});
      const auto form = std::make_shared<ModalForm>(hold ? held_modal_form(*s, held, "test")
                                                         : free_modal_form(*s, "test"));
      ModalBody other("b", s, form, oblique(true), method.scheme, {method.alpha});
      EXPECT_NEAR(body->largest_frequency() / other.largest_frequency(), 1, 1e-6);
      EXPECT_GE(body->largest_frequency(), other.largest_frequency() * (1 - 1e-12));
      const Index set = body->track({1, 5}), other_set = other.track({1, 5});
      const double h = 1.5 / other.largest_frequency();
      const Matrix response = body->response(set, h).dense();
      EXPECT_LT((response - other.response(other_set, h).dense()).norm(), 1e-12 * response.norm());
      // K multiplies rotations of radians, which modal coordinates keep apart
      const bool newmark = method.scheme == Scheme::newmark;
      move_alike(*body, other, newmark ? 5 : 1.5, newmark ? 1e-10 : 1e-11);
    }
  }
}

TEST(CoupledBody, MeshMovesAsMeshBody) {
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    for (const bool hold : {false, true}) {
      const auto held = hold ? some_held() : std::vector<HeldDirection>{};
      const test::Brick b = test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2}, mass);
      const auto body = coupled_body("b", shared(coupled_model(b.fe, b.geometry.coordinates)),
                                     oblique(true), held, Scheme::central_difference, {});
      const auto model = std::make_shared<MeshModel>(
          mesh_model(b.fe, b.geometry.coordinates, mass == MassKind::lumped));
      MeshBody other("b", model, oblique(true), held, std::make_shared<RowThreads>(1));
      EXPECT_NEAR(body->largest_frequency() / other.largest_frequency(), 1, 1e-9);
      const Index set = body->track({1, 5}), other_set = other.track({1, 5}),
                  at_held = body->track({1, 7});
      const NodeResponse response = body->response(set, 0.1),
                         expected = other.response(other_set, 0.1);
      EXPECT_EQ(response.is_diagonal(), mass == MassKind::lumped);
      EXPECT_LT((response.dense() - expected.dense()).norm(), 1e-12 * expected.dense().norm());
      EXPECT_EQ(body->response(at_held, 0.1).is_diagonal(), mass == MassKind::lumped && !hold);
      // Without nodal velocities, which a mesh takes as impulses
      std::mt19937 random(2);
      const Points force = random_points(random, other.n_nodes(), 0.01);
      const BodyPlan plan{.loads = {force_load(force, ramp), gravity_load(Vector3(0, 1, -1))}};
      body->prepare(plan);
      other.prepare(plan);
      const double h = 1.7 / other.largest_frequency();
      for (int step = 0; step < 100; ++step) {
        const Points p = random_points(random, 2, 0.01);
        body->predict(step * h, h);
        other.predict(step * h, h);
        if (step % 5 == 2) {
          body->add_impulses(set, p);
          other.add_impulses(other_set, p);
        }
        body->accept();
        other.accept();
      }
      expect_equal_states(*body, other, 1e-12);
    }
  }
}

// So few free dofs that Lanczos spans them all; two nodes are held whole, one in two directions
// that are oblique to the component.
TEST(CoupledBody, HeldMeshHasTheFrequencyOfWhatIsFree) {
  const Matrix3 T = oblique(true).T;
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    for (const Index n : {1, 2, 3}) {
      const test::Brick b = test::make_brick({n, 1, 1}, Vector3(1, 0.6, 0.5), {100, 0.3, 2}, mass);
      const Index n_nodes = b.geometry.coordinates.rows();
      std::vector<HeldDirection> held;
      std::vector<Index> free;
      Matrix R = Matrix::Zero(3 * n_nodes, 3 * n_nodes);  // displacements in the scene's axes
      for (Index i = 0; i < n_nodes; ++i) {
        R.block<3, 3>(3 * i, 3 * i) = T;
        for (int c = 0; c < 3; ++c)
          i < 2 || (i == 2 && c < 2) ? held.push_back({i, T.row(c).transpose()})
                                     : free.push_back(3 * i + c);
      }
      const Matrix K = Matrix(R * Matrix(b.fe.K) * R.transpose())(free, free),
                   M = Matrix(R * Matrix(b.fe.M) * R.transpose())(free, free);
      const Vector dense = generalized_eigen(K, M).values;
      const double omega = std::sqrt(dense.maxCoeff());
      const auto model = std::make_shared<MeshModel>(
          mesh_model(b.fe, b.geometry.coordinates, mass == MassKind::lumped));
      const auto of = [&](const std::vector<HeldDirection>& directions) {
        return MeshBody("b", model, oblique(true), directions, std::make_shared<RowThreads>(1))
            .largest_frequency();
      };
      EXPECT_NEAR(of(held) / omega, 1, 1e-9) << n;
      // Instances that are held alike share it, others do not
      EXPECT_EQ(of(held), of(held));
      EXPECT_EQ(of({}), model->largest_frequency);
      held.resize(6);
      EXPECT_GT(of(held), omega * (1 + 1e-6)) << n;
      EXPECT_EQ(model->of_held->known.size(), 2u);
    }
  }
}

TEST(CoupledBody, InstancesShareASystem) {
  const auto system =
      std::make_shared<CoupledSystem>(shared(chain(2, 3).model()), some_held(), "test");
  const auto alone = coupled_body("a", shared(chain(2, 3).model()), oblique(true), some_held(),
                                  Scheme::newmark, {-0.1});
  CoupledBody a("a", system, oblique(true), Scheme::newmark, {-0.1}),
      b("b", system, {}, Scheme::newmark, {0.0});
  const double h = 3 / system->largest_frequency();
  for (int step = 0; step < 20; ++step) {
    for (Body* body : {static_cast<Body*>(&a), static_cast<Body*>(&b), alone.get()})
      body->predict(step * h, h);
    for (Body* body : {static_cast<Body*>(&a), static_cast<Body*>(&b), alone.get()}) body->accept();
  }
  expect_equal_states(a, *alone, 1e-14);
}

}  // namespace
}  // namespace cbr::coupled_likeness_test
