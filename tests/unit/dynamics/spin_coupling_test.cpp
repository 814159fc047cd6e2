// SPDX-License-Identifier: GPL-3.0-or-later
// Modes of a body that spins: Coriolis forces against the rotating mass on springs and its
// instability between two critical speeds; momentum and energy of all masses of a body that
// tumbles.
#include "dynamics/motion/modal/forms/spin_coupling.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <vector>

#include "common/app/report.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::spin_coupling_test {
namespace {

// All nodes of a block are its interface, with lumped masses: its modes are all there are, and all
// are coupled.
Superelement block() {
  set_threads(1);
  const Mesh mesh = test::block_mesh({{2, 1, 1}, Vector3(1, 0.4, 0.3)});
  ReductionOptions options;
  options.interface_sets = {"x_min", "x_max", "y_min", "y_max"};
  options.modes = 0;
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, {BlockProperties{{2000, 0.3, 1}, HexFormulation::incompatible}},
                          MassKind::lumped, options, {}, report);
  const Index m = s.n() - 6;
  Matrix P = Matrix::Zero(3 * m, 3 * m);
  for (Index node = 0; node < s.c(); node += 3) {
    const Matrix phi = s.V.middleRows(node, 3).rightCols(m);
    P += s.M_cc(node, node) * phi.reshaped() * phi.reshaped().transpose();
  }
  const Index kept = s.spin_couplings.rows();
  EXPECT_LT((s.spin_couplings - P.topLeftCorner(kept, kept)).norm(), 1e-12 * P.norm());
  s.spin_couplings = P;
  return s;
}

struct Spinning {
  std::unique_ptr<ModalBody> body;

  void step(double t, double h) const {
    body->predict(t, h);
    body->accept();
  }
};

Spinning spinning(Superelement s, const Vector3& w, const Matrix3& axes = Matrix3::Identity(),
                  const std::function<void(ModalForm&)>& change = {}) {
  auto form = std::make_shared<ModalForm>(free_modal_form(s, "block"));
  if (change) change(*form);
  Spinning spinning;
  spinning.body =
      std::make_unique<ModalBody>("b", std::make_shared<const Superelement>(std::move(s)), form,
                                  Placement{axes}, Scheme::exact);
  spinning.body->turn_freely(w, 1e3);
  return spinning;
}

// A unit mass in the centre of a flywheel, on springs along x and y, that spins about z.
constexpr double omega_x = 3, omega_y = 4;

Spinning rotor(double w, const Vector& start) {
  Superelement s = block();
  s.spin_moments.setZero();
  s.spin_couplings = Matrix::Zero(6, 6);
  for (const Index row : {0, 4})
    for (const Index column : {0, 4}) s.spin_couplings(row, column) = 1;
  Spinning rotor =
      spinning(std::move(s), Vector3(0, 0, w), Matrix3::Identity(), [](ModalForm& form) {
        form.omega[6] = omega_x;
        form.omega[7] = omega_y;
        form.E.rightCols(3) *= 1e6;  // of the flywheel
      });
  Vector eta = Vector::Zero(rotor.body->n_dofs());
  eta.segment(6, 2) = start;
  rotor.body->take_shape(eta);
  return rotor;
}

