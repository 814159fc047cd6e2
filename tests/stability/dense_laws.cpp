// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_laws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/linalg/dense.hpp"

namespace cbr::test {
namespace {

using Vector2 = Eigen::Vector2d;

// Murty's principal pivoting: 0 <= p, 0 <= g + W p, p . (g + W p) = 0. One choice at a time, the
// first that is wrong; finite when W is positive definite. Empty where it ends nowhere.
Vector complementary(const Matrix& W, const Vector& g) {
  const Index n = g.size();
  const double tolerance = 1e-14 * g.cwiseAbs().maxCoeff();
  std::vector<char> active(n, 0);
  for (Index round = 0; round < 10000; ++round) {
    std::vector<Index> in;
    for (Index i = 0; i < n; ++i)
      if (active[i]) in.push_back(i);
    Vector p = Vector::Zero(n);
    if (!in.empty()) p(in) = -Ldlt(W(in, in)).solve(Vector(g(in)));
    const Vector gap = g + W * p;
    Index wrong = -1;
    for (Index i = 0; i < n && wrong < 0; ++i)
      if (active[i] ? p[i] < 0 : gap[i] < -tolerance) wrong = i;
    if (wrong < 0) return p;
    active[wrong] ^= 1;
  }
  return {};
}

// Whether those that press do so in one way only.
bool is_definite(const Matrix& W, const Vector& p) {
  std::vector<Index> in;
  for (Index i = 0; i < p.size(); ++i)
    if (p[i] > 0) in.push_back(i);
  if (in.empty()) return true;
  const Vector lambda = symmetric_eigenvalues(W(in, in));
  return lambda.minCoeff() > 1e-10 * lambda.maxCoeff();
}

// A point that slides, for a direction of its tangential impulse at the angle `at`: p = p_n (1, mu
// cos, mu sin) with gap_n = 0. `cross`: 0 where the slip is along the direction; `along`: below 0
// where it is against it.
struct Slide {
  Vector3 p;
  double cross, along;
};
Slide slide(const Matrix3& W, const Vector3& g, double mu, double at) {
  const Vector2 d(std::cos(at), std::sin(at));
  const Vector3 r(1, mu * d[0], mu * d[1]);
  const Vector3 p = -g[0] / W.row(0).dot(r) * r;
  const Vector2 slip = (g + W * p).tail<2>();
  return {p, d[0] * slip[1] - d[1] * slip[0], d.dot(slip)};
}

// One point with three rows: open, sticking, or sliding in the direction that a scan of all of them
// finds.
Vector3 impulse_of_point(const Matrix3& W, const Vector3& g, double mu) {
  if (g[0] >= 0) return Vector3::Zero();
  const Vector3 stuck = -solve_symmetric(W, g);
  if (stuck[0] >= 0 && stuck.tail<2>().norm() <= mu * stuck[0]) return stuck;
  constexpr int n = 48;
  constexpr double turn = 2 * std::numbers::pi / n;
  for (int i = 0; i < n; ++i) {
    double low = i * turn, high = (i + 1) * turn;
    const bool below = slide(W, g, mu, low).cross < 0;
    if (below == (slide(W, g, mu, high).cross < 0)) continue;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      ((slide(W, g, mu, middle).cross < 0) == below ? low : high) = middle;
    }
    const Slide found = slide(W, g, mu, 0.5 * (low + high));
    if (found.p[0] >= 0 && found.along <= 0) return found.p;
  }
  throw std::runtime_error("the oracle finds no direction for a point to slide in");
}

std::vector<Index> first_rows(const std::vector<double>& mu) {
  std::vector<Index> first{0};
  for (const double m : mu) first.push_back(first.back() + (m > 0 ? 3 : 1));
  return first;
}

}  // namespace

double law_violation(const Matrix& W, const Vector& g, const std::vector<double>& mu,
                     const Vector& p) {
  const std::vector<Index> first = first_rows(mu);
  const Vector gap = g + W * p;
  double worst = 0;
  for (std::size_t i = 0; i < mu.size(); ++i) {
    const Index n = first[i];
    const double w = W(n, n);
    worst = std::max(worst, std::abs(std::min(w * p[n], gap[n])));
    if (mu[i] == 0) continue;
    Vector2 to = w * p.segment<2>(n + 1) - gap.segment<2>(n + 1);
    const double limit = mu[i] * w * std::max(0.0, p[n]);
    if (to.norm() > limit) to *= limit / to.norm();
    worst = std::max(worst, (w * p.segment<2>(n + 1) - to).norm());
  }
  return worst;
}

namespace {

// Gauss-Seidel from `p`, each point's law solved for itself.
Vector point_by_point(const Matrix& W, const Vector& g, const std::vector<double>& mu, Vector p) {
  const std::vector<Index> first = first_rows(mu);
  const double scale = g.cwiseAbs().maxCoeff();
  for (int sweep = 0; sweep < 100000; ++sweep) {
    double change = 0;
    for (std::size_t i = 0; i < mu.size(); ++i) {
      const Index n = first[i], rows = first[i + 1] - n;
      const Vector before = p.segment(n, rows);
      p.segment(n, rows).setZero();
      const Vector b = g.segment(n, rows) + W.middleRows(n, rows) * p;
      if (rows == 1) {
        p[n] = std::max(0.0, -b[0] / W(n, n));
      } else {
        p.segment<3>(n) = impulse_of_point(W.block<3, 3>(n, n), b, mu[i]);
      }
      change = std::max(change, W(n, n) * (p.segment(n, rows) - before).norm());
    }
    if (change <= 1e-16 * scale) break;
    if (sweep % 10 == 9 && law_violation(W, g, mu, p) <= 3e-16 * scale) break;
  }
  return p;
}

}  // namespace

DenseImpulses dense_impulses(const Matrix& W, const Vector& g, const std::vector<double>& mu) {
  const auto is_solved = [&](const Vector& p) {
    return law_violation(W, g, mu, p) <= 1e-13 * g.cwiseAbs().maxCoeff();
  };
  const bool friction = std::any_of(mu.begin(), mu.end(), [](double m) { return m > 0; });
  if (!friction) {
    Vector p = complementary(W, g);
    if (p.size() == 0) p = point_by_point(W, g, mu, Vector::Zero(g.size()));
    if (is_solved(p)) return {p, !is_definite(W, p), false};
    if (is_definite(W, Vector::Ones(g.size())))
      throw std::runtime_error("the oracle's complementarity problem is not solved");
    // pivots and sweeps may go round where a node touches more faces than it has ways to go
    return {p, true, true};
  }
  const Vector p = point_by_point(W, g, mu, Vector::Zero(g.size()));
  const Vector other =
      point_by_point(W, g, mu, Vector::Constant(g.size(), 3 * p.cwiseAbs().maxCoeff()));
  if (!is_solved(p) || !is_solved(other)) return {p, true, true};
  const auto differ = [](const Vector& a, const Vector& b) {
    return (a - b).cwiseAbs().maxCoeff() > 1e-9 * b.cwiseAbs().maxCoeff();
  };
  return {p, differ(other, p), differ(W * other, W * p)};
}

}  // namespace cbr::test
