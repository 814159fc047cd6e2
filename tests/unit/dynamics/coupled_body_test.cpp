// SPDX-License-Identifier: GPL-3.0-or-later
// Coupled bodies against dense algebra and against what must be conserved.
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

#include "tests/unit/dynamics/bricks.hpp"
#include "tests/unit/dynamics/coupled_parts.hpp"

namespace cbr::coupled_body_test {
namespace {

using test::chain;
using test::chain_with_shells;
using test::Method;
using test::methods;
using test::oblique;
using test::ramp;
using test::random_points;
using test::shared;
using test::some_held;

std::vector<std::shared_ptr<const CoupledModel>> all_models() {
  const test::Brick lumped = test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2});
  const test::Brick full =
      test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2}, MassKind::consistent);
  return {shared(chain(1, 5).model()), shared(chain(3, 4).model()), shared(chain_with_shells(3)),
          shared(coupled_model(lumped.fe, lumped.geometry.coordinates)),
          shared(coupled_model(full.fe, full.geometry.coordinates))};
}

double energy(const Body& body) { return body.state().kinetic_energy + body.state().strain_energy; }
double booked(const Body& body) {
  return body.work().external + body.work().contact + body.work().numerical;
}

std::vector<Index> all_nodes(const Body& body) {
  std::vector<Index> nodes = first_numbers(body.n_nodes());
  return nodes;
}

// The equations as they stand, on the free coordinates: q = Z y.
struct Dense {
  Matrix Z, K, M, A;
  std::optional<Ldlt> mass, system;
  Vector y, v, a, f, p;
  Method method;

  Dense(const CoupledModel& model, const std::vector<HeldDirection>& held, Method m)
      : Z(test::whole_free_basis(model, held)), method(m) {
    K = Z.transpose() * test::whole_stiffness(model) * Z;
    M = Z.transpose() * test::whole_mass(model) * Z;
    mass.emplace(M);
    y = Vector::Zero(M.rows());
  }

  void step(double h, double last_h, double f0, double f1, bool kick) {
    if (method.scheme == Scheme::central_difference) {
      const Vector a0 = mass->solve(f0 * f - K * y);
      if (last_h == 0) {
        v -= 0.5 * h * a0;
        last_h = h;
      }
      v += 0.5 * (last_h + h) * a0;
      if (kick) v += mass->solve(p);
      y += h * v;
      return;
    }
    const double alpha = method.alpha, beta = 0.25 * (1 - alpha) * (1 - alpha), gamma = 0.5 - alpha;
    if (last_h == 0) a = mass->solve(f0 * f - K * y);
    if (h != last_h) system.emplace(M + (1 + alpha) * beta * h * h * K);
    const Vector dv = kick ? Vector(mass->solve(p)) : Vector(Vector::Zero(p.size()));
    const Vector start = y + h * v + 0.5 * h * dv + h * h * (0.5 - beta) * a;
    const Vector a1 = system->solve((1 + alpha) * (f1 * f - K * start) - alpha * (f0 * f - K * y));
    v += h * ((1 - gamma) * a + gamma * a1) + dv;
    y = start + h * h * beta * a1;
    a = a1;
  }
};

