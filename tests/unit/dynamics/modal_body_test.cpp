// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/modal_body.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::modal_body_test {
namespace {

using test::block;
using test::lattice;
using test::Lattice;
using test::oblique;
using test::random_points;

double energy(const Body& body) { return body.state().kinetic_energy + body.state().strain_energy; }

std::vector<Index> all_nodes(const Body& body) {
  std::vector<Index> nodes = first_numbers(body.n_nodes());
  return nodes;
}

ModalBody make_body(Index k, Scheme scheme, bool mirrored = false) {
  const auto model = test::model(test::reduce(block(), test::x_nodes(block(), true, true), k));
  return {"body", model.superelement, model.form, oblique(mirrored), scheme};
}

TEST(ModalBody, RigidFlightIsExact) {
  ModalBody body = make_body(10, Scheme::exact);
  const Index set = body.track(all_nodes(body));
  const BodyState before = body.state();
  EXPECT_LT((before.momentum - 18 * Vector3(2, -1, 0.5)).norm(), 1e-13 * before.momentum.norm());
  EXPECT_NEAR(before.kinetic_energy, 0.5 * 18 * 5.25, 1e-11);
  Points start, end;
  body.positions(set, start);
  body.predict(0, 3.0);
  body.accept();
  body.positions(set, end);
  EXPECT_LT(((end - start).rowwise() - 3 * Vector3(2, -1, 0.5).transpose()).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_LT(body.state().strain_energy, 1e-20);
}

TEST(ModalBody, ImpulsesChangeMomentumByTheirSum) {
  std::mt19937 random(1);
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference}) {
    for (const bool mirrored : {false, true}) {
      ModalBody body = make_body(12, scheme, mirrored);
      const Index set = body.track(all_nodes(body));
      const double h = 1.5 / body.largest_frequency();
      body.predict(0, h);
      body.accept();
      Vector3 momentum = body.state().momentum, angular = body.state().angular_momentum;
      double scale = momentum.norm(), angular_scale = angular.norm();
      // undeformed
      const Vector3 center = body.state().center_of_mass - h * body.state().momentum / 18;
      for (int step = 1; step <= 200; ++step) {
        const Points p = random_points(random, body.n_nodes(), step % 10 == 0 ? 0.3 : 0.0);
        // Arms are those of the undeformed body about its centre of mass.
        const Vector3 drift = body.state().center_of_mass - center;
        for (Index i = 0; i < p.rows(); ++i)
          angular += Vector3(body.reference_positions().row(i).transpose() + drift)
                         .cross(Vector3(p.row(i).transpose()));
        momentum += p.colwise().sum().transpose();
        body.predict(step * h, h);
        body.add_impulses(set, p);
        body.accept();
        scale = std::max(scale, momentum.norm());
        angular_scale = std::max(angular_scale, angular.norm());
      }
      EXPECT_LT((body.state().momentum - momentum).norm(), 1e-13 * scale);
      EXPECT_LT((body.state().angular_momentum - angular).norm(), 1e-12 * angular_scale);
    }
  }
}

TEST(ModalBody, ResponseIsWhatImpulsesDo) {
  std::mt19937 random(2);
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference}) {
    ModalBody body = make_body(8, scheme, true);
    const Index set = body.track({0, 3, 5, 11});
    const double h = 1.9 / body.largest_frequency();
    const NodeResponse S = body.response(set, h);
    EXPECT_FALSE(S.is_diagonal());
    EXPECT_GT(symmetric_eigenvalues(S.dense()).minCoeff(), 0);
    Points before, after;
    body.predict(0, h);
    body.predicted_positions(set, before);
    const Points p = random_points(random, 4, 1);
    body.add_impulses(set, p);
    body.predicted_positions(set, after);
    const Points moved = after - before;
    const Vector expected = S.dense() * Eigen::Map<const Vector>(p.data(), p.size());
    EXPECT_LT((Eigen::Map<const Vector>(moved.data(), 12) - expected).norm(),
              1e-12 * expected.norm());
  }
}

