// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/modal_propagator.hpp"

#include <gtest/gtest.h>

#include <unsupported/Eigen/MatrixFunctions>

#include <cmath>

namespace cbr::modal_propagator_test {
namespace {

// From rigid over slow (the series) to beyond half a period in a step.
Vector frequencies() {
  Vector omega(9);
  omega << 0, 1e-9, 1e-4, 0.3, 0.9999, 1.0001, 2, 3, 40;
  return omega;
}

// Exponential of the system [eta; v; f; f'] over h: the load is linear in time, so this is the
// exact answer, found another way.
Eigen::Matrix4d exponential(double omega, double h) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 1) = 1;
  A(1, 0) = -omega * omega;
  A(1, 2) = 1;
  A(2, 3) = 1;
  return (A * h).exp();
}

TEST(ModalPropagator, AgreesWithTheMatrixExponential) {
  const Vector omega = frequencies();
  for (const double h : {1.0, 0.25}) {
    const ModalPropagator step = modal_propagator(omega, h, true);
    const Vector eta = Vector::Constant(9, 0.7), v = Vector::Constant(9, -1.3),
                 f0 = Vector::Constant(9, 2.1), f1 = Vector::Constant(9, -0.4);
    Vector eta_end, v_end;
    propagate_free(step, eta, v, eta_end, v_end);
    add_load(step, f0, f1, eta_end, v_end);
    for (Index j = 0; j < 9; ++j) {
      const Eigen::Vector4d end =
          exponential(omega[j], h) * Eigen::Vector4d(0.7, -1.3, 2.1, (-0.4 - 2.1) / h);
      EXPECT_NEAR(eta_end[j], end[0], 1e-12) << omega[j];
      EXPECT_NEAR(v_end[j], end[1], 1e-12 * std::max(1.0, omega[j])) << omega[j];
    }
  }
}

TEST(ModalPropagator, LoadWorkIsTheEnergyItBrings) {
  const Vector omega = frequencies();
  const ModalPropagator step = modal_propagator(omega, 0.8, true);
  for (Index j = 0; j < 9; ++j) {
    Vector f0 = Vector::Zero(9), f1 = Vector::Zero(9), eta = Vector::Zero(9), v = Vector::Zero(9),
           eta_end, v_end;
    f0[j] = 1.7;
    f1[j] = -3.2;
    eta[j] = 0.4;
    v[j] = 0.9;
    propagate_free(step, eta, v, eta_end, v_end);
    add_load(step, f0, f1, eta_end, v_end);
    const auto energy = [&](double q, double rate) {
      return 0.5 * rate * rate + 0.5 * std::pow(omega[j] * q, 2);
    };
    EXPECT_NEAR(load_work(step, eta, v, eta_end, {f0, f1}, {f0, f1}),
                energy(eta_end[j], v_end[j]) - energy(eta[j], v[j]),
                1e-13 * std::max(1.0, omega[j] * omega[j]));
  }
}

TEST(ModalPropagator, FreeStepsKeepTheEnergy) {
  const Vector omega = frequencies();
  const ModalPropagator step = modal_propagator(omega, 0.7, false);
  Vector eta = Vector::Constant(9, 1), v = Vector::Constant(9, 1), eta_end, v_end;
  const auto energy = [&] { return (v.cwiseAbs2() + omega.cwiseProduct(eta).cwiseAbs2()).eval(); };
  const Vector before = energy();
  for (int i = 0; i < 1000000; ++i) {
    propagate_free(step, eta, v, eta_end, v_end);
    eta.swap(eta_end);
    v.swap(v_end);
  }
  // Round-off of 10^6 steps adds up as of a walk at random, not as 10^6 times the same; the rigid
  // mode's displacement does not enter.
  for (Index j = 0; j < 9; ++j) EXPECT_NEAR(energy()[j] / before[j], 1, 3e-12) << omega[j];
}

}  // namespace
}  // namespace cbr::modal_propagator_test