TEST(CoupledBody, IsTheSchemeOfTheDenseMatrices) {
  std::mt19937 random(7);
  for (const auto& model : all_models()) {
    for (const bool hold : {false, true}) {
      for (const Method& method : methods) {
        const auto held = hold ? some_held() : std::vector<HeldDirection>{};
        const Placement placement = oblique(true);
        const auto body = coupled_body("b", model, placement, held, method.scheme, {method.alpha});
        const Index set = body->track({2, 5, 7});
        Dense dense(*model, held, method);
        const Index n_modal = model->n_modal(), n = body->n_nodes();
        ASSERT_EQ(body->n_dofs(), dense.Z.cols());
        // The same in component axes
        const auto local = [&](const Points& x, const std::vector<Index>& nodes) {
          Vector f = Vector::Zero(model->n());
          for (Index i = 0; i < x.rows(); ++i)
            f.segment<3>(n_modal + 3 * nodes[i]) = placement.T.transpose() * x.row(i).transpose();
          return Vector(dense.Z.transpose() * f);
        };
        const Points force = random_points(random, n, 1), impulse = random_points(random, 3, 1);
        body->prepare({.loads = {force_load(force, ramp)}});
        dense.f = local(force, all_nodes(*body));
        dense.p = local(impulse, {2, 5, 7});
        const Vector rigid =
            rigid_motions(*model).leftCols(3) * (placement.T.transpose() * placement.velocity);
        dense.v = dense.mass->solve(dense.Z.transpose() * Vector(test::whole_mass(*model) * rigid));
        const double share = method.scheme == Scheme::newmark ? 6 : 1.5;
        double t = 0, last_h = 0;
        for (int step = 0; step < 40; ++step) {
          const double h = (step < 30 ? share : 0.7) / body->largest_frequency();
          dense.step(h, last_h, history_value(ramp, t), history_value(ramp, t + h), step % 9 == 3);
          body->predict(t, h);
          if (step % 9 == 3) body->add_impulses(set, impulse);
          body->accept();
          t += h;
          last_h = h;
        }
        Vector q, rates;
        body->coordinates(q, rates);
        EXPECT_LT((q - dense.Z * dense.y).norm(), 1e-10 * q.norm());
        if (method.scheme == Scheme::newmark) {
          EXPECT_LT((rates - dense.Z * dense.v).norm(), 1e-10 * rates.norm());
        }
        for (const HeldDirection& h : held)
          EXPECT_LT(std::abs(h.direction.dot(q.segment<3>(n_modal + 3 * h.node))),
                    1e-13 * q.norm());
      }
    }
  }
}

TEST(CoupledBody, EnergyBalanceClosesToRoundOff) {
  std::mt19937 random(3);
  for (const auto& model : all_models()) {
    for (const bool hold : {false, true}) {
      for (const Method& method : methods) {
        const auto body = coupled_body("b", model, oblique(true),
                                       hold ? some_held() : std::vector<HeldDirection>{},
                                       method.scheme, {method.alpha});
        const Index set = body->track({1, 4, 7});
        body->prepare({.loads = {force_load(random_points(random, body->n_nodes(), 1), ramp),
                                 gravity_load(Vector3(0, 0, -9.81))}});
        const double share = method.scheme == Scheme::newmark ? 10 : 1.2, start = energy(*body);
        double t = 0, largest = start;
        for (int step = 0; step < 200; ++step) {
          const double h = (step < 120 ? share : 0.5 * share) / body->largest_frequency();
          body->predict(t, h);
          if (step % 7 == 0) body->add_impulses(set, random_points(random, 3, 0.1));
          if (step % 11 == 0) body->add_impulses(set, random_points(random, 3, 0.1));
          if (step % 13 == 0 && method.scheme == Scheme::central_difference)
            body->add_velocities(set, random_points(random, 3, 0.05), Vector3(0.1, 0, -0.1));
          body->accept();
          t += h;
          largest = std::max(largest, energy(*body));
          EXPECT_LT(std::abs(energy(*body) - start - booked(*body)), 2e-11 * largest)
              << step << " " << method.alpha;
        }
        EXPECT_GT(std::abs(body->work().contact), 1e-6 * largest);
        if (method.scheme == Scheme::newmark && method.alpha == 0) {
          EXPECT_EQ(body->work().numerical, 0);
        }
      }
    }
  }
}

