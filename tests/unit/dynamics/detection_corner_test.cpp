// SPDX-License-Identifier: GPL-3.0-or-later
// Hollow corners: which faces hold a node there together.
#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/contact/search/detection.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::detection_corner_test {
namespace {

using test::patch, test::Patch, test::run;

// z = slope |x|, two faces of 1 x 1 in plan that share the edge x = 0.
Patch groove(double slope) {
  Patch p = patch(1, 0, true);
  Points x(6, 3);
  x << -1, 0, slope, 0, 0, 0, 1, 0, slope, -1, 1, slope, 0, 1, 0, 1, 1, slope;
  p.surface.faces.resize(2, 4);
  p.surface.faces << 0, 1, 4, 3, 1, 2, 5, 4;
  p.surface.nodes = {0, 1, 2, 3, 4, 5};
  p.body.start = p.body.end = x;
  fill_sizes(p.surface, x);
  return p;
}

Vector3 normal(double slope, Index face) {
  return Vector3(face == 0 ? slope : -slope, 0, 1).normalized();
}

// One node, in a step from one place to another.
Patch node(const Vector3& from, const Vector3& to) {
  Patch p = patch(1, 0, true);
  p.surface.nodes = {0};
  p.surface.areas = Vector::Ones(1);
  p.surface.area_vectors.resize(0, 3);
  p.body.start = Points(from.transpose());
  p.body.end = Points(to.transpose());
  p.surface.faces.resize(0, 4);
  return p;
}

void expect_both(const ContactList& list, const Patch& at, double slope) {
  ASSERT_EQ(list.points.size(), 2u);
  EXPECT_NE(list.points[0].face, list.points[1].face);
  for (const ContactPoint& point : list.points) {
    const Vector3 n = normal(slope, point.face);
    EXPECT_NEAR((point.normal() - n).norm(), 0, 1e-12);
    EXPECT_NEAR(point.gap[0], n.dot(at.body.end.row(0)), 1e-12);
    EXPECT_NEAR(point.start_gap, n.dot(at.body.start.row(0)), 1e-12);
  }
}

TEST(HollowCorner, FacesRiseFromEachOtherFrom15DegreesOn) {
  for (const double slope : {0.14, 1.0, 5.0}) {
    const Patch p = groove(slope);
    EXPECT_EQ(p.surface.rising_begin, (std::vector<Index>{0, 1, 2})) << slope;
    EXPECT_EQ(p.surface.rising, (std::vector<Index>{1, 0})) << slope;
  }
  for (const double slope : {-1.0, 0.0, 0.12}) {  // a ridge; flat; 13.7 degrees
    EXPECT_TRUE(groove(slope).surface.rising.empty()) << slope;
    EXPECT_TRUE(groove(slope).surface.rising_begin.empty()) << slope;
  }
}

// Whatever the prediction goes through first, and however far off the other face it does so.
TEST(HollowCorner, WhatTheFirstFaceWouldLetIntoTheOtherIsHeldByBoth) {
  int n_tried = 0;
  for (const double slope : {0.2, 0.5, 1.0, 3.0}) {
    for (const double way : {0.01, 0.1, 0.4}) {
      for (const double down : {0.1, 1.0, 3.0}) {
        const Vector3 from(0.6 * way, 0.4, slope * 0.6 * way + 1e-6),
            to = from + way * Vector3(-1, 0.1, -down);
        const Patch n = node(from, to), g = groove(slope);
        // Behind the right face, and still behind the left one when the right one has put it back;
        // or the other way round
        const Vector3 right = normal(slope, 1), left = normal(slope, 0);
        const bool goes_on = right.dot(to) < 0 && left.dot(to - right.dot(to) * right) < 0;
        if (!goes_on && !(left.dot(to) < 0 && right.dot(to - left.dot(to) * left) < 0)) continue;
        ++n_tried;
        PairMemory memory;
        SCOPED_TRACE(testing::Message()
                     << "slope " << slope << ", way " << way << ", down " << down);
        expect_both(run(n, g, memory), n, slope);
      }
    }
  }
  EXPECT_GE(n_tried, 15);
}

// Springs let it sink: it stays with both, whichever of the two it has touched longer, until it is
// out of one.
TEST(HollowCorner, WhatHasTouchedBothStaysWithBothHoweverDeep) {
  for (const double slope : {0.2, 0.5, 1.0, 3.0}) {
    const Patch g = groove(slope);
    for (const double depth : {1e-5, 1e-3, 0.01, 0.04}) {
      for (const double x : {-0.01, -1e-4, 0.0, 1e-4, 0.01}) {
        const Vector3 from(x, 0.4, slope * std::abs(x) - depth);
        const Patch n = node(from, from + Vector3(1e-4, 0, -1e-4));
        for (const Index first : {0, 1}) {
          PairMemory memory;
          start_memory(1, memory);
          memory.has_points = true;
          memory.face = memory.known_face = {first};
          memory.further_faces.assign(PairMemory::n_further, -1);
          memory.further_faces[0] = 1 - first;
          const ContactList list = run(n, g, memory);
          // of both planes: slope |x| - depth < - slope |x|
          const bool behind_both = slope * std::abs(x) < depth / 2;
          SCOPED_TRACE(testing::Message() << "slope " << slope << ", depth " << depth << ", x " << x
                                          << ", first " << first);
          if (behind_both) expect_both(list, n, slope);
          EXPECT_EQ(memory.offset[0], 0);  // nothing is left where it is
        }
      }
    }
  }
}

// An overlap from the start, deeper than what a node may be beside a face, is left, in the face
// that holds it first; the other one does not throw it out.
TEST(HollowCorner, AnOverlapFromTheStartIsNotThrownOutByTheOtherFace) {
  const Patch g = groove(0.5);
  const Vector3 at(0.02, 0.4, -0.03);  // 0.036 behind the right face, 0.018 behind the left
  PairMemory memory;
  const Patch n = node(at, at);
  for (int step = 0; step < 3; ++step) {
    const ContactList list = run(n, g, memory, step == 0);
    ASSERT_EQ(list.points.size(), 1u) << step;
    EXPECT_NEAR(list.points[0].gap[0], 0, 1e-12) << step;
    remember(list, 0, 1, Points::Zero(1, 3), Points::Zero(1, 3), 1e-6, memory);
  }
}

// Floor and two walls of a box, 2 x 2 faces each: x = 0, y = 0 and z = 0, inside where all three
// are above 0.
Patch room() {
  Patch p = patch(1, 0, true);
  Points x(19, 3);
  Index n = 0, number[3][3][3];
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < 3; ++j)
      for (Index k = 0; k < 3; ++k) {
        if (i * j * k > 0) continue;
        x.row(n) << double(i), double(j), double(k);
        number[i][j][k] = n++;
      }
  p.surface.faces.resize(12, 4);
  Index f = 0;
  for (Index a = 0; a < 2; ++a)
    for (Index b = 0; b < 2; ++b) {
      p.surface.faces.row(f++) << number[a][b][0], number[a + 1][b][0], number[a + 1][b + 1][0],
          number[a][b + 1][0];
      p.surface.faces.row(f++) << number[0][a][b], number[0][a + 1][b], number[0][a + 1][b + 1],
          number[0][a][b + 1];
      p.surface.faces.row(f++) << number[a][0][b], number[a][0][b + 1], number[a + 1][0][b + 1],
          number[a + 1][0][b];
    }
  p.surface.nodes.clear();
  for (Index i = 0; i < n; ++i) p.surface.nodes.push_back(i);
  p.body.start = p.body.end = x;
  fill_sizes(p.surface, x);
  return p;
}

