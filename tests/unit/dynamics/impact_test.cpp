// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that meet: closed forms, conservation, invariance. Both kinds of body, all enforcements.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>

#include "dynamics/output/summary/summary.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::impact_test {
namespace {

using test::Part;
using test::row;
using test::two_bodies;

constexpr double speed = 1e-3;  // strain of 5e-5

// Two equal bars of wave speed 10 and length 1 (nu = 0: one-dimensional), a gap of one step's way
// apart; a flies into b.
struct Bars {
  Part a, b;
  double contact = 2 * 1.0 / 10, start = 0.02, end = 0.6;
};

Bars bars(Index n, bool mesh_a, bool mesh_b) {
  Bars s;
  s.a.n = s.b.n = {n, 1, 1};
  s.a.size = s.b.size = Vector3(1, 0.1, 0.1);
  s.a.material = s.b.material = {100, 0, 1};
  s.a.mesh = mesh_a;
  s.b.mesh = mesh_b;
  s.a.modes = s.b.modes = 12 * n;
  s.a.placement.velocity = Vector3(speed, 0, 0);
  s.b.placement.position = Vector3(1 + s.start * speed, 0, 0);
  s.b.face = "x_min";
  return s;
}

// Two blocks with Poisson's ratio, non-matching faces, one of them turned.
struct Blocks {
  Part a, b;
};

Blocks blocks(bool mesh_a, bool mesh_b) {
  Blocks s;
  s.a.n = {3, 4, 4};
  s.b.n = {3, 3, 2};
  s.a.mesh = mesh_a;
  s.b.mesh = mesh_b;
  s.a.modes = s.b.modes = 30;
  s.a.placement.velocity = Vector3(0.3, 0.02, -0.01);
  s.b.placement.position = Vector3(2.01, 0.01, 0.02);
  s.b.placement.T = Vector3(-1, 1, 1).asDiagonal();
  return s;
}

double final_speed(const RunResult& result, std::size_t body, double mass) {
  return row(result.bodies[body].momentum, result.time.size() - 1)[0] / mass;
}

void expect_balanced(const RunResult& result, double energy, double momentum) {
  const Balance b = balance(result);
  EXPECT_LT(b.energy, energy);
  EXPECT_LT(b.momentum, momentum);
}

TEST(Impact, EqualBarsSwapTheirVelocities) {
  for (const bool mesh_a : {false, true}) {
    for (const bool mesh_b : {false, true}) {
      double error[2];
      for (const int level : {0, 1}) {
        Bars s = bars(level == 0 ? 15 : 30, mesh_a, mesh_b);
        Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, s.end, 0.01);
        const RunResult result = run(sim);
        expect_balanced(result, 1e-12, 1e-12);
        const double mass = 0.01;
        error[level] = std::abs(final_speed(result, 1, mass) / speed - 1);
        EXPECT_NEAR(final_speed(result, 0, mass), speed - final_speed(result, 1, mass),
                    1e-12 * speed);
        // In contact from `start` for 2 L / c; half the speed and force E A v / (2 c) meanwhile
        double impulse = 0, first = 0, last = 0;
        for (std::size_t i = 1; i < result.time.size(); ++i) {
          impulse += row(result.monitors[1].force, i)[0] * (result.time[i] - result.time[i - 1]);
          if (row(result.monitors[1].force, i)[0] > 0.1 * 100 * 0.01 * speed / 20) {
            if (first == 0) first = result.time[i - 1];
            last = result.time[i];
          }
        }
        EXPECT_NEAR(impulse, mass * final_speed(result, 1, mass), 1e-12 * mass * speed);
        EXPECT_NEAR(last - first, s.contact, 0.03);
      }
      EXPECT_LT(error[0], 0.06);
      EXPECT_LT(error[1], 0.75 * error[0]);
    }
  }
}

TEST(Impact, BarStrikesOneTwiceAsLong) {
  Bars s = bars(20, false, false);
  s.b.n = {40, 1, 1};
  s.b.size[0] = 2;
  s.b.modes = 200;
  Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, 0.8, 0.01);
  const RunResult result = run(sim);
  EXPECT_NEAR(final_speed(result, 0, 0.01), 0, 0.04 * speed);
  EXPECT_NEAR(final_speed(result, 1, 0.02), 0.5 * speed, 0.02 * speed);
  expect_balanced(result, 1e-12, 1e-12);
}