// exp(A t), by its Taylor series of a small part of t.
Matrix exponential(const Matrix& A, double t) {
  constexpr int halvings = 12, order = 12;
  Matrix term = Matrix::Identity(A.rows(), A.cols()), sum = term;
  for (int n = 1; n <= order; ++n) {
    term = term * A * (t / std::pow(2, halvings) / n);
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = (sum * sum).eval();
  return sum;
}

// x'' = 2 w y' + (w^2 - omega_x^2) x, y'' = -2 w x' + (w^2 - omega_y^2) y
TEST(SpinCoupling, AMassOnSpringsMovesByItsEquations) {
  constexpr double w = 1.7, end = 6;
  const Vector start = Eigen::Vector2d(1e-2, -4e-3);
  Matrix A = Matrix::Zero(4, 4);
  A.topRightCorner(2, 2).setIdentity();
  A(2, 0) = w * w - omega_x * omega_x;
  A(3, 1) = w * w - omega_y * omega_y;
  A(2, 3) = 2 * w;
  A(3, 2) = -2 * w;
  // At rest in the scene's axes
  const Vector state = Eigen::Vector4d(start[0], start[1], w * start[1], -w * start[0]);
  const Vector expected = exponential(A, end) * state;
  std::vector<double> steps, errors;
  for (const int n : {150, 300, 600}) {
    const Spinning of = rotor(w, start);
    for (int i = 0; i < n; ++i) of.step(i * end / n, end / n);
    steps.push_back(end / n);
    errors.push_back((of.body->modal_coordinates().segment(6, 2) - expected.head(2)).norm() /
                     start.norm());
    std::printf("step %.3f: off by %.2e\n", steps.back(), errors.back());
  }
  EXPECT_LT(errors.back(), 1e-4);
  EXPECT_NEAR(test::observed_order(steps, errors), 2, 0.1);
}

// Per second, between the moments 24 and 48: by then all other motion is a share of 1e-5.
double growth(double w, int n) {
  const Spinning of = rotor(w, Eigen::Vector2d(1e-10, 1e-10));
  std::array<double, 2> largest{};
  for (int i = 0; i < n; ++i) {
    of.step(i * 48.0 / n, 48.0 / n);
    for (std::size_t half = 0; half < 2; ++half) {
      const int from = half == 0 ? 5 * n / 12 : 11 * n / 12, to = half == 0 ? n / 2 : n;
      if (i >= from && i < to)
        largest[half] = std::max(largest[half], of.body->modal_coordinates().segment(6, 2).norm());
    }
  }
  return std::log(largest[1] / largest[0]) / 24;
}

// lambda^4 + (omega_x^2 + omega_y^2 + 2 w^2) lambda^2 + (omega_x^2 - w^2) (omega_y^2 - w^2) = 0
TEST(SpinCoupling, AnUnequalShaftGrowsBetweenItsCriticalSpeeds) {
  constexpr double w = 3.5, xx = omega_x * omega_x, yy = omega_y * omega_y;
  const double b = xx + yy + 2 * w * w, c = (xx - w * w) * (yy - w * w);
  const double expected = std::sqrt(0.5 * (std::sqrt(b * b - 4 * c) - b));
  std::vector<double> errors;
  for (const int n : {2400, 4800}) {
    const double found = growth(w, n);
    errors.push_back(std::abs(found / expected - 1));
    std::printf("%d steps: grows at %.6f, exactly %.6f\n", n, found, expected);
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4);
  for (const double stable : {2.5, 4.5}) EXPECT_LT(std::abs(growth(stable, 4800)), 0.02) << stable;
}

// Of all masses, from where they are and how fast they move.
struct OfMasses {
  Vector3 angular = Vector3::Zero();
  double kinetic = 0;
};

OfMasses of_masses(const Spinning& of, const Points& masses) {
  Points u, v;
  of.body->displacements(u, v);
  OfMasses sum;
  for (Index i = 0; i < u.rows(); ++i) {
    const Vector3 x = (of.body->reference_positions().row(i) + u.row(i)).transpose();
    const Vector3 v_i = v.row(i).transpose();
    sum.angular += masses(i, 0) * x.cross(v_i);
    sum.kinetic += 0.5 * masses(i, 0) * v_i.squaredNorm();
  }
  return sum;
}

// A block that tumbles about no axis of its own, and has been struck.
Spinning tumbling(Superelement s, double w, const Matrix3& axes) {
  Spinning of = spinning(std::move(s), w * Vector3(1, -0.6, 0.8), axes);
  std::vector<Index> nodes = first_numbers(of.body->n_nodes());
  of.body->track(nodes);
  Points impulses(of.body->n_nodes(), 3);
  for (Index i = 0; i < impulses.size(); ++i)
    impulses(i / 3, i % 3) = w > 0 ? 0.01 * std::sin(static_cast<double>(i * i)) : 0;
  if (w == 0) {  // pulled apart: neither momentum
    impulses.setZero();
    impulses.row(0) = Vector3(0.02, 0, 0).transpose();
    impulses.row(1) = -impulses.row(0);
  }
  of.body->predict(0, 1e-4);
  of.body->add_impulses(0, impulses);
  of.body->accept();
  return of;
}

class TumblingBlock : public testing::TestWithParam<bool> {
 protected:
  Matrix3 axes() const {
    return Matrix3(Vector3(1, 1, GetParam() ? -1 : 1).asDiagonal()) *
           Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  }
};

// The momenta of the modes are none of their velocities: L and the energy of all masses say so.
TEST_P(TumblingBlock, HasTheMomentumAndTheEnergyOfItsMasses) {
  const Spinning of = tumbling(block(), 2, axes());
  const Points masses = of.body->nodal_masses(0);
  const Vector3 L = of.body->state().angular_momentum;
  for (int i = 0; i < 300; ++i) {
    of.step(0, 5e-3);
    if (i % 20 > 0) continue;
    const BodyState state = of.body->state();
    const OfMasses found = of_masses(of, masses);
    const double moves = of.body->modal_coordinates().tail(30).norm();
    EXPECT_LT((state.angular_momentum - L).norm(), 1e-13 * L.norm());
    EXPECT_LT((found.angular - L).norm(), 1e-12 * L.norm()) << i;
    EXPECT_NEAR(found.kinetic, state.kinetic_energy, 1e-12 * state.kinetic_energy);
    EXPECT_GT(moves, 1e-4);
  }
}

TEST_P(TumblingBlock, KeepsItsEnergyToTheSquareOfTheStep) {
  std::vector<double> steps, left;
  for (const int n : {1000, 2000, 4000}) {  // none is cut
    const Spinning of = tumbling(block(), 2, axes());
    const auto energy = [&] {
      const BodyState state = of.body->state();
      return state.kinetic_energy + state.strain_energy;
    };
    const double start = energy(), booked = of.body->work().numerical;
    std::array<double, 2> most{};  // of the first half and the second
    for (int i = 0; i < n; ++i) {
      of.step(0, 2.0 / n);
      auto& of_half = most[2 * i / n];
      of_half = std::max(of_half, std::abs(energy() / start - 1));
      ASSERT_NEAR(energy() - (of.body->work().numerical - booked), start, 1e-12 * start);
    }
    std::printf("step %.4f: energy off by %.1e, then %.1e\n", 2.0 / n, most[0], most[1]);
    EXPECT_LT(most[1], 2 * most[0]);
    steps.push_back(2.0 / n);
    left.push_back(most[0]);
  }
  EXPECT_LT(left.back(), 1e-5);
  EXPECT_NEAR(test::observed_order(steps, left), 2, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Mirrored, TumblingBlock, testing::Bool());

// A jump is cut where the coupling could not see it: it is as good as critical steps.
TEST(SpinCoupling, AJumpIsManySteps) {
  const auto after = [](int n) {
    const Spinning of = tumbling(block(), 2, Matrix3::Identity());
    for (int i = 0; i < n; ++i) of.step(0, 1.0 / n);
    Points u, v;
    of.body->displacements(u, v);
    return u;
  };
  const Points u = after(8000), u_jump = after(1);
  const double highest = tumbling(block(), 2, Matrix3::Identity()).body->largest_frequency();
  const double critical = (after(static_cast<int>(highest / 2) + 1) - u).norm();
  std::printf("critical steps: %.1e, a jump: %.1e\n", critical, (u_jump - u).norm());
  EXPECT_LT(critical, 1e-3);
  EXPECT_LT((u_jump - u).norm(), 1.1 * critical);
}

// What does not spin moves to the last bit as what knows no coupling.
TEST(SpinCoupling, WithoutSpinNothingIsCoupled) {
  Superelement s = block(), without = s;
  without.spin_couplings.resize(0, 0);
  const Spinning a = tumbling(std::move(s), 0, Matrix3::Identity()),
                 b = tumbling(std::move(without), 0, Matrix3::Identity());
  EXPECT_TRUE(a.body->frame()->has_coupling());
  EXPECT_FALSE(b.body->frame()->has_coupling());
  for (int i = 0; i < 50; ++i) {
    a.step(0, 0.01);
    b.step(0, 0.01);
  }
  Points u, v, u_b, v_b;
  a.body->displacements(u, v);
  b.body->displacements(u_b, v_b);
  EXPECT_GT(u.norm(), 1e-4);
  EXPECT_EQ(u, u_b);
  EXPECT_EQ(v, v_b);
}

}  // namespace
}  // namespace cbr::spin_coupling_test
