// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/mortar.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "common/mesh/surface.hpp"
#include "dynamics/setup/contact_faces.hpp"
#include "face_grid.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

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

// Flat, closed: the nodal forces of any impulses have no moment.
TEST(Mortar, ClosedFlatSurfacesExchangeNoMoment) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for_flat_pairs([&](FlatPair& pair) {
    const Matrix3 R = turn(0.8, Vector3(1, 2, 3));
    transform(pair.slave, R, Vector3(3, 4, 5)), transform(pair.master, R, Vector3(3, 4, 5));
    const ContactList list = run(pair.slave, pair.master);
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    for (const auto& point : list.points) {
      const Vector3 p = point.frame.transpose() * Vector3(unit(random), unit(random), unit(random));
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = list.terms[t];
        const Vector3 x = (term.body == 0 ? pair.slave : pair.master).body.end.row(term.node).transpose();
        force += term.coefficient * p, moment += term.coefficient * x.cross(p);
      }
    }
    EXPECT_LT(force.norm(), 1e-13);
    EXPECT_LT(moment.norm(), 1e-12);
  });
}

// Squares of side 1 and 2, one turned by 45 degrees and moved: what they share is cut off by one straight line each.
TEST(Mortar, AreaIsThatOfTheSharedPolygon) {
  for (const GridFaces kind : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    for (const double distortion : {0.0, 0.25}) {
      // |x| + |y| <= sqrt(2) holds the square [0, 1]^2 but for the corner beyond x + y = sqrt(2)
      FaceGrid slave = face_grid(4, 3, false, kind, distortion, 1), master = face_grid(5, 5, true, kind, distortion, 2);
      transform(master, 2 * Matrix3::Identity(), Vector3(-1, -1, 0));
      transform(master, turn(std::numbers::pi / 4), Vector3::Zero());
      const double corner = 2 - std::sqrt(2.0);
      EXPECT_NEAR(shared_area(run(slave, master)), 1 - corner * corner / 2, 1e-13);
      // The same from the other side: less than all of the large square has a point
      FaceGrid large = face_grid(5, 5, false, kind, distortion, 2), small = face_grid(4, 3, true, kind, distortion, 1);
      transform(large, 2 * Matrix3::Identity(), Vector3(-1, -1, 0));
      transform(large, turn(std::numbers::pi / 4), Vector3::Zero());
      EXPECT_NEAR(shared_area(run(large, small)), 1 - corner * corner / 2, 1e-13);
    }
  }
}

// Rows against sums over many points of a face: where each lies is found by closest points in space, not by clipping.
TEST(Mortar, AgreesWithFineSamplingOnRandomFaces) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 30; ++trial) {
    FaceGrid slave = face_grid(1, 1, false, trial % 3 ? GridFaces::quads : GridFaces::triangles),
             master = face_grid(1, 1, true, trial % 2 ? GridFaces::quads : GridFaces::triangles);
    for (FaceGrid* grid : {&slave, &master}) {
      for (Index i = 0; i < 4; ++i) grid->body.end.row(i).head<2>() += 0.15 * Eigen::RowVector2d(unit(random), unit(random));
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
              triangle ? Eigen::Vector4d(1 - s - t, s, t, 0) : Eigen::Vector4d((1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t);
          const Vector3 u = triangle ? Vector3(x[1] - x[0]) : Vector3((1 - t) * (x[1] - x[0]) + t * (x[2] - x[3])),
                        v = triangle ? Vector3(x[2] - x[0]) : Vector3((1 - s) * (x[3] - x[0]) + s * (x[2] - x[1]));
          const double dA = u.cross(v).norm() / (double(n) * n);
          const Vector3 place = N[0] * x[0] + N[1] * x[1] + N[2] * x[2] + N[3] * x[3];
          for (Index m = 0; m < master.surface.faces.rows(); ++m) {
            const Projection foot = project(corners(master.surface, m, master.body.end), is_triangle(master.surface, m), place);
            if (foot.outside > 0) continue;
            for (int a = 0; a < (triangle ? 3 : 4); ++a) {
              for (int b = 0; b < (triangle ? 3 : 4); ++b)
                D(slave.surface.faces(f, a), slave.surface.faces(f, b)) += N[a] * N[b] * dA;
              for (int l = 0; l < (is_triangle(master.surface, m) ? 3 : 4); ++l)
                M(slave.surface.faces(f, a), master.surface.faces(m, l)) += N[a] * foot.weights[l] * dA;
            }
            break;
          }
        }
      }
    }
    if (list.points.size() < 4) continue;  // rows of nodes without area of their own are part of others
    for (const auto& point : list.points) {
      const Index j = slave.surface.nodes[point.slot];
      EXPECT_NEAR(point.area, D.row(j).sum(), 2e-3) << trial;
      Vector d = Vector::Zero(4), m = Vector::Zero(4);
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
        (list.terms[t].body == 0 ? d : m)[list.terms[t].node] += list.terms[t].coefficient * point.area;
      EXPECT_LT((d - D.row(j).transpose()).cwiseAbs().maxCoeff(), 2e-3) << trial;
      EXPECT_LT((m + M.row(j).transpose()).cwiseAbs().maxCoeff(), 2e-3) << trial;
    }
  }
}

