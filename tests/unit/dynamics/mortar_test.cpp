// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/mortar.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "face_grid.hpp"

namespace cbr {
namespace {

using test::face_grid;
using test::FaceGrid;
using test::GridFaces;
using test::move;
using test::shift;
using test::transform;
using test::turn;

ContactList run(FaceGrid& slave, FaceGrid& master, PairMemory& memory, bool initial = false) {
  slave.surface.body = 0, master.surface.body = 1;
  ContactList list;
  detect_mortar(slave.surface, slave.body, master.surface, master.body, initial, {}, memory, list);
  return list;
}

ContactList run(FaceGrid& slave, FaceGrid& master) {
  PairMemory memory;
  return run(slave, master, memory);
}

// sum of coefficient x field over the terms of one body, or of both
Vector3 apply(const ContactList& list, const ContactPoint& point, const Points& slave, const Points& master) {
  Vector3 sum = Vector3::Zero();
  for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
    const ContactTerm& term = list.terms[t];
    sum += term.coefficient * (term.body == 0 ? slave : master).row(term.node).transpose();
  }
  return sum;
}

double shared_area(const ContactList& list) {
  double sum = 0;
  for (const auto& point : list.points) sum += point.area;
  return sum;
}

// Forces of a uniform unit pressure: sum of area x coefficient per node.
Vector pressure_forces(const ContactList& list, Index body, Index n_nodes) {
  Vector force = Vector::Zero(n_nodes);
  for (const auto& point : list.points)
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
      if (list.terms[t].body == body) force[list.terms[t].node] += point.area * list.terms[t].coefficient;
  return force;
}

// int N_k dA of a surface by its own 3 x 3 Gauss points: exact for flat faces.
Vector consistent_forces(const FaceGrid& grid) {
  Vector force = Vector::Zero(grid.body.end.rows());
  for (Index f = 0; f < grid.surface.faces.rows(); ++f) {
    const FaceCorners x = corners(grid.surface, f, grid.body.end);
    if (is_triangle(grid.surface, f)) {
      for (int a = 0; a < 3; ++a) force[grid.surface.faces(f, a)] += (x[1] - x[0]).cross(x[2] - x[0]).norm() / 6;
      continue;
    }
    const double p = std::sqrt(0.6);
    for (const auto& [s, ws] : {std::pair{-p, 5.0 / 9}, std::pair{0.0, 8.0 / 9}, std::pair{p, 5.0 / 9}}) {
      for (const auto& [t, wt] : {std::pair{-p, 5.0 / 9}, std::pair{0.0, 8.0 / 9}, std::pair{p, 5.0 / 9}}) {
        const Vector3 u = ((1 - t) * (x[1] - x[0]) + (1 + t) * (x[2] - x[3])) / 4,
                      v = ((1 - s) * (x[3] - x[0]) + (1 + s) * (x[2] - x[1])) / 4;
        const double dA = ws * wt * u.cross(v).norm() / 4;
        const std::array<double, 4> N{(1 - s) * (1 - t), (1 + s) * (1 - t), (1 + s) * (1 + t), (1 - s) * (1 + t)};
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
        FlatPair pair{face_grid(5, 4, false, of_slave, distortion, 3), face_grid(4, 3, true, of_master, distortion, 5)};
        transform(pair.master, turn(0.5), Vector3(0.2, 0.1, 0));
        SCOPED_TRACE(testing::Message() << "faces " << int(of_slave) << " on " << int(of_master) << ", distortion " << distortion);
        visit(pair);
      }
    }
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
    transform(pair.slave, R, Vector3(3, 4, 5)), transform(pair.master, R, Vector3(3, 4, 5));
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

// A uniform pressure loads both sides as their own elements' faces would be loaded: the contact patch test's condition.
TEST(Mortar, UniformPressureGivesConsistentForcesOnBothSides) {
  for (const GridFaces of_slave : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    for (const GridFaces of_master : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
      for (const double distortion : {0.0, 0.15, 0.3}) {
        FaceGrid slave = face_grid(5, 4, false, of_slave, distortion, 3), master = face_grid(3, 7, true, of_master, distortion, 5);
        const ContactList list = run(slave, master);
        const Vector of_s = pressure_forces(list, 0, slave.body.end.rows()) - consistent_forces(slave),
                     of_m = pressure_forces(list, 1, master.body.end.rows()) + consistent_forces(master);
        // Quadrature over quads that are no parallelograms; at 0.3 some have nearly a corner of 180 degrees
        const double tolerance = distortion == 0 ? 1e-15 : distortion < 0.2 ? 1e-11 : 1e-9;
        EXPECT_LT(of_s.cwiseAbs().maxCoeff(), tolerance) << distortion;
        EXPECT_LT(of_m.cwiseAbs().maxCoeff(), tolerance) << distortion;
        EXPECT_NEAR(shared_area(list), 1, 1e-13);
      }
    }
  }
}

}  // namespace
}  // namespace cbr
