// SPDX-License-Identifier: GPL-3.0-or-later
// W against its definition, column by column: impulses spread, bodies moved, gaps read again.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <random>

#include "dynamics/contact/response.hpp"

namespace cbr {
namespace {

struct Scene {
  std::vector<ContactBody> bodies;
  ContactList list;
  std::vector<PointLaw> laws;
};

// `n_bodies` in a chain, m points between neighbours, every third body lumped or all of them dense; laws mixed.
Scene random_scene(Index n_bodies, Index m, bool any_lumped, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Index n_nodes = 7;
  Scene s;
  s.bodies.resize(n_bodies);
  for (Index b = 0; b < n_bodies; ++b) {
    ContactBody& body = s.bodies[b];
    body.impulses.setZero(n_nodes, 3), body.friction.setZero(n_nodes, 3);
    if (any_lumped && b % 3 == 1) {
      body.response.diagonal = Vector::NullaryExpr(3 * n_nodes, [&] { return 0.5 + std::abs(normal(random)); });
    } else {
      const Matrix A = Matrix::NullaryExpr(3 * n_nodes, 3 * n_nodes, [&] { return normal(random); });
      body.response.set_block(A * A.transpose());
      body.response.axes = Eigen::AngleAxisd(0.3 * static_cast<double>(b), Vector3(1, 2, -1).normalized()).toRotationMatrix();
    }
  }
  for (Index b = 0; b + 1 < n_bodies; ++b) {
    for (Index k = 0; k < m; ++k) {
      ContactPoint point;
      point.frame = contact_frame(Vector3(normal(random), normal(random), normal(random)).normalized());
      point.first_term = static_cast<Index>(s.list.terms.size());
      s.list.terms.push_back({b, static_cast<Index>(random() % n_nodes), 1});
      for (int a = 0; a < 3; ++a) s.list.terms.push_back({b + 1, static_cast<Index>(random() % n_nodes), -1.0 / 3});
      point.n_terms = 4;
      s.list.points.push_back(point);
      const auto law = static_cast<ContactLaw>(random() % 3);
      s.laws.push_back({law, law == ContactLaw::coulomb ? 0.3 : 0.0});
    }
  }
  return s;
}

TEST(Response, IsWhatImpulsesDoToGaps) {
  for (const auto& [n_bodies, m, lumped] : {std::tuple<Index, Index, bool>{2, 5, false}, {2, 9, true}, {40, 6, true}}) {
    const Scene s = random_scene(n_bodies, m, lumped, static_cast<unsigned>(7 + m));
    const GapResponse W = gap_response(s.list, s.laws, s.bodies);
    EXPECT_EQ(W.is_sparse, n_bodies == 40);
    const std::vector<Index> first = first_rows(s.laws);
    ASSERT_EQ(W.size(), first.back());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    Points p = Points::Zero(static_cast<Index>(s.laws.size()), 3);
    Vector packed(first.back());
    for (Index i = 0; i < p.rows(); ++i)
      for (Index d = 0; d < n_rows(s.laws[i].law); ++d) packed[first[i] + d] = p(i, d) = unit(random);
    const Vector gap = apply(W, packed);
    std::vector<ContactBody> bodies = s.bodies;
    spread_impulses(s.list, s.laws, p, bodies);
    for (ContactBody& body : bodies) {
      const Points total = body.impulses + body.friction;
      const Eigen::Map<const Vector> f(total.data(), total.size());
      body.start.setZero(total.rows(), 3), body.end.setZero(total.rows(), 3);
      Eigen::Map<Vector>(body.end.data(), f.size()) = body.response.dense() * f;
    }
    for (Index i = 0; i < p.rows(); ++i) {
      const Vector3 moved = s.list.points[i].frame * relative_motion(s.list, s.list.points[i], bodies);
      for (Index d = 0; d < n_rows(s.laws[i].law); ++d)
        EXPECT_NEAR(gap[first[i] + d], moved[d], 1e-12 * gap.cwiseAbs().maxCoeff()) << n_bodies << " bodies, point " << i;
    }
    Vector3 sum = Vector3::Zero();
    for (const ContactBody& body : bodies) sum += (body.impulses + body.friction).colwise().sum().transpose();
    EXPECT_LT(sum.norm(), 1e-12 * p.norm());
  }
}

TEST(ContactFrame, IsRightHandedAndTurnsWithTheNormal) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 2000; ++trial) {
    Vector3 n(normal(random), normal(random), normal(random));
    if (trial % 4 == 0) n = Vector3(1e-9 * n[0], 1e-9 * n[1], -1);  // beside the pole
    n.normalize();
    const Matrix3 frame = contact_frame(n);
    EXPECT_LT((frame * frame.transpose() - Matrix3::Identity()).norm(), 1e-14);
    EXPECT_GT(frame.determinant(), 0);
    EXPECT_LT((frame.row(0).transpose() - n).norm(), 1e-15);
  }
  EXPECT_LT((contact_frame(-Vector3::UnitZ()) * contact_frame(-Vector3::UnitZ()).transpose() - Matrix3::Identity()).norm(), 1e-15);
  EXPECT_GT(contact_frame(-Vector3::UnitZ()).determinant(), 0);
}

}  // namespace
}  // namespace cbr