// Each of the faces that hold puts the node beyond another one's end, if it is asked alone.
TEST(HollowCorner, WhatIsPressedIntoTwoWallsIsHeldByTheThird) {
  const Patch walls = room();
  const auto expect_all = [&](const Vector3& from, const Vector3& to, PairMemory& memory) {
    const Patch n = node(from, to);
    const ContactList list = run(n, walls, memory);
    ASSERT_EQ(list.points.size(), 3u) << from.transpose() << " to " << to.transpose();
    Vector3 gaps = Vector3::Zero();
    for (const ContactPoint& point : list.points) gaps += point.gap[0] * point.normal();
    EXPECT_NEAR((gaps - to).norm(), 0, 1e-12);
  };
  for (const double press : {1e-4, 0.01, 0.2}) {
    // Out of the air, through all three in one step, in any order
    for (const Vector3& late : {Vector3(1, 2, 3), Vector3(3, 1, 2), Vector3(2, 3, 1)}) {
      PairMemory memory;
      expect_all(0.5 * press * late, Vector3(-press, -press, -press), memory);
    }
    // Along an edge, held by floor and wall, into the third
    for (int axis = 0; axis < 3; ++axis) {
      PairMemory memory;
      start_memory(1, memory);
      Vector3 along = 0.5 * press * Vector3::Unit(axis);
      const auto face_at = [&](int of) {  // the one with this normal at the corner
        for (Index f = 0; f < 3; ++f)
          if (std::abs(mean_normal(corners(walls.surface, f, walls.body.start))[of]) > 0.9)
            return f;
        return Index{-1};
      };
      memory.has_points = true;
      memory.face = memory.known_face = {face_at((axis + 1) % 3)};
      memory.further_faces.assign(PairMemory::n_further, -1);
      memory.further_faces[0] = face_at((axis + 2) % 3);
      expect_all(along, Vector3(-press, -press, -press), memory);
    }
  }
}

// Beyond the ends of the groove nothing holds: a node passes by.
TEST(HollowCorner, EndsWhereItsFacesEnd) {
  const Patch g = groove(1);
  PairMemory memory;
  EXPECT_TRUE(run(node({0.01, 1.01, 0.02}, {-0.05, 1.01, -0.1}), g, memory).empty());
  EXPECT_EQ(run(node({0.01, 0.99, 0.02}, {-0.05, 0.99, -0.1}), g, memory).points.size(), 2u);
}

// Nodes amid sides carry no area, and say nothing of how much a surface bends.
TEST(ContactSurface, BendsAsItsFacesDo) {
  // Three faces of a cube that share a corner: a node of three, three of two, three of one
  Patch p = patch(1, 0, true);
  Points x(16, 3);
  x.topRows(7) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1;
  p.surface.faces.resize(3, 4);
  p.surface.faces << 0, 1, 4, 2, 0, 2, 5, 3, 0, 3, 6, 1;
  p.surface.nodes = {0, 1, 2, 3, 4, 5, 6};
  fill_sizes(p.surface, x.topRows(7));
  EXPECT_NEAR(bend(p.surface), 1 - std::sqrt(0.5), 1e-12);
  p.surface.middle = IndexTable::Constant(3, 5, -1);
  Index n = 7;
  for (Index f = 0; f < 3; ++f)
    for (int a = 0; a < 3; ++a, ++n) {
      x.row(n) = 0.5 * (x.row(p.surface.faces(f, a)) + x.row(p.surface.faces(f, a + 1)));
      p.surface.middle(f, a) = n;
      p.surface.nodes.push_back(n);
    }
  fill_sizes(p.surface, x);
  EXPECT_NEAR(bend(p.surface), 1 - std::sqrt(0.5), 1e-12);
}

}  // namespace
}  // namespace cbr::detection_corner_test
