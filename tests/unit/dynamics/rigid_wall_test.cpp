// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/rigid_wall.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

namespace cbr::rigid_wall_test {
namespace {

Vector3 random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return size * Vector3(unit(random), unit(random), unit(random));
}

WallOptions wall(WallOptions::Kind kind, bool inside, std::mt19937& random) {
  WallOptions w;
  w.kind = kind;
  w.point = random_vector(random, 1);
  w.direction = random_vector(random, 1).normalized();
  if (random() % 3 == 0) w.direction = Vector3::Unit(random() % 3);
  w.radius = kind == WallOptions::Kind::plane ? 0 : 1.5;
  w.inside = inside;
  return w;
}

std::vector<WallOptions> all_kinds(std::mt19937& random) {
  using Kind = WallOptions::Kind;
  return {wall(Kind::plane, false, random), wall(Kind::sphere, false, random),
          wall(Kind::sphere, true, random), wall(Kind::cylinder, false, random),
          wall(Kind::cylinder, true, random)};
}

TEST(RigidWall, NormalIsTheGradientOfTheDistance) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    for (const WallOptions& options : all_kinds(random)) {
      const RigidWall w(options);
      const Vector3 x = random_vector(random, 3), n = w.normal(x);
      EXPECT_NEAR(n.norm(), 1, 1e-14);
      for (int c = 0; c < 3; ++c) {
        const Vector3 d = 1e-6 * Vector3::Unit(c);
        EXPECT_NEAR((w.distance(x + d) - w.distance(x - d)) / 2e-6, n[c], 1e-4);
      }
      // The distance is that to the foot point, which lies on the wall
      EXPECT_NEAR(w.distance(x - w.distance(x) * n), 0, 1e-13);
    }
  }
}

TEST(RigidWall, KnownDistances) {
  WallOptions options;
  options.point = Vector3(0, 0, 1);
  EXPECT_DOUBLE_EQ(RigidWall(options).distance(Vector3(5, 6, 1.25)), 0.25);
  options.kind = WallOptions::Kind::cylinder;
  options.direction = Vector3::UnitY();
  options.radius = 2;
  EXPECT_DOUBLE_EQ(RigidWall(options).distance(Vector3(3, 9, 5)), 3);
  options.inside = true;
  EXPECT_DOUBLE_EQ(RigidWall(options).distance(Vector3(0, 9, 2)), 1);
  EXPECT_DOUBLE_EQ(RigidWall(options).normal(Vector3(0, 9, 2))[2], -1);
}

TEST(RigidWall, BulgesBetweenNodes) {
  WallOptions wall;
  wall.kind = WallOptions::Kind::sphere;
  wall.radius = 5;
  EXPECT_DOUBLE_EQ(RigidWall(wall).bulge(3 * std::sqrt(2.0)), 1);
  EXPECT_EQ(RigidWall(wall).bulge(8), HUGE_VAL);
  wall.kind = WallOptions::Kind::cylinder;
  EXPECT_DOUBLE_EQ(RigidWall(wall).bulge(8), 2);
  wall.inside = true;
  EXPECT_EQ(RigidWall(wall).bulge(8), 0);
}

TEST(RigidWall, OnTheAxisTheNormalIsFinite) {
  for (const bool inside : {false, true}) {
    for (const auto kind : {WallOptions::Kind::sphere, WallOptions::Kind::cylinder}) {
      WallOptions options;
      options.kind = kind;
      options.radius = 1;
      options.inside = inside;
      const Vector3 n = RigidWall(options).normal(Vector3::Zero());
      EXPECT_NEAR(n.norm(), 1, 1e-14);
      if (kind == WallOptions::Kind::cylinder) {
        EXPECT_NEAR(n.dot(options.direction), 0, 1e-14);
      }
    }
  }
}

// A bound and motions that keep to it: each coordinate anywhere between its limits.
MotionBound random_bound(std::mt19937& random, bool still) {
  MotionBound b;
  const Vector3 at = random_vector(random, 4), size = random_vector(random, 0.4).cwiseAbs(),
                v = random_vector(random, 1);
  b.lower = at - size;
  b.upper = at + size;
  b.lower_speed = v - random_vector(random, 0.1).cwiseAbs();
  b.upper_speed = v + random_vector(random, 0.1).cwiseAbs();
  b.growth = still ? Vector3(Vector3::Zero()) : Vector3(random_vector(random, 0.1).cwiseAbs());
  b.acceleration =
      still ? Vector3(Vector3::Zero()) : Vector3(random_vector(random, 0.2).cwiseAbs());
  return b;
}

