// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/pressure_functions.hpp"

#include <gtest/gtest.h>

#include "common/mesh/face_weights.hpp"

namespace cbr::pressure_functions_test {
namespace {

// A strip of n x m faces, bent by `bend` so that it is curved; nodes are numbered row by row.
struct Strip {
  Points x;
  Surface surface;
};

Strip strip(FaceKind kind, Index n, Index m, double bend) {
  const bool second = kind == FaceKind::tri6 || kind == FaceKind::quad8 || kind == FaceKind::quad9;
  const Index step = second ? 2 : 1, columns = step * n + 1, rows = step * m + 1;
  Strip of;
  of.x.resize(columns * rows, 3);
  for (Index j = 0; j < rows; ++j)
    for (Index i = 0; i < columns; ++i) {
      const double u = static_cast<double>(i) / static_cast<double>(step),
                   v = static_cast<double>(j) / static_cast<double>(step);
      of.x.row(j * columns + i) << u + 0.1 * v, v, bend * u * u;
    }
  const auto at = [&](Index i, Index j) { return j * columns + i; };
  std::vector<std::vector<Index>> faces;
  for (Index j = 0; j < rows - 1; j += step)
    for (Index i = 0; i < columns - 1; i += step) {
      const Index a = at(i, j), b = at(i + step, j), c = at(i + step, j + step),
                  d = at(i, j + step);
      if (kind == FaceKind::tri3) {
        faces.push_back({a, b, c});
        faces.push_back({a, c, d});
      } else if (kind == FaceKind::tri6) {
        faces.push_back({a, b, c, at(i + 1, j), at(i + 2, j + 1), at(i + 1, j + 1)});
        faces.push_back({a, c, d, at(i + 1, j + 1), at(i + 1, j + 2), at(i, j + 1)});
      } else {
        std::vector<Index> face{a, b, c, d};
        if (second)
          for (const Index side : {at(i + 1, j), at(i + 2, j + 1), at(i + 1, j + 2), at(i, j + 1)})
            face.push_back(side);
        if (kind == FaceKind::quad9) face.push_back(at(i + 1, j + 1));
        faces.push_back(face);
      }
    }
  of.surface.kind = kind;
  of.surface.faces.resize(static_cast<Index>(faces.size()), n_nodes(kind));
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t a = 0; a < faces[f].size(); ++a)
      of.surface.faces(static_cast<Index>(f), static_cast<Index>(a)) = faces[f][a];
  return of;
}

const FaceKind kinds[] = {FaceKind::tri3, FaceKind::quad4, FaceKind::tri6, FaceKind::quad8,
                          FaceKind::quad9};

// A unit pressure on all functions is the uniform pressure, whose nodal forces face_weights() has.
void expect_uniform(const PressureFunctions& functions, const Strip& of, const char* what) {
  const Vector weights = face_weights(of.surface, of.x);
  Vector forces = Vector::Zero(of.x.rows());
  forces(functions.nodes) = functions.N * Vector::Ones(functions.size());
  EXPECT_LT((forces - weights).lpNorm<Eigen::Infinity>(), 1e-13) << what << name(of.surface.kind);
  EXPECT_EQ(static_cast<Index>(functions.entry_cell.size()), functions.N.nonZeros());
}

TEST(PressureFunctions, AUniformPressureIsExactOnFacesOfEveryKind) {
  for (const FaceKind kind : kinds) {
    const Strip of = strip(kind, 8, 6, 0.01);
    for (const Index k : {1, 3, 12})
      expect_uniform(pressure_functions({of.surface}, of.x, k), of, "aggregates ");
    const PressureFunctions corners = corner_functions({of.surface}, of.x);
    expect_uniform(corners, of, "corners ");
    EXPECT_EQ(corners.size(), 9 * 7);
    const Vector values = corners.Psi * Vector::Ones(corners.size());
    EXPECT_LT((values.array() - 1).abs().maxCoeff(), 1e-14);
    const Vector3 normal = face_normals(of.surface, of.x).colwise().sum().transpose();
    EXPECT_LT((corners.normals.colwise().sum().transpose() - normal).norm(), 1e-13);
  }
}

TEST(PressureFunctions, EveryNodeOfASmoothSurfaceHasACellAndEveryCellANode) {
  const Strip of = strip(FaceKind::quad4, 20, 15, 0.01);
  const PressureFunctions functions = pressure_functions({of.surface}, of.x, 24);
  ASSERT_EQ(functions.size(), 24);
  std::vector<int> nodes(24, 0);
  std::vector<int> cell(functions.nodes.size(), -1);
  std::size_t entry = 0;
  for (Index a = 0; a < functions.size(); ++a)
    for (SparseMatrix::InnerIterator it(functions.N, a); it; ++it, ++entry)
      cell[it.row()] = static_cast<int>(functions.entry_cell[entry]);
  for (const int of_node : cell) {
    ASSERT_GE(of_node, 0);
    ++nodes[of_node];
  }
  for (const int n : nodes) EXPECT_GT(n, 0);
}

TEST(PressureFunctions, NoFunctionReachesOverASharpEdge) {
  // Two strips at a right angle that share the nodes of an edge
  Strip of = strip(FaceKind::quad4, 8, 4, 0);
  for (Index i = 0; i < of.x.rows(); ++i)
    if (of.x(i, 0) - 0.1 * of.x(i, 1) > 4) {
      const double over = of.x(i, 0) - 0.1 * of.x(i, 1) - 4;
      of.x.row(i) << 4 + 0.1 * of.x(i, 1), of.x(i, 1), over;
    }
  const PressureFunctions functions = pressure_functions({of.surface}, of.x, 10);
  for (Index a = 0; a < functions.size(); ++a) {
    bool flat = false, upright = false;
    for (SparseMatrix::InnerIterator it(functions.N, a); it; ++it) {
      const Index node = functions.nodes[it.row()];
      flat |= of.x(node, 0) - 0.1 * of.x(node, 1) < 4 - 1e-9;
      upright |= of.x(node, 2) > 1e-9;
    }
    EXPECT_FALSE(flat && upright) << a;
  }
  expect_uniform(functions, of, "bent ");
}

}  // namespace
}  // namespace cbr::pressure_functions_test
