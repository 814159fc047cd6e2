// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/mortar.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "common/mesh/surface.hpp"
#include "dynamics/contact/surfaces/shared_area.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "mortar_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::test::mortar_test {
namespace {

// int N_k dA of a surface by its own 3 x 3 Gauss points: exact for flat faces.
Vector consistent_forces(const FaceGrid& grid) {
  Vector force = Vector::Zero(grid.body.end.rows());
  for (Index f = 0; f < grid.surface.faces.rows(); ++f) {
    const FaceCorners x = corners(grid.surface, f, grid.body.end);
    if (is_triangle(grid.surface, f)) {
      for (int a = 0; a < 3; ++a)
        force[grid.surface.faces(f, a)] += (x[1] - x[0]).cross(x[2] - x[0]).norm() / 6;
      continue;
    }
    const double p = std::sqrt(0.6);
    for (const auto& [s, ws] :
         {std::pair{-p, 5.0 / 9}, std::pair{0.0, 8.0 / 9}, std::pair{p, 5.0 / 9}}) {
      for (const auto& [t, wt] :
           {std::pair{-p, 5.0 / 9}, std::pair{0.0, 8.0 / 9}, std::pair{p, 5.0 / 9}}) {
        const Vector3 u = ((1 - t) * (x[1] - x[0]) + (1 + t) * (x[2] - x[3])) / 4,
                      v = ((1 - s) * (x[3] - x[0]) + (1 + s) * (x[2] - x[1])) / 4;
        const double dA = ws * wt * u.cross(v).norm() / 4;
        const std::array<double, 4> N{(1 - s) * (1 - t), (1 + s) * (1 - t), (1 + s) * (1 + t),
                                      (1 - s) * (1 + t)};
        for (int a = 0; a < 4; ++a) force[grid.surface.faces(f, a)] += dA * N[a];
      }
    }
  }
  return force;
}

// Flat pairs that do not match: faces of all kinds, turned, part of them shared.
struct FlatPair {
  FaceGrid slave, master;
};
void for_flat_pairs(const std::function<void(FlatPair&)>& visit) {
  for (const GridFaces of_slave : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    for (const GridFaces of_master : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
      for (const double distortion : {0.0, 0.25}) {
        FlatPair pair{face_grid(5, 4, false, of_slave, distortion, 3),
                      face_grid(4, 3, true, of_master, distortion, 5)};
        transform(pair.master, turn(0.5), Vector3(0.2, 0.1, 0));
        SCOPED_TRACE(testing::Message() << "faces " << int(of_slave) << " on " << int(of_master)
                                        << ", distortion " << distortion);
        visit(pair);
      }
    }
  }
}

// The area of a square over a larger one of any mesh, turned and at any place, from both sides.
TEST(SharedArea, NodesOfBothSidesShareIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const auto& [n, m] : {std::pair{1, 1}, std::pair{4, 3}, std::pair{3, 7}}) {
    Patch small = patch(n, 0.001, false, 0.5), large = patch(m, 0, true, 2);
    const Matrix3 turn = Eigen::AngleAxisd(6 * unit(random), Vector3::UnitZ()).toRotationMatrix();
    small.body.start = small.body.start * turn.transpose();
    small.body.start.rowwise() += Vector3(1 + 0.2 * unit(random), 1, 0).transpose();
    const auto total = [](const Patch& a, const Patch& b, const std::vector<char>& has_point) {
      return Vector3(shared_areas(a.surface, a.body.start, b.surface, b.body.start, has_point)
                         .colwise()
                         .sum()
                         .transpose());
    };
    std::vector<char> all(small.surface.nodes.size(), 1), one(large.surface.nodes.size(), 1);
    EXPECT_LT((total(small, large, all) - Vector3(0, 0, -0.25)).norm(), 1e-13);
    EXPECT_LT((total(large, small, one) - Vector3(0, 0, 0.25)).norm(), 1e-13);
    small.body.start.rowwise() += Vector3(3, 0, 0).transpose();
    EXPECT_EQ(total(small, large, all).norm(), 0);
  }
}

TEST(Mortar, CoefficientsSumToOneOnEachSide) {
  for_flat_pairs([](FlatPair& pair) {
    const ContactList list = run(pair.slave, pair.master);
    ASSERT_GT(list.points.size(), 10u);
    for (const auto& point : list.points) {
      double slave = 0, master = 0;
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
        (list.terms[t].body == 0 ? slave : master) += list.terms[t].coefficient;
      EXPECT_NEAR(slave, 1, 1e-14);
      EXPECT_NEAR(master, -1, 1e-14);
      EXPECT_NEAR(point.normal()[2], 1, 1e-14);
    }
  });
}