TEST(RigidWall, NothingReachesItBeforeItsTime) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  int apart = 0, never = 0, close = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const MotionBound b = random_bound(random, trial % 4 == 0);
    const double margin = trial % 2 ? 0.05 : 0;
    for (const WallOptions& options : all_kinds(random)) {
      const RigidWall w(options);
      const double found = w.time_apart(b, margin);
      ASSERT_GE(found, 0);
      const double end = std::min(found, 50.0);
      double nearest = HUGE_VAL;
      for (int sample = 0; sample < 60; ++sample) {
        const double t = sample < 30 ? end : end * unit(random);
        const Vector3 spread = b.growth * t + 0.5 * t * t * b.acceleration;
        Vector3 x;
        for (int c = 0; c < 3; ++c) {
          // corners, and anywhere
          const double share = sample % 3 ? std::round(unit(random)) : unit(random);
          x[c] = (1 - share) * (b.lower[c] + b.lower_speed[c] * t - spread[c]) +
                 share * (b.upper[c] + b.upper_speed[c] * t + spread[c]);
        }
        if (found > 0) {
          EXPECT_GE(w.distance(x), margin - 1e-9 * (1 + x.norm())) << trial;
        }
        nearest = std::min(nearest, w.distance(x));
      }
      apart += found > 0 && std::isfinite(found);
      never += !std::isfinite(found);
      close += found > 0 && nearest < margin + 0.1;
    }
  }
  // It is no empty statement: many are apart for a time, some for ever, and most of the others do
  // come near
  EXPECT_GT(apart, 2000);
  EXPECT_GT(never, 500);
  EXPECT_GT(close, apart / 2);
}

// A point on a straight way: the time is that of its arrival, not much less.
TEST(RigidWall, TheTimeOfAStraightFlightIsFoundClosely) {
  std::mt19937 random(3);
  int found = 0;
  for (int trial = 0; trial < 800; ++trial) {
    for (const WallOptions& options : all_kinds(random)) {
      const RigidWall w(options);
      const Vector3 x = random_vector(random, 3), v = random_vector(random, 1);
      if (!(w.distance(x) > 0.01)) continue;
      double arrival = HUGE_VAL;
      for (int i = 1; i < 4000 && arrival == HUGE_VAL; ++i)
        if (w.distance(x + 0.005 * i * v) < 0) arrival = 0.005 * i;
      const MotionBound b{x, x, v, v, Vector3::Zero(), Vector3::Zero()};
      const double apart = w.time_apart(b, 0);
      EXPECT_LE(apart, arrival * (1 + 1e-12));
      if (arrival < 20) {
        EXPECT_GT(apart, 0.9 * (arrival - 0.005));
        ++found;
      }
    }
  }
  EXPECT_GT(found, 300);
}

// Loose nodes as a slave surface.
struct Nodes {
  ContactSurface surface;
  ContactBody body;
};

Nodes nodes(const Points& start, const Points& end) {
  Nodes s;
  s.body.start = start;
  s.body.end = end;
  s.surface.body = 3;
  s.surface.size = 0.5;
  for (Index i = 0; i < start.rows(); ++i) s.surface.nodes.push_back(i);
  s.surface.areas = Vector::LinSpaced(start.rows(), 1, 2);
  return s;
}

ContactList detect_once(const Nodes& s, const WallOptions& options, bool initial,
                        PairMemory& memory, double standing_reach = 0) {
  ContactList list;
  detect_wall(s.surface, s.body, RigidWall(options), initial, standing_reach, memory, list);
  return list;
}

WallOptions ball(double radius, bool inside) {
  WallOptions options;
  options.kind = WallOptions::Kind::sphere;
  options.radius = radius;
  options.inside = inside;
  return options;
}

// However far a node would go in a step: with its gap closed along the normal it is not behind the
// wall.
TEST(RigidWallDetection, EveryNodeThatGetsThroughIsHeld) {
  std::mt19937 random(4);
  int through = 0, held = 0;
  for (int trial = 0; trial < 300; ++trial) {
    for (const WallOptions& options : all_kinds(random)) {
      const RigidWall w(options);
      Points start(20, 3), end(20, 3);
      for (Index i = 0; i < 20; ++i) {
        Vector3 x;
        do x = random_vector(random, 3);
        while (w.distance(x) < 0.01);
        start.row(i) = x.transpose();
        end.row(i) = (x + random_vector(random, trial % 2 ? 0.2 : 4)).transpose();
      }
      const Nodes s = nodes(start, end);
      PairMemory memory;
      const ContactList list = detect_once(s, options, false, memory);
      std::vector<Index> point_of(20, -1);
      for (std::size_t i = 0; i < list.points.size(); ++i) {
        const ContactPoint& point = list.points[i];
        ASSERT_EQ(point.n_terms, 1);
        const ContactTerm& term = list.terms[point.first_term];
        EXPECT_EQ(term.body, 3);
        EXPECT_EQ(term.node, point.slot);
        EXPECT_EQ(term.coefficient, 1);
        EXPECT_EQ(point.area, s.surface.areas[point.slot]);
        EXPECT_NEAR((point.frame * point.frame.transpose() - Matrix3::Identity()).norm(), 0, 1e-12);
        point_of[point.slot] = static_cast<Index>(i);
        const Vector3 x1 = end.row(point.slot).transpose();
        const Vector3 closed = x1 + std::max(0.0, -point.gap[0]) * point.normal();
        EXPECT_GE(w.distance(closed), -1e-9);
        held += point.gap[0] < 0;
      }
      for (Index i = 0; i < 20; ++i) {
        bool behind = false;
        for (int k = 1; k <= 200; ++k)
          behind |=
              w.distance((start.row(i) + 0.005 * k * (end.row(i) - start.row(i))).transpose()) <
              -1e-6;
        through += behind && w.distance(end.row(i).transpose()) > 0;
        if (w.distance(end.row(i).transpose()) < 0) {
          ASSERT_GE(point_of[i], 0);
          EXPECT_LT(list.points[point_of[i]].gap[0], 0);
        }
      }
    }
  }
  EXPECT_GT(held, 1000);
  EXPECT_GT(through, 50);
}

