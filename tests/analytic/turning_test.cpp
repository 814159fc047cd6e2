// SPDX-License-Identifier: GPL-3.0-or-later
// Free superelements that turn by any angle: symmetric tops, Euler's equations, gravity, restart,
// and what is refused.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "common/files/state_archive.hpp"
#include "dynamics/motion/modal/frame.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::turning_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A block of 0.4 x 0.1 x 0.1, density 2: centre of mass and moments of inertia are known. Basis
// massless turns as a rigid body: its modes do not feel the spin (spin_test.cpp has those that do).
const Vector3 size(0.4, 0.1, 0.1);
const double mass = 2 * 0.4 * 0.1 * 0.1;
const double J_axis = mass / 12 * 0.02, J_across = mass / 12 * 0.17;

const char* const plain = "{end: 2, step: 0.01, rotations: large}";

std::string scene(const std::string& time, const std::string& instance,
                  const std::string& more = "", const std::string& output = "") {
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
         "components: {block: {mesh: block.exo, material: m, mass: consistent, reduction: "
         "{basis: massless, interface: [x_min, x_max], modes: 8}}}\n"
         "instances: {b: {component: block, " +
         instance + "}}\n" + more + "time: " + time + "\noutput: {every: 0.1, history: [b.x_max]" +
         output + "}\n";
}

struct FolderWithBlock : SceneFolder {
  FolderWithBlock() { add("block.exo", test::block_mesh({{4, 2, 2}, size})); }
};

Matrix3 turn_of(const RunResult::OfBody& body, std::size_t i) {
  const double* q = body.orientation.data() + 4 * i;
  return Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Matrix3 turn_about(const Vector3& rotation) {
  const double angle = rotation.norm();
  return angle > 0 ? AngleAxisd(angle, rotation / angle).toRotationMatrix() : Matrix3::Identity();
}

// w = L / J_across + (1 - J_axis / J_across) w_axis e: the body turns about its axis e, and that
// about L.
Matrix3 top(const Vector3& axis, const Vector3& w, double t) {
  const double spin = axis.dot(w);
  const Vector3 L = J_across * (w - spin * axis) + J_axis * spin * axis;
  return turn_about(L / J_across * t) * turn_about((1 - J_axis / J_across) * spin * t * axis);
}

// Placed askew and mirrored, thrown under gravity: turns thirty times about its axis.
TEST(Turning, ASymmetricTopFliesByItsClosedForm) {
  FolderWithBlock folder;
  const Vector3 w(60, -70, 20), v(1, 2, 3), g(0, 0, -9.81);
  const Ran ran = folder.run(
      scene("{end: 2, rotations: large}",
            "position: [5, 6, 7], rotation: [20, -50, 110], mirror: x, velocity: " + text(v) +
                ", angular_velocity: " + text(w),
            "loads: [{gravity: " + text(g) + "}]\n", ", fields: [displacement]"));
  const Matrix3 T = ran.scene.instances[0].transformation();
  const Vector3 c_0 = T * (size / 2) + Vector3(5, 6, 7), axis = T.col(0);
  const Vector3 face = T * Vector3(0.4, 0.05, 0.05) + Vector3(5, 6, 7);
  const Vector3 L = J_across * w + (J_axis - J_across) * axis.dot(w) * axis;
  const RunResult::OfBody& body = ran.body("b");
  ASSERT_EQ(body.orientation.size(), 4 * ran.result.time.size());
  double turn = 0, place = 0, speed = 0, momentum = 0, energy = 0;
  for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
    const double t = ran.result.time[i];
    const Matrix3 R = top(axis, w, t);
    const Vector3 c = c_0 + v * t + g * t * t / 2, rate = v + g * t, arm = R * (face - c_0);
    const Vector3 w_now = L / J_across + (1 - J_axis / J_across) * axis.dot(w) * (R * axis);
    turn = std::max(turn, (turn_of(body, i) - R).norm());
    place = std::max(place, (at(ran.monitor("b.x_max").mean_position, i) - c - arm).norm());
    speed = std::max(
        speed, (at(ran.monitor("b.x_max").mean_velocity, i) - rate - w_now.cross(arm)).norm());
    momentum = std::max(momentum, (at(body.angular_momentum, i) - L - mass * c.cross(rate)).norm());
    energy = std::max(energy, std::abs(body.kinetic_energy[i] - 0.5 * mass * rate.squaredNorm() -
                                       0.5 * L.dot(w_now)));
  }
  std::printf("turn %.0e place %.0e speed %.0e momentum %.0e energy %.0e\n", turn, place, speed,
              momentum, energy);
  EXPECT_LT(turn, 1e-10);
  EXPECT_LT(place, 1e-10);
  EXPECT_LT(speed, 1e-9);
  EXPECT_LT(momentum, 1e-12);
  EXPECT_LT(energy, 1e-12);
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  EXPECT_EQ(ran.result.largest_rotation, 0);  // nothing to warn of
}

