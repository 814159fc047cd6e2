// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that meet: nodal enforcement in closed forms, meshes of consistent mass, overlaps, loads.
#include <gtest/gtest.h>

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
  double start = 0.02, end = 0.6;
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
