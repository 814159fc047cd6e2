// SPDX-License-Identifier: GPL-3.0-or-later
// Impulses of slides: points that come and go, laws mixed, singular responses, bodies that share a
// block in different axes. Parts of dense arithmetic.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "common/linalg/dense.hpp"
#include "common/mesh/pressure_functions.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr::enforce_impulse_test {
namespace {

// Two square faces of n x n nodes, spacing 1, one over the other; the upper one (slave) has slid by
// (x, y). A ball's gap.
struct Slide {
  Index n = 9;
  std::vector<PointLaw> laws_of_slots;
  std::vector<ContactBody> bodies;
  ContactList list;
  std::vector<PointLaw> laws;
  double reach = HUGE_VAL;  // only nodes within this distance of the ball's centre have a point

  Index master(Index i, Index j) const {
    return std::clamp<Index>(j, 0, n - 1) * n + std::clamp<Index>(i, 0, n - 1);
  }

  void start(const Matrix& S, bool shared) {
    bodies.assign(2, ContactBody());
    const auto block = std::make_shared<const Matrix>(S);
    for (int b = 0; b < 2; ++b) {
      ContactBody& body = bodies[b];
      body.impulses.setZero(n * n, 3);
      body.friction.setZero(n * n, 3);
      body.response.block = shared ? block : std::make_shared<const Matrix>((1 + b) * S);
    }
    bodies[0].response.axes =
        Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
    bodies[1].response.axes = bodies[0].response.axes * Vector3(-1, 1, 1).asDiagonal();
  }

  void at(double x, double y) {
    list = ContactList();
    laws.clear();
    const double middle = 0.5 * static_cast<double>(n - 1);
    for (Index slot = 0; slot < n * n; ++slot) {
      const double px = static_cast<double>(slot % n) + x, py = static_cast<double>(slot / n) + y;
      const double r = std::hypot(px - middle - 3 * x, py - middle);
      if (r > reach) continue;
      const Index i = static_cast<Index>(std::floor(px)), j = static_cast<Index>(std::floor(py));
      const double u = px - std::floor(px), v = py - std::floor(py);
      ContactPoint point;
      point.frame =
          contact_frame(Vector3(0.1 * std::sin(px + x), 0.1 * std::cos(py), 1).normalized());
      point.gap = 1e-3 * Vector3(r * r / (0.4 * static_cast<double>(n * n)) - 1, 0.3 - 0.05 * py,
                                 0.05 * px);
      point.slot = slot;
      point.first_term = static_cast<Index>(list.terms.size());
      point.n_terms = 5;
      list.terms.push_back({0, slot, 1});
      list.terms.push_back({1, master(i, j), -(1 - u) * (1 - v)});
      list.terms.push_back({1, master(i + 1, j), -u * (1 - v)});
      list.terms.push_back({1, master(i + 1, j + 1), -u * v});
      list.terms.push_back({1, master(i, j + 1), -(1 - u) * v});
      list.points.push_back(point);
      laws.push_back(laws_of_slots[slot]);
    }
  }
};

// As of a short step: what is near answers, directions are mixed.
Matrix response_of_face(Index n) {
  Matrix S(3 * n * n, 3 * n * n);
  for (Index a = 0; a < n * n; ++a)
    for (Index b = 0; b < n * n; ++b) {
      const double x = static_cast<double>(a % n - b % n), y = static_cast<double>(a / n - b / n);
      Matrix3 T = Matrix3::Identity();
      T(0, 1) = T(1, 0) = 0.2;
      T(1, 2) = T(2, 1) = -0.1;
      S.block<3, 3>(3 * a, 3 * b) = std::exp(-std::hypot(x, y)) * T;
    }
  return S;
}

// Takes steps of a slide: the laws hold, gaps are those of the bodies' moves, and moves are those
// of the impulses. Gaps are shares of the ball's 1e-3.
void follow(Slide& slide, int n_steps, double stride, double most_residual) {
  ImpulseMemory memory;
  Points guess;
  for (int k = 0; k < n_steps; ++k) {
    slide.at(stride * k, 0.6 * stride * k);
    const Index m = slide.list.points.size();
    if (guess.rows() != m) guess.setZero(m, 3);
    for (ContactBody& body : slide.bodies) {
      body.impulses.setZero();
      body.friction.setZero();
    }
    const EnforcementResult found =
        enforce_impulse(slide.list, slide.laws, guess, 1e-3, slide.bodies, memory);
    EXPECT_LT(found.residual, most_residual) << k;
    EXPECT_GT(found.p.col(0).maxCoeff(), 0) << k;
    Points gap(m, 3);
    for (Index i = 0; i < m; ++i) {
      const ContactPoint& point = slide.list.points[i];
      Vector3 moved = Vector3::Zero();
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = slide.list.terms[t];
        moved += term.coefficient * slide.bodies[term.body].move.row(term.node).transpose();
      }
      gap.row(i) = (point.gap + point.frame * moved).transpose();
      if (slide.laws[i].law == ContactLaw::tied) continue;
      const double limit = slide.laws[i].friction * found.p(i, 0);
      EXPECT_GE(found.p(i, 0), 0);
      EXPECT_LE(found.p.row(i).tail<2>().norm(), (1 + 1e-12) * limit + 1e-300);
    }
    EXPECT_LT((found.gap.col(0) - gap.col(0)).cwiseAbs().maxCoeff(), 1e-11 * 1e-3) << k;
    EXPECT_GT(gap.col(0).minCoeff(), -2 * most_residual * 1e-3) << k;
    for (ContactBody& body : slide.bodies) {
      EXPECT_TRUE(body.has_move);
      Points product = Points::Zero(body.move.rows(), 3);
      body.response.add_product(body.impulses + body.friction, product);
      EXPECT_LT((product - body.move).cwiseAbs().maxCoeff(),
                1e-13 * body.move.cwiseAbs().maxCoeff());
    }
    guess = found.p;
  }
}

