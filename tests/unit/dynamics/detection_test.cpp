// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/detection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

#include "dynamics/contact/search/standing_search.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::detection_test {
namespace {

using test::box, test::move, test::patch, test::Patch, test::run;

TEST(Detection, MatchingFacesKeepTheirEdgeNodes) {
  Patch top = patch(4, 0.01, false), bottom = patch(4, 0, true);
  // They meet, and slip by 2 % of a face (0.005) in later steps
  PairMemory memory;
  move(top, Vector3(0, 0, -0.02));
  ContactList list = run(top, bottom, memory);
  ASSERT_EQ(list.points.size(), 25u);
  remember(list, 0, 25, Points::Zero(25, 3), Points::Ones(25, 3), 1e-6, memory);
  top.body.start = top.body.end;
  top.body.start.col(2).setZero();
  move(top, Vector3(0.004, 0.003, -0.01));
  list = run(top, bottom, memory);
  ASSERT_EQ(list.points.size(), 25u);
  // They lose touch for a step, but do not go apart
  remember(list, 0, 25, Points::Ones(25, 3), Points::Zero(25, 3), 1e-6, memory);
  top.body.start = top.body.end;
  top.body.start.col(2).setConstant(1e-4);
  move(top, Vector3(0.001, 0, -0.0101));
  list = run(top, bottom, memory);
  EXPECT_EQ(list.points.size(), 25u);
  for (const auto& c : list.points) {
    EXPECT_NEAR(c.gap[0], -0.01, 1e-12);
    EXPECT_NEAR(c.normal()[2], 1, 1e-12);
    double slave = 0, master = 0;
    for (Index t = c.first_term; t < c.first_term + c.n_terms; ++t)
      (list.terms[t].coefficient > 0 ? slave : master) += list.terms[t].coefficient;
    EXPECT_EQ(slave, 1);
    EXPECT_NEAR(master, -1, 1e-14);
  }
}

// As a search finds them.
TEST(Detection, PointsStandWhileAnOverlapOpens) {
  const Patch top = patch(2, -1e-3, false), bottom = patch(2, 0, true);
  PairMemory memory;
  ContactList list = run(top, bottom, memory, true);
  ASSERT_EQ(list.points.size(), 9u);
  remember(list, 0, 9, Points::Zero(9, 3), Points::Ones(9, 3), 1e-6, memory);
  keep_standing(top.surface, top.body, bottom.surface, bottom.body, list, 0, 9, 9, memory);
  ASSERT_NEAR(memory.offset[4], -1e-3, 1e-15);
  memory.offset[4] = -5e-4;
  ContactList stands;
  ASSERT_TRUE(
      take_standing(top.surface, top.body, bottom.surface, bottom.body, {}, memory, stands));
  const ContactList searched = run(top, bottom, memory);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(stands.points[i].gap[0], stands.points[i].slot == 4 ? -5e-4 : 0, 1e-15);
    EXPECT_NEAR(stands.points[i].gap[0], searched.points[i].gap[0], 1e-15);
    EXPECT_NEAR(stands.points[i].start_gap, searched.points[i].start_gap, 1e-15);
  }
}

// A coarse patch above a fine one, both tested; turned by an angle about y. How many points are of
// the fine nodes, of the coarse ones, and of edges.
struct Found {
  std::size_t nodes = 0, back = 0, edges = 0;
};
Found both_sides(double angle, double height) {
  Patch fine = patch(10, 0, true), coarse = patch(2, 0, false, 0.5);
  const Eigen::AngleAxisd turn(angle, Vector3::UnitY());
  Points& x = coarse.body.start;
  for (Index i = 0; i < x.rows(); ++i)
    x.row(i) = (turn * Vector3(x.row(i).transpose())).transpose() +
               Eigen::RowVector3d(0.213, 0.241, height);
  move(coarse, Vector3(0, 0, -2 * height));
  fill_sizes(coarse.surface, coarse.body.start);
  coarse.surface.body = 1;
  for (Patch* of : {&fine, &coarse}) fill_edges(of->surface, of->body.start);
  PairMemory nodes, back, edges;
  ContactList list;
  const SearchEnds ends = detect_both(fine.surface, fine.body, coarse.surface, coarse.body, false,
                                      {}, nodes, {*coarse.surface.ridge, true, back, edges}, list);
  return {ends.nodes, ends.back - ends.nodes, ends.edges - ends.back};
}

