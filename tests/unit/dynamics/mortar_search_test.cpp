// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces meet, from which side and in what order, and that the answer does not hang on
// numbering or axes.
#include "dynamics/contact/search/mortar.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "common/mesh/surface.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "mortar_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::mortar_search_test {
namespace {

struct CurvedPair {
  FaceGrid slave, master;
};

// Surfaces that are neither flat nor aligned, for invariance.
CurvedPair curved_pair() {
  CurvedPair pair{face_grid(7, 6, false, GridFaces::mixed, 0.2, 3),
                  face_grid(5, 6, true, GridFaces::mixed, 0.2, 5)};
  transform(pair.master, 1.5 * turn(0.4), Vector3(-0.2, -0.4, 0));
  for (FaceGrid* grid : {&pair.slave, &pair.master}) {
    for (Index i = 0; i < grid->body.start.rows(); ++i) {
      const double x = grid->body.start(i, 0) - 0.5, y = grid->body.start(i, 1) - 0.4;
      grid->body.start(i, 2) =
          (grid == &pair.slave ? 0.3 : 0.2) * (x * x + y * y) + (grid == &pair.slave ? 2e-3 : 0);
    }
    fill_sizes(grid->surface, grid->body.start);
  }
  move(pair.slave, Vector3(0.01, 0.02, -0.03));
  pair.master.body.end = pair.master.body.start;
  return pair;
}

TEST(Mortar, TurningAllTurnsThePoints) {
  CurvedPair pair = curved_pair();
  const ContactList before = run(pair.slave, pair.master);
  ASSERT_GT(before.points.size(), 20u);
  const Matrix3 R = turn(1.1, Vector3(2, -1, 3));
  transform(pair.slave, R, Vector3(1, 2, 3));
  transform(pair.master, R, Vector3(1, 2, 3));
  const ContactList after = run(pair.slave, pair.master);
  ASSERT_EQ(after.points.size(), before.points.size());
  for (std::size_t i = 0; i < after.points.size(); ++i) {
    const ContactPoint &a = after.points[i], &b = before.points[i];
    EXPECT_EQ(a.slot, b.slot);
    EXPECT_LT((a.normal() - R * b.normal()).norm(), 1e-13);
    EXPECT_NEAR(a.gap[0], b.gap[0], 1e-13);
    EXPECT_NEAR(a.start_gap, b.start_gap, 1e-13);
    EXPECT_NEAR(a.area, b.area, 1e-13);
  }
}

TEST(Mortar, NumberingDoesNotMatter) {
  CurvedPair pair = curved_pair();
  const ContactList before = run(pair.slave, pair.master);
  std::mt19937 random(4);
  std::array<std::vector<Index>, 2> place;  // new number of a node
  for (FaceGrid* grid : {&pair.slave, &pair.master}) {
    std::vector<Index>& p = place[grid == &pair.slave ? 0 : 1];
    p = grid->surface.nodes;
    std::shuffle(p.begin(), p.end(), random);
    const Points start = grid->body.start, end = grid->body.end;
    for (std::size_t i = 0; i < p.size(); ++i) {
      grid->body.start.row(p[i]) = start.row(static_cast<Index>(i));
      grid->body.end.row(p[i]) = end.row(static_cast<Index>(i));
    }
    std::vector<Index> order = first_numbers(grid->surface.faces.rows());
    std::shuffle(order.begin(), order.end(), random);
    IndexTable faces = grid->surface.faces(order, Eigen::all);
    for (Index f = 0; f < faces.rows(); ++f) {
      const int n = faces(f, 2) == faces(f, 3) ? 3 : 4, first = int(random() % 4) % n;
      const auto row = faces.row(f).eval();
      for (int a = 0; a < 4; ++a) faces(f, a) = p[row[(std::min(a, n - 1) + first) % n]];
    }
    grid->surface.faces = faces;
    fill_sizes(grid->surface, grid->body.start);
  }
  const ContactList after = run(pair.slave, pair.master);
  ASSERT_EQ(after.points.size(), before.points.size());
  for (const ContactPoint& b : before.points) {
    const auto at = std::find_if(after.points.begin(), after.points.end(),
                                 [&](const ContactPoint& a) { return a.slot == place[0][b.slot]; });
    ASSERT_NE(at, after.points.end());
    // The first corner of a face sets the tangents of its plane, and the start of the triangles
    EXPECT_NEAR(at->gap[0], b.gap[0], 1e-10);
    EXPECT_NEAR(at->area, b.area, 1e-12);
    EXPECT_LT((at->normal() - b.normal()).norm(), 1e-10);
  }
}

TEST(Mortar, SameInputSamePoints) {
  CurvedPair pair = curved_pair();
  const ContactList a = run(pair.slave, pair.master), b = run(pair.slave, pair.master);
  ASSERT_EQ(a.terms.size(), b.terms.size());
  for (std::size_t t = 0; t < a.terms.size(); ++t) {
    EXPECT_EQ(a.terms[t].node, b.terms[t].node);
    EXPECT_EQ(a.terms[t].coefficient, b.terms[t].coefficient);
  }
}

// Which side is the slave changes the points, not what a uniform pressure does.
// What the step is told of a motion is what the next search finds, however the faces are inclined:
// else contact brings energy.
TEST(Mortar, GapsCloseAsTheStepIsTold) {
  for (const double lean : {0.0, 0.3, 0.9}) {
    FaceGrid slave = face_grid(3, 2, false),
             master = face_grid(6, 5, true, GridFaces::mixed, 0.2, 4);
    transform(slave, turn(lean, Vector3(1, 2, 0.5)), Vector3(0, 0, 0.01));
    transform(master, 8 * Matrix3::Identity(), Vector3(-4, -4, 0));
    PairMemory memory;
    const ContactList before = run(slave, master, memory, true);
    ASSERT_GT(before.points.size(), 0u);
    for (const Vector3& d : {Vector3(0, 0, 1e-3), Vector3(2e-2, -1e-2, 0)}) {
      FaceGrid moved = slave;
      shift(moved, d);
      PairMemory again;
      const ContactList after = run(moved, master, again, true);
      for (const ContactPoint& a : before.points) {
        const auto b = std::find_if(after.points.begin(), after.points.end(),
                                    [&](const ContactPoint& p) { return p.slot == a.slot; });
        ASSERT_NE(b, after.points.end());
        const double predicted = a.normal().dot(apply(before, a, moved.body.end, master.body.end));
        const double found = b->normal().dot(apply(after, *b, moved.body.end, master.body.end));
        EXPECT_NEAR(predicted, found, 1e-12) << lean;
      }
    }
  }
}

TEST(Mortar, SidesCanBeExchanged) {
  CurvedPair pair = curved_pair();
  for (FaceGrid* grid : {&pair.slave, &pair.master}) {
    grid->body.start.col(2).setZero();
    grid->body.end = grid->body.start;
  }
  const ContactList one = run(pair.slave, pair.master), other = run(pair.master, pair.slave);
  const Index n_s = pair.slave.body.end.rows(), n_m = pair.master.body.end.rows();
  EXPECT_LT((pressure_forces(one, 0, n_s) + pressure_forces(other, 1, n_s)).cwiseAbs().maxCoeff(),
            1e-9);
  EXPECT_LT((pressure_forces(one, 1, n_m) + pressure_forces(other, 0, n_m)).cwiseAbs().maxCoeff(),
            1e-9);
}

TEST(Mortar, FacesThatLookAwayDoNotMeet) {
  FaceGrid slave = face_grid(3, 3, true), master = face_grid(2, 2, true);
  EXPECT_TRUE(run(slave, master).empty());
  FaceGrid wall = face_grid(3, 3, false);
  transform(wall, turn(1.5, Vector3::UnitX()), Vector3(0, 0.5, -0.5));
  EXPECT_TRUE(run(wall, master).empty());
}

// A common edge, a common corner, a sliver of round-off: nothing. A strip: all of it, whatever
// share of a face it is.
TEST(Mortar, StripsCountAndEdgesDoNot) {
  for (const double strip : {0.0, 1e-15, 1e-9, 1e-6, 1e-3, 0.1, 0.24, 0.3, 0.49, 0.9}) {
    for (const double other : {0.0, strip, 1.0}) {
      FaceGrid slave = face_grid(4, 4, false), master = face_grid(3, 3, true);
      shift(slave, Vector3(1 - strip, 1 - other, 0));
      const ContactList list = run(slave, master);
      EXPECT_NEAR(shared_area(list), strip * other, 1e-13);
      if (strip * other < 1e-14) {
        EXPECT_TRUE(list.empty()) << strip << " " << other;
      } else {
        EXPECT_FALSE(list.empty());
      }
      for (const auto& point : list.points) {
        EXPECT_NEAR(point.gap[0], 0, 1e-13);
        EXPECT_LT(apply(list, point, slave.body.end, master.body.end).norm(), 1e-12);
      }
      // What is shared has no more points than nodes that can move it
      const auto columns = [](double share) { return std::ceil(4 * share - 1e-12) + 1; };
      EXPECT_LE(static_cast<double>(list.points.size()), columns(strip) * columns(other) + 1e-9);
    }
  }
}

TEST(Mortar, FastBodiesAreCaught) {
  for (const double speed : {0.05, 1.0, 30.0}) {
    for (const double sideways : {0.0, 0.3, 5.0}) {
      FaceGrid slave = face_grid(3, 3, false), master = face_grid(2, 2, true);
      shift(slave, Vector3(-0.3 * sideways, 0, 0.3 * speed));
      move(slave, speed * Vector3(sideways / speed, 0, -1));
      move(master, Vector3(0, 0, 0.1 * speed));
      const ContactList list = run(slave, master);
      ASSERT_FALSE(list.empty()) << speed << " " << sideways;
      for (const auto& point : list.points) {
        EXPECT_NEAR(point.start_gap, 0.3 * speed, 1e-12 * speed);
        EXPECT_NEAR(point.gap[0], -0.8 * speed, 1e-12 * speed);
      }
    }
  }
}

// A plate thinner than its faces, top and bottom: what comes from above meets the top only, what is
// below and looks down nothing.
TEST(Mortar, ThinBodiesHoldFromTheirOwnSide) {
  const double thickness = 0.06;
  FaceGrid plate = face_grid(3, 3, true), bottom = face_grid(3, 3, false);
  const Index n = plate.body.start.rows(), f = plate.surface.faces.rows();
  shift(bottom, Vector3(0, 0, -thickness));
  plate.body.start.conservativeResize(2 * n, 3);
  plate.surface.faces.conservativeResize(2 * f, 4);
  plate.body.start.bottomRows(n) = bottom.body.start;
  plate.surface.faces.bottomRows(f) = bottom.surface.faces.array() + n;
  plate.body.end = plate.body.start;
  for (Index i = n; i < 2 * n; ++i) plate.surface.nodes.push_back(i);
  fill_sizes(plate.surface, plate.body.start);
  for (const double height : {1e-4, 0.01, 0.5}) {
    FaceGrid slave = face_grid(4, 5, false);
    shift(slave, Vector3(0.1, 0.1, height));
    move(slave, Vector3(0, 0, -2));
    const ContactList list = run(slave, plate);
    EXPECT_FALSE(list.empty());
    for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], height - 2, 1e-12);
    FaceGrid below = face_grid(4, 5, false);
    shift(below, Vector3(0.1, 0.1, -thickness - height));
    EXPECT_TRUE(run(below, plate).empty()) << height;
    FaceGrid from_below = face_grid(4, 5, true);
    shift(from_below, Vector3(0.1, 0.1, -thickness - height));
    move(from_below, Vector3(0, 0, 2));
    const ContactList held = run(from_below, plate);
    EXPECT_FALSE(held.empty());
    for (const auto& point : held.points) EXPECT_NEAR(point.gap[0], height - 2, 1e-12);
  }
}