std::vector<PointLaw> same_law(Index n, ContactLaw law, double friction = 0) {
  return std::vector<PointLaw>(n, {law, friction});
}

TEST(EnforceImpulse, NothingIsFormedWhereNoPointCloses) {
  for (const ContactLaw law : {ContactLaw::frictionless, ContactLaw::coulomb, ContactLaw::tied}) {
    Slide slide;
    slide.laws_of_slots = same_law(81, law, 0.3);
    slide.start(response_of_face(9), true);
    slide.at(0.1, 0.2);
    for (ContactPoint& point : slide.list.points) point.gap[0] = std::abs(point.gap[0]);
    ImpulseMemory memory;
    const Points none = Points::Zero(static_cast<Index>(slide.list.points.size()), 3);
    const EnforcementResult found =
        enforce_impulse(slide.list, slide.laws, none, 1e-3, slide.bodies, memory);
    const bool tied = law == ContactLaw::tied;
    EXPECT_EQ(memory.n_formed, tied ? 1 : 0);
    EXPECT_EQ(found.p.isZero(0), !tied);
    EXPECT_EQ(slide.bodies[0].impulses.isZero(0), !tied);
    for (Index i = 0; i < none.rows() && !tied; ++i)
      EXPECT_EQ(found.gap(i, 0), slide.list.points[i].gap[0]);
    // One point that closes is enough
    slide.list.points[40].gap[0] = -1e-6;
    EXPECT_FALSE(
        enforce_impulse(slide.list, slide.laws, none, 1e-3, slide.bodies, memory).p.isZero(0));
  }
}

TEST(EnforceImpulse, LongSlideWithoutFriction) {
  for (const bool shared : {true, false}) {
    Slide slide;
    slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
    slide.start(response_of_face(9), shared);
    follow(slide, 60, 0.017, 1e-10);  // a face along x
  }
}

TEST(EnforceImpulse, LongSlideWithFrictionAndTies) {
  Slide slide;
  slide.laws_of_slots = same_law(81, ContactLaw::coulomb, 0.3);
  for (Index slot = 0; slot < 81; slot += 20) slide.laws_of_slots[slot] = {ContactLaw::tied, 0};
  for (Index slot = 5; slot < 81; slot += 11)
    slide.laws_of_slots[slot] = {ContactLaw::frictionless, 0};
  slide.start(response_of_face(9), true);
  follow(slide, 30, 0.01, 1e-10);
}

TEST(EnforceImpulse, PointsComeAndGo) {
  Slide slide;
  slide.reach = 3.6;
  slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
  slide.start(response_of_face(9), true);
  follow(slide, 60, 0.01, 1e-10);
}

// 20 coordinates.
Matrix singular_response() {
  const Matrix S = response_of_face(9);
  const SymmetricEigen modes = symmetric_eigen(S);
  const Matrix V = modes.vectors.rightCols(20) * modes.values.tail(20).cwiseSqrt().asDiagonal();
  return V * V.transpose();
}

// Fewer coordinates than points in contact: impulses are not unique, gaps and moves are.
TEST(EnforceImpulse, SingularResponsesWherePointsComeAndGo) {
  for (const double reach : {HUGE_VAL, 3.6})
    for (const ContactLaw law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
      Slide slide;
      slide.reach = reach;
      slide.laws_of_slots = same_law(81, law, law == ContactLaw::coulomb ? 0.3 : 0);
      slide.start(singular_response(), true);
      follow(slide, 20, 0.02, 1e-9);
    }
}