TEST(Detection, WhatTheFinerNodesHoldIsNotHeldTwice) {
  const Found flat = both_sides(0, 1e-3);
  EXPECT_EQ(flat.nodes, 25u);  // of eleven by eleven those under the coarse patch
  EXPECT_EQ(flat.back, 0u);
  EXPECT_EQ(flat.edges, 0u);
}

TEST(Detection, AnEdgeIsHeldByItsNodes) {
  const Found tilted = both_sides(-0.7, 1e-3);
  EXPECT_EQ(tilted.nodes, 0u);
  EXPECT_EQ(tilted.back, 3u);   // of the lower edge, of two sides
  EXPECT_EQ(tilted.edges, 0u);  // between them it is as deep as they are
}

// A gap that counts as closed, and a node that is found nearer than that without having touched: it
// stays where it is.
TEST(Detection, ANodeInsideAnAdjustedGapIsLeftWhereItIs) {
  Patch top = patch(4, 0.004, false), bottom = patch(4, 0, true);
  PairMemory memory;
  memory.adjust = 0.005;
  ContactList list = run(top, bottom, memory, true);
  ASSERT_EQ(list.points.size(), 25u);
  EXPECT_NEAR(list.points[12].gap[0], 0, 1e-15);
  remember(list, 0, 25, Points::Ones(25, 3), Points::Zero(25, 3), 1e-6, memory);
  for (const double down : {0.0, 0.0005}) {
    top.body.start.col(2).setConstant(0.002);
    move(top, Vector3(0, 0, -down));
    list = run(top, bottom, memory);
    ASSERT_EQ(list.points.size(), 25u);
    for (const auto& c : list.points) {
      EXPECT_NEAR(c.start_gap, 0, 1e-15);
      EXPECT_NEAR(c.gap[0], -down, 1e-15);
    }
  }
}

// Beside the rim by 0.4 % of a face: a body that has not touched flies past, one that slides there
// is still held.
TEST(Detection, WhatPassesCloseByIsNotCaught) {
  Patch top = patch(2, 0.01, false), bottom = patch(2, 0, true);
  top.body.start.col(0).array() += 1.002;
  PairMemory memory;
  for (int step = 0; step < 4; ++step) {
    move(top, Vector3(0, 0, -0.02));
    EXPECT_TRUE(run(top, bottom, memory, step == 0).empty()) << step;
    top.body.start = top.body.end;
  }
}

TEST(Detection, FastBodiesDoNotTunnel) {
  for (const double speed : {0.5, 3.0, 50.0}) {
    Patch top = patch(3, 0.1, false), bottom = patch(5, 0, true);
    move(top, Vector3(0, 0, -speed));
    PairMemory memory;
    const auto list = run(top, bottom, memory);
    ASSERT_EQ(list.points.size(), 16u) << speed;
    for (const auto& c : list.points) EXPECT_NEAR(c.gap[0], 0.1 - speed, 1e-12);
  }
}

TEST(Detection, CommonMotionChangesNothing) {
  Patch top = patch(3, 0.1, false), bottom = patch(5, 0, true);
  move(top, Vector3(1000, -500, 299.8));
  move(bottom, Vector3(1000, -500, 300));
  PairMemory memory;
  const auto list = run(top, bottom, memory);
  EXPECT_EQ(list.points.size(), 16u);
  EXPECT_LE(memory.grid.candidates.target.size(), 16u * 9u);
}