TEST(ModalBody, EnergyBalanceClosesToRoundOff) {
  std::mt19937 random(3);
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference}) {
    ModalBody body = make_body(12, scheme);
    const Index set = body.track({1, 4, 7});
    body.prepare({.loads = {force_load(random_points(random, body.n_nodes(), 4.0),
                                       {{0.0, 0.013, 0.041, 0.3}, {1.0, 3.0, -2.0, 0.5}}),
                            gravity_load(Vector3(0, 0, -9.81))}});
    const double start = energy(body);
    double largest = start, t = 0;
    for (int step = 0; step < 400; ++step) {
      // What a change of the step brings to the leapfrog's energy is booked too.
      const double h = (step < 250 ? 1.2 : step < 300 ? 0.5 : 0.8) / body.largest_frequency();
      body.predict(t, h);
      t += h;
      if (step % 7 == 0) body.add_impulses(set, random_points(random, 3, 0.4));
      if (step % 11 == 0)
        body.add_velocities(set, random_points(random, 3, 0.05), Vector3(0.1, 0, -0.1));
      body.accept();
      largest = std::max(largest, energy(body));
      const BodyWork work = body.work();
      EXPECT_LT(std::abs(energy(body) - start - work.external - work.contact - work.numerical),
                2e-12 * largest)
          << step;
    }
    EXPECT_GT(largest, 2 * start);
  }
}

TEST(ModalBody, AllModesAreTheFullModel) {
  const Lattice& full = block();
  const Index N = full.mass.size();
  // Exact motion of the full model from its own eigenvectors, against the superelement with every
  // mode kept.
  Vector m(3 * N);
  for (Index i = 0; i < 3 * N; ++i) m[i] = full.mass[i / 3];
  const SymmetricEigen modes = generalized_eigen(full.K, Matrix(m.asDiagonal()));
  const auto nodes = test::x_nodes(full, true, true);
  const auto model =
      test::model(test::reduce(full, nodes, 3 * (N - static_cast<Index>(nodes.size()))));
  ModalBody body("body", model.superelement, model.form, Placement{}, Scheme::exact);
  const Index set = body.track(all_nodes(body));
  Points p = Points::Zero(body.n_nodes(), 3);
  p(0, 0) = 1;
  p(5, 1) = -2;
  p(7, 2) = 0.5;
  Vector impulse = Vector::Zero(3 * N);
  for (Index i = 0; i < p.rows(); ++i) impulse.segment<3>(3 * nodes[i]) = p.row(i).transpose();
  const double t = 0.37;
  body.predict(0, t);
  body.add_impulses(set, p);
  body.accept();
  const Vector lambda = modes.values;
  Vector eta = modes.vectors.transpose() * impulse;
  for (Index j = 0; j < eta.size(); ++j)
    eta[j] *= j < 6 ? t : std::sin(std::sqrt(lambda[j]) * t) / std::sqrt(lambda[j]);
  const Vector u = modes.vectors * eta;
  Points x;
  body.positions(set, x);
  for (Index i = 0; i < p.rows(); ++i)
    EXPECT_LT(
        (x.row(i) - body.reference_positions().row(i) - u.segment<3>(3 * nodes[i]).transpose())
            .norm(),
        1e-9 * u.norm());
}

TEST(ModalBody, LoadsWithBreakpointsInsideAStepAreExact) {
  std::mt19937 random(4);
  const Points force = random_points(random, make_body(5, Scheme::exact).n_nodes(), 3.0);
  const History history{{0.0, 0.11, 0.12, 0.5}, {0.0, 2.0, -1.0, 0.3}};
  const auto final_positions = [&](int steps) {
    ModalBody body = make_body(5, Scheme::exact);
    const Index set = body.track(all_nodes(body));
    body.prepare({.loads = {force_load(force, history)}});
    const double h = 0.6 / steps;
    for (int i = 0; i < steps; ++i) {
      body.predict(i * h, h);
      body.accept();
    }
    Points x;
    body.positions(set, x);
    return x;
  };
  const Points one = final_positions(1);
  for (const int steps : {2, 7, 600})
    EXPECT_LT((final_positions(steps) - one).cwiseAbs().maxCoeff(), 1e-11) << steps;
}

