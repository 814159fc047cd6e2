// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/element_type.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <map>
#include <set>

#include "sample_meshes.hpp"

namespace cbr::element_type_test {
namespace {

using test::all_types;

Vector3 point(const Points& X, int i) { return X.row(i).transpose(); }

// Sum over a closed, linear face (fan of triangles) of its vector area.
Vector3 vector_area(const Points& X, const std::vector<int>& face, int corners) {
  Vector3 area = Vector3::Zero();
  for (int i = 1; i + 1 < corners; ++i)
    area +=
        0.5 *
        (point(X, face[i]) - point(X, face[0])).cross(point(X, face[i + 1]) - point(X, face[0]));
  return area;
}

TEST(ElementType, countsAgreeWithTheFigures) {
  for (const auto type : all_types) {
    SCOPED_TRACE(name(type));
    EXPECT_EQ(static_cast<std::size_t>(n_nodes(type)), test::node_corners(type).size());
    EXPECT_EQ(name(type).find_last_not_of("0123456789") + 1,
              name(type).size() - std::to_string(n_nodes(type)).size());
    EXPECT_EQ(dimension(type) == 2, n_sides(type) == 0);
  }
}

TEST(ElementType, sidesLookOutwardsAndClose) {
  for (const auto type : all_types) {
    if (dimension(type) != 3) continue;
    SCOPED_TRACE(name(type));
    const Points corners = test::skew_corners(type);
    const Vector3 center = corners.colwise().mean().transpose();
    Vector3 sum = Vector3::Zero();
    for (int s = 1; s <= n_sides(type); ++s) {
      const auto& face = side_nodes(type, s);
      const Vector3 area = vector_area(corners, face, n_corners(side_kind(type, s)));
      EXPECT_GT(area.dot(point(corners, face[0]) - center), 0) << "side " << s;
      sum += area;
    }
    EXPECT_LT(sum.norm(), 1e-14);
  }
}

TEST(ElementType, everyEdgeBelongsToTwoSidesInOppositeSenses) {
  for (const auto type : all_types) {
    if (dimension(type) != 3) continue;
    SCOPED_TRACE(name(type));
    std::map<std::pair<int, int>, int> edges;
    for (int s = 1; s <= n_sides(type); ++s) {
      const auto& face = side_nodes(type, s);
      const int corners = n_corners(side_kind(type, s));
      for (int i = 0; i < corners; ++i) ++edges[{face[i], face[(i + 1) % corners]}];
    }
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
  }
}

TEST(ElementType, midSideNodesLieBetweenTheCornersOfTheirSide) {
  for (const auto type : all_types) {
    SCOPED_TRACE(name(type));
    const Points X = test::element_points(type, test::skew_corners(type));
    for (int s = 1; s <= n_sides(type); ++s) {
      const auto& face = side_nodes(type, s);
      const int corners = n_corners(side_kind(type, s));
      const auto n_amid = std::min(face.size(), static_cast<std::size_t>(2 * corners));
      for (std::size_t m = corners; m < n_amid; ++m) {
        const int i = static_cast<int>(m) - corners;
        EXPECT_LT(
            (point(X, face[m]) - 0.5 * (point(X, face[i]) + point(X, face[(i + 1) % corners])))
                .norm(),
            1e-15);
      }
      if (face.size() == 9) {
        Vector3 centre = Vector3::Zero();
        for (int i = 0; i < 4; ++i) centre += 0.25 * point(X, face[i]);
        EXPECT_LT((point(X, face[8]) - centre).norm(), 1e-15);
      }
    }
  }
}

TEST(ElementType, mirroredOrderMakesAReflectedElementRightHandedAndKeepsMidSideNodes) {
  for (const auto type : all_types) {
    SCOPED_TRACE(name(type));
    const auto& order = mirrored_order(type);
    Points X = test::element_points(type, test::skew_corners(type));
    Points Y(X.rows(), 3);
    X.col(1) *= -1;
    for (Index i = 0; i < X.rows(); ++i) {
      Y.row(i) = X.row(order[i]);
      EXPECT_EQ(order[order[i]], i);
    }
    const Points rebuilt = test::element_points(type, Y.topRows(n_corners(type)));
    EXPECT_LT((rebuilt - Y).norm(), 1e-14);
    const Vector3 center = Y.colwise().mean().transpose();
    std::set<int> sides;
    for (int s = 1; s <= n_sides(type); ++s) {
      const auto& face = side_nodes(type, s);
      EXPECT_GT(vector_area(Y, face, n_corners(side_kind(type, s))).dot(point(Y, face[0]) - center),
                0);
      // Same geometric face before and after.
      Vector3 before = Vector3::Zero(), after = Vector3::Zero();
      for (const int n : face) before += point(X, n);
      for (const int n : side_nodes(type, mirrored_side(type, s))) after += point(Y, n);
      EXPECT_LT((before - after).norm(), 1e-14);
      sides.insert(mirrored_side(type, s));
    }
    EXPECT_EQ(static_cast<int>(sides.size()), n_sides(type));
  }
}

}  // namespace
}  // namespace cbr::element_type_test
