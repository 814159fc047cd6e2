// SPDX-License-Identifier: GPL-3.0-or-later
// W against its definition, column by column: impulses spread, bodies moved, gaps read again.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <random>

#include "dynamics/contact/response/body_moves.hpp"
#include "dynamics/contact/response/response.hpp"
#include "dynamics/contact/response/standing_response.hpp"

namespace cbr::response_test {
namespace {

struct Scene {
  std::vector<ContactBody> bodies;
  ContactList list;
  std::vector<PointLaw> laws;
};

// F of s rows in two levels: three places, and all.
std::vector<ComplianceLevel> random_levels(Index s, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<ComplianceLevel> levels;
  for (const Index k : {Index{3}, s}) {
    const Matrix P = k == s ? Matrix(Matrix::Identity(s, s))
                            : Matrix(Matrix::NullaryExpr(k, s, [&] { return normal(random); })),
                 root = Matrix::NullaryExpr(k, k, [&] { return normal(random); });
    levels.push_back({P.sparseView(), Matrix(root * root.transpose()).sparseView()});
  }
  return levels;
}

// Two modes, and statics of some nodes: node i has i % 4 directions.
std::shared_ptr<const ThinResponse> random_thin(Index n_nodes, std::mt19937& random, bool levels) {
  std::normal_distribution<double> normal;
  const auto any = [&] { return normal(random); };
  auto rows = std::make_shared<StaticRows>();
  rows->first.push_back(0);
  for (Index i = 0; i < n_nodes; ++i) {
    for (Index d = 0; d < i % 4; ++d) rows->node.push_back(i);
    rows->first.push_back(rows->size());
  }
  rows->direction = Points::NullaryExpr(rows->size(), 3, any).rowwise().normalized();
  const Matrix root = Matrix::NullaryExpr(rows->size(), rows->size(), any);
  rows->F = std::make_shared<const Matrix>(root * root.transpose());
  if (levels) rows->F = StaticCompliance(random_levels(rows->size(), random));
  auto S = std::make_shared<ThinResponse>();
  S->A = std::make_shared<const Matrix>(Matrix::NullaryExpr(2, 3 * n_nodes, any));
  S->C = Matrix(Eigen::Vector2d(0.3, 1.7).asDiagonal());
  S->C(0, 1) = S->C(1, 0) = 0.2;
  S->rows = rows;
  S->h = 0.25;
  return S;
}

// `n_bodies` in a chain, m points between neighbours, every third body lumped or all of them dense;
// laws mixed. `thin`: so are the first and every third after it, and share what they answer with.
Scene random_scene(Index n_bodies, Index m, bool any_lumped, unsigned seed, bool thin = false) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Index n_nodes = 7;
  Scene s;
  s.bodies.resize(n_bodies);
  const auto shared = thin ? random_thin(n_nodes, random, seed % 4 == 0) : nullptr;
  for (Index b = 0; b < n_bodies; ++b) {
    ContactBody& body = s.bodies[b];
    body.impulses.setZero(n_nodes, 3);
    body.friction.setZero(n_nodes, 3);
    if (any_lumped && b % 3 == 1) {
      body.response.diagonal =
          Vector::NullaryExpr(3 * n_nodes, [&] { return 0.5 + std::abs(normal(random)); });
    } else if (thin && b % 3 == 0) {
      body.response.thin = shared;
      body.response.axes =
          Eigen::AngleAxisd(0.3 * static_cast<double>(b), Vector3(1, 2, -1).normalized())
              .toRotationMatrix();
    } else {
      const Matrix A =
          Matrix::NullaryExpr(3 * n_nodes, 3 * n_nodes, [&] { return normal(random); });
      body.response.set_block(A * A.transpose());
      body.response.axes =
          Eigen::AngleAxisd(0.3 * static_cast<double>(b), Vector3(1, 2, -1).normalized())
              .toRotationMatrix();
    }
  }
  for (Index b = 0; b + 1 < n_bodies; ++b) {
    for (Index k = 0; k < m; ++k) {
      ContactPoint point;
      point.frame =
          contact_frame(Vector3(normal(random), normal(random), normal(random)).normalized());
      point.first_term = static_cast<Index>(s.list.terms.size());
      s.list.terms.push_back({b, static_cast<Index>(random() % n_nodes), 1});
      for (int a = 0; a < 3; ++a)
        s.list.terms.push_back({b + 1, static_cast<Index>(random() % n_nodes), -1.0 / 3});
      point.n_terms = 4;
      s.list.points.push_back(point);
      const auto law = static_cast<ContactLaw>(random() % 3);
      s.laws.push_back({law, law == ContactLaw::coulomb ? 0.3 : 0.0});
    }
  }
  return s;
}

// Shares of three functions, one cut off, and rows of points: A = N Y + E Z.
struct RandomUnknowns {
  SparseMatrix A;
  Combinations of;
};

RandomUnknowns unknowns_of(const SparseMatrix& N, const std::vector<Index>& rows, double cut) {
  RandomUnknowns u;
  const Index n_rows = rows.size();
  u.of.rows = rows;
  u.of.Y.resize(N.cols(), 3 + n_rows);
  u.of.Z.resize(n_rows, 3 + n_rows);
  SparseMatrix E(N.rows(), n_rows);
  for (Index k = 0; k < 3; ++k) u.of.Y.insert(k, k) = 0.5 + static_cast<double>(k);
  u.of.Z.insert(0, 1) = -cut;
  for (Index i = 0; i < n_rows; ++i) {
    E.insert(rows[i], i) = 1;
    u.of.Z.insert(i, 3 + i) = 1;
  }
  u.A = SparseMatrix(N * u.of.Y) + SparseMatrix(E * u.of.Z);
  return u;
}

// Unknowns come, go and change: W is that of a new start, and what statics answer that of products
// with the bodies' own responses.
TEST(Response, UnknownsKeepWhatStandsOfW) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Scene s = random_scene(3, 8, false, seed, seed % 2 == 0);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Index m = first_rows(s.laws).back();
    const Matrix any = Matrix::NullaryExpr(m, 3, [&] { return std::abs(normal(random)); });
    const SparseMatrix N = any.sparseView();
    StandingResponse standing;
    standing.start(s.list, s.laws, s.bodies, N);
    Matrix W;
    const auto step = [&](const RandomUnknowns& u, const std::vector<Index>& from) {
      standing.take(u.of, from);
      W = standing.form(from, W.size() > 0 ? &W : nullptr);
      const Matrix expected =
          gap_response(s.list, s.laws, s.bodies, &ContactBody::response, &u.A).dense;
      EXPECT_LT((W - expected).norm(), 1e-13 * expected.norm()) << seed;
      EXPECT_EQ(W, W.transpose());
      const Vector x = Vector::NullaryExpr(u.A.cols(), [&] { return normal(random); });
      BodyMoves moves, known_moves;
      const StaticAnswers known = standing.statics(x);
      EXPECT_EQ(known.body.empty(), seed % 2 != 0);
      moves.push(s.list, s.laws, u.A * x, s.bodies);
      known_moves.push(s.list, s.laws, u.A * x, s.bodies, &known);
      Vector gap = Vector::Zero(m), known_gap = gap;
      moves.add_to_gaps(s.list, s.laws, gap);
      known_moves.add_to_gaps(s.list, s.laws, known_gap);
      EXPECT_LT((gap - known_gap).norm(), 1e-13 * gap.norm()) << seed;
    };
    step(unknowns_of(N, {1, 4, 9}, 0.3), {-1, -1, -1, -1, -1, -1});
    step(unknowns_of(N, {1, 4, 9}, 0.3), {0, 1, 2, 3, 4, 5});
    step(unknowns_of(N, {1, 2, 4, 7, 9}, 0.3), {0, 1, 2, 3, -1, 4, -1, 5});
    step(unknowns_of(N, {1, 7, 9}, 0.6), {0, -1, 2, 3, 6, 7});
    step(unknowns_of(N, {7, 9, 10}, 0.6), {0, -1, 2, 4, 5, -1});
  }
}