// Two plates, one over the other, as one master: the first is met.
TEST(Mortar, TheNearerOfTwoLayersIsMet) {
  for (const double distance : {0.01, 0.1, 1.0}) {
    FaceGrid layers = face_grid(3, 3, true), lower = face_grid(3, 3, true, GridFaces::triangles);
    const Index n = layers.body.start.rows(), f = layers.surface.faces.rows();
    shift(lower, Vector3(0, 0, -distance));
    layers.body.start.conservativeResize(2 * n, 3);
    layers.surface.faces.conservativeResize(f + lower.surface.faces.rows(), 4);
    layers.body.start.bottomRows(n) = lower.body.start;
    layers.surface.faces.bottomRows(lower.surface.faces.rows()) = lower.surface.faces.array() + n;
    layers.body.end = layers.body.start;
    for (Index i = n; i < 2 * n; ++i) layers.surface.nodes.push_back(i);
    fill_sizes(layers.surface, layers.body.start);
    for (const double step : {1e-4, 0.1, 3.0}) {
      FaceGrid slave = face_grid(4, 5, false);
      shift(slave, Vector3(0.05, 0.1, 1e-5));
      move(slave, Vector3(0, 0, -step));
      const ContactList list = run(slave, layers);
      EXPECT_FALSE(list.empty());
      for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], 1e-5 - step, 1e-12);
    }
  }
}