TEST(CoupledBody, ResponseIsWhatImpulsesDoAndMomentumIsTheirs) {
  std::mt19937 random(2);
  for (const auto& model : all_models()) {
    for (const Method& method : methods) {
      const auto body = coupled_body("b", model, oblique(true), {}, method.scheme, {method.alpha});
      const auto nodes = all_nodes(*body);
      const Index set = body->track(nodes);
      const double h = (method.scheme == Scheme::newmark ? 6 : 1.9) / body->largest_frequency();
      const NodeResponse S = body->response(set, h);
      Points before, after;
      body->predict(0, h);
      body->predicted_positions(set, before);
      const Points p = random_points(random, body->n_nodes(), 1);
      const Eigen::Map<const Vector> p_flat(p.data(), p.size());
      body->add_impulses(set, p);
      body->predicted_positions(set, after);
      const Points moved = after - before;
      const Vector expected =
          S.is_diagonal() ? Vector(S.diagonal.cwiseProduct(p_flat)) : Vector(S.dense() * p_flat);
      EXPECT_LT((Eigen::Map<const Vector>(moved.data(), moved.size()) - expected).norm(),
                1e-11 * expected.norm());
      if (!S.is_diagonal()) {
        EXPECT_GT(symmetric_eigenvalues(S.dense()).minCoeff(), 0);
      }
      body->accept();

      const BodyState start = body->state();
      Vector3 momentum = start.momentum, angular = start.angular_momentum;
      const Vector3 center = body->reference_positions().colwise().mean().transpose() * 0 +
                             oblique(true).T * model->rigid_body.center + oblique(true).position;
      double scale = momentum.norm(), angular_scale = angular.norm();
      for (int step = 1; step < 100; ++step) {
        const Points q = random_points(random, body->n_nodes(), step % 10 == 0 ? 0.3 : 0.0);
        // Arms are those of the undeformed body, which moves on while a force of Newmark acts.
        const Vector3 before_step = body->state().center_of_mass;
        body->predict(step * h, h);
        body->add_impulses(set, q);
        body->accept();
        Vector3 drift = before_step - center;
        if (method.scheme == Scheme::newmark)
          drift = 0.5 * (before_step + body->state().center_of_mass) - center;
        for (Index i = 0; i < q.rows(); ++i)
          angular += Vector3(body->reference_positions().row(i).transpose() + drift)
                         .cross(Vector3(q.row(i).transpose()));
        momentum += q.colwise().sum().transpose();
        scale = std::max(scale, momentum.norm());
        angular_scale = std::max(angular_scale, angular.norm());
      }
      EXPECT_LT((body->state().momentum - momentum).norm(), 1e-10 * scale);
      EXPECT_LT((body->state().angular_momentum - angular).norm(), 1e-10 * angular_scale);
    }
  }
}

TEST(CoupledBody, ABodyThatIsHeldWhollyStays) {
  std::vector<HeldDirection> held;
  const test::Brick b = test::make_brick({1, 1, 1}, Vector3(1, 1, 1), {100, 0.3, 2});
  for (Index i = 0; i < 8; ++i)
    for (int c = 0; c < 3; ++c) held.push_back({i, Vector3::Unit(c)});
  const test::Lattice block = test::lattice({3, 2, 2}, 0.1, 2e3, 0.5);
  const auto superelement =
      std::make_shared<Superelement>(test::reduce(block, test::x_nodes(block, true, true), 0));
  for (const auto& model :
       {shared(coupled_model(b.fe, b.geometry.coordinates)), shared(coupled_model(superelement))}) {
    for (const Method& method : methods) {
      const auto body =
          coupled_body("b", model, oblique(true), held, method.scheme, {method.alpha});
      EXPECT_EQ(body->n_dofs(), 0);
      EXPECT_EQ(body->largest_frequency(), 0);
      const Index set = body->track({0, 1});
      EXPECT_EQ(body->response(set, 0.1).dense().norm(), 0);
      body->prepare({.loads = {gravity_load(Vector3(0, 0, -1))}});
      body->predict(0, 0.1);
      body->add_impulses(set, Points::Ones(2, 3));
      body->accept();
      EXPECT_EQ(energy(*body), 0);
      EXPECT_EQ(body->state().momentum.norm(), 0);
    }
  }
}

}  // namespace
}  // namespace cbr::coupled_body_test
