// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/mortar_segment.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/elements/quadrature.hpp"

namespace cbr {
namespace {

struct TrianglePoint {
  double s, t, weight;  // weights sum to 1
};

// Zeros and weights on [0, 1].
std::vector<LinePoint> gauss_unit_line(int n) {
  std::vector<LinePoint> rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double p = 1, before = 0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p, p = next;
      }
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.push_back({0.5 * (1 - x), 1 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

constexpr int max_line = 8;

// n = 0: six points of degree 4. Else a square of n x n Gauss points drawn together into a triangle: degree 2 n - 2.
const std::vector<TrianglePoint>& triangle_points(int n) {
  static const std::array<std::vector<TrianglePoint>, max_line + 1> rules = [] {
    std::array<std::vector<TrianglePoint>, max_line + 1> all;
    for (const QuadraturePoint& q : triangle_rule(6)) all[0].push_back({q.xi[0], q.xi[1], 2 * q.weight});
    for (int k = 1; k <= max_line; ++k)
      for (const LinePoint& u : gauss_unit_line(k))
        for (const LinePoint& v : gauss_unit_line(k))
          all[k].push_back({u.xi, v.xi * (1 - u.xi), 2 * u.weight * v.weight * (1 - u.xi)});
    return all;
  }();
  return rules[n];
}

double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }

FacePiece triangle_piece(const std::array<Vector2, 4>& x, int i, int j, int k) {
  FacePiece piece;
  piece.n = 3, piece.corner = {i, j, k, k};
  piece.origin = x[i], piece.a = x[j] - x[i], piece.b = x[k] - x[i], piece.w.setZero();
  return piece;
}

FacePiece quad_piece(const std::array<Vector2, 4>& x) {
  FacePiece piece;
  piece.n = 4, piece.corner = {0, 1, 2, 3};
  piece.origin = (x[0] + x[1] + x[2] + x[3]) / 4;
  piece.a = (-x[0] + x[1] + x[2] - x[3]) / 4;
  piece.b = (-x[0] - x[1] + x[2] + x[3]) / 4;
  piece.w = (x[0] - x[1] + x[2] - x[3]) / 4;
  return piece;
}

// The map's Jacobian is J0 (1 + c . (s, t)); a quad is convex where |c_s| + |c_t| < 1.
bool complete(const std::array<Vector2, 4>& x, bool counter_clockwise, FacePiece& piece) {
  const double J0 = cross(piece.a, piece.b);
  piece.area = piece.n == 3 ? 0.5 * std::abs(J0) : 4 * std::abs(J0);
  const double scale = piece.a.squaredNorm() + piece.b.squaredNorm() + piece.w.squaredNorm();
  if (!(std::abs(J0) > 1e-12 * scale) || (J0 > 0) != counter_clockwise) return false;
  if (piece.n == 4) piece.distortion = (std::abs(cross(piece.a, piece.w)) + std::abs(cross(piece.w, piece.b))) / std::abs(J0);
  if (piece.distortion < 1e-12) piece.distortion = 0;
  piece.inverse << piece.b[1], -piece.b[0], -piece.a[1], piece.a[0];
  piece.inverse /= J0;
  piece.outline.n = piece.n;
  for (int a = 0; a < piece.n; ++a) piece.outline.x[counter_clockwise ? a : piece.n - 1 - a] = x[piece.corner[a]];
  return true;
}

// Parent coordinates: barycentric for a triangle, of [-1, 1]^2 for a quad.
Vector2 inverse_map(const FacePiece& piece, const Vector2& x) {
  const Vector2 d = x - piece.origin;
  Vector2 p = piece.inverse * d;
  if (piece.distortion == 0) return p;
  // Newton's method; a convex quad has one solution inside
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vector2 r = d - p[0] * piece.a - p[1] * piece.b - p[0] * p[1] * piece.w;
    const Vector2 u = piece.a + p[1] * piece.w, v = piece.b + p[0] * piece.w;
    const double J = cross(u, v);
    const Vector2 change(cross(r, v) / J, cross(u, r) / J);
    p = (p + change).cwiseMax(-1.5).cwiseMin(1.5);
    if (change.cwiseAbs().maxCoeff() < 1e-9) break;  // it squares the error: the next change would be below rounding
  }
  return p;
}

// How fast Gauss points converge for functions of the inverse map of a quad over a polygon: its square root vanishes where the
// square of the Jacobian, linear along any line, goes through 0, so that the error falls with (r + sqrt(r^2 - 1))^(-2 n), r the
// distance of that point from the middle in half lengths.
double convergence(const FacePiece& piece, const Polygon& polygon) {
  if (piece.distortion == 0) return HUGE_VAL;
  double least = HUGE_VAL, most = 0;
  for (int i = 0; i < polygon.n; ++i) {
    const Vector2 p = inverse_map(piece, polygon.x[i]);
    const double J = cross(piece.a + p[1] * piece.w, piece.b + p[0] * piece.w);
    least = std::min(least, J * J), most = std::max(most, J * J);
  }
  const double r = (most + least) / std::max(most - least, 1e-12 * most);
  return r + std::sqrt(r * r - 1);
}

// Points on a line for an error of about 1e-10; 0: the piece is affine.
int line_points(double rate) {
  if (rate > 1e12) return 0;
  return std::clamp(static_cast<int>(std::ceil(0.5 * 10 * std::numbers::ln10 / std::log(rate))) + 1, 3, max_line);
}

void add_polygon(const FacePiece& slave, const FacePiece& master, const Polygon& shared, double sliver, Segment& segment) {
  const auto& points = triangle_points(line_points(std::min(convergence(slave, shared), convergence(master, shared))));
  for (int i = 2; i < shared.n; ++i) {
    const Vector2 &origin = shared.x[0], u = shared.x[i - 1] - origin, v = shared.x[i] - origin;
    const double size = 0.5 * cross(u, v);
    if (!(size > sliver)) continue;
    Eigen::Matrix4d D = Eigen::Matrix4d::Zero(), M = Eigen::Matrix4d::Zero();
    for (const TrianglePoint& q : points) {
      const Vector2 x = origin + q.s * u + q.t * v;
      const Eigen::Vector4d N = shape_functions(slave, x), weighted = (q.weight * size) * N;
      D.noalias() += weighted * N.transpose();
      M.noalias() += weighted * shape_functions(master, x).transpose();
    }
    segment.D += D, segment.M += M, segment.area += size;
  }
}

}  // namespace

FlatFace flatten(const FaceCorners& corners, bool triangle, const Matrix3& frame, const Vector3& origin, bool counter_clockwise) {
  std::array<Vector2, 4> x;
  for (int a = 0; a < 4; ++a) x[a] = frame.bottomRows<2>() * (corners[a] - origin);
  FlatFace face;
  const auto add = [&](FacePiece piece) {
    if (complete(x, counter_clockwise, piece)) face.pieces[face.n_pieces++] = piece;
  };
  if (triangle) {
    add(triangle_piece(x, 0, 1, 2));
    return face;
  }
  const FacePiece quad = quad_piece(x);
  // Near the border of convexity the inverse map loses its digits
  const double J0 = std::abs(cross(quad.a, quad.b)), J1 = std::abs(cross(quad.a, quad.w)) + std::abs(cross(quad.w, quad.b));
  if (J1 < 0.95 * J0) {
    add(quad);
    return face;
  }
  // The diagonal whose triangles are more alike: at a concave corner it is the one that stays inside
  const auto signed_area = [&](int i, int j, int k) { return cross(x[j] - x[i], x[k] - x[i]) * (counter_clockwise ? 1 : -1); };
  const double first = std::min(signed_area(0, 1, 2), signed_area(0, 2, 3));
  const double second = std::min(signed_area(0, 1, 3), signed_area(1, 2, 3));
  if (first >= second) {
    add(triangle_piece(x, 0, 1, 2)), add(triangle_piece(x, 0, 2, 3));
  } else {
    add(triangle_piece(x, 0, 1, 3)), add(triangle_piece(x, 1, 2, 3));
  }
  return face;
}

Eigen::Vector4d shape_functions(const FacePiece& piece, const Vector2& x) {
  const Vector2 p = inverse_map(piece, x);
  Eigen::Vector4d N = Eigen::Vector4d::Zero();
  if (piece.n == 3) {
    N[piece.corner[0]] = 1 - p[0] - p[1], N[piece.corner[1]] = p[0], N[piece.corner[2]] = p[1];
    return N;
  }
  const double s = p[0], t = p[1];
  N << 0.25 * (1 - s) * (1 - t), 0.25 * (1 + s) * (1 - t), 0.25 * (1 + s) * (1 + t), 0.25 * (1 - s) * (1 + t);
  return N;
}

Segment integrate(const FlatFace& slave, const FlatFace& master, double sliver) {
  Segment segment;
  for (int i = 0; i < slave.n_pieces; ++i) {
    for (int j = 0; j < master.n_pieces; ++j) {
      const FacePiece &s = slave.pieces[i], &m = master.pieces[j];
      const double smallest = sliver * std::min(s.area, m.area);
      const Polygon shared = clip(s.outline, m.outline);
      if (shared.n >= 3 && area(shared) > smallest) add_polygon(s, m, shared, 1e-3 * smallest, segment);
    }
  }
  return segment;
}

}  // namespace cbr