TEST(Mortar, InitialOverlapIsKept) {
  FaceGrid slave = face_grid(4, 3, false), master = face_grid(3, 3, true);
  shift(slave, Vector3(0, 0, -0.02));
  PairMemory memory;
  ContactList list = run(slave, master, memory, true);
  ASSERT_EQ(list.points.size(), 20u);
  for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], 0, 1e-14);
  EXPECT_NEAR(memory.initial_overlap, 0.02, 1e-14);
  // Pressed: the next step remembers
  Points end_gap = Points::Zero(20, 3), impulse = Points::Zero(20, 3);
  impulse.col(0).setOnes();
  remember(list, 0, 20, end_gap, impulse, 1e-6, memory);
  move(slave, Vector3(0, 0, -1e-3));
  list = run(slave, master, memory);
  ASSERT_EQ(list.points.size(), 20u);
  for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], -1e-3, 1e-14);
}

// Nodes that were closed are found 0.01 deep before anything has moved, as their weights have
// changed.
TEST(Mortar, ImpulsesGiveBackOverDriftsWhatTheyHaveTaken) {
  FaceGrid slave = face_grid(4, 3, false), master = face_grid(3, 3, true);
  PairMemory touched;
  const ContactList closed = run(slave, master, touched, true);
  ASSERT_EQ(closed.points.size(), 20u);
  Points gap = Points::Zero(20, 3), impulse = Points::Zero(20, 3);
  impulse.col(0).setConstant(3);
  remember(closed, 0, 20, gap, impulse, 1e-6, touched);
  EXPECT_EQ(touched.drift_taken, 0);
  shift(slave, Vector3(0, 0, -0.01));
  move(slave, Vector3(0.1, 0, 0));
  const auto depths = [&](double taken, bool lets_jump, PairMemory& memory) {
    memory = touched;
    memory.drift_taken = taken;
    memory.lets_jump = lets_jump;
    double sum = 0;
    for (const ContactPoint& point : run(slave, master, memory).points) sum -= point.start_gap;
    return sum;
  };
  PairMemory memory;
  EXPECT_NEAR(depths(0, false, memory), 0, 1e-12);
  EXPECT_NEAR(memory.offset.maxCoeff(), -0.01, 1e-12);
  EXPECT_NEAR(depths(0.09, false, memory), 0.09 / 3, 1e-12);
  EXPECT_NEAR(depths(100, false, memory), 20 * 0.01, 1e-12);
  EXPECT_NEAR(memory.offset.minCoeff(), 0, 1e-12);
  EXPECT_NEAR(depths(0, true, memory), 20 * 0.01, 1e-12);
  // Not more in a step than a quarter of the motion
  slave.body.end = slave.body.start;
  move(slave, Vector3(0.008, 0, 0));
  EXPECT_NEAR(depths(100, false, memory), 20 * 0.002, 1e-12);
  // What is pushed out brings energy, what is caught up with takes it
  const ContactList found = run(slave, master, memory);
  remember(found, 0, found.points.size(), gap, impulse, 1e-6, memory);
  EXPECT_NEAR(memory.drift_taken, 100 - 3 * 20 * 0.002, 1e-10);
  shift(slave, Vector3(0, 0, 0.02));
  const ContactList apart = run(slave, master, memory);
  remember(apart, 0, apart.points.size(), gap, impulse, 1e-6, memory);
  EXPECT_GT(memory.drift_taken, 100);
}