TEST(Impact, PenaltySwapsThemToo) {
  for (const bool mesh : {false, true}) {
    Bars s = bars(20, mesh, mesh);
    Simulation sim = two_bodies(s.a, s.b, Enforcement::penalty, s.end, 0.01, 0.3);
    const RunResult result = run(sim);
    EXPECT_NEAR(final_speed(result, 1, 0.01), speed, 0.05 * speed);
    expect_balanced(result, 1e-12, 1e-12);
    EXPECT_NEAR(result.total.back() / result.total.front(), 1, 0.02);
  }
}

TEST(Impact, NodalEnforcementOfOneFaceIsPerfectlyPlastic) {
  for (const Index modes : {0, 5, 60}) {
    for (const Scheme scheme : {Scheme::exact, Scheme::central_difference}) {
      Bars s = bars(20, false, false);
      s.a.modes = s.b.modes = modes;
      s.a.scheme = s.b.scheme = scheme;
      Simulation sim = two_bodies(s.a, s.b, Enforcement::nodal, 2, 0.01, 0.5);
      const RunResult result = run(sim);
      EXPECT_NEAR(final_speed(result, 0, 0.01), 0.5 * speed, 1e-6 * speed) << modes;
      EXPECT_NEAR(final_speed(result, 1, 0.01), 0.5 * speed, 1e-6 * speed) << modes;
      EXPECT_NEAR(result.total.back() / result.total.front(), 0.5, 1e-6);
      expect_balanced(result, 1e-12, 1e-12);
    }
  }
}

TEST(Impact, NodalEnforcementOfTwoFacesReboundsInPart) {
  Bars s = bars(20, false, false);
  s.a.both_faces = s.b.both_faces = true;
  s.a.modes = s.b.modes = 60;
  Simulation sim = two_bodies(s.a, s.b, Enforcement::nodal, 2, 0.01, 0.5);
  const RunResult result = run(sim);
  expect_balanced(result, 1e-12, 1e-12);
  const double rebound = (final_speed(result, 1, 0.01) - 0.5 * speed) / (0.5 * speed);
  EXPECT_GT(rebound, 0.2);
  EXPECT_LT(rebound, 0.8);
  // The impulse does not care which interface was kept.
  Simulation impulse = two_bodies(s.a, s.b, Enforcement::impulse, 0.6, 0.01);
  EXPECT_NEAR(final_speed(run(impulse), 1, 0.01), speed, 0.06 * speed);
}

TEST(Impact, NodalEnforcementKeepsMomentumInAllDirections) {
  Blocks s = blocks(false, false);
  s.a.both_faces = s.b.both_faces = true;
  Simulation sim = two_bodies(s.a, s.b, Enforcement::nodal, 1, 0.02, 0.5);
  const RunResult result = run(sim);
  EXPECT_GT(row(result.bodies[1].momentum, result.time.size() - 1)[0], 0.01);
  expect_balanced(result, 1e-12, 1e-12);
}

TEST(Impact, NodalEnforcementOfMeshesWeighsNodesRightly) {
  Bars s = bars(30, true, true);
  Simulation sim = two_bodies(s.a, s.b, Enforcement::nodal, s.end, 0.01);
  EXPECT_NEAR(final_speed(run(sim), 1, 0.01), speed, 0.05 * speed);
}

TEST(Impact, ConsistentMassMesh) {
  Bars s = bars(20, true, true);
  s.a.mass = s.b.mass = MassKind::consistent;
  Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, s.end, 0.01);
  const RunResult result = run(sim);
  EXPECT_NEAR(final_speed(result, 1, 0.01), speed, 0.06 * speed);
  expect_balanced(result, 1e-11, 1e-12);
}

void place(Part& part, const Matrix3& R, const Vector3& shift, const Vector3& boost) {
  part.placement.T = (R * part.placement.T).eval();
  part.placement.position = R * part.placement.position + shift;
  part.placement.velocity = R * part.placement.velocity + boost;
}