TEST(Mortar, LinearFieldsPassBetweenMeshesThatDoNotMatch) {
  Matrix3 A;
  A << 0.3, -1.2, 0.7, 2, 0.4, -0.6, -0.8, 1.1, 0.5;
  for_flat_pairs([&](FlatPair& pair) {
    const ContactList list = run(pair.slave, pair.master);
    const Points u = pair.slave.body.end * A, v = pair.master.body.end * A;
    for (const auto& point : list.points) EXPECT_LT(apply(list, point, u, v).norm(), 2e-14);
  });
}

TEST(Mortar, GapOfParallelSurfacesIsTheirDistance) {
  for_flat_pairs([](FlatPair& pair) {
    shift(pair.slave, Vector3(0, 0, 1e-3));
    move(pair.slave, Vector3(0.01, -0.02, -4e-3));
    const Matrix3 R = turn(0.8, Vector3(1, 2, 3));
    transform(pair.slave, R, Vector3(3, 4, 5));
    transform(pair.master, R, Vector3(3, 4, 5));
    const ContactList list = run(pair.slave, pair.master);
    ASSERT_GT(list.points.size(), 10u);
    for (const auto& point : list.points) {
      EXPECT_NEAR(point.gap[0], -3e-3, 1e-14);
      EXPECT_NEAR(point.start_gap, 1e-3, 1e-14);
      EXPECT_LT((point.normal() - R.col(2)).norm(), 1e-14);
      EXPECT_NEAR((point.frame * point.frame.transpose() - Matrix3::Identity()).norm(), 0, 1e-14);
    }
  });
}

// A uniform pressure loads both sides as their own elements' faces would be loaded: the contact
// patch test's condition.
TEST(Mortar, UniformPressureGivesConsistentForcesOnBothSides) {
  for (const GridFaces of_slave : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    for (const GridFaces of_master : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
      for (const double distortion : {0.0, 0.15, 0.3}) {
        FaceGrid slave = face_grid(5, 4, false, of_slave, distortion, 3),
                 master = face_grid(3, 7, true, of_master, distortion, 5);
        const ContactList list = run(slave, master);
        const Vector of_s =
                         pressure_forces(list, 0, slave.body.end.rows()) - consistent_forces(slave),
                     of_m = pressure_forces(list, 1, master.body.end.rows()) +
                            consistent_forces(master);
        // Quadrature over quads that are no parallelograms; at 0.3 some have nearly a corner of 180
        // degrees
        const double tolerance = distortion == 0 ? 1e-15 : distortion < 0.2 ? 1e-11 : 1e-9;
        EXPECT_LT(of_s.cwiseAbs().maxCoeff(), tolerance) << distortion;
        EXPECT_LT(of_m.cwiseAbs().maxCoeff(), tolerance) << distortion;
        EXPECT_NEAR(shared_area(list), 1, 1e-13);
      }
    }
  }
}

// Flat, closed: the nodal forces of any impulses have no moment.
TEST(Mortar, ClosedFlatSurfacesExchangeNoMoment) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for_flat_pairs([&](FlatPair& pair) {
    const Matrix3 R = turn(0.8, Vector3(1, 2, 3));
    transform(pair.slave, R, Vector3(3, 4, 5));
    transform(pair.master, R, Vector3(3, 4, 5));
    const ContactList list = run(pair.slave, pair.master);
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    for (const auto& point : list.points) {
      const Vector3 p = point.frame.transpose() * Vector3(unit(random), unit(random), unit(random));
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = list.terms[t];
        const Vector3 x =
            (term.body == 0 ? pair.slave : pair.master).body.end.row(term.node).transpose();
        force += term.coefficient * p;
        moment += term.coefficient * x.cross(p);
      }
    }
    EXPECT_LT(force.norm(), 1e-13);
    EXPECT_LT(moment.norm(), 1e-12);
  });
}

// Squares of side 1 and 2, one turned by 45 degrees and moved: what they share is cut off by one
// straight line each.
TEST(Mortar, AreaIsThatOfTheSharedPolygon) {
  for (const GridFaces kind : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    for (const double distortion : {0.0, 0.25}) {
      // |x| + |y| <= sqrt(2) holds the square [0, 1]^2 but for the corner beyond x + y = sqrt(2)
      FaceGrid slave = face_grid(4, 3, false, kind, distortion, 1),
               master = face_grid(5, 5, true, kind, distortion, 2);
      transform(master, 2 * Matrix3::Identity(), Vector3(-1, -1, 0));
      transform(master, turn(std::numbers::pi / 4), Vector3::Zero());
      const double corner = 2 - std::sqrt(2.0);
      EXPECT_NEAR(shared_area(run(slave, master)), 1 - corner * corner / 2, 1e-13);
      // The same from the other side: less than all of the large square has a point
      FaceGrid large = face_grid(5, 5, false, kind, distortion, 2),
               small = face_grid(4, 3, true, kind, distortion, 1);
      transform(large, 2 * Matrix3::Identity(), Vector3(-1, -1, 0));
      transform(large, turn(std::numbers::pi / 4), Vector3::Zero());
      EXPECT_NEAR(shared_area(run(large, small)), 1 - corner * corner / 2, 1e-13);
    }
  }
}