// What rests on a plate and hangs over its rim is not held by the plate's side, nor is the side of
// what rests.
TEST(Mortar, OnlyTheFaceThatHoldsHolds) {
  for (const double inside : {1e-7, 0.01, 0.2}) {
    FaceGrid cube = face_grid(2, 2, false), side = face_grid(2, 2, true),
             plate = face_grid(3, 3, true);
    // A side of the cube at x = 1, outward, with the nodes of its lower edge
    transform(side, turn(std::numbers::pi / 2, Vector3::UnitY()), Vector3(1, 0, 1));
    const Index n = cube.body.start.rows(), f = cube.surface.faces.rows();
    cube.body.start.conservativeResize(2 * n, 3);
    cube.surface.faces.conservativeResize(2 * f, 4);
    cube.body.start.bottomRows(n) = side.body.start;
    cube.surface.faces.bottomRows(f) = side.surface.faces.array() + n;
    for (Index i = n; i < 2 * n; ++i) cube.surface.nodes.push_back(i);
    cube.body.end = cube.body.start;
    fill_sizes(cube.surface, cube.body.start);
    // The plate's own side at x = 0 looks at it from behind by `inside`
    FaceGrid rim = face_grid(2, 2, true);
    transform(rim, turn(-std::numbers::pi / 2, Vector3::UnitY()), Vector3(0, 0, -1));
    plate.body.start.conservativeResize(16 + n, 3);
    plate.surface.faces.conservativeResize(9 + f, 4);
    plate.body.start.bottomRows(n) = rim.body.start;
    plate.surface.faces.bottomRows(f) = rim.surface.faces.array() + 16;
    for (Index i = 16; i < 16 + n; ++i) plate.surface.nodes.push_back(i);
    plate.body.end = plate.body.start;
    fill_sizes(plate.surface, plate.body.start);
    shift(cube, Vector3(-1 + inside, 0, 0));
    PairMemory memory;
    for (int step = 0; step < 3; ++step) {
      move(cube, Vector3(0, 0, -1e-3));
      const ContactList list = run(cube, plate, memory, step == 0);
      const Index m = list.points.size();
      Points end_gap = Points::Zero(m, 3), impulse = Points::Zero(m, 3);
      for (Index i = 0; i < m; ++i) {
        EXPECT_GT(list.points[i].normal()[2], 0.999) << inside << " " << step;
        EXPECT_NEAR(list.points[i].gap[0], -1e-3, 1e-12);
        impulse(i, 0) = 1;
      }
      EXPECT_GT(m, 0);
      remember(list, 0, list.points.size(), end_gap, impulse, 1e-6, memory);
    }
  }
}