TEST(Mortar, EqualMeshesTieEachNodeToItsTwin) {
  for (const GridFaces kind : {GridFaces::quads, GridFaces::triangles, GridFaces::mixed}) {
    FaceGrid slave = face_grid(4, 3, false, kind, 0.2, 1), master = face_grid(4, 3, true, kind, 0.2, 1);
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

// Surfaces that are neither flat nor aligned, for invariance.
FlatPair curved_pair() {
  FlatPair pair{face_grid(7, 6, false, GridFaces::mixed, 0.2, 3), face_grid(5, 6, true, GridFaces::mixed, 0.2, 5)};
  transform(pair.master, 1.5 * turn(0.4), Vector3(-0.2, -0.4, 0));
  for (FaceGrid* grid : {&pair.slave, &pair.master}) {
    for (Index i = 0; i < grid->body.start.rows(); ++i) {
      const double x = grid->body.start(i, 0) - 0.5, y = grid->body.start(i, 1) - 0.4;
      grid->body.start(i, 2) = (grid == &pair.slave ? 0.3 : 0.2) * (x * x + y * y) + (grid == &pair.slave ? 2e-3 : 0);
    }
    fill_sizes(grid->surface, grid->body.start);
  }
  move(pair.slave, Vector3(0.01, 0.02, -0.03)), pair.master.body.end = pair.master.body.start;
  return pair;
}

TEST(Mortar, TurningAllTurnsThePoints) {
  FlatPair pair = curved_pair();
  const ContactList before = run(pair.slave, pair.master);
  ASSERT_GT(before.points.size(), 20u);
  const Matrix3 R = turn(1.1, Vector3(2, -1, 3));
  transform(pair.slave, R, Vector3(1, 2, 3)), transform(pair.master, R, Vector3(1, 2, 3));
  const ContactList after = run(pair.slave, pair.master);
  ASSERT_EQ(after.points.size(), before.points.size());
  for (std::size_t i = 0; i < after.points.size(); ++i) {
    const ContactPoint &a = after.points[i], &b = before.points[i];
    EXPECT_EQ(a.slot, b.slot);
    EXPECT_LT((a.normal() - R * b.normal()).norm(), 1e-13);
    EXPECT_NEAR(a.gap[0], b.gap[0], 1e-13);
    EXPECT_NEAR(a.start_gap, b.start_gap, 1e-13);
    EXPECT_NEAR(a.area, b.area, 1e-13);
  }
}

TEST(Mortar, NumberingDoesNotMatter) {
  FlatPair pair = curved_pair();
  const ContactList before = run(pair.slave, pair.master);
  std::mt19937 random(4);
  std::array<std::vector<Index>, 2> place;  // new number of a node
  for (FaceGrid* grid : {&pair.slave, &pair.master}) {
    std::vector<Index>& p = place[grid == &pair.slave ? 0 : 1];
    p = grid->surface.nodes;
    std::shuffle(p.begin(), p.end(), random);
    const Points start = grid->body.start, end = grid->body.end;
    for (std::size_t i = 0; i < p.size(); ++i) {
      grid->body.start.row(p[i]) = start.row(static_cast<Index>(i));
      grid->body.end.row(p[i]) = end.row(static_cast<Index>(i));
    }
    std::vector<Index> order(grid->surface.faces.rows());
    std::iota(order.begin(), order.end(), Index{0});
    std::shuffle(order.begin(), order.end(), random);
    IndexTable faces = grid->surface.faces(order, Eigen::all);
    for (Index f = 0; f < faces.rows(); ++f) {
      const int n = faces(f, 2) == faces(f, 3) ? 3 : 4, first = int(random() % 4) % n;
      const auto row = faces.row(f).eval();
      for (int a = 0; a < 4; ++a) faces(f, a) = p[row[(std::min(a, n - 1) + first) % n]];
    }
    grid->surface.faces = faces;
    fill_sizes(grid->surface, grid->body.start);
  }
  const ContactList after = run(pair.slave, pair.master);
  ASSERT_EQ(after.points.size(), before.points.size());
  for (const ContactPoint& b : before.points) {
    const auto at =
        std::find_if(after.points.begin(), after.points.end(), [&](const ContactPoint& a) { return a.slot == place[0][b.slot]; });
    ASSERT_NE(at, after.points.end());
    // The first corner of a face sets the tangents of its plane, and the start of the triangles
    EXPECT_NEAR(at->gap[0], b.gap[0], 1e-10);
    EXPECT_NEAR(at->area, b.area, 1e-12);
    EXPECT_LT((at->normal() - b.normal()).norm(), 1e-10);
  }
}

TEST(Mortar, SameInputSamePoints) {
  FlatPair pair = curved_pair();
  const ContactList a = run(pair.slave, pair.master), b = run(pair.slave, pair.master);
  ASSERT_EQ(a.terms.size(), b.terms.size());
  for (std::size_t t = 0; t < a.terms.size(); ++t) {
    EXPECT_EQ(a.terms[t].node, b.terms[t].node);
    EXPECT_EQ(a.terms[t].coefficient, b.terms[t].coefficient);
  }
}

// Which side is the slave changes the points, not what a uniform pressure does.
TEST(Mortar, SidesCanBeExchanged) {
  FlatPair pair = curved_pair();
  for (FaceGrid* grid : {&pair.slave, &pair.master}) grid->body.start.col(2).setZero(), grid->body.end = grid->body.start;
  const ContactList one = run(pair.slave, pair.master), other = run(pair.master, pair.slave);
  const Index n_s = pair.slave.body.end.rows(), n_m = pair.master.body.end.rows();
  EXPECT_LT((pressure_forces(one, 0, n_s) + pressure_forces(other, 1, n_s)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((pressure_forces(one, 1, n_m) + pressure_forces(other, 0, n_m)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Mortar, FacesThatLookAwayDoNotMeet) {
  FaceGrid slave = face_grid(3, 3, true), master = face_grid(2, 2, true);
  EXPECT_TRUE(run(slave, master).empty());
  FaceGrid wall = face_grid(3, 3, false);
  transform(wall, turn(1.5, Vector3::UnitX()), Vector3(0, 0.5, -0.5));
  EXPECT_TRUE(run(wall, master).empty());
}

// A common edge, a common corner, a sliver of round-off: nothing. A strip: all of it, whatever share of a face it is.
TEST(Mortar, StripsCountAndEdgesDoNot) {
  for (const double strip : {0.0, 1e-15, 1e-9, 1e-6, 1e-3, 0.1, 0.24, 0.3, 0.49, 0.9}) {
    for (const double other : {0.0, strip, 1.0}) {
      FaceGrid slave = face_grid(4, 4, false), master = face_grid(3, 3, true);
      shift(slave, Vector3(1 - strip, 1 - other, 0));
      const ContactList list = run(slave, master);
      EXPECT_NEAR(shared_area(list), strip * other, 1e-13);
      if (strip * other < 1e-14) {
        EXPECT_TRUE(list.empty()) << strip << " " << other;
      } else {
        EXPECT_FALSE(list.empty());
      }
      for (const auto& point : list.points) {
        EXPECT_NEAR(point.gap[0], 0, 1e-13);
        EXPECT_LT(apply(list, point, slave.body.end, master.body.end).norm(), 1e-12);
      }
      // What is shared has no more points than nodes that can move it
      const auto columns = [](double share) { return std::ceil(4 * share - 1e-12) + 1; };
      EXPECT_LE(static_cast<double>(list.points.size()), columns(strip) * columns(other) + 1e-9);
    }
  }
}

TEST(Mortar, FastBodiesAreCaught) {
  for (const double speed : {0.05, 1.0, 30.0}) {
    for (const double sideways : {0.0, 0.3, 5.0}) {
      FaceGrid slave = face_grid(3, 3, false), master = face_grid(2, 2, true);
      shift(slave, Vector3(-0.3 * sideways, 0, 0.3 * speed));
      move(slave, speed * Vector3(sideways / speed, 0, -1));
      move(master, Vector3(0, 0, 0.1 * speed));
      const ContactList list = run(slave, master);
      ASSERT_FALSE(list.empty()) << speed << " " << sideways;
      for (const auto& point : list.points) {
        EXPECT_NEAR(point.start_gap, 0.3 * speed, 1e-12 * speed);
        EXPECT_NEAR(point.gap[0], -0.8 * speed, 1e-12 * speed);
      }
    }
  }
}

// A plate thinner than its faces, top and bottom: what comes from above meets the top only, what is below and looks down nothing.
TEST(Mortar, ThinBodiesHoldFromTheirOwnSide) {
  const double thickness = 0.06;
  FaceGrid plate = face_grid(3, 3, true), bottom = face_grid(3, 3, false);
  const Index n = plate.body.start.rows(), f = plate.surface.faces.rows();
  shift(bottom, Vector3(0, 0, -thickness));
  plate.body.start.conservativeResize(2 * n, 3), plate.surface.faces.conservativeResize(2 * f, 4);
  plate.body.start.bottomRows(n) = bottom.body.start, plate.surface.faces.bottomRows(f) = bottom.surface.faces.array() + n;
  plate.body.end = plate.body.start;
  for (Index i = n; i < 2 * n; ++i) plate.surface.nodes.push_back(i);
  fill_sizes(plate.surface, plate.body.start);
  for (const double height : {1e-4, 0.01, 0.5}) {
    FaceGrid slave = face_grid(4, 5, false);
    shift(slave, Vector3(0.1, 0.1, height));
    move(slave, Vector3(0, 0, -2));
    const ContactList list = run(slave, plate);
    EXPECT_FALSE(list.empty());
    for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], height - 2, 1e-12);
    FaceGrid below = face_grid(4, 5, false);
    shift(below, Vector3(0.1, 0.1, -thickness - height));
    EXPECT_TRUE(run(below, plate).empty()) << height;
    FaceGrid from_below = face_grid(4, 5, true);
    shift(from_below, Vector3(0.1, 0.1, -thickness - height));
    move(from_below, Vector3(0, 0, 2));
    const ContactList held = run(from_below, plate);
    EXPECT_FALSE(held.empty());
    for (const auto& point : held.points) EXPECT_NEAR(point.gap[0], height - 2, 1e-12);
  }
}

// Two plates, one over the other, as one master: the first is met.
TEST(Mortar, TheNearerOfTwoLayersIsMet) {
  for (const double distance : {0.01, 0.1, 1.0}) {
    FaceGrid layers = face_grid(3, 3, true), lower = face_grid(3, 3, true, GridFaces::triangles);
    const Index n = layers.body.start.rows(), f = layers.surface.faces.rows();
    shift(lower, Vector3(0, 0, -distance));
    layers.body.start.conservativeResize(2 * n, 3), layers.surface.faces.conservativeResize(f + lower.surface.faces.rows(), 4);
    layers.body.start.bottomRows(n) = lower.body.start;
    layers.surface.faces.bottomRows(lower.surface.faces.rows()) = lower.surface.faces.array() + n;
    layers.body.end = layers.body.start;
    for (Index i = n; i < 2 * n; ++i) layers.surface.nodes.push_back(i);
    fill_sizes(layers.surface, layers.body.start);
    for (const double step : {1e-4, 0.1, 3.0}) {
      FaceGrid slave = face_grid(4, 5, false);
      shift(slave, Vector3(0.05, 0.1, 1e-5));
      move(slave, Vector3(0, 0, -step));
      const ContactList list = run(slave, layers);
      EXPECT_FALSE(list.empty());
      for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], 1e-5 - step, 1e-12);
    }
  }
}

TEST(Mortar, InitialOverlapIsKept) {
  FaceGrid slave = face_grid(4, 3, false), master = face_grid(3, 3, true);
  shift(slave, Vector3(0, 0, -0.02));
  PairMemory memory;
  ContactList list = run(slave, master, memory, true);
  ASSERT_EQ(list.points.size(), 20u);
  for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], 0, 1e-14);
  EXPECT_NEAR(memory.initial_overlap, 0.02, 1e-14);
  // Pressed: the next step remembers
  Points end_gap = Points::Zero(20, 3), impulse = Points::Zero(20, 3);
  impulse.col(0).setOnes();
  remember(list, 0, 20, end_gap, impulse, 1e-6, memory);
  move(slave, Vector3(0, 0, -1e-3));
  list = run(slave, master, memory);
  ASSERT_EQ(list.points.size(), 20u);
  for (const auto& point : list.points) EXPECT_NEAR(point.gap[0], -1e-3, 1e-14);
}