// What fields show: all nodes go with the body.
TEST(Turning, DisplacementsAreThoseOfTheTurnedBody) {
  FolderWithBlock folder;
  const Vector3 w(3, -2, 1);
  const Ran ran = folder.run(
      scene("{end: 1, rotations: large}", "velocity: [1, 0, 0], angular_velocity: " + text(w)));
  const Body& body = *ran.built.simulation.bodies[0];
  Points u, v;
  body.displacements(u, v);
  const Matrix3 R = top(Vector3::UnitX(), w, 1);
  const Vector3 c_0 = size / 2;
  const Vector3 L(J_axis * w.x(), J_across * w.y(), J_across * w.z());
  const Vector3 w_now = L / J_across + (1 - J_axis / J_across) * w.x() * R.col(0);
  for (Index i = 0; i < u.rows(); ++i) {
    const Vector3 X = body.reference_positions().row(i);
    const Vector3 arm = R * (X - c_0);
    EXPECT_LT((X + u.row(i).transpose() - c_0 - Vector3(1, 0, 0) - arm).norm(), 1e-11);
    EXPECT_LT((v.row(i).transpose() - Vector3(1, 0, 0) - w_now.cross(arm)).norm(), 1e-11);
  }
}

// Without spin and with it, steps of any length give the same: with them and in one jump.
TEST(Turning, StepsDoNotMatter) {
  FolderWithBlock folder;
  const std::string spin = "angular_velocity: [1, 20, 30]";
  RunOptions every_step;
  every_step.jumps = false;
  const Ran fine = folder.run(scene("{end: 2, step: 0.003, rotations: large}", spin), every_step);
  const Ran coarse = folder.run(scene("{end: 2, step: 0.1, rotations: large}", spin));
  const auto last = fine.result.time.size() - 1;
  EXPECT_LT((turn_of(fine.body("b"), last) - turn_of(coarse.body("b"), last)).norm(), 1e-10);
}

TEST(Turning, WithoutSpinSmallAndLargeAreTheSame) {
  FolderWithBlock folder;
  const std::string gravity = "loads: [{gravity: [1, 2, 3]}]\n";
  const Ran large = folder.run(scene(plain, "velocity: [1, 2, 3]", gravity));
  const Ran small = folder.run(scene("{end: 2, step: 0.01}", "velocity: [1, 2, 3]", gravity));
  EXPECT_EQ(large.result.total, small.result.total);
  EXPECT_EQ(large.body("b").center_of_mass.values, small.body("b").center_of_mass.values);
  EXPECT_TRUE(small.body("b").orientation.empty());
}

TEST(Turning, ARestartGoesOnBitForBit) {
  FolderWithBlock folder;
  const std::string yaml = scene(plain, "velocity: [1, 2, 3], angular_velocity: [5, 6, -7]");
  const auto [whole, rest] = restarted(folder, yaml, 0.95);
  EXPECT_EQ(whole.body("b").orientation, rest.body("b").orientation);
  EXPECT_EQ(whole.body("b").kinetic_energy, rest.body("b").kinetic_energy);
  EXPECT_EQ(whole.monitor("b.x_max").mean_position.values,
            rest.monitor("b.x_max").mean_position.values);
}

// sn, cn, dn of u for the parameter m = k^2, by the arithmetic-geometric mean (Abramowitz, Stegun
// 1964, 16.4).
std::array<double, 3> jacobi(double u, double m) {
  std::array<double, 12> a{1}, c{std::sqrt(m)};
  double b = std::sqrt(1 - m);
  int n = 0;
  for (; n + 1 < 12 && std::abs(c[n]) > 1e-16; ++n) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  return {std::sin(phi), std::cos(phi), std::sqrt(1 - m * std::sin(phi) * std::sin(phi))};
}

