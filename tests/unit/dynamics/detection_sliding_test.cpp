// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes that slide across edges between faces and off a rim.
#include "dynamics/contact/search/detection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/dynamics/patch.hpp"

namespace cbr::detection_sliding_test {
namespace {

using test::box, test::move, test::patch, test::Patch, test::run;

// A roof of two faces that tilt by 0.1 either way, and a node that touches it and slides across the
// ridge: the normal turns without a jump, and on the ridge it is the mean of both.
TEST(Detection, NormalsGoOverAcrossAnEdge) {
  Patch roof = patch(1, 0, true);
  Points x(6, 3);
  x << -1, 0, -0.1, 0, 0, 0, 1, 0, -0.1, -1, 1, -0.1, 0, 1, 0, 1, 1, -0.1;
  roof.surface.faces.resize(2, 4);
  roof.surface.faces << 0, 1, 4, 3, 1, 2, 5, 4;
  roof.surface.nodes = {0, 1, 2, 3, 4, 5};
  roof.body.start = roof.body.end = x;
  fill_sizes(roof.surface, x);
  const auto normal_at = [&](double at, Index face) {
    Patch node = patch(1, 0, false, 1e-4);
    node.body.start.rowwise() = Eigen::RowVector3d(at, 0.5, -0.1 * std::abs(at));
    node.body.end = node.body.start;
    PairMemory memory;
    start_memory(4, memory);
    memory.face.assign(4, face);
    memory.known_face.assign(4, face);
    memory.has_points = true;
    const ContactList list = run(node, roof, memory);
    EXPECT_FALSE(list.empty()) << at;
    return list.empty() ? Vector3(Vector3::Zero()) : list.points[0].normal();
  };
  const Vector3 left = Vector3(-0.1, 0, 1).normalized(), right = Vector3(0.1, 0, 1).normalized();
  EXPECT_LT((normal_at(-0.1, 0) - left).norm(), 1e-12);
  EXPECT_LT((normal_at(0.1, 1) - right).norm(), 1e-12);
  EXPECT_LT((normal_at(0, 0) - Vector3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((normal_at(0, 1) - Vector3::UnitZ()).norm(), 1e-12);
  Vector3 before = left;
  for (int i = -60; i <= 60; ++i) {
    const Vector3 now = normal_at(1e-3 * i, i < 0 ? 0 : 1);
    EXPECT_LT((now - before).norm(), 0.2 / 50) << i;  // the whole turn over 0.1, in steps of 1e-3
    before = now;
  }
}

// The same roof: a node that arrives on the ridge is held by neither side, whatever round-off makes
// of it in other units, turned, or with the faces in another order.
TEST(Detection, ANodeThatArrivesOnAnEdgeTakesNoSide) {
  Points x(6, 3), way(2, 3);
  x << -1, 0, -0.1, 0, 0, 0, 1, 0, -0.1, -1, 1, -0.1, 0, 1, 0, 1, 1, -0.1;
  way << 0, 0.3, 0.005, 0, 0.3, -0.005;
  for (int k = 0; k < 40; ++k) {
    const double length = std::pow(10, k % 9 - 4);
    const Matrix3 turn =
        Eigen::AngleAxisd(0.7 * k, Vector3(1, k % 3 - 1, 0.3 * k).normalized()).toRotationMatrix();
    const auto placed = [&](const Points& at) { return Points(length * at * turn.transpose()); };
    Patch roof = patch(1, 0, true), node = patch(1, 0, false);
    roof.surface.faces.resize(2, 4);
    roof.surface.faces << 0, 1, 4, 3, 1, 2, 5, 4;
    if (k % 2 == 1) roof.surface.faces.row(0).swap(roof.surface.faces.row(1));
    roof.surface.nodes = {0, 1, 2, 3, 4, 5};
    roof.body.start = roof.body.end = placed(x);
    fill_sizes(roof.surface, roof.body.start);
    const Points along = placed(way);
    for (Index i = 0; i < node.body.start.rows(); ++i) {
      node.body.start.row(i) = along.row(0);
      node.body.end.row(i) = along.row(1);
    }
    PairMemory memory;
    const ContactList list = run(node, roof, memory);
    ASSERT_FALSE(list.empty()) << k;
    EXPECT_LT((list.points[0].normal() - turn.col(2)).norm(), 1e-12) << k;
    // From where it is nearest to one of the faces: 0.1 is the tilt
    EXPECT_NEAR(list.points[0].gap[0] / length, -0.005 / (1 + 0.1 * 0.1), 1e-12) << k;
  }
}

// A flat patch of crooked quads; a node slides over it, pressed in by the same depth in each step.
TEST(Detection, SlidingOverFaceBoundariesOfAFlatMeshIsSmooth) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> unit(-1, 1);
  Patch bottom = patch(6, 0, true), top = patch(2, 0, false, 0.3);
  for (Index i = 0; i < bottom.body.start.rows(); ++i)
    for (int c = 0; c < 2; ++c) bottom.body.start(i, c) += 0.04 * unit(random);
  bottom.body.end = bottom.body.start;
  fill_sizes(bottom.surface, bottom.body.start);
  bottom.surface.body = 1;
  top.body.start.leftCols(2).array() += 0.15;
  PairMemory memory;
  const Vector3 step(0.004, 0.0023, -1e-3);
  std::vector<Index> faces;
  for (int k = 0; k < 100; ++k) {
    move(top, step);
    const ContactList list = run(top, bottom, memory, k == 0);
    ASSERT_EQ(list.points.size(), 9u) << k;
    const Index m = 9;
    for (const ContactPoint& point : list.points) {
      EXPECT_NEAR(point.gap[0], -1e-3, 1e-15);
      EXPECT_NEAR(point.normal()[2], 1, 1e-14);
      // The force acts where the node is now
      Vector3 at = Vector3::Zero();
      for (Index t = point.first_term + 1; t < point.first_term + point.n_terms; ++t)
        at -= list.terms[t].coefficient * bottom.body.start.row(list.terms[t].node).transpose();
      const Vector3 now = top.body.start.row(point.slot).transpose();
      EXPECT_LT((at - now).head<2>().norm(), (k == 0 ? 1.01 : 0.1) * step.head<2>().norm()) << k;
      if (point.slot == 4 && (faces.empty() || faces.back() != point.face))
        faces.push_back(point.face);
    }
    remember(list, 0, list.points.size(), Points::Zero(m, 3), Points::Ones(m, 3), 1e-6, memory);
    top.body.start = top.body.end;
    top.body.start.col(2).setZero();
  }
  EXPECT_GE(faces.size(), 4u);
}

// Off the rim of a box: held while it is on, then let go, and not pushed from then on although it
// sinks beside the box.
TEST(Detection, SlidingOffTheRimEndsTheContact) {
  const Patch plate = box(3, 3, 1.0);
  Patch node = patch(1, 0, false, 0.1);
  node.body.start.col(0).array() += 2.7;
  node.body.start.col(1).array() += 1.2;
  PairMemory memory;
  std::vector<double> last(4, 0);
  for (int k = 0; k < 60; ++k) {
    move(node, Vector3(0.01, 0, -2e-3));
    const ContactList list = run(node, plate, memory, k == 0);
    std::vector<char> held(4, 0);
    Points end_gap(static_cast<Index>(list.points.size()), 3),
        impulse = Points::Zero(static_cast<Index>(list.points.size()), 3);
    for (std::size_t i = 0; i < list.points.size(); ++i) {
      const ContactPoint& point = list.points[i];
      const bool is_top = point.normal()[2] > 0.99;
      if (!is_top) {
        EXPECT_GT(point.gap[0], 0) << "pushed aside at step " << k;
      }
      held[point.slot] |= is_top;
      end_gap(static_cast<Index>(i), 0) = is_top ? 0 : point.gap[0];
      impulse(static_cast<Index>(i), 0) = is_top;
      if (is_top) last[point.slot] = std::max(last[point.slot], node.body.start(point.slot, 0));
    }
    remember(list, 0, list.points.size(), end_gap, impulse, 1e-6, memory);
    node.body.start = node.body.end;
    for (Index i = 0; i < 4; ++i)
      if (held[i]) node.body.start(i, 2) = 0;
  }
  for (const double x : last) {
    EXPECT_GT(x, 2.98);
    EXPECT_LT(x, 3.06);
  }
  EXPECT_LT(node.body.start.col(2).maxCoeff(), -0.01);
}

// Within the edge tolerance of a long face, or beyond its sharp corner, a node may be far from it
// beside the face's size: whether it is still held is no matter of the axes.
TEST(Detection, LongFacesHoldWhatIsOffTheirEdgesInAllDirections) {
  Patch sharp = patch(1, 0, true), strip = sharp;
  sharp.body.start.resize(3, 3);
  sharp.body.start << 0, 0, 0, 20, -1, 0, 20, 1, 0;
  sharp.surface.faces << 0, 1, 2, 2;
  sharp.surface.nodes = {0, 1, 2};
  strip.body.start.col(0) *= 40;
  for (Patch* face : {&sharp, &strip}) {
    fill_sizes(face->surface, face->body.start);
    const Points flat = face->body.start;
    for (int i = 0; i < 12; ++i) {
      const Matrix3 turn =
          Eigen::AngleAxisd(i * std::numbers::pi / 6, Vector3(1, 2, i - 6).normalized())
              .toRotationMatrix();
      face->body.start = face->body.end = flat * turn.transpose();
      Patch node = patch(1, 0, false, 1e-4);
      node.body.start.rowwise() =
          Eigen::RowVector3d(-1.8, face == &sharp ? 0 : 0.5, 0) * turn.transpose();
      node.body.end = node.body.start;
      PairMemory memory;
      start_memory(4, memory);
      memory.face.assign(4, 0);
      memory.known_face.assign(4, 0);
      memory.has_points = true;
      EXPECT_EQ(run(node, *face, memory).points.size(), 4u) << i;
    }
  }
}

}  // namespace
}  // namespace cbr::detection_sliding_test