// What rests on a plate and hangs over its rim is not held by the plate's side, nor is the side of what rests.
TEST(Mortar, OnlyTheFaceThatHoldsHolds) {
  for (const double inside : {1e-7, 0.01, 0.2}) {
    FaceGrid cube = face_grid(2, 2, false), side = face_grid(2, 2, true), plate = face_grid(3, 3, true);
    // A side of the cube at x = 1, outward, with the nodes of its lower edge
    transform(side, turn(std::numbers::pi / 2, Vector3::UnitY()), Vector3(1, 0, 1));
    const Index n = cube.body.start.rows(), f = cube.surface.faces.rows();
    cube.body.start.conservativeResize(2 * n, 3), cube.surface.faces.conservativeResize(2 * f, 4);
    cube.body.start.bottomRows(n) = side.body.start, cube.surface.faces.bottomRows(f) = side.surface.faces.array() + n;
    for (Index i = n; i < 2 * n; ++i) cube.surface.nodes.push_back(i);
    cube.body.end = cube.body.start;
    fill_sizes(cube.surface, cube.body.start);
    // The plate's own side at x = 0 looks at it from behind by `inside`
    FaceGrid rim = face_grid(2, 2, true);
    transform(rim, turn(-std::numbers::pi / 2, Vector3::UnitY()), Vector3(0, 0, -1));
    plate.body.start.conservativeResize(16 + n, 3), plate.surface.faces.conservativeResize(9 + f, 4);
    plate.body.start.bottomRows(n) = rim.body.start, plate.surface.faces.bottomRows(f) = rim.surface.faces.array() + 16;
    for (Index i = 16; i < 16 + n; ++i) plate.surface.nodes.push_back(i);
    plate.body.end = plate.body.start;
    fill_sizes(plate.surface, plate.body.start);
    shift(cube, Vector3(-1 + inside, 0, 0));
    PairMemory memory;
    for (int step = 0; step < 3; ++step) {
      move(cube, Vector3(0, 0, -1e-3));
      const ContactList list = run(cube, plate, memory, step == 0);
      const Index m = static_cast<Index>(list.points.size());
      Points end_gap = Points::Zero(m, 3), impulse = Points::Zero(m, 3);
      for (Index i = 0; i < m; ++i) {
        EXPECT_GT(list.points[i].normal()[2], 0.999) << inside << " " << step;
        EXPECT_NEAR(list.points[i].gap[0], -1e-3, 1e-12);
        impulse(i, 0) = 1;
      }
      EXPECT_GT(m, 0);
      remember(list, 0, list.points.size(), end_gap, impulse, 1e-6, memory);
    }
  }
}

