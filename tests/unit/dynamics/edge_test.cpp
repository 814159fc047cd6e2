// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies at each other's edges and corners: no contact where they pass, no energy from where they
// meet.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <numbers>
#include <random>

#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::edge_test {
namespace {

using test::Part;
using test::row;

// Unit cubes of wave speed 10, all six faces in contact.
Part cube(std::array<Index, 3> n) {
  Part part;
  part.n = n;
  part.size = Vector3(1, 1, 1);
  part.material = {100, 0.3, 1};
  part.mesh = true;
  part.face = "surface";
  return part;
}

const Vector3 centre(0.5, 0.5, 0.5);

// Turned about its centre, which is put at `at`.
void place(Part& part, const Matrix3& R, const Vector3& at, const Vector3& velocity) {
  part.placement.T = R;
  part.placement.position = at - R * centre;
  part.placement.velocity = velocity;
}

struct Outcome {
  // of energy, as shares of the kinetic energy at the start: largest of the run
  double gain = 0, loss = 0;
  Vector3 momentum_b = Vector3::Zero();  // of b at the end
  double largest_sideways = 0;           // of |momentum of b across z|
  double touched_until = 0;              // last output with an impulse
};

Outcome run_scene(Simulation& sim) {
  const RunResult r = run(sim);
  Outcome o;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const double work = r.work_contact[i] / r.total[0];
    o.gain = std::max(o.gain, work);
    o.loss = std::max(o.loss, -work);
    o.largest_sideways =
        std::max(o.largest_sideways, row(r.bodies[1].momentum, i).head<2>().norm());
    if (r.active[i] > 0) o.touched_until = r.time[i];
  }
  o.momentum_b = row(r.bodies[1].momentum, r.time.size() - 1);
  return o;
}

Outcome meet(const Part& a, const Part& b, double end) {
  Simulation sim = test::two_bodies(a, b, Enforcement::impulse, end, end / 100);
  return run_scene(sim);
}

TEST(Edges, WhatPassesAnEdgeClosebyIsNotTouched) {
  for (const double speed : {0.05, 0.5}) {
    for (const double clearance : {0.004, 0.02}) {  // of a face
      Part a = cube({3, 3, 3}), b = cube({3, 3, 3});
      place(a, Matrix3::Identity(), centre + Vector3(0, 0, 0.05), Vector3(speed, 0, 0));
      place(b, Matrix3::Identity(), centre + Vector3(1.05, -1 - clearance / 3, 0), Vector3::Zero());
      for (const bool swap : {false, true}) {
        const Outcome o = swap ? meet(b, a, 1.3 / speed) : meet(a, b, 1.3 / speed);
        EXPECT_EQ(o.touched_until, 0) << speed << ' ' << clearance;
        EXPECT_EQ(o.gain, 0);
        EXPECT_EQ(o.loss, 0);
      }
    }
  }
}

// Not all hits keep below 0.1 %: with other random numbers one of forty hard ones (3 % strain, 3 x
// 3 x 3 elements) brought 0.4 %.
TEST(Edges, ConvexCornersBringHardlyAnyEnergy) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  int hits = 0, too_much = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Part a = cube({3, 3, 3}),
         b = cube(trial % 3 ? std::array<Index, 3>{3, 3, 3} : std::array<Index, 3>{2, 2, 2});
    Eigen::Matrix<double, 6, 1> any;  // axis, angle, two offsets
    for (double& x : any) x = unit(random);
    const Matrix3 R =
        Eigen::AngleAxisd(std::numbers::pi * any[3], any.head<3>().normalized()).toRotationMatrix();
    const double speed = trial % 2 ? 0.05 : 0.3;
    place(a, R, centre + Vector3(-1.8, 0.8 * any[4], 0.8 * any[5]), Vector3(speed, 0, 0));
    const Outcome o = meet(a, b, 2 / speed);
    EXPECT_LT(o.gain, 1e-2) << trial;
    too_much += o.gain > 1e-3;
    EXPECT_LT(o.loss, 0.2) << trial;
    hits += o.momentum_b.norm() > 0.05 * speed;
  }
  EXPECT_GT(hits, 30);
  EXPECT_LE(too_much, 2);
}

// Edge on edge and edge on face, head on and aside.
TEST(Edges, EdgesHitHeadOnBringNoEnergy) {
  const Matrix3 R = Eigen::AngleAxisd(std::numbers::pi / 4, Vector3::UnitZ()).toRotationMatrix();
  for (const double speed : {0.05, 0.3}) {
    for (const double aside : {0.0, 1e-3, 0.01, 0.1, 0.3, 0.6}) {
      for (const bool both : {false, true}) {
        Part a = cube({3, 3, 3}), b = cube({3, 3, 3});
        place(a, R, centre + Vector3(-1.8, aside, 0.03), Vector3(speed, 0, 0));
        if (both) place(b, R, centre, Vector3::Zero());
        const Outcome o = meet(a, b, 2 / speed);
        EXPECT_LT(o.gain, 1e-3) << speed << ' ' << aside << ' ' << both;
        EXPECT_GT(o.momentum_b.norm(), 0.2 * speed);
      }
    }
  }
}