TEST(ModalBody, LoadsThatShareBreakpointsBringTheirWork) {
  std::mt19937 random(4);
  const Points force = random_points(random, make_body(5, Scheme::exact).n_nodes(), 3.0);
  const History history{{0.0, 0.11, 0.12, 0.5}, {0.0, 2.0, -1.0, 0.3}};
  History shifted = history;
  for (double& t : shifted.time) t *= 1 + 1e-15;
  ModalBody body = make_body(5, Scheme::exact);
  body.prepare({.loads = {force_load(force, history), force_load(force, history),
                          gravity_load(Vector3(0, 1, 2), shifted)}});
  const auto energy = [&] { return body.state().kinetic_energy + body.state().strain_energy; };
  const double before = energy();
  for (int i = 0; i < 7; ++i) {
    body.predict(i * 0.09, 0.09);
    body.accept();
  }
  EXPECT_NEAR(body.work().external, energy() - before, 1e-11 * (energy() + before));
}

TEST(ModalBody, MomentumUnderLoadsIsOfTheTimeWritten) {
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference}) {
    ModalBody body = make_body(5, scheme);
    const Vector3 before = body.state().momentum;
    body.prepare({.loads = {gravity_load(Vector3(0, 1, -2))}});
    const double h = 1 / body.largest_frequency();
    body.predict(0, h);
    body.accept();
    body.predict(h, h);
    body.accept();
    const Vector3 first = (body.state().momentum - before) / (2 * h);
    body.predict(2 * h, h);
    body.accept();
    const Vector3 second = (body.state().momentum - before) / (3 * h);
    EXPECT_LT((first - second).norm(), 1e-11 * first.norm());
    EXPECT_GT(first.norm(), 0);
  }
}

TEST(ModalBody, CentralDifferencesAreThoseOfTheDenseMass) {
  const Superelement s = test::reduce(block(), test::x_nodes(block(), true, true), 6);
  const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
  const auto model = test::model(s);
  ModalBody body("body", model.superelement, model.form, Placement{}, Scheme::central_difference);
  const Index set = body.track({2});
  const double h = 0.8 * 2 / body.largest_frequency();
  Vector q = Vector::Zero(s.n()), v = q, p = q;
  p[s.k() + 6] = 1;
  p[s.k() + 8] = -3;
  Points impulse(1, 3);
  impulse << 1, 0, -3;
  const Ldlt mass(M);
  for (int step = 0; step < 50; ++step) {
    v -= h * mass.solve(K * q);
    if (step == 3) v += mass.solve(p);
    q += h * v;
    body.predict(step * h, h);
    if (step == 3) body.add_impulses(set, impulse);
    body.accept();
  }
  Vector coordinates, rates;
  body.coordinates(coordinates, rates);
  EXPECT_LT((coordinates - q).norm(), 1e-10 * q.norm());
}

