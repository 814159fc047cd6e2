// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/face_slabs.hpp"

#include <gtest/gtest.h>

#include <random>

#include "dynamics/contact/projection.hpp"

namespace cbr {
namespace {

// Random quads, skewed, warped and deformed in the step, and nodes on their ways past them.
TEST(FaceSlabs, NeverLeaveOutANodeThatIsOverTheFace) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto vector = [&](double size) { return Vector3(size * Vector3::NullaryExpr([&](Index) { return normal(random); })); };
  int n_beside = 0, n_over = 0, n_known = 0;
  for (int i = 0; i < 20000; ++i) {
    const double rough = 0.02 * (i % 4), height = i % 3 == 0 ? 2 : 0.2;
    FaceCorners start{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1.2, 0.9, 0), Vector3(0.1, 1, 0)}, end;
    const Vector3 way = vector(1);
    for (int a = 0; a < 4; ++a) start[a] += vector(rough), end[a] = start[a] + way + vector(0.5 * rough);
    const FaceSlab slab = face_slab(start, end, false, 0.05);
    n_known += slab.is_known;
    const Vector3 x0 = Vector3(0.5, 0.5, 0) + vector(1).cwiseProduct(Vector3(1.5, 1.5, height));
    const Vector3 x1 = x0 + way + vector(0.5);
    bool over = false;
    for (int k = 0; k <= 20; ++k) {
      const double t = k / 20.0;
      FaceCorners at;
      for (int a = 0; a < 4; ++a) at[a] = (1 - t) * start[a] + t * end[a];
      over |= project(at, false, (1 - t) * x0 + t * x1).outside <= 0.05;
    }
    const bool beside = is_beside(slab, x0, x1);
    EXPECT_FALSE(beside && over) << i;
    n_beside += beside, n_over += over;
  }
  EXPECT_GT(n_known, 10000);
  EXPECT_GT(n_beside, 3000);
  EXPECT_GT(n_over, 2500);
}

TEST(FaceSlabs, AreNotKnownForTrianglesAndFacesWithoutArea) {
  const FaceCorners flat{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 1, 0)};
  EXPECT_FALSE(face_slab(flat, flat, true, 0.05).is_known);
  const FaceCorners line{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(2, 0, 0), Vector3(3, 0, 0)};
  EXPECT_FALSE(face_slab(line, line, false, 0.05).is_known);
  EXPECT_FALSE(is_beside(FaceSlab{}, Vector3(9, 9, 9), Vector3(9, 9, 9)));
}

}  // namespace
}  // namespace cbr