TEST(Detection, TheFarSideOfAThinPlateDoesNotCatch) {
  // A plate of 7 % of the face size, both faces in one surface: a node above it is not "deep
  // inside" the bottom face.
  Patch node = patch(1, 0.005, false, 0.1);
  Patch plate = patch(2, 0, true);
  const Patch under = patch(2, -0.035, false);
  const Index n = plate.body.start.rows();
  Points x(2 * n, 3);
  x << plate.body.start, under.body.start;
  IndexTable faces(8, 4);
  faces << plate.surface.faces, (under.surface.faces.array() + n).matrix();
  plate.surface.faces = faces;
  plate.surface.nodes.clear();
  for (Index i = 0; i < 2 * n; ++i) plate.surface.nodes.push_back(i);
  plate.body.start = plate.body.end = x;
  fill_sizes(plate.surface, x);
  for (auto& p : {&node}) {
    p->body.start.col(0).array() += 0.2;
    p->body.start.col(1).array() += 0.2;
    move(*p, Vector3(0, 0, -0.03));  // to -0.025, nearer to the bottom than to the top
  }
  PairMemory memory;
  const auto list = run(node, plate, memory);
  ASSERT_EQ(list.points.size(), 4u);
  for (const auto& c : list.points) {
    EXPECT_NEAR(c.normal()[2], 1, 1e-12);
    EXPECT_NEAR(c.gap[0], -0.025, 1e-12);
  }
}

TEST(Detection, BodiesBehindASurfaceAreLeftAlone) {
  Patch behind = patch(3, -0.4, false), bottom = patch(2, 0, true);
  move(behind, Vector3(0, 0, 0.1));
  PairMemory memory;
  EXPECT_TRUE(run(behind, bottom, memory).empty());
}

TEST(Detection, InitialOverlapIsKeptAndReported) {
  Patch top = patch(3, -0.05, false), bottom = patch(3, 0, true);
  PairMemory memory;
  const auto list = run(top, bottom, memory, true);
  ASSERT_EQ(list.points.size(), 16u);
  EXPECT_NEAR(memory.initial_overlap, 0.05, 1e-12);
  for (const auto& c : list.points) EXPECT_NEAR(c.gap[0], 0, 1e-12);
  // Half of it opens: that half is not given up again.
  remember(list, 0, list.points.size(), Points::Constant(16, 3, 0.02), Points::Zero(16, 3), 0.03,
           memory);
  EXPECT_NEAR(memory.offset.minCoeff(), -0.03, 1e-12);
}

TEST(Detection, ACornerHoldsFromBothSides) {
  // Floor and wall of a concave corner, a node driven into both.
  Patch corner = patch(1, 0, true);
  Points x(8, 3);
  x << corner.body.start, (Points(4, 3) << 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1).finished();
  corner.surface.faces.resize(2, 4);
  corner.surface.faces << 0, 1, 3, 2, 4, 5, 7, 6;
  corner.surface.nodes = {0, 1, 2, 3, 4, 5, 6, 7};
  corner.body.start = corner.body.end = x;
  fill_sizes(corner.surface, x);
  Patch node = patch(1, 0.01, false, 0.1);
  node.body.start.col(0).array() += 0.01;
  node.body.start.col(1).array() += 0.4;
  move(node, Vector3(-0.02, 0, -0.02));
  PairMemory memory;
  const auto list = run(node, corner, memory);
  int wall = 0, floor = 0;
  for (const auto& c : list.points) {
    wall += c.normal()[0] > 0.99;
    floor += c.normal()[2] > 0.99;
  }
  EXPECT_EQ(floor, 4);
  EXPECT_EQ(wall, 2);
}

