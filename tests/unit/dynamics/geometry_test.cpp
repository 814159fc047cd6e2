// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/geometry.hpp"

#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::geometry_test {
namespace {

// One face, points in the plane z = x/2, with mid-side nodes where the kind has them.
Surface face(FaceKind kind, Points& x) {
  Surface s;
  s.kind = kind;
  const int n = n_nodes(kind), corners = kind == FaceKind::tri3 || kind == FaceKind::tri6 ? 3 : 4;
  x.resize(n, 3);
  const Points square = (Points(4, 3) << 0, 0, 0, 2, 0, 1, 2, 3, 1, 0, 3, 0).finished();
  x.topRows(corners) = square.topRows(corners);
  for (int i = corners; i < std::min(n, 2 * corners); ++i)
    x.row(i) = 0.5 * (x.row(i - corners) + x.row((i - corners + 1) % corners));
  if (n == 9) x.row(8) = square.colwise().mean();
  s.faces.resize(1, n);
  for (int i = 0; i < n; ++i) s.faces(0, i) = i;
  return s;
}

TEST(FaceWeights, SumToTheAreaAndKeepTheMoment) {
  const double square = 3 * std::sqrt(5.0);
  for (const FaceKind kind :
       {FaceKind::tri3, FaceKind::quad4, FaceKind::tri6, FaceKind::quad8, FaceKind::quad9}) {
    Points x;
    const Surface s = face(kind, x);
    const Vector w = face_weights(s, x);
    const bool triangle = kind == FaceKind::tri3 || kind == FaceKind::tri6;
    EXPECT_NEAR(w.sum(), triangle ? square / 2 : square, 1e-13 * square);
    // Resultant at the centroid
    const Vector3 centre = triangle ? Vector3(4.0 / 3, 1, 2.0 / 3) : Vector3(1, 1.5, 0.5);
    EXPECT_LT((x.transpose() * w / w.sum() - centre).norm(), 1e-13);
  }
}

TEST(FaceWeights, CollapsedQuadIsATriangle) {
  Points x;
  const Surface triangle = face(FaceKind::tri3, x);
  Surface collapsed = triangle;
  collapsed.kind = FaceKind::quad4;
  collapsed.faces.resize(1, 4);
  collapsed.faces << 0, 1, 2, 2;
  EXPECT_LT((face_weights(collapsed, x) - face_weights(triangle, x)).norm(), 1e-14);
}

TEST(FaceWeights, QuadraticTriangleHasNoForceOnItsCorners) {
  Points x;
  const Vector w = face_weights(face(FaceKind::tri6, x), x);
  EXPECT_LT(w.head(3).norm(), 1e-13 * w.sum());
  EXPECT_LT((w.tail(3).array() - w.sum() / 3).matrix().norm(), 1e-13 * w.sum());
}

TEST(FaceWeights, OfNineNodesAreSimpsons) {
  Points x;
  const Vector w = face_weights(face(FaceKind::quad9, x), x);
  const Vector expected = (Vector(9) << 1, 1, 1, 1, 4, 4, 4, 4, 16).finished() / 36;
  EXPECT_LT((w / w.sum() - expected).norm(), 1e-13);
}

TEST(ContactFaces, NineNodesAreFourFacesToNodesAndOneToMortar) {
  Points x;
  const Surface surface = face(FaceKind::quad9, x);
  const IndexTable whole = whole_faces(surface), linear = contact_faces(surface);
  ASSERT_EQ(whole.rows(), 1);
  EXPECT_EQ(whole, surface.faces);
  ASSERT_EQ(linear.rows(), 4);
  EXPECT_EQ(nodes_of(linear).size(), 9u);
}

TEST(GeometryNames, WhatIsNotThereIsNamedWithTheCure) {
  const test::Lattice full = test::lattice({3, 3, 3}, 1, 1, 1);
  const Geometry geometry = geometry_of(test::reduce(full, test::x_nodes(full, false, true), 2));
  const std::string text = test::refusal_of([&] {
    find_surface(geometry, "left", "x_mx", {"scene.yaml", 12});
  });
  for (const char* part : {"scene.yaml:12", "left", "x_mx", "x_max", "did you mean", "cbr-reduce"})
    EXPECT_SAYS(text, part) << part;
}

}  // namespace
}  // namespace cbr::geometry_test