// Largest difference of momenta and mean face positions after undoing the placement, relative to
// the largest.
double difference(const RunResult& plain, const RunResult& moved, const Matrix3& R,
                  const Vector3& shift, const Vector3& boost, const std::array<double, 2>& mass) {
  double worst = 0, momentum_scale = 0;
  for (std::size_t i = 0; i < plain.time.size(); ++i)
    for (int b : {0, 1})
      momentum_scale = std::max(momentum_scale, row(plain.bodies[b].momentum, i).norm());
  for (std::size_t i = 0; i < plain.time.size(); ++i) {
    for (int b : {0, 1}) {
      const Vector3 p = R.transpose() * (row(moved.bodies[b].momentum, i) - mass[b] * boost);
      worst = std::max(worst, (p - row(plain.bodies[b].momentum, i)).norm() / momentum_scale);
      const Vector3 x =
          R.transpose() * (row(moved.monitors[b].mean_position, i) - shift - plain.time[i] * boost);
      worst = std::max(worst, (x - row(plain.monitors[b].mean_position, i)).norm());
    }
  }
  return worst;
}

TEST(Impact, RotatedMirroredAndMovingScenesGiveTheSameAnswer) {
  const Matrix3 R = Eigen::AngleAxisd(0.83, Vector3(1, -2, 0.7).normalized()).toRotationMatrix();
  const Matrix3 mirror = R * Vector3(1, 1, -1).asDiagonal();
  for (const auto& [mesh_a, mesh_b] :
       {std::pair{false, false}, std::pair{true, false}, std::pair{true, true}}) {
    const Blocks plain = blocks(mesh_a, mesh_b);
    Simulation reference = two_bodies(plain.a, plain.b, Enforcement::impulse, 0.6, 0.02);
    const RunResult expected = run(reference);
    expect_balanced(expected, 1e-11, 1e-12);
    // they did meet
    EXPECT_GT(row(expected.bodies[1].momentum, expected.time.size() - 1)[0], 0.01);
    const std::array<double, 2> mass{0.25, 0.25};
    const auto moved = [&](const Matrix3& T, const Vector3& shift, const Vector3& boost) {
      Blocks s = plain;
      place(s.a, T, shift, boost);
      place(s.b, T, shift, boost);
      Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, 0.6, 0.02);
      return difference(expected, run(sim), T, shift, boost, mass);
    };
    EXPECT_LT(moved(R, Vector3(0.3, -0.2, 0.5), Vector3::Zero()), 1e-9);
    EXPECT_LT(moved(mirror, Vector3::Zero(), Vector3::Zero()), 1e-9);
    EXPECT_LT(moved(Matrix3::Identity(), Vector3::Zero(), Vector3(2, -1, 3)), 1e-9);
  }
}

TEST(Impact, MeshAndSuperelementWithAllModesAgree) {
  Blocks s = blocks(true, true), t = blocks(false, false);
  t.a.modes = t.b.modes = 100000;
  t.a.scheme = t.b.scheme = Scheme::central_difference;
  Simulation a = two_bodies(s.a, s.b, Enforcement::impulse, 0.6, 0.02),
             b = two_bodies(t.a, t.b, Enforcement::impulse, 0.6, 0.02);
  b.plan = a.plan;
  // The same model, the same scheme, the same step: full mesh and superelement agree to round-off
  // of the eigenvectors.
  EXPECT_LT(difference(run(a), run(b), Matrix3::Identity(), Vector3::Zero(), Vector3::Zero(),
                       {0.25, 0.25}),
            1e-8);
}

TEST(Impact, JumpsChangeNothing) {
  for (const bool loaded : {false, true}) {
    const Blocks s = blocks(false, false);
    const auto simulate = [&](bool jumps, Index& steps) {
      Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, 1.5, 0.05);
      if (loaded)
        sim.bodies[1]->prepare(
            {.loads = {gravity_load(Vector3(-0.5, 0.1, 0), {{0, 0.3, 1}, {0, 1, 0.2}})}});
      RunOptions options;
      options.jumps = jumps;
      RunResult result = run(sim, options);
      steps = result.steps;
      return result;
    };
    Index with = 0, without = 0;
    const RunResult a = simulate(true, with), b = simulate(false, without);
    EXPECT_LT(with, (3 * without) / 4);
    EXPECT_LT(difference(b, a, Matrix3::Identity(), Vector3::Zero(), Vector3::Zero(), {0.25, 0.25}),
              1e-10);
  }
}

