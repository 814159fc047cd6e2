// SPDX-License-Identifier: GPL-3.0-or-later
// What serves several steps, or several pairs at once, finds what a search of all would.
#include "dynamics/contact/search/kept_candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "dynamics/contact/search/closeness.hpp"
#include "dynamics/contact/surfaces/pair_projection.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::kept_candidates_test {
namespace {

using test::patch, test::Patch, test::run;

// A sheet with waves, so that edges between faces are hollow and raised.
double height(double x, double y) { return 0.02 * std::sin(9 * x) * std::cos(7 * y); }

void expect_same(const ContactList& found, const ContactList& expected, int step) {
  ASSERT_EQ(found.points.size(), expected.points.size()) << step;
  ASSERT_EQ(found.terms.size(), expected.terms.size()) << step;
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const ContactPoint &a = found.points[i], &b = expected.points[i];
    EXPECT_EQ(a.slot, b.slot) << step;
    EXPECT_EQ(a.face, b.face) << step;
    EXPECT_EQ(a.gap, b.gap) << step;
    EXPECT_EQ(a.start_gap, b.start_gap) << step;
    EXPECT_EQ(a.frame, b.frame) << step;
  }
  for (std::size_t i = 0; i < found.terms.size(); ++i)
    EXPECT_EQ(found.terms[i].coefficient, expected.terms[i].coefficient) << step;
}

// A sheet slides over the edges of another's faces while both drift; all faces of all nodes are
// looked at beside it in each step.
void slide(double way, int steps, int& searches, int& crossings) {
  Patch top = patch(6, 0, false, 0.4), bottom = patch(7, 0, true);
  for (Index i = 0; i < bottom.body.start.rows(); ++i)
    bottom.body.start(i, 2) = height(bottom.body.start(i, 0), bottom.body.start(i, 1));
  fill_sizes(bottom.surface, bottom.body.start);
  bottom.surface.body = 1;
  top.body.start.leftCols(2).array() += 0.1;
  const Eigen::RowVector3d drift(0.01, -0.02, 0.03), slip(way, 0.6 * way, 0);
  PairMemory memory;
  std::vector<Index> face(top.surface.nodes.size(), -1);
  Points last;
  for (int k = 0; k < steps; ++k) {
    // Pressed in by a little
    for (Index i = 0; i < top.body.start.rows(); ++i) {
      const Eigen::RowVector3d x = top.body.start.row(i) - k * drift;
      top.body.start(i, 2) = k * drift[2] + height(x[0], x[1]) + 0.002;
    }
    top.body.end = top.body.start.rowwise() + (drift + slip - Eigen::RowVector3d(0, 0, 0.004));
    bottom.body.end = bottom.body.start.rowwise() + drift;
    PairMemory of_all = memory;
    of_all.kept = {};
    of_all.depth = 1e6;  // every box meets every other
    const ContactList found = run(top, bottom, memory), expected = run(top, bottom, of_all);
    ASSERT_EQ(of_all.grid.candidates.target.size(),
              top.surface.nodes.size() * static_cast<std::size_t>(bottom.surface.faces.rows()));
    expect_same(found, expected, k);
    ASSERT_GT(found.points.size(), 20u);
    searches += last.rows() == 0 || memory.kept.slave_at != last;
    last = memory.kept.slave_at;
    for (const ContactPoint& point : found.points) {
      Index& of = face[point.slot];
      crossings += of >= 0 && of != point.face;
      of = point.face;
    }
    const Index m = found.points.size();
    remember(found, 0, found.points.size(), Points::Zero(m, 3), Points::Ones(m, 3), 1e-6, memory);
    top.body.start = top.body.end;
    bottom.body.start = bottom.body.end;
  }
}

TEST(KeptCandidates, SlidingOverEdgesFindsWhatASearchOfAllFinds) {
  for (const double way : {1e-5, 5e-4, 0.004}) {
    int searches = 0, crossings = 0;
    const int steps = 60;
    slide(way, steps, searches, crossings);
    EXPECT_LT(searches, steps) << way;
    if (way > 1e-3) {
      EXPECT_GT(crossings, 20);
    } else {
      EXPECT_LT(searches, steps / 3) << way;
    }
  }
}

// What lies several faces away when it is first searched for is found when it comes.
TEST(KeptCandidates, ANodeThatComesFromFarIsFound) {
  Patch top = patch(2, 0.02, false, 0.1), bottom = patch(10, 0, true);
  bottom.surface.body = 1;
  bottom.body.end = bottom.body.start;
  PairMemory memory;
  std::size_t points = 0;
  for (int k = 0; k < 200; ++k) {
    top.body.end = top.body.start.rowwise() + Eigen::RowVector3d(4e-3, 3e-3, -1.5e-4);
    PairMemory of_all = memory;
    of_all.kept = {};
    of_all.depth = 1e6;
    const ContactList found = run(top, bottom, memory), expected = run(top, bottom, of_all);
    expect_same(found, expected, k);
    points += found.points.size();
    top.body.start = top.body.end;
  }
  EXPECT_GT(points, 9u);
}