// Landau, Lifshitz 1976, section 37: for L^2 > 2 E J2 and w2 = 0 at t = 0. Close to the separatrix
// the body flips over.
TEST(FreeTurn, AsymmetricBodiesFlipByJacobisFunctions) {
  const Vector3 J(1, 2, 3);
  const FreeTurn free(J.asDiagonal());
  const Vector3 w_0(1, 0, 0.5774);
  const Vector3 L = J.cwiseProduct(w_0);
  const double E2 = L.dot(w_0), LL = L.squaredNorm();
  ASSERT_GT(LL, E2 * J[1]);
  const double rate = std::sqrt((J[2] - J[1]) * (LL - E2 * J[0]) / J.prod());
  const double m = (J[1] - J[0]) * (E2 * J[2] - LL) / ((J[2] - J[1]) * (LL - E2 * J[0]));
  ASSERT_GT(m, 0.999);
  const double h = 0.37;
  Quaterniond q = Quaterniond::Identity();
  double error = 0, least = 0, most = 0;
  for (int i = 1; i <= 300; ++i) {
    q = free.turned(q, L, h);
    const Vector3 w = q.conjugate() * free.angular_velocity(q, L);
    const auto [sn, cn, dn] = jacobi(rate * h * i, m);
    const Vector3 expected(w_0[0] * cn, std::sqrt((E2 * J[2] - LL) / (J[1] * (J[2] - J[1]))) * sn,
                           w_0[2] * dn);
    error = std::max(error, (w - expected).norm());
    least = std::min(least, w[1]);
    most = std::max(most, w[1]);
  }
  std::printf("flips: error %.0e\n", error);
  EXPECT_LT(error, 9e-10);  // errors of rounding grow with each flip of an unstable motion
  EXPECT_GT(most, 0.8);
  EXPECT_LT(least, -0.8);
}

TEST(FreeTurn, EnergyAndMomentumStayOverManyTurns) {
  const FreeTurn free(Vector3(1, 2, 2.5).asDiagonal());
  const Vector3 L(1, 2, 3);
  Quaterniond q = Quaterniond::Identity();
  const double energy = L.dot(free.angular_velocity(q, L));
  double drift = 0;
  constexpr int turns = 10000;
  for (int i = 0; i < turns; ++i) {
    q = free.turned(q, L, 2 * std::numbers::pi / free.angular_velocity(q, L).norm());
    drift = std::max(drift, std::abs(L.dot(free.angular_velocity(q, L)) / energy - 1));
  }
  std::printf("energy over %d turns: %.1e\n", turns, drift);
  EXPECT_LT(drift, 5e-12);
  EXPECT_LT(std::abs(q.norm() - 1), 1e-15);
}

TEST(Turning, WhatDoesNotTurnIsRefusedByName) {
  FolderWithBlock folder;
  const auto refusal = [&](const std::string& yaml) {
    return test::refusal_of([&] { (void)folder.prepare(yaml); });
  };
  const std::string massless = "basis: massless, ";
  const auto expect = [&](std::string yaml, const std::string& part) {
    yaml.erase(yaml.find(massless), massless.size());
    const std::string said = refusal(yaml);
    EXPECT_SAYS(said, part);
    EXPECT_EQ(said.find('\n'), std::string::npos);
  };
  expect(scene("{end: 1, rotations: small}", "angular_velocity: [0, 0, 1]"),
         "'b': angular_velocity does not go with time.rotations: small");
  expect(scene("{end: 1, rotations: big}", "as: mesh"), "rotations");
  expect(scene("{end: 1, integrator: newmark, rotations: large}", "as: superelement"),
         "does not go with integrator: newmark: take integrator: exact");
  expect(scene(plain, "angular_velocity: [0, 0, 1]",
               "boundary: [{instance: b, nodes: x_min, fix: x}]\n"),
         "'b': angular_velocity does not go with supports");
  expect(scene(plain, "as: superelement", "loads: [{gravity: [1, 0, 0], follow: true}]\n"),
         "gravity acts on everything, remove 'follow'");
}

}  // namespace
}  // namespace cbr::turning_test