class InitialOverlap : public testing::TestWithParam<double> {};

TEST_P(InitialOverlap, BringsNoEnergy) {
  Blocks s = blocks(false, false);
  s.b.placement.position[0] = 2 - GetParam();
  s.a.placement.velocity.setZero();
  Simulation sim = two_bodies(s.a, s.b, Enforcement::impulse, 0.3, 0.02);
  const RunResult result = run(sim);
  EXPECT_LT(result.total.back(), 1e-20);
  EXPECT_NEAR(sim.pairs[0].seen().memory.initial_overlap, GetParam(), 1e-10);
  // Pressed together, they stay where they overlap, and the energy does not grow.
  s.a.placement.velocity = Vector3(0.01, 0, 0);
  Simulation pressed = two_bodies(s.a, s.b, Enforcement::impulse, 0.3, 0.02);
  const RunResult pushed = run(pressed);
  EXPECT_LE(pushed.total.back(), pushed.total.front() * (1 + 1e-12));
  EXPECT_GT(row(pushed.bodies[1].momentum, pushed.time.size() - 1)[0], 0);
}
INSTANTIATE_TEST_SUITE_P(Lengths, InitialOverlap, testing::Values(0.001, 0.02, 0.1));

// Velocities live half a step before the positions; what is written is of the positions' time.
TEST(Impact, MomentumUnderLoadsIsOfTheTimeWritten) {
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    const test::Brick b = test::make_brick({4, 2, 2}, Vector3(1, 0.5, 0.5), {100, 0.25, 1}, mass);
    const auto model = std::make_shared<MeshModel>(
        mesh_model(b.fe, b.geometry.coordinates, mass == MassKind::lumped));
    MeshBody body("b", model, {}, {}, std::make_shared<RowThreads>(1));
    body.prepare({.loads = {gravity_load(Vector3(0, 0, -2))}});
    const double h = 1 / body.largest_frequency();
    Points u, v;
    for (int step = 1; step <= 10; ++step) {
      body.predict((step - 1) * h, h);
      body.accept();
      EXPECT_NEAR(body.state().momentum[2], -2 * 0.25 * step * h, 1e-13);
      body.displacements(u, v);
      EXPECT_NEAR(v.col(2).mean(), -2 * step * h, 1e-12);
    }
  }
}

TEST(Impact, HangingOnAFixedEndUnderGravity) {
  // A held superelement falls into its static sag and swings about it; work and energy balance.
  const test::Lattice full = test::lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  const Superelement s = test::reduce(full, test::x_nodes(full, true, true), 12);
  std::vector<HeldDirection> held;
  for (const Surface& surface : s.surfaces)
    if (surface.name == "x_min")
      for (const Index node : surface_nodes(surface))
        for (int c = 0; c < 3; ++c) held.push_back({node, Vector3::Unit(c)});
  const auto shared = std::make_shared<Superelement>(s);
  const auto form = std::make_shared<ModalForm>(held_modal_form(s, held, "test"));
  ModalBody body("bar", shared, form, Placement{}, Scheme::exact);
  const Index tip = body.track_mean(surface_nodes(s.surfaces[1]));
  body.prepare({.loads = {gravity_load(Vector3(9.81, 0, 0))}});
  double mean = 0;
  Vector3 position, velocity;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    body.predict(0.005 * i, 0.005);
    body.accept();
    body.mean_motion(tip, position, velocity);
    mean += (position[0] - 0.3) / steps;
  }
  const BodyState state = body.state();
  EXPECT_NEAR(state.kinetic_energy + state.strain_energy, body.work().external,
              1e-9 * body.work().external);
  // Static sag from the reduced stiffness: K_f q = M_f r g
  EXPECT_NEAR(
      mean,
      (form->V.bottomRows(s.c()) * (form->E.col(0) * 9.81).cwiseQuotient(form->omega.cwiseAbs2()))(
          displacement_rows(s)(surface_nodes(s.surfaces[1])[4], 0) - s.k()),
      0.02 * mean);
}

}  // namespace
}  // namespace cbr::impact_test
