// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement under Newmark's method and HHT-alpha.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <random>
#include <utility>

#include "common/linalg/dense.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::newmark_test {
namespace {

using test::random_points;

constexpr double alphas[] = {0.0, -0.1, -1.0 / 3};

Superelement reduced(Index k) {
  const test::Lattice block = test::lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  return test::reduce(block, test::x_nodes(block, true, true), k);
}

ModalBody make_body(Index k, double alpha, const Placement& placement = {}) {
  const auto model = test::model(reduced(k));
  return {"body",    model.superelement, model.form,
          placement, Scheme::newmark,    NewmarkOptions{alpha}};
}

std::pair<Vector, Vector> coordinates(const Body& body) {
  std::pair<Vector, Vector> of;
  body.coordinates(of.first, of.second);
  return of;
}

double energy(const Body& body) { return body.state().kinetic_energy + body.state().strain_energy; }

const History ramp{{0.0, 0.013, 0.041, 0.3}, {1.0, 3.0, -2.0, 0.5}};

// The equations as they stand, with dense matrices: accelerations from M a_1 + (1 + alpha) (K u_1 -
// f_1) - alpha (K u_0 - f_0) = 0.
TEST(Newmark, IsTheSchemeOfTheDenseMatrices) {
  for (const double alpha : alphas) {
    const Superelement s = reduced(6);
    const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
    const double beta = 0.25 * (1 - alpha) * (1 - alpha), gamma = 0.5 - alpha;
    const auto model = test::model(s);
    ModalBody body("body", model.superelement, model.form, Placement{}, Scheme::newmark,
                   NewmarkOptions{alpha});
    const Index set = body.track({2, 5});
    Points force = Points::Zero(body.n_nodes(), 3), impulse(2, 3);
    force.row(7) << 3, -1, 2;
    impulse << 1, 0, -3, 0.3, 1, 2;
    body.prepare({.loads = {force_load(force, ramp)}});
    Vector q = Vector::Zero(s.n()), v = q, f = q, p = q;
    f.segment<3>(s.k() + 21) << 3, -1, 2;
    p.segment<3>(s.k() + 6) << 1, 0, -3;
    p.segment<3>(s.k() + 15) << 0.3, 1, 2;
    Vector a = Ldlt(M).solve(f);
    double t = 0;
    for (int step = 0; step < 60; ++step) {
      const double h = (step < 40 ? 3.0 : 0.7) / body.largest_frequency(),
                   f0 = history_value(ramp, t), f1 = history_value(ramp, t + h);
      const Vector push = Ldlt(M).solve(step % 9 == 3 ? p : Vector(Vector::Zero(s.n())));
      const Vector start = q + h * v + h * h * (0.5 - beta) * a + 0.5 * h * push;
      const Vector a1 = Ldlt(M + (1 + alpha) * beta * h * h * K)
                            .solve((1 + alpha) * (f1 * f - K * start) - alpha * (f0 * f - K * q));
      v += h * ((1 - gamma) * a + gamma * a1) + push;
      q = start + h * h * beta * a1;
      a = a1;
      body.predict(t, h);
      if (step % 9 == 3) body.add_impulses(set, impulse);
      body.accept();
      t += h;
    }
    const auto [is_q, is_v] = coordinates(body);
    EXPECT_LT((is_q - q).norm(), 1e-9 * q.norm()) << alpha;
    EXPECT_LT((is_v - v).norm(), 1e-9 * v.norm()) << alpha;
  }
}

TEST(Newmark, ResponseIsWhatImpulsesDoAndTheInverseOfTheSystemMatrix) {
  std::mt19937 random(2);
  for (const double alpha : alphas) {
    ModalBody body = make_body(8, alpha, test::oblique(true));
    const Index set = body.track({0, 3, 5, 11});
    for (const double share : {0.5, 2.0, 300.0}) {
      const double h = share / body.largest_frequency();
      const NodeResponse S = body.response(set, h);
      EXPECT_GT(symmetric_eigenvalues(S.dense()).minCoeff(), 0);
      Points before, after;
      body.predict(0, h);
      body.predicted_positions(set, before);
      const Points p = random_points(random, 4, 1);
      body.add_impulses(set, 0.25 * p);
      body.add_impulses(set, 0.75 * p);
      body.predicted_positions(set, after);
      const Points moved = after - before;
      const Vector expected = S.dense() * Eigen::Map<const Vector>(p.data(), p.size());
      EXPECT_LT((Eigen::Map<const Vector>(moved.data(), 12) - expected).norm(),
                1e-10 * expected.norm());
    }
    // h / 2 A^-1 at the dofs of an upright body
    const Superelement s = reduced(8);
    ModalBody upright = make_body(8, alpha);
    const Index one = upright.track({4});
    const double h = 5 / upright.largest_frequency();
    const NewmarkOptions newmark{alpha};
    const Matrix A = reduced_mass(s) + newmark.stiffness_factor(h) * reduced_stiffness(s);
    const Matrix expected = (0.5 * h * Lu(A).inverse()).block<3, 3>(s.k() + 12, s.k() + 12);
    EXPECT_LT((upright.response(one, h).dense() - expected).norm(), 1e-10 * expected.norm());
  }
}

TEST(Newmark, MomentumIsThatOfTheImpulses) {
  std::mt19937 random(1);
  for (const double alpha : alphas) {
    ModalBody body = make_body(12, alpha, test::oblique(true));
    std::vector<Index> nodes = first_numbers(body.n_nodes());
    const Index set = body.track(nodes);
    const double h = 20 / body.largest_frequency();
    const Vector3 center = body.state().center_of_mass;
    Vector3 momentum = body.state().momentum, angular = body.state().angular_momentum;
    double scale = momentum.norm(), angular_scale = angular.norm();
    for (int step = 0; step < 200; ++step) {
      const Points p = random_points(random, body.n_nodes(), step % 10 == 0 ? 0.3 : 0.0);
      const Vector3 before = body.state().center_of_mass;
      body.predict(step * h, h);
      body.add_impulses(set, p);
      body.accept();
      // Arms are those of the undeformed body, as far on as it is on average
      const Vector3 drift = 0.5 * (before + body.state().center_of_mass) - center;
      for (Index i = 0; i < p.rows(); ++i)
        angular += Vector3(body.reference_positions().row(i).transpose() + drift)
                       .cross(Vector3(p.row(i).transpose()));
      momentum += p.colwise().sum().transpose();
      scale = std::max(scale, momentum.norm());
      angular_scale = std::max(angular_scale, angular.norm());
    }
    EXPECT_LT((body.state().momentum - momentum).norm(), 1e-13 * scale);
    EXPECT_LT((body.state().angular_momentum - angular).norm(), 1e-12 * angular_scale);
  }
}

TEST(Newmark, EnergyBalanceClosesToRoundOff) {
  std::mt19937 random(3);
  for (const double alpha : alphas) {
    for (const double share : {1.2, 150.0}) {
      ModalBody body = make_body(12, alpha, test::oblique(true));
      const Index set = body.track({1, 4, 7});
      body.prepare({.loads = {force_load(random_points(random, body.n_nodes(), 4.0), ramp),
                              gravity_load(Vector3(0, 0, -9.81))}});
      const double start = energy(body);
      double largest = start, t = 0;
      for (int step = 0; step < 400; ++step) {
        const double h = (step < 200 ? 1 : 0.37) * share / body.largest_frequency();
        body.predict(t, h);
        if (step % 7 == 0) body.add_impulses(set, random_points(random, 3, 0.4));
        body.accept();
        t += h;
        largest = std::max(largest, energy(body));
        const BodyWork work = body.work();
        EXPECT_LT(std::abs(energy(body) - start - work.external - work.contact - work.numerical),
                  2e-12 * largest)
            << alpha << " " << step;
        if (alpha == 0) {
          EXPECT_EQ(work.numerical, 0);
        }
      }
      EXPECT_GT(largest, 2 * start);
    }
  }
}

// Struck once, and then left to itself.
TEST(Newmark, AverageAccelerationKeepsAllEnergyAndHhtTakesIt) {
  for (const double share : {0.2, 1.0, 2.0, 20.0, 200.0}) {
    for (const double alpha : alphas) {
      ModalBody body = make_body(20, alpha);
      const Index set = body.track({0});
      Points p(1, 3);
      p << 1, -2, 3;
      const double h = share / body.largest_frequency();
      body.predict(0, h);
      body.add_impulses(set, p);
      body.accept();
      const double struck = energy(body);
      double least = struck, most = struck;
      for (int step = 1; step < 5000; ++step) {
        body.predict(step * h, h);
        body.accept();
        least = std::min(least, energy(body));
        most = std::max(most, energy(body));
      }
      if (alpha == 0) {
        EXPECT_LT(most - least, 1e-12 * most) << share;
        EXPECT_NEAR(body.work().contact, most, 1e-12 * most);
      } else {
        EXPECT_LT(energy(body), (1 - 1e-6) * struck) << alpha << " " << share;
        EXPECT_LT(body.work().numerical, 0);
        EXPECT_LT(most, (1 + 2 * alpha * alpha) * struck);  // accelerations store some alpha^2
      }
    }
  }
}

// Coefficients that are rounded must not make modes gain or lose by some 1e-16 in every step: it
// adds up.
TEST(Newmark, EachModeKeepsItsEnergyInManySteps) {
  const auto s = std::make_shared<Superelement>(reduced(20));
  std::vector<HeldDirection> held;
  for (Index node = 0; node < 6; ++node)
    for (int d = 0; d < 3; ++d) held.push_back({node, Vector3::Unit(d)});
  const auto form = std::make_shared<ModalForm>(held_modal_form(*s, held, "body"));
  ASSERT_EQ(form->n_rigid, 0);
  const Matrix VtM = form->V.transpose() * reduced_mass(*s);
  constexpr int n = 100000;
  for (const double share : {0.3, 3.7, 60.0, 4e3}) {
    ModalBody body("body", s, form, Placement{}, Scheme::newmark, NewmarkOptions{});
    const double h = share / body.largest_frequency();
    std::mt19937 random(8);
    std::vector<Index> nodes = first_numbers(body.n_nodes());
    const Index set = body.track(nodes);
    const auto energies = [&] {
      const auto [q, rate] = coordinates(body);
      return Vector(form->omega.cwiseProduct(VtM * q).cwiseAbs2() + (VtM * rate).cwiseAbs2());
    };
    body.predict(0, h);
    body.add_impulses(set, random_points(random, body.n_nodes(), 1));
    body.accept();
    const Vector before = energies();
    for (int step = 1; step < n; ++step) {
      body.predict(step * h, h);
      body.accept();
    }
    const Vector after = energies();
    double worst = 0;
    for (Index j = 0; j < before.size(); ++j)
      if (before[j] > 1e-4 * before.maxCoeff())
        worst = std::max(worst, std::abs(after[j] / before[j] - 1));
    std::printf("omega_max h %g: a mode's energy drifts by up to %.1e in %d steps\n", share, worst,
                n);
    EXPECT_LT(worst, 2e-12) << share;
  }
}

// One mode by itself: the logarithmic decrement of HHT-alpha grows with omega h, and the period is
// longer by (omega h)^2 / 12.
TEST(Newmark, HhtDampsHighFrequenciesAndSparesLowOnes) {
  const auto left_after = [](double x, double alpha) {
    ModalBody body = make_body(20, alpha);
    const Index set = body.track({0});
    Points p(1, 3);
    p << 1, 0, 0;
    const double h = x / body.largest_frequency();
    body.predict(0, h);
    body.add_impulses(set, p);
    body.accept();
    const double start = energy(body) - 0.5 * body.state().momentum.squaredNorm() / 18;
    for (int step = 1; step < 100; ++step) {
      body.predict(step * h, h);
      body.accept();
    }
    return (energy(body) - 0.5 * body.state().momentum.squaredNorm() / 18) / start;
  };
  const double slow = left_after(0.02, -0.1), fast = left_after(2, -0.1),
               faster = left_after(20, -0.1);
  EXPECT_GT(slow, 0.999);
  EXPECT_LT(fast, 0.9 * slow);
  EXPECT_LT(faster, 0.9 * slow);
}

}  // namespace
}  // namespace cbr::newmark_test