// A C that is known to be diagonal is not multiplied as a full one: the same bits.
TEST(Response, DiagonalWeightsOfModesGiveTheSameBits) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto full = random_thin(7, random, false);
  const Index r = 40;
  auto S = std::make_shared<ThinResponse>(*full);
  S->A = std::make_shared<const Matrix>(
      Matrix::NullaryExpr(r, full->n_dofs(), [&] { return normal(random); }));
  S->C = Vector(Vector::NullaryExpr(r, [&] { return normal(random); })).asDiagonal();
  auto quick = std::make_shared<ThinResponse>(*S);
  quick->C_is_diagonal = true;
  Scene s = random_scene(2, 9, false, 5);
  const auto answer_of = [&](const std::shared_ptr<const ThinResponse>& thin, Matrix& move) {
    for (ContactBody& body : s.bodies) {
      body.response.block = nullptr;
      body.response.thin = thin;
    }
    Matrix still;
    ThinWork work;
    const Matrix p = Matrix::Ones(thin->n_dofs(), 2);
    respond(*thin, p, move, still, work);
    return gap_response(s.list, s.laws, s.bodies).dense;
  };
  Matrix move, quick_move;
  EXPECT_EQ(answer_of(S, move), answer_of(quick, quick_move));
  EXPECT_EQ(move, quick_move);
}