// n x n nodes that lie on a wall, with six coordinates and residual compliance at each node.
ContactBody body_on_a_wall(Index n) {
  const Matrix S = response_of_face(n);
  auto rows = std::make_shared<StaticRows>();
  rows->direction.resize(3 * n * n, 3);
  for (Index i = 0; i < n * n; ++i) {
    rows->first.push_back(3 * i);
    for (Index c = 0; c < 3; ++c) {
      rows->node.push_back(i);
      rows->direction.row(3 * i + c) = Matrix3::Identity().row(c);
    }
  }
  rows->first.push_back(3 * n * n);
  rows->F = std::make_shared<const Matrix>(1e-3 * S);
  ContactBody body;
  body.impulses.setZero(n * n, 3);
  body.friction.setZero(n * n, 3);
  body.end.setZero(n * n, 3);
  body.response.thin = std::make_shared<const ThinResponse>(
      ThinResponse{std::make_shared<const Matrix>(S.topRows(6)), Matrix::Identity(6, 6),
                   std::move(rows), 1e-3, true});
  return body;
}

// Responses are kept in the body's axes while it rotates: as if they were formed anew.
TEST(EnforceImpulse, FunctionsOfABodyThatRotatesOnAWall) {
  const Index n = 12;
  Surface face;
  face.faces.resize((n - 1) * (n - 1), 4);
  Points x(n * n, 3);
  for (Index i = 0; i < n * n; ++i)
    x.row(i) << static_cast<double>(i % n), static_cast<double>(i / n), 0;
  for (Index j = 0; j < n - 1; ++j)
    for (Index i = 0; i < n - 1; ++i)
      face.faces.row(j * (n - 1) + i) << j * n + i, j * n + i + 1, (j + 1) * n + i + 1,
          (j + 1) * n + i;
  const PressureFunctions functions = pressure_functions({face}, x, 12);
  for (const PointLaw law : {PointLaw{}, PointLaw{ContactLaw::coulomb, 0.3}}) {
    std::vector<ContactBody> bodies{body_on_a_wall(n)}, as_they_are = bodies;
    const std::vector<PointLaw> laws(n * n, law);
    ImpulseMemory memory;
    const Points guess = Points::Zero(n * n, 3);
    for (int k = 0; k < 4; ++k) {
      const Matrix3 R =
          Eigen::AngleAxisd(0.3 + 0.02 * k, Vector3(1, 2, -1).normalized()).toRotationMatrix();
      ContactList list;
      for (Index i = 0; i < n * n; ++i) {
        ContactPoint point;
        point.frame = contact_frame(Vector3(0, 0.6, 0.8));
        const double r = std::hypot(x(i, 0) - 5.5 - k, x(i, 1) - 5);
        point.gap = 1e-3 * Vector3(r * r / 64 - 1, 0.3 - 0.05 * x(i, 1), 0.02 * x(i, 0));
        point.slot = point.first_term = i;
        point.n_terms = 1;
        list.points.push_back(point);
        list.terms.push_back({0, i, 1});
      }
      bodies[0].response.axes = as_they_are[0].response.axes = R;
      bodies[0].turn = R;
      const std::vector<FunctionsOfSearch> searches{{0, laws.size(), &functions, nullptr}};
      ImpulseMemory anew;
      const auto found = enforce_impulse(list, laws, guess, 1, bodies, memory, searches),
                 expected = enforce_impulse(list, laws, guess, 1, as_they_are, anew, searches);
      EXPECT_EQ(found.n_unknowns, expected.n_unknowns);
      EXPECT_LT(found.n_unknowns[0], 100) << "functions are among them";
      EXPECT_GT(expected.p.col(0).maxCoeff(), 0);
      EXPECT_LT((found.p - expected.p).cwiseAbs().maxCoeff(),
                1e-9 * expected.p.cwiseAbs().maxCoeff());
    }
  }
}

TEST(DensePanels, Columns) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const Index n : {1, 2, 5, 6, 7, 31, 250, 1203}) {
    Matrix S = Matrix::NullaryExpr(n, n, [&] { return normal(random); });
    for (const Index k : {1, 2}) {
      std::vector<Index> columns;
      Matrix X = Matrix::Zero(n, k), Y = Matrix::Constant(n, k, 0.5);
      for (Index j = 0; j < n; ++j)
        if (n > 1000 || j % 5 == 0) {
          columns.push_back(j);
          X.row(j) = Matrix::NullaryExpr(1, k, [&] { return normal(random); });
        }
      const Matrix expected = Y + S * X;
      Matrix two = Y;
      add_columns(S, columns, X, Y, 1);
      add_columns(S, columns, X, two, 2);
      EXPECT_LT((Y - expected).cwiseAbs().maxCoeff(), 1e-13 * static_cast<double>(n));
      EXPECT_EQ(Y, two) << "not another sum with more threads";
    }
  }
}

}  // namespace
}  // namespace cbr::enforce_impulse_test
