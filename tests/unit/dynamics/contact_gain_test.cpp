// SPDX-License-Identifier: GPL-3.0-or-later
// Impulses of contact on a body that moves exactly: with the gain, what is pressed for long
// compresses as it should, at any step.
#include "dynamics/motion/modal/forms/modal_propagator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::test::contact_gain_test {
namespace {

const std::vector<Index>& pressed() {
  static const std::vector<Index> nodes{1, 3, 5};
  return nodes;
}

Model free_block() { return model(reduce(block(), x_nodes(block(), true, true), 10)); }

Model held_block() {
  Model m = free_block();
  std::vector<HeldDirection> held{{2, Vector3::UnitZ()},
                                  {7, Vector3::UnitZ()},
                                  {4, Vector3::UnitZ()},
                                  {0, Vector3(1, -1, 0).normalized()}};
  for (const Index node : {0, 2, 4}) held.push_back({node, Vector3(1, 1, 0).normalized()});
  m.form = std::make_shared<ModalForm>(held_modal_form(*m.superelement, held, "test"));
  return m;
}

// Rows of the pressed nodes' dofs in V   (9 x n)
Matrix rows_of(const Model& m) {
  Matrix V(9, m.form->omega.size());
  for (Index i = 0; i < 9; ++i)
    V.row(i) = m.form->V.row(displacement_rows(*m.superelement)(pressed()[i / 3], i % 3));
  return V;
}

Points some_force() {
  std::mt19937 random(4);
  return random_points(random, 3, 1);
}

// Displacements of the pressed nodes of a held body under a force that stays.
Vector statics(const Model& m, const Points& force) {
  const Matrix V = rows_of(m);
  return V * m.form->omega.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose() *
         Eigen::Map<const Vector>(force.data(), 9);
}

// Displacements of the pressed nodes at the end of steps in each of which `force` h acts as one
// impulse at its start, the force raised so slowly (six times differentiable ramp over `steps`)
// that nothing swings.
Vector pressed_down(Body& body, Index set, const Points& force, double h, int steps) {
  for (int step = 0; step < steps; ++step) {
    const double s = double(step + 1) / steps, ramp = s * s * s * (10 - 15 * s + 6 * s * s);
    body.predict(step * h, h);
    body.add_impulses(set, ramp * h * force);
    body.accept();
  }
  Points x;
  body.positions(set, x);
  const Points u = x - body.reference_positions()(pressed(), Eigen::all);
  return Eigen::Map<const Vector>(u.data(), u.size());
}

TEST(ContactGain, IsOneForRigidMotionsAndSlowModes) {
  Vector omega(4);
  omega << 0, 1e-9, 1e-3, 1.8;
  const Vector gain = contact_gain(omega, 1);
  EXPECT_EQ(gain[0], 1);
  EXPECT_EQ(gain[1], 1);
  EXPECT_NEAR(gain[2], std::tan(5e-4) / 5e-4, 1e-15);
  EXPECT_NEAR(gain[3], std::tan(0.9) / 0.9, 1e-15);
}

TEST(ContactGain, WhatIsPressedForLongCompressesAsItShould) {
  const Model m = held_block();
  const Points force = some_force();
  const Vector expected = statics(m, force);
  const double h = 1.9 / m.form->omega.maxCoeff();
  double error[2];
  for (const bool gain : {false, true}) {
    ModalBody body("body", m.superelement, m.form, Placement{}, Scheme::exact);
    const Index set = body.track(pressed());
    if (gain) body.prepare({.contact_step = h});
    error[gain] = (pressed_down(body, set, force, h, 20000) - expected).norm() / expected.norm();
  }
  EXPECT_LT(error[1], 1e-6);
  EXPECT_GT(error[0], 1e-3);  // what the gain mends
}

// W's block: V diag(2 (1 - cos omega h) / (omega^2 h)) V^T, what a constant force h does in one
// step.
TEST(ContactGain, ResponseIsThatOfAForceOverTheStep) {
  const Model m = free_block();
  const Matrix V = rows_of(m);
  const double h = 1.9 / m.form->omega.maxCoeff();
  Vector weight(V.cols());
  for (Index j = 0; j < weight.size(); ++j) {
    const double x = 0.5 * m.form->omega[j] * h;  // 2 (1 - cos 2 x) / (4 x^2 / h) = h (sin x / x)^2
    weight[j] = x < 1e-6 ? h : h * std::pow(std::sin(x) / x, 2);
  }
  ModalBody body("body", m.superelement, m.form, Placement{}, Scheme::exact);
  const Index set = body.track(pressed());
  body.prepare({.contact_step = h});
  const Matrix expected = V * weight.asDiagonal() * V.transpose(),
               S = body.response(set, h).dense();
  EXPECT_LT((S - expected).norm(), 1e-12 * expected.norm());
  // and it is what impulses do
  Points before, after;
  body.predict(0, h);
  body.predicted_positions(set, before);
  std::mt19937 random(6);
  const Points p = random_points(random, 3, 1);
  body.add_impulses(set, p);
  body.predicted_positions(set, after);
  const Points moved = after - before;
  const Vector answer = S * Eigen::Map<const Vector>(p.data(), 9);
  EXPECT_LT((Eigen::Map<const Vector>(moved.data(), 9) - answer).norm(), 1e-10 * answer.norm());
}

TEST(ContactGain, IsLeftOutWhereForcedStepsAreTooLong) {
  const Model m = free_block();
  const double h = 2.5 / m.form->omega.maxCoeff();
  ModalBody with("with", m.superelement, m.form, Placement{}, Scheme::exact);
  ModalBody without("without", m.superelement, m.form, Placement{}, Scheme::exact);
  with.track(pressed());
  without.track(pressed());
  with.prepare({.contact_step = h});
  EXPECT_EQ((with.response(0, h).dense() - without.response(0, h).dense()).norm(), 0);
}

}  // namespace
}  // namespace cbr::test::contact_gain_test