// Nodes that lie on a box near its rim are behind its sides, and behind the bottom of a thin one:
// only the top holds them.
TEST(Detection, OnlyTheFaceThatANodeCameThroughHoldsIt) {
  for (const double height : {0.1, 1.0}) {
    const Patch plate = box(3, 3, height);
    for (const double inside : {0.0, 1e-7, 1e-4, 0.01, 0.04, 0.3}) {
      for (const double gap : {0.0, 1e-6, 0.01}) {
        Patch node = patch(1, gap, false, 3 - 2 * inside);
        node.body.start.leftCols(2).array() += inside;
        PairMemory memory;
        for (int step = 0; step < 4; ++step) {
          // Down and a little sidewards; then the node is put on the top, as a contact would do
          move(node, Vector3(1e-9, -1e-9, -gap - 1e-3));
          auto list = run(node, plate, memory, step == 0);
          Points end_gap = Points::Zero(static_cast<Index>(list.points.size()), 3),
                 impulse = end_gap;
          std::array<int, 4> held{};
          for (std::size_t i = 0; i < list.points.size(); ++i) {
            const ContactPoint& c = list.points[i];
            if (c.normal()[2] > 0.99) {
              ++held[c.slot];
              EXPECT_LT(c.gap[0], -9e-4);
            } else {
              EXPECT_GT(c.gap[0], -1e-8)
                  << "pushed sidewards or through: inside " << inside << ", height " << height;
            }
            end_gap(static_cast<Index>(i), 0) = c.normal()[2] > 0.99 ? 0 : c.gap[0];
            impulse(static_cast<Index>(i), 0) = c.normal()[2] > 0.99;
          }
          EXPECT_EQ(held, (std::array<int, 4>{1, 1, 1, 1}))
              << "inside " << inside << ", gap " << gap << ", step " << step;
          remember(list, 0, list.points.size(), end_gap, impulse, 1e-6, memory);
          node.body.start.col(2).setConstant(step % 2 ? 1e-13 : -1e-13);
        }
      }
    }
  }
}

// Every node by every face, straight from the definition, against what the grid lets through.
TEST(Detection, AgreesWithBruteForceOnRoughSurfaces) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    Patch top = patch(7, 0.03, false), bottom = patch(5, 0, true);
    for (Index i = 0; i < top.body.start.rows(); ++i) top.body.start(i, 2) += 0.02 * unit(random);
    for (Index i = 0; i < bottom.body.start.rows(); ++i)
      bottom.body.start(i, 2) += 0.02 * unit(random);
    bottom.body.end = bottom.body.start;
    move(top, Vector3(0.05 * unit(random), 0.05 * unit(random), -0.05));
    PairMemory memory;
    const auto list = run(top, bottom, memory);
    for (Index i = 0; i < top.body.end.rows(); ++i) {
      double nearest = 1e300;
      for (Index f = 0; f < bottom.surface.faces.rows(); ++f) {
        const Projection p = project(corners(bottom.surface, f, bottom.body.end), false,
                                     top.body.end.row(i).transpose());
        if (p.outside <= 0) nearest = std::min(nearest, p.distance);
      }
      double found = 1e300;
      for (const auto& c : list.points)
        if (c.slot == i) found = std::min(found, c.gap[0]);
      // A node that comes in beside the sheet has not come through it
      const Vector3 start = top.body.start.row(i).transpose();
      const bool beside = start.head<2>().minCoeff() < 0.002 || start.head<2>().maxCoeff() > 0.998;
      // At a ridge the face that it came through and the one that it is nearest to may differ by
      // the roughness.
      if (nearest < 0 && !beside) {
        EXPECT_NEAR(found, nearest, 0.01);
      }
    }
  }
}