TEST(ModalBody, MotionBoundHoldsTheMotion) {
  std::mt19937 random(5);
  for (const bool loaded : {false, true}) {
    ModalBody body = make_body(10, Scheme::exact);
    const Index set = body.track({0, 2, 6, 9});
    if (loaded)
      body.prepare({.loads = {force_load(random_points(random, body.n_nodes(), 5.0),
                                         {{0, 0.2, 0.4}, {0, 1, -1}})}});
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

TEST(ModalBody, NodalVelocitiesLeaveModalCoordinatesAlone) {
  ModalBody body = make_body(9, Scheme::exact);
  const Index set = body.track(all_nodes(body));
  Points dv = Points::Zero(body.n_nodes(), 3);
  dv.row(3) << 1, -2, 3;
  body.predict(0, 1e-9);
  Vector q, before, after;
  body.coordinates(q, before);
  const Vector3 momentum = body.state().momentum, wanted(0.3, 0.2, 0.1);
  const Vector3 extra = body.add_velocities(set, dv, wanted);
  body.accept();
  EXPECT_LT((body.state().momentum - momentum - wanted).norm(), 1e-10);
  body.coordinates(q, after);
  const Vector change = after - before;
  // the start of the step is not its end: 1e-9 s of motion in between
  EXPECT_LT(change.head(9).norm(), 1e-6);
  dv.rowwise() += extra.transpose();
  EXPECT_NEAR(change.norm(), dv.norm(), 1e-6);
}

TEST(ModalForm, HeldDirectionsStayWhereTheyAre) {
  const Superelement s = test::reduce(block(), test::x_nodes(block(), true, true), 7);
  std::vector<HeldDirection> held;
  for (const Index node : {0, 1, 2, 3}) held.push_back({node, Vector3(1, 1, 0).normalized()});
  held.push_back({2, Vector3(0, 0, 1)});
  const ModalForm form = held_modal_form(s, held, "test");
  const IndexTable rows = displacement_rows(s);
  EXPECT_EQ(form.V.cols(), s.n() - 5);
  for (const auto& h : held) {
    Eigen::RowVectorXd motion = Eigen::RowVectorXd::Zero(form.V.cols());
    for (int c = 0; c < 3; ++c) motion += h.direction[c] * form.V.row(rows(h.node, c));
    EXPECT_LT(motion.norm(), 1e-12 * form.V.norm());
  }
  const Matrix I = form.V.transpose() * reduced_mass(s) * form.V;
  EXPECT_LT((I - Matrix::Identity(I.rows(), I.cols())).norm(), 1e-9);
  EXPECT_EQ(form.n_rigid, (form.omega.array() == 0).count());
}

// Two copies of a body, one beside the other and not connected: one component.
Superelement two_parts() {
  const Superelement one = test::reduce(block(), test::x_nodes(block(), true, true), 7);
  const Index k = one.k(), c = one.c();
  Superelement s = one;
  s.eigenvalues = one.eigenvalues.replicate(2, 1);
  s.K_cc = Matrix::Zero(2 * c, 2 * c);
  s.M_cc = s.K_cc;
  s.M_kc = Matrix::Zero(2 * k, 2 * c);
  for (const Index i : {0, 1}) {
    s.K_cc.block(i * c, i * c, c, c) = one.K_cc;
    s.M_cc.block(i * c, i * c, c, c) = one.M_cc;
    s.M_kc.block(i * k, i * c, k, c) = one.M_kc;
  }
  const Vector3 apart(0, 7, 0);
  const Index n = one.node_ids.size();
  for (const Index id : one.node_ids) s.node_ids.push_back(id + 1000);
  for (const Index node : one.dof_node) s.dof_node.push_back(node + n);
  s.dof_component.insert(s.dof_component.end(), one.dof_component.begin(), one.dof_component.end());
  s.coordinates.resize(2 * n, 3);
  s.coordinates << one.coordinates, one.coordinates.rowwise() + apart.transpose();
  s.rigid_body.mass = 2 * one.rigid_body.mass;
  s.rigid_body.center = one.rigid_body.center + 0.5 * apart;
  s.rigid_body.inertia = 2 * one.rigid_body.inertia + 0.25 * s.rigid_body.mass *
                                                          apart.squaredNorm() *
                                                          Matrix3(Vector3(1, 0, 1).asDiagonal());
  return s;
}

TEST(ModalForm, OfAComponentOfTwoPartsNeedsNoMatrices) {
  Superelement s = two_parts();
  const Matrix M = reduced_mass(s), R = reduced_rigid_modes(s, s.rigid_body.center);
  const SymmetricEigen modes = generalized_eigen(reduced_stiffness(s), M);
  s.omega = modes.values.cwiseMax(0).cwiseSqrt();
  s.omega.head(12).setZero();
  s.V = modes.vectors;
  ASSERT_GT(s.omega[12], 1e-4 * s.omega.maxCoeff());
  const Matrix expected = s.V.transpose() * M * R;
  // As read for a run in diagonal form: without K_cc, M_cc, M_kc.
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  const ModalForm form = free_modal_form(s, "test");
  EXPECT_EQ(form.n_rigid, 12);
  EXPECT_LT((form.E - expected).norm(), 1e-9 * expected.norm());
  EXPECT_NEAR(form.E.col(0).squaredNorm(), s.rigid_body.mass, 1e-9 * s.rigid_body.mass);
}

}  // namespace
}  // namespace cbr::modal_body_test