// Three cubes of 2 x 2 x 2 elements in the shape of an L: the edge between its arms is concave.
Mesh l_shape() {
  Mesh mesh = test::brick({4, 4, 2}, Vector3(2, 2, 1));
  const auto removed = [](Index e) { return e % 4 >= 2 && (e / 4) % 4 >= 2; };
  const auto is_solid = [&](Index i, Index j, Index k) {
    return i >= 0 && j >= 0 && k >= 0 && i < 4 && j < 4 && k < 2 && !removed(i + 4 * (j + 4 * k));
  };
  std::vector<Index> kept;
  for (Index e = 0; e < 32; ++e)
    if (!removed(e)) kept.push_back(e);
  Block& block = mesh.blocks[0];
  block.connectivity = block.connectivity(kept, Eigen::all).eval();
  block.element_ids.resize(kept.size());
  std::vector<Index> used(block.connectivity.data(),
                          block.connectivity.data() + block.connectivity.size());
  sort_uniquely(used);
  for (Index i = 0; i < block.connectivity.size(); ++i) {
    Index& node = block.connectivity.data()[i];
    node = std::lower_bound(used.begin(), used.end(), node) - used.begin();
  }
  mesh.coordinates = mesh.coordinates(used, Eigen::all).eval();
  mesh.node_ids.resize(used.size());
  Sideset all{"surface", 3, {}};
  for (Index e = 0; e < static_cast<Index>(kept.size()); ++e) {
    const Index i = kept[e] % 4, j = (kept[e] / 4) % 4, k = kept[e] / 16;
    const std::array<bool, 6> inner{is_solid(i, j - 1, k), is_solid(i + 1, j, k),
                                    is_solid(i, j + 1, k), is_solid(i - 1, j, k),
                                    is_solid(i, j, k - 1), is_solid(i, j, k + 1)};
    for (int side = 1; side <= 6; ++side)
      if (!inner[side - 1]) all.sides.push_back({0, e, side});
  }
  mesh.sidesets = {all};
  return mesh;
}

TEST(Edges, AConcaveCornerHoldsWithoutBringingEnergy) {
  const Part shape = cube({1, 1, 1});
  for (const double turn : {0.0, 0.1, std::numbers::pi / 4}) {
    for (const double aside : {0.0, 0.05}) {
      Part a = cube({3, 3, 3});
      const Matrix3 R = Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
      place(a, R, Vector3(2 + aside, 2 - aside, 0.51), 0.3 * Vector3(-1, -0.9, 0).normalized());
      Simulation sim = test::two_bodies(a, shape, Enforcement::impulse, 6, 0.06);
      // The L in the place of the second body
      test::Brick l;
      l.mesh = l_shape();
      l.fe = assemble(l.mesh, {{shape.material, HexFormulation::incompatible}}, MassKind::lumped);
      l.geometry = geometry_of(l.mesh, l.fe);
      sim.bodies[1] = std::make_unique<MeshBody>(
          "l", std::make_shared<MeshModel>(mesh_model(l.fe, l.geometry.coordinates, true)),
          Placement{}, std::vector<HeldDirection>{}, std::make_shared<RowThreads>(1));
      const Surface& skin = l.geometry.surfaces.at("surface");
      ContactNodes& contact = sim.contact_nodes[1];
      contact.nodes = surface_nodes(skin);
      contact.set = sim.bodies[1]->track(contact.nodes);
      ContactSurface master = *sim.pairs[0].master;
      master.faces = linear_faces(skin).faces;
      master.nodes.clear();
      for (Index k = 0; k < master.faces.size(); ++k) {
        Index& node = master.faces.data()[k];
        node = std::lower_bound(contact.nodes.begin(), contact.nodes.end(), node) -
               contact.nodes.begin();
      }
      for (std::size_t k = 0; k < contact.nodes.size(); ++k)
        master.nodes.push_back(static_cast<Index>(k));
      const Points corners = sim.bodies[1]->reference_positions()(contact.nodes, Eigen::all);
      fill_sizes(master, corners);
      fill_edges(master, corners);
      sim.monitors[1].mean_set = sim.bodies[1]->track_mean(contact.nodes);
      sim.monitors[1].contact_slots = master.nodes;
      sim.pairs[0].master = std::make_shared<const ContactSurface>(std::move(master));
      const double h =
          0.9 * std::min(critical_step(*sim.bodies[0], true), critical_step(*sim.bodies[1], true));
      sim.plan = fit_steps(h, 0.06, 6);
      const Outcome o = run_scene(sim);
      EXPECT_LT(o.gain, 1e-3) << turn << ' ' << aside;
      // Pushed by both arms, and the cube is not inside
      EXPECT_LT(o.momentum_b[0], -0.05);
      EXPECT_LT(o.momentum_b[1], -0.05);
      EXPECT_LT(sim.pairs[0].seen().memory.depth, 1e-9);
      // Of all nodes and edges of both: 2 % of a face
      EXPECT_LT(sim.pairs[0].seen().penetration, 0.02);
    }
  }
}

// Pressed on by a light gravity, a cube slides over another and off its edge: pushed down only, let
// go when it is off.
TEST(Edges, SlidingOffAnEdgeGivesNoKick) {
  for (const std::array<Index, 3> n :
       {std::array<Index, 3>{3, 3, 3}, std::array<Index, 3>{4, 3, 2}}) {
    Part a = cube({3, 3, 3}), b = cube(n);
    const double speed = 0.4;
    place(a, Matrix3::Identity(), centre + Vector3(0.1, 0.013, 1 + 1e-6), Vector3(speed, 0, 0));
    Simulation sim = test::two_bodies(a, b, Enforcement::impulse, 3, 0.02);
    sim.bodies[0]->prepare({.loads = {gravity_load(Vector3(0, 0, -0.01))}});
    const Outcome o = run_scene(sim);
    EXPECT_LT(o.gain, 1e-3);
    EXPECT_LT(o.loss, 1e-3);
    EXPECT_LT(o.momentum_b[2], -0.005);               // it was pressed
    EXPECT_LT(o.largest_sideways, 2e-3 * speed);      // and not pushed aside
    EXPECT_LT(o.touched_until, (0.9 + 0.1) / speed);  // off the edge, at the latest
    EXPECT_GT(o.touched_until, 0.3 / speed);
  }
}

}  // namespace
}  // namespace cbr::edge_test