// Two boxes somewhere near each other, each deformed and moved on its own, one of them turned; thin
// ones among them, and steps longer than they are.
void disturb(Patch& p, std::mt19937& random, const Vector3& shift, const Vector3& way) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Matrix3 R =
      Eigen::AngleAxisd(unit(random), Vector3(1, 2, -1).normalized()).toRotationMatrix();
  const Matrix3 turn =
      Eigen::AngleAxisd(0.2 * unit(random), Vector3(-1, 1, 3).normalized()).toRotationMatrix() * R;
  for (Index i = 0; i < p.body.start.rows(); ++i) {
    const Vector3 x = p.body.start.row(i).transpose(),
                  rough = 0.03 * Vector3::NullaryExpr([&](Index) { return unit(random); });
    p.body.start.row(i) = (R * x + shift + rough).transpose();
    p.body.end.row(i) = (turn * x + shift + way + 0.5 * rough).transpose();
  }
}

TEST(Detection, TheGridLosesNothing) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  int near = 0, points = 0;
  for (int trial = 0; trial < 150; ++trial) {
    Patch slave = box(3, 1, trial % 3 == 0 ? 0.05 : 0.8),
          master = box(4, 1.2, trial % 4 == 0 ? 0.03 : 0.7);
    slave.surface.body = 0;
    master.surface.body = 1;
    const double far = trial % 2 ? 0.3 : 3;  // steps up to three times the body's size
    const auto any = [&](double size) {
      Vector3 x;
      for (int c = 0; c < 3; ++c) x[c] = size * unit(random);
      return x;
    };
    // one by one: compilers differ in the order of arguments
    const Vector3 slave_step = any(far), slave_place = any(1.2);
    disturb(slave, random, slave_place, slave_step);
    const Vector3 master_step = any(far), master_place = any(0.2);
    disturb(master, random, master_place, master_step);
    PairMemory memory, brute;
    brute.depth = 1e6;  // every box meets every other
    ContactList found, expected;
    detect(slave.surface, slave.body, master.surface, master.body, false, {}, memory, found);
    detect(slave.surface, slave.body, master.surface, master.body, false, {}, brute, expected);
    ASSERT_EQ(brute.grid.candidates.target.size(),
              slave.surface.nodes.size() * master.surface.faces.rows());
    ASSERT_EQ(found.points.size(), expected.points.size()) << trial;
    for (std::size_t i = 0; i < found.points.size(); ++i) {
      EXPECT_EQ(found.points[i].slot, expected.points[i].slot);
      EXPECT_EQ(found.points[i].gap[0], expected.points[i].gap[0]);
      EXPECT_EQ(found.points[i].normal(), expected.points[i].normal());
    }
    points += static_cast<int>(found.points.size());
    // With bodies that have been swept the same is found
    sweep(slave.body);
    sweep(master.body);
    PairMemory again;
    ContactList swept;
    detect(slave.surface, slave.body, master.surface, master.body, false, {}, again, swept);
    EXPECT_EQ(swept.points.size(), found.points.size());
    // Whatever comes within reach of a face at any time of the step is a candidate
    for (std::size_t slot = 0; slot < slave.surface.nodes.size(); ++slot) {
      for (Index f = 0; f < master.surface.faces.rows(); ++f) {
        double nearest = HUGE_VAL;
        for (int k = 0; k <= 10; ++k) {
          const double t = 0.1 * k;
          const FaceCorners start = corners(master.surface, f, master.body.start),
                            end = corners(master.surface, f, master.body.end);
          FaceCorners at;
          for (int a = 0; a < 4; ++a) at[a] = (1 - t) * start[a] + t * end[a];
          const Index node = slave.surface.nodes[slot];
          Vector3 d =
              ((1 - t) * slave.body.start.row(node) + t * slave.body.end.row(node)).transpose();
          const Projection p = project(at, false, d);
          for (int a = 0; a < 4; ++a) d -= p.weights[a] * at[a];
          nearest = std::min(nearest, d.norm());
        }
        if (nearest > 0.02 * master.surface.size) continue;
        ++near;
        const auto& [first, target] = memory.grid.candidates;
        EXPECT_TRUE(
            std::binary_search(target.begin() + first[slot], target.begin() + first[slot + 1], f))
            << trial;
      }
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_GT(points, 400);
}

}  // namespace
}  // namespace cbr::detection_test