TEST(RigidWallDetection, AFastNodeDoesNotPassThroughABall) {
  const Nodes s = nodes((Points(2, 3) << -5, 0.1, 0, -5, 0.1, 0).finished(),
                        (Points(2, 3) << 7, 0.1, 0, 0.4, 0.1, 0).finished());
  PairMemory memory;
  const ContactList list = detect_once(s, ball(1, false), false, memory);
  ASSERT_EQ(list.points.size(), 2u);
  EXPECT_LT(list.points[0].normal()[0], -0.9);  // back to where it came from
  EXPECT_LT(list.points[0].gap[0], -7);
  EXPECT_LT(list.points[1].normal()[0], -0.9);
}

TEST(RigidWallDetection, ABodyThatStandsOnAWallHasNoInitialGap) {
  const WallOptions floor;
  const Points start = (Points(2, 3) << 0, 0, 0, 1, 0, 0.002).finished();
  PairMemory memory;
  detect_once(nodes(start, start), floor, true, memory);
  EXPECT_EQ(memory.initial_gap, 0);
  EXPECT_EQ(memory.initial_overlap, 0);
}

TEST(RigidWallDetection, InitialOverlapsAreKeptAndGapsAdjustedWhenAsked) {
  WallOptions floor;
  const Points start =
      (Points(4, 3) << 0, 0, -0.01, 1, 0, 0.002, 2, 0, 0.02, 3, 0, -1e-9).finished();
  for (const double adjust : {0.0, 0.005}) {
    PairMemory memory;
    memory.adjust = adjust;
    const ContactList list = detect_once(nodes(start, start), floor, true, memory);
    ASSERT_EQ(list.points.size(), 4u);
    EXPECT_DOUBLE_EQ(memory.initial_overlap, 0.01);
    EXPECT_DOUBLE_EQ(memory.initial_gap, 0.002);
    EXPECT_DOUBLE_EQ(list.points[0].gap[0], 0);
    EXPECT_DOUBLE_EQ(list.points[1].gap[0], adjust > 0 ? 0 : 0.002);
    EXPECT_DOUBLE_EQ(list.points[2].gap[0], 0.02);
    EXPECT_DOUBLE_EQ(list.points[3].gap[0], 0);
  }
}

TEST(RigidWallDetection, FarNodesMakeNoPoints) {
  const Points far = (Points(2, 3) << 0, 0, 3, 0, 0, 4).finished();
  PairMemory memory;
  EXPECT_TRUE(detect_once(nodes(far, far), WallOptions{}, true, memory).empty());
  EXPECT_TRUE(detect_once(nodes(far, far), ball(100, true), false, memory).empty());
}

// Nodes of a plane that come within the reach of 0.01 and leave it. Within 0.1 beyond that they
// have points that stand until a node without one comes near.
TEST(RigidWallDetection, PointsOfAPlaneStandWhileNodesComeAndGo) {
  PairMemory memory;
  const auto slots = [&](double a, double b, double c) {
    const Points at = (Points(3, 3) << 0, 0, a, 1, 0, b, 2, 0, c).finished();
    std::vector<Index> list;
    for (const ContactPoint& point : detect_once(nodes(at, at), {}, false, memory, 0.1).points)
      list.push_back(point.slot);
    return list;
  };
  using List = std::vector<Index>;
  EXPECT_EQ(slots(0.02, 0.02, 0.2), List());
  EXPECT_EQ(slots(0, 0.05, 0.2), List({0, 1}));
  EXPECT_EQ(slots(0, 0, 0.2), List({0, 1}));
  EXPECT_EQ(slots(0.3, 0, 0.05), List({0, 1}));
  EXPECT_EQ(slots(0.3, 0, 0), List({1, 2}));
  EXPECT_EQ(slots(0.3, 0.02, 0.02), List());
}

}  // namespace
}  // namespace cbr::rigid_wall_test