TEST(PairProjection, IsThatOfOnePairAtATime) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  Patch bottom = patch(5, 0, true), top = patch(8, 0, false, 1.3);
  for (Points* x : {&bottom.body.start, &top.body.start})
    for (Index i = 0; i < x->rows(); ++i)
      for (int c = 0; c < 3; ++c) (*x)(i, c) += 0.05 * unit(random);
  bottom.surface.faces(3, 3) = bottom.surface.faces(3, 2);  // a triangle
  bottom.surface.faces.row(7).setConstant(4);               // no area
  bottom.body.end = bottom.body.start * 1.1;
  top.body.end = top.body.start * 0.9;
  std::vector<NodeAndFace> pairs;
  for (Index node = 0; node < top.body.start.rows(); ++node)
    for (Index face = 0; face < bottom.surface.faces.rows(); ++face) pairs.push_back({node, face});
  std::vector<PairProjection> found;
  project_pairs(bottom.surface, bottom.body, top.body, pairs, HUGE_VAL, found);
  ASSERT_EQ(found.size(), pairs.size());
  int n_near = 0;
  const auto compare = [&](const Projection& p, const NodeAndFace& pair, const Points& faces,
                           const Points& nodes) {
    const Vector3 x = nodes.row(pair.node).transpose();
    const bool triangle = is_triangle(bottom.surface, pair.face);
    const Projection q = project(corners(bottom.surface, pair.face, faces), triangle, x);
    // Far beyond the face, where it counts for nothing, the minimum is flat: project() ends where
    // its value no longer falls, at the root of round-off
    if (std::isinf(q.outside)) {
      EXPECT_EQ(p.outside, q.outside);
      return;
    }
    if (q.outside > 0.3) {
      EXPECT_NEAR(p.outside, q.outside, 1e-6);
      return;
    }
    ++n_near;
    EXPECT_NEAR(p.distance, q.distance, 1e-13);
    EXPECT_NEAR(p.outside, q.outside, 1e-12);
    EXPECT_LT((p.normal - q.normal).norm(), 1e-12);
    for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(p.weights[a], q.weights[a], 1e-12);
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    compare(found[i].before, pairs[i], bottom.body.start, top.body.start);
    compare(found[i].end, pairs[i], bottom.body.end, top.body.end);
  }
  EXPECT_GT(n_near, 200);
  // One by one the same to the bit
  std::vector<PairProjection> alone;
  for (std::size_t i = 0; i < pairs.size(); i += 13) {
    project_pairs(bottom.surface, bottom.body, top.body, {&pairs[i], 1}, HUGE_VAL, alone);
    EXPECT_EQ(alone[0].end.distance, found[i].end.distance);
    EXPECT_EQ(alone[0].before.weights, found[i].before.weights);
  }
}

// Two sheets with waves, one pressed into the other by other depths in each look.
TEST(Closeness, LooksThatRememberFindTheSameDepths) {
  Patch top = patch(6, 0, false, 0.4), bottom = patch(7, 0, true);
  bottom.surface.body = 1;
  top.body.start.leftCols(2).array() += 0.1;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  ClosenessMemory memory;
  int deep = 0, known_enough = 0;
  for (int k = 0; k < 60; ++k) {
    top.body.start.leftCols(2).array() += 0.004 * any(random);
    for (Patch* of : {&top, &bottom})
      for (Index i = 0; i < of->body.start.rows(); ++i)
        of->body.start(i, 2) =
            height(of->body.start(i, 0), of->body.start(i, 1)) + 0.003 * any(random);
    top.body.end = top.body.start;
    bottom.body.end = bottom.body.start;
    const auto look = [&](double known, ClosenessMemory& of) {
      return closeness(top.surface, top.body, bottom.surface, bottom.body, bottom.surface.size,
                       DetectionOptions(), known, of)
          .depth;
    };
    ClosenessMemory fresh;
    const double expected = look(0, fresh);
    deep += expected > 1e-4;
    const double known = k % 3 == 0 ? 0 : 0.9 * expected + 1e-3 * (k % 2);
    known_enough += known > expected;
    EXPECT_EQ(look(known, memory), std::max(known, expected)) << k;
  }
  EXPECT_GT(deep, 40);
  EXPECT_GT(known_enough, 5);
  EXPECT_LT(known_enough, 40);
}

}  // namespace
}  // namespace cbr::kept_candidates_test