// Rows against sums over many points of a face: where each lies is found by closest points in
// space, not by clipping.
TEST(Mortar, AgreesWithFineSamplingOnRandomFaces) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 30; ++trial) {
    FaceGrid slave = face_grid(1, 1, false, trial % 3 ? GridFaces::quads : GridFaces::triangles),
             master = face_grid(1, 1, true, trial % 2 ? GridFaces::quads : GridFaces::triangles);
    for (FaceGrid* grid : {&slave, &master}) {
      for (Index i = 0; i < 4; ++i)
        grid->body.end.row(i).head<2>() += 0.15 * Eigen::RowVector2d(unit(random), unit(random));
      transform(*grid, turn(3 * unit(random)), 0.3 * Vector3(unit(random), unit(random), 0));
      grid->body.start = grid->body.end;
    }
    const ContactList list = run(slave, master);
    // By slave faces: their groups are all one flat face, so that a node's sum is over all of them
    Matrix D = Matrix::Zero(4, 4), M = Matrix::Zero(4, 4);
    const int n = 600;
    for (Index f = 0; f < slave.surface.faces.rows(); ++f) {
      const FaceCorners x = corners(slave.surface, f, slave.body.end);
      const bool triangle = is_triangle(slave.surface, f);
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const double s = (i + 0.5) / n, t = (j + 0.5) / n;
          if (triangle && s + t > 1) continue;
          const Eigen::Vector4d N =
              triangle ? Eigen::Vector4d(1 - s - t, s, t, 0)
                       : Eigen::Vector4d((1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t);
          const Vector3 u = triangle ? Vector3(x[1] - x[0])
                                     : Vector3((1 - t) * (x[1] - x[0]) + t * (x[2] - x[3])),
                        v = triangle ? Vector3(x[2] - x[0])
                                     : Vector3((1 - s) * (x[3] - x[0]) + s * (x[2] - x[1]));
          const double dA = u.cross(v).norm() / (double(n) * n);
          const Vector3 place = N[0] * x[0] + N[1] * x[1] + N[2] * x[2] + N[3] * x[3];
          for (Index m = 0; m < master.surface.faces.rows(); ++m) {
            const Projection foot = project(corners(master.surface, m, master.body.end),
                                            is_triangle(master.surface, m), place);
            if (foot.outside > 0) continue;
            for (int a = 0; a < (triangle ? 3 : 4); ++a) {
              for (int b = 0; b < (triangle ? 3 : 4); ++b)
                D(slave.surface.faces(f, a), slave.surface.faces(f, b)) += N[a] * N[b] * dA;
              for (int l = 0; l < (is_triangle(master.surface, m) ? 3 : 4); ++l)
                M(slave.surface.faces(f, a), master.surface.faces(m, l)) +=
                    N[a] * foot.weights[l] * dA;
            }
            break;
          }
        }
      }
    }
    // rows of nodes without area of their own are part of others
    if (list.points.size() < 4) continue;
    for (const auto& point : list.points) {
      const Index j = slave.surface.nodes[point.slot];
      EXPECT_NEAR(point.area, D.row(j).sum(), 2e-3) << trial;
      Vector d = Vector::Zero(4), m = Vector::Zero(4);
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
        (list.terms[t].body == 0 ? d : m)[list.terms[t].node] +=
            list.terms[t].coefficient * point.area;
      EXPECT_LT((d - D.row(j).transpose()).cwiseAbs().maxCoeff(), 2e-3) << trial;
      EXPECT_LT((m + M.row(j).transpose()).cwiseAbs().maxCoeff(), 2e-3) << trial;
    }
  }
}

TEST(Mortar, EqualMeshesTieEachNodeToItsTwin) {
  for (const GridFaces kind : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    FaceGrid slave = face_grid(4, 3, false, kind, 0.2, 1),
             master = face_grid(4, 3, true, kind, 0.2, 1);
    const ContactList list = run(slave, master);
    EXPECT_EQ(list.points.size(), 20u);
    for (const auto& point : list.points) {
      Vector sum = Vector::Zero(20);  // coefficients of a node and of its twin
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
        sum[list.terms[t].node] += list.terms[t].coefficient;
      EXPECT_LT(sum.cwiseAbs().maxCoeff(), 1e-14);
    }
  }
}

}  // namespace
}  // namespace cbr::test::mortar_test