// Faces of second order for mortar: mid-side nodes lie between their corners, also when a mirror
// has turned the faces over.
TEST(Mortar, WholeFacesKeepTheirMiddles) {
  for (const ElementType type : {ElementType::hex8, ElementType::hex20, ElementType::hex27,
                                 ElementType::tet4, ElementType::tet10, ElementType::wedge15}) {
    const Mesh mesh = test::box_mesh(type, {2, 1, 1}, Vector3(2, 1, 1));
    Sideset top{"top", 1, {}};
    for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
      for (int side = 1; side <= n_sides(type); ++side)
        if (mesh.coordinates(nodes_of_side(mesh, {0, e, side}), 2).minCoeff() == 1)
          top.sides.push_back({0, e, side});
    const Surface surface = extract_surface(mesh, top);
    IndexTable faces = whole_faces(surface), linear = contact_faces(surface);
    const bool has_centre = type == ElementType::hex27;
    const bool quadratic = n_nodes(surface.kind) > n_corners(surface.kind);
    const auto area_vectors = [&](const IndexTable& table) {
      Vector3 sum = Vector3::Zero();
      for (Index f = 0; f < table.rows(); ++f)
        sum += (mesh.coordinates.row(table(f, 2)) - mesh.coordinates.row(table(f, 0)))
                   .transpose()
                   .cross((mesh.coordinates.row(table(f, 3)) - mesh.coordinates.row(table(f, 1)))
                              .transpose()
                              .eval());
      return sum;
    };
    const Vector3 outward = area_vectors(linear);
    EXPECT_NEAR(outward[2], 4, 1e-12);
    for (const bool mirrored : {false, true}) {
      if (mirrored) turn_over(faces);
      EXPECT_LT((area_vectors(faces) - (mirrored ? -1 : 1) * outward).norm(), 1e-12);
      for (Index f = 0; f < faces.rows(); ++f) {
        const int n = faces(f, 2) == faces(f, 3) ? 3 : 4;
        for (int a = 0; a < 4; ++a) {
          const Index middle = faces(f, 4 + a);
          if (!quadratic || a >= n) {
            EXPECT_EQ(middle, -1);
            continue;
          }
          ASSERT_GE(middle, 0);
          const auto x = 0.5 * (mesh.coordinates.row(faces(f, a)) +
                                mesh.coordinates.row(faces(f, (a + 1) % n)));
          EXPECT_LT((mesh.coordinates.row(middle) - x).norm(), 1e-14);
        }
        if (!has_centre) {
          EXPECT_EQ(faces(f, 8), -1);
          continue;
        }
        const auto centre =
            0.5 * (mesh.coordinates.row(faces(f, 0)) + mesh.coordinates.row(faces(f, 2)));
        EXPECT_LT((mesh.coordinates.row(faces(f, 8)) - centre).norm(), 1e-14);
      }
    }
  }
}

}  // namespace
}  // namespace cbr::test::mortar_search_test
