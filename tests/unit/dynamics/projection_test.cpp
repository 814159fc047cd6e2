// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

namespace cbr::projection_test {
namespace {

Vector3 random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return size * Vector3(unit(random), unit(random), unit(random));
}

FaceCorners random_quad(std::mt19937& random, double warp) {
  FaceCorners x{Vector3(-1, -1, 0), Vector3(1, -1, 0), Vector3(1, 1, 0), Vector3(-1, 1, 0)};
  for (auto& corner : x) corner += random_vector(random, warp);
  return x;
}

Vector3 foot(const FaceCorners& x, const Projection& p) {
  Vector3 sum = Vector3::Zero();
  for (int a = 0; a < 4; ++a) sum += p.weights[a] * x[a];
  return sum;
}

// Distance to the quad by sampling, then local refinement.
double sampled_distance(const FaceCorners& x, const Vector3& point, bool triangle) {
  double best = HUGE_VAL, best_s = 0, best_t = 0, range = 1;
  for (int level = 0; level < 12; ++level, range *= 0.3) {
    const double s0 = best_s, t0 = best_t;
    for (int i = -10; i <= 10; ++i) {
      for (int j = -10; j <= 10; ++j) {
        const double s = std::clamp(s0 + range * i / 10, -1.0, 1.0),
                     t = std::clamp(t0 + range * j / 10, -1.0, 1.0);
        Vector3 p = 0.25 * ((1 - s) * (1 - t) * x[0] + (1 + s) * (1 - t) * x[1] +
                            (1 + s) * (1 + t) * x[2] + (1 - s) * (1 + t) * x[3]);
        if (triangle) {
          const double u = 0.5 * (1 + s), v = 0.5 * (1 + t) * (1 - u);
          p = (1 - u - v) * x[0] + u * x[1] + v * x[2];
        }
        if ((p - point).norm() < best) {
          best = (p - point).norm();
          best_s = s;
          best_t = t;
        }
      }
    }
  }
  return best;
}

TEST(Projection, InnerFootPointIsTheClosestPoint) {
  std::mt19937 random(1);
  int inside = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const FaceCorners x = random_quad(random, 0.2);
    const Vector3 point = Vector3(0, 0, 0.3) + random_vector(random, 0.9);
    const Projection p = project(x, false, point);
    EXPECT_NEAR(p.weights[0] + p.weights[1] + p.weights[2] + p.weights[3], 1, 1e-14);
    if (p.outside > -1e-3) continue;
    ++inside;
    const Vector3 d = point - foot(x, p);
    EXPECT_NEAR(std::abs(p.distance), d.norm(), 1e-10);  // the offset is along the normal
    EXPECT_NEAR(d.norm(), sampled_distance(x, point, false), 1e-5);
  }
  EXPECT_GT(inside, 100);
}

TEST(Projection, Triangle) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 300; ++trial) {
    FaceCorners x{random_vector(random, 1), random_vector(random, 1), random_vector(random, 1), {}};
    x[3] = x[2];
    if ((x[1] - x[0]).cross(x[2] - x[0]).norm() < 0.3) continue;
    const Vector3 point = random_vector(random, 1.5);
    const Projection p = project(x, true, point);
    EXPECT_EQ(p.weights[3], 0);
    const double sampled = sampled_distance(x, point, true);  // never below the true distance
    EXPECT_LT((point - foot(x, p)).norm(), sampled + 1e-12);
    EXPECT_GT((point - foot(x, p)).norm(), sampled - 5e-3);
    const Vector3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    EXPECT_LT((p.normal - normal).norm(), 1e-14);
    if (p.outside <= 0) {
      EXPECT_NEAR(p.distance, normal.dot(point - x[0]), 1e-13);
    }
  }
}

TEST(Projection, OutsideIsAShareOfTheFace) {
  const FaceCorners x{Vector3(0, 0, 0), Vector3(2, 0, 0), Vector3(2, 2, 0), Vector3(0, 2, 0)};
  EXPECT_NEAR(project(x, false, Vector3(2.1, 1, 5)).outside, 0.05, 1e-12);
  EXPECT_NEAR(project(x, false, Vector3(1, 1, -3)).outside, -0.5, 1e-12);
  EXPECT_NEAR(project(x, false, Vector3(1, 1, -3)).distance, -3, 1e-12);
  // far off is cut off at a whole face
  EXPECT_NEAR(project(x, false, Vector3(50, 1, 0)).outside, 1, 1e-12);
}

TEST(Projection, SignAndNormalFollowTheRightHandRule) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    FaceCorners x = random_quad(random, 0.1);
    const Vector3 point(0.1, 0.2, 0.4);
    const double distance = project(x, false, point).distance;
    EXPECT_GT(distance, 0);
    std::swap(x[1], x[3]);
    EXPECT_NEAR(project(x, false, point).distance, -distance, 1e-10);
  }
}

TEST(Projection, DegenerateFacesGiveNoNormalAndNoNaN) {
  const Vector3 point(0.3, 0.4, 0.5);
  for (const FaceCorners& x :
       {FaceCorners{Vector3(1, 1, 1), Vector3(1, 1, 1), Vector3(1, 1, 1), Vector3(1, 1, 1)},
        FaceCorners{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(2, 0, 0), Vector3(2, 0, 0)}}) {
    for (const bool triangle : {false, true}) {
      const Projection p = project(x, triangle, point);
      EXPECT_TRUE(std::isfinite(p.distance));
      EXPECT_TRUE(p.normal.isZero());
    }
  }
}

}  // namespace
}  // namespace cbr::projection_test