// Faces of second order for mortar: mid-side nodes lie between their corners, also when a mirror has turned the faces over.
TEST(Mortar, WholeFacesKeepTheirMiddles) {
  for (const ElementType type : {ElementType::hex8, ElementType::hex20, ElementType::tet4, ElementType::tet10}) {
    const Mesh mesh = test::box_mesh(type, {2, 1, 1}, Vector3(2, 1, 1));
    Sideset top{"top", 1, {}};
    for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
      for (int side = 1; side <= n_sides(type); ++side)
        if (mesh.coordinates(nodes_of_side(mesh, {0, e, side}), 2).minCoeff() == 1) top.sides.push_back({0, e, side});
    const Surface surface = extract_surface(mesh, top);
    IndexTable faces = whole_faces(surface), linear = contact_faces(surface);
    const bool quadratic = type == ElementType::hex20 || type == ElementType::tet10;
    const auto area_vectors = [&](const IndexTable& table) {
      Vector3 sum = Vector3::Zero();
      for (Index f = 0; f < table.rows(); ++f)
        sum += (mesh.coordinates.row(table(f, 2)) - mesh.coordinates.row(table(f, 0)))
                   .transpose()
                   .cross((mesh.coordinates.row(table(f, 3)) - mesh.coordinates.row(table(f, 1))).transpose().eval());
      return sum;
    };
    const Vector3 outward = area_vectors(linear);
    EXPECT_NEAR(outward[2], 4, 1e-12);
    for (const bool mirrored : {false, true}) {
      if (mirrored) turn_over(faces);
      EXPECT_LT((area_vectors(faces) - (mirrored ? -1 : 1) * outward).norm(), 1e-12);
      for (Index f = 0; f < faces.rows(); ++f) {
        const int n = faces(f, 2) == faces(f, 3) ? 3 : 4;
        for (int a = 0; a < 4; ++a) {
          const Index middle = faces(f, 4 + a);
          if (!quadratic || a >= n) {
            EXPECT_EQ(middle, -1);
            continue;
          }
          ASSERT_GE(middle, 0);
          const auto x = 0.5 * (mesh.coordinates.row(faces(f, a)) + mesh.coordinates.row(faces(f, (a + 1) % n)));
          EXPECT_LT((mesh.coordinates.row(middle) - x).norm(), 1e-14);
        }
      }
    }
  }
}

}  // namespace
}  // namespace cbr