TEST(Response, IsWhatImpulsesDoToGaps) {
  for (const auto& [n_bodies, m, lumped, thin] :
       {std::tuple<Index, Index, bool, bool>{2, 5, false, false},
        {2, 9, true, false},
        {40, 6, true, false},
        {2, 7, false, true},
        {4, 8, true, true},
        {40, 8, true, true}}) {
    const Scene s = random_scene(n_bodies, m, lumped, static_cast<unsigned>(7 + m), thin);
    const GapResponse W = gap_response(s.list, s.laws, s.bodies);
    EXPECT_EQ(W.is_sparse, n_bodies == 40);
    const std::vector<Index> first = first_rows(s.laws);
    ASSERT_EQ(W.size(), first.back());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    Points p = Points::Zero(static_cast<Index>(s.laws.size()), 3);
    Vector packed(first.back());
    for (Index i = 0; i < p.rows(); ++i)
      for (Index d = 0; d < n_rows(s.laws[i].law); ++d)
        packed[first[i] + d] = p(i, d) = unit(random);
    const Vector gap = apply(W, packed);
    std::vector<ContactBody> bodies = s.bodies;
    spread_impulses(s.list, s.laws, p, bodies);
    for (ContactBody& body : bodies) {
      const Points total = body.impulses + body.friction;
      const Eigen::Map<const Vector> f(total.data(), total.size());
      body.start.setZero(total.rows(), 3);
      body.end.setZero(total.rows(), 3);
      Eigen::Map<Vector>(body.end.data(), f.size()) = body.response.dense() * f;
    }
    for (Index i = 0; i < p.rows(); ++i) {
      const Vector3 moved =
          s.list.points[i].frame * relative_motion(s.list, s.list.points[i], bodies);
      for (Index d = 0; d < n_rows(s.laws[i].law); ++d)
        EXPECT_NEAR(gap[first[i] + d], moved[d], 1e-12 * gap.cwiseAbs().maxCoeff())
            << n_bodies << " bodies, point " << i;
    }
    Vector3 sum = Vector3::Zero();
    for (const ContactBody& body : bodies)
      sum += (body.impulses + body.friction).colwise().sum().transpose();
    EXPECT_LT(sum.norm(), 1e-12 * p.norm());
  }
}

// With modes and statics alone the response is what the formula says, and it is symmetric.
TEST(Response, OfThinBodiesIsTheSumOfModesAndStatics) {
  std::mt19937 random(11);
  const auto thin = random_thin(7, random, false);
  const StaticRows& rows = *thin->rows;
  Matrix B = Matrix::Zero(21, rows.size());
  for (Index i = 0; i < rows.size(); ++i)
    B.col(i).segment<3>(3 * rows.node[i]) = rows.direction.row(i).transpose();
  const Matrix modes = thin->A->transpose() * thin->C * *thin->A,
               S = modes + B * rows.F.formed() * B.transpose() / 0.25;
  NodeResponse response;
  response.thin = thin;
  EXPECT_EQ(response.n_dofs(), 21);
  EXPECT_FALSE(response.is_diagonal() || response.empty());
  EXPECT_LT((response.dense() - S).norm(), 1e-14 * S.norm());
  EXPECT_FALSE(response.is_static(0));
  EXPECT_TRUE(response.is_static(1));
  EXPECT_FALSE(response.is_static(4));
  // Of few nodes that are pushed, and of all: the one reads columns, the other half of F
  for (const Index n : {Index{1}, Index{7}}) {
    Matrix p = Matrix::Zero(21, 2), move, still;
    p.topRows(3 * n).setRandom();
    ThinWork work;
    respond(*thin, p, move, still, work);
    EXPECT_LT((move - S * p).norm(), 1e-13 * S.norm()) << n;
    EXPECT_LT((still - rows.F.formed() * B.transpose() * p / 0.25).norm(), 1e-13 * S.norm()) << n;
  }
}

// What the impulses do to the bodies by products is what they do to gaps by W, whoever shares a
// response.
TEST(BodyMoves, AgreeWithW) {
  for (const bool lumped : {false, true}) {
    const Scene s = random_scene(7, 6, lumped, 5, true);
    const GapResponse W = gap_response(s.list, s.laws, s.bodies);
    const Vector p = Vector::Random(W.size());
    BodyMoves moves;
    moves.push(s.list, s.laws, p, s.bodies);
    Vector gap = Vector::Zero(p.size());
    moves.add_to_gaps(s.list, s.laws, gap);
    const Vector expected = apply(W, p);
    EXPECT_LT((gap - expected).norm(), 1e-13 * expected.norm());
    std::vector<ContactBody> bodies = s.bodies;
    moves.give(bodies);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      EXPECT_TRUE(bodies[b].has_move);
      const auto& thin = bodies[b].response.thin;
      EXPECT_EQ(bodies[b].still.size(), thin ? thin->rows->size() : 0) << b;
    }
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
  EXPECT_LT((contact_frame(-Vector3::UnitZ()) * contact_frame(-Vector3::UnitZ()).transpose() -
             Matrix3::Identity())
                .norm(),
            1e-15);
  EXPECT_GT(contact_frame(-Vector3::UnitZ()).determinant(), 0);
}

}  // namespace
}  // namespace cbr::response_test
