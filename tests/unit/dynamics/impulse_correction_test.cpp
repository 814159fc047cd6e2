// SPDX-License-Identifier: GPL-3.0-or-later
// Impulses with a W that is kept from step to step and corrected, against a W that is formed anew
// in each: long slides, points that come and go, laws mixed, singular responses, bodies that share
// a block in different axes.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"
#include "dynamics/contact/solve/newton/kept_factor.hpp"

namespace cbr::impulse_correction_test {
namespace {

// Two square faces of n x n nodes, spacing 1, one over the other; the upper one (slave) has slid by
// (x, y). A ball's gap.
struct Slide {
  Index n = 9;
  std::vector<PointLaw> laws_of_slots;
  std::vector<ContactBody> bodies;
  ContactList list;
  std::vector<PointLaw> laws;
  std::function<void()> before_step = [] {};
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

struct Compared {
  // largest differences, as shares of the largest impulse, gap and move
  double impulse = 0, gap = 0, move = 0;
  Index steps = 0, products = 0, formed = 0, changed = 0;
};

// Takes the same steps with a W that is kept and with one that is not.
Compared compare(Slide& slide, int n_steps, double stride, double unique_impulses = 1) {
  Compared result;
  ImpulseMemory kept, anew;
  kept.options.least_rows = 1;
  anew.options.least_rows = 1 << 20;
  Points guess;
  for (int k = 0; k < n_steps; ++k) {
    slide.at(stride * k, 0.6 * stride * k);
    slide.before_step();
    const Index m = static_cast<Index>(slide.list.points.size());
    if (guess.rows() != m) guess.setZero(m, 3);
    const auto enforce = [&](ImpulseMemory& memory) {
      for (ContactBody& body : slide.bodies) {
        body.impulses.setZero();
        body.friction.setZero();
      }
      return enforce_impulse(slide.list, slide.laws, guess, 1e-3, slide.bodies, memory);
    };
    const EnforcementResult expected = enforce(anew);
    const std::vector<ContactBody> truth = slide.bodies;
    const EnforcementResult found = enforce(kept);
    EXPECT_LT(std::max(expected.residual, found.residual), 1e-9);
    const double force = expected.p.cwiseAbs().maxCoeff(), length = 1e-3;  // of g
    result.impulse = std::max(
        result.impulse, unique_impulses * (found.p - expected.p).cwiseAbs().maxCoeff() / force);
    result.gap = std::max(result.gap, (found.gap - expected.gap).cwiseAbs().maxCoeff() / length);
    for (int b = 0; b < 2; ++b) {
      const Points &a = slide.bodies[b].move, &c = truth[b].move;
      EXPECT_TRUE(slide.bodies[b].has_move);
      result.move = std::max(result.move, (a - c).cwiseAbs().maxCoeff() / c.cwiseAbs().maxCoeff());
      // The move is what the impulses do
      Points product = Points::Zero(c.rows(), 3);
      slide.bodies[b].response.add_product(slide.bodies[b].impulses + slide.bodies[b].friction,
                                           product);
      EXPECT_LT((product - a).cwiseAbs().maxCoeff(), 1e-13 * a.cwiseAbs().maxCoeff());
    }
    guess = found.p;
  }
  result.steps = kept.n_steps;
  result.products = kept.n_pushes;
  result.formed = kept.n_formed;
  result.changed = kept.n_changed;
  EXPECT_EQ(anew.n_formed, n_steps);
  return result;
}

std::vector<PointLaw> same_law(Index n, ContactLaw law, double friction = 0) {
  return std::vector<PointLaw>(n, {law, friction});
}

TEST(ImpulseCorrection, NothingIsFormedWhereNoPointCloses) {
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

TEST(ImpulseCorrection, LongSlideWithoutFriction) {
  for (const bool shared : {true, false}) {
    Slide slide;
    slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
    slide.start(response_of_face(9), shared);
    const Compared c = compare(slide, 250, 0.004);  // a face along x
    EXPECT_LT(c.impulse, 1e-9);
    EXPECT_LT(c.gap, 1e-9);
    EXPECT_LT(c.move, 1e-9);
    EXPECT_LT(c.formed, c.steps);
    EXPECT_LT(c.products, 6 * c.steps);
  }
}

TEST(ImpulseCorrection, LongSlideWithFrictionAndTies) {
  Slide slide;
  slide.laws_of_slots = same_law(81, ContactLaw::coulomb, 0.3);
  for (Index slot = 0; slot < 81; slot += 20) slide.laws_of_slots[slot] = {ContactLaw::tied, 0};
  for (Index slot = 5; slot < 81; slot += 11)
    slide.laws_of_slots[slot] = {ContactLaw::frictionless, 0};
  slide.start(response_of_face(9), true);
  const Compared c = compare(slide, 60, 0.004);
  EXPECT_LT(c.impulse, 1e-9);
  EXPECT_LT(c.gap, 1e-9);
  EXPECT_LT(c.move, 1e-9);
  EXPECT_LT(c.formed, c.steps);
}

TEST(ImpulseCorrection, PointsComeAndGo) {
  Slide slide;
  slide.reach = 3.6;
  slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
  slide.start(response_of_face(9), true);
  const Compared c = compare(slide, 120, 0.004);
  EXPECT_LT(c.impulse, 1e-9);
  EXPECT_LT(c.gap, 1e-9);
  EXPECT_LT(c.move, 1e-9);
}

// W of bodies that turn is another in each step, however new W_0 is: a second product is no reason
// to form it.
TEST(ImpulseCorrection, SlowTurnsDoNotFormAnew) {
  Slide slide;
  slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
  slide.start(response_of_face(9), true);
  const Matrix3 turn = Eigen::AngleAxisd(1e-6, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  slide.before_step = [&] {
    for (ContactBody& body : slide.bodies) {
      body.response.axes = turn * body.response.axes;
      body.turn = body.response.axes;
    }
  };
  const Compared c = compare(slide, 60, 0);
  EXPECT_LT(c.impulse, 1e-9);
  EXPECT_LT(c.gap, 1e-9);
  EXPECT_LT(c.move, 1e-9);
  EXPECT_GT(c.products, c.steps);
  EXPECT_EQ(c.formed, 1);
}

// 20 coordinates.
Matrix singular_response() {
  const Matrix S = response_of_face(9);
  const SymmetricEigen modes = symmetric_eigen(S);
  const Matrix V = modes.vectors.rightCols(20) * modes.values.tail(20).cwiseSqrt().asDiagonal();
  return V * V.transpose();
}

// Fewer coordinates than points in contact: impulses are not unique, gaps and moves are.
TEST(ImpulseCorrection, SingularResponses) {
  Slide slide;
  slide.laws_of_slots = same_law(81, ContactLaw::frictionless);
  slide.start(singular_response(), true);
  const Compared c = compare(slide, 25, 0.02, 0);
  EXPECT_LT(c.gap, 1e-7);
  EXPECT_LT(c.move, 1e-7);
}

// Points that come would be patched into a W of another geometry, which is not semi-definite then:
// with friction a W is formed anew from the first that needed more than Newton's method; without it
// what Newton solves may be patched.
TEST(ImpulseCorrection, SingularResponsesWherePointsComeAndGo) {
  for (const ContactLaw law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
    Slide slide;
    slide.reach = 3.6;
    slide.laws_of_slots = same_law(81, law, law == ContactLaw::coulomb ? 0.3 : 0);
    slide.start(singular_response(), true);
    const Compared c = compare(slide, 40, 0.02, 0);
    EXPECT_LT(c.gap, 1e-9);
    EXPECT_LT(c.move, 1e-9);
    if (law == ContactLaw::frictionless) continue;
    EXPECT_LE(c.changed, 1);
    EXPECT_EQ(c.formed, 40);
  }
}

TEST(DensePanels, ColumnsAndTriangles) {
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
    S.diagonal().array() = 2 * static_cast<double>(n);
    const Vector b = Vector::NullaryExpr(n, [&] { return normal(random); });
    Vector y = b;
    solve_lower(S, n, y.data());
    EXPECT_LT((S.triangularView<Eigen::Lower>() * y - b).cwiseAbs().maxCoeff(), 1e-13);
    y = b;
    solve_lower_transposed(S, n, y.data());
    EXPECT_LT((S.triangularView<Eigen::Lower>().transpose() * y - b).cwiseAbs().maxCoeff(), 1e-13);
  }
}

// Sets that change by a few rows, some coming back, W getting other rows in between: always the
// solution over the set.
TEST(KeptFactor, FollowsTheSet) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  const Index n = 60;
  const Matrix A = Matrix::NullaryExpr(n, 2 * n, [&] { return normal(random); });
  const Matrix all = A * A.transpose();
  std::vector<Index> ids;  // rows of W now, of `all`
  std::vector<char> closed(n, 0);
  for (Index i = 0; i < n; ++i)
    if (i % 6 != 0) {
      ids.push_back(i);
      closed[i] = unit(random) < 0.8;
    }
  KeptFactor factor;
  Index changes = 0;
  for (int step = 0; step < 200; ++step) {
    for (int k = 0; k < 2; ++k) closed[static_cast<std::size_t>(unit(random) * n)] ^= 1;
    if (step % 10 == 9) {  // a row leaves, another comes
      std::vector<Index> next = ids;
      next.erase(next.begin() +
                 static_cast<std::ptrdiff_t>(unit(random) * static_cast<double>(next.size())));
      for (Index i = 0; i < n; ++i)
        if (std::find(ids.begin(), ids.end(), i) == ids.end()) {
          next.insert(std::upper_bound(next.begin(), next.end(), i), i);
          break;
        }
      std::vector<Index> from;
      for (const Index id : next) {
        const auto old = std::find(ids.begin(), ids.end(), id);
        from.push_back(old == ids.end() ? -1 : old - ids.begin());
      }
      factor.renumber(from);
      ids = next;
    }
    const Matrix W = all(ids, ids);
    std::vector<Index> rows;
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (closed[ids[i]]) rows.push_back(static_cast<Index>(i));
    changes += factor.is_near(rows);
    ASSERT_TRUE(factor.adapt(W, rows));
    const Vector b =
        Vector::NullaryExpr(static_cast<Index>(rows.size()), [&] { return normal(random); });
    Vector p;
    factor.solve(b, p);
    EXPECT_LT((W(rows, rows) * p - b).cwiseAbs().maxCoeff(), 1e-11) << step;
  }
  EXPECT_GT(changes, 100);
  EXPECT_LT(factor.n_factored(), 60);
  const Matrix singular = A.leftCols(20) * A.leftCols(20).transpose();
  std::vector<Index> rows(40);
  for (Index i = 0; i < 40; ++i) rows[i] = i;
  EXPECT_FALSE(factor.adapt(singular, rows));
  EXPECT_TRUE(factor.empty());
}

}  // namespace
}  // namespace cbr::impulse_correction_test
