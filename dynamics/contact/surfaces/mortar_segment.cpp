// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/mortar_segment.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "common/fem/elements/reference_element.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Clips to the half-plane on the left of the line from `from` to `to`.
void keep_left(const Vector2& from, const Vector2& to, Polygon& polygon) {
  const Vector2 along = to - from;
  std::array<double, 12> side;
  bool all = true;
  for (int i = 0; i < polygon.n; ++i) {
    side[i] = cross(along, polygon.x[i] - from);
    all = all && side[i] >= 0;
  }
  if (all) return;
  Polygon result;
  for (int i = 0; i < polygon.n; ++i) {
    const int next = i + 1 < polygon.n ? i + 1 : 0;
    const bool in = side[i] >= 0, next_in = side[next] >= 0;
    // Round-off may make a polygon without area concave, with a growing number of corners: it is
    // empty
    if (result.n + 2 > static_cast<int>(result.x.size()) && next > 0 && in != next_in)
      return void(polygon.n = 0);
    if (in) result.x[result.n++] = polygon.x[i];
    if (in != next_in) {
      const double t = side[i] / (side[i] - side[next]);
      result.x[result.n++] = polygon.x[i] + t * (polygon.x[next] - polygon.x[i]);
    }
  }
  polygon = result;
}

constexpr int capacity = 128;  // of a batch of quadrature points
using Batch = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, capacity, 1>;
// columns: corners of the face
using Shapes = Eigen::Array<double, Eigen::Dynamic, 4, Eigen::ColMajor, capacity, 4>;
// columns: all nodes of the face
using NodeShapes = Eigen::Array<double, Eigen::Dynamic, 9, Eigen::ColMajor, capacity, 9>;

struct TrianglePoint {
  double s, t, weight;  // weights sum to 1
};

// Gauss points on [0, 1] for the weight 1, or 1 - x (`jacobi`), from the eigenvalues of the
// recurrence (Golub and Welsch 1969, doi 10.1090/S0025-5718-69-99647-1); weights sum to 1.
std::vector<LinePoint> gauss_unit_line(int n, bool jacobi) {
  Vector diagonal = Vector::Zero(n), beside(n - 1);
  for (int k = 0; k < n && jacobi; ++k) diagonal[k] = -1.0 / ((2 * k + 1) * (2 * k + 3));
  for (int k = 1; k < n; ++k)
    beside[k - 1] =
        jacobi ? std::sqrt(double(k) * (k + 1)) / (2 * k + 1) : k / std::sqrt(4.0 * k * k - 1);
  const SymmetricEigen eigen = tridiagonal_eigen(diagonal, beside);
  std::vector<LinePoint> rule;
  for (int k = 0; k < n; ++k) {
    const double v = eigen.vectors(0, k);
    rule.push_back({0.5 * (1 + eigen.values[k]), v * v});
  }
  return rule;
}

constexpr int max_line = 11;

// n < 3: six points of degree 4. Else n x n Gauss points of a square collapsed to a triangle:
// degree 2 n - 1.
const std::vector<TrianglePoint>& triangle_points(int n) {
  static const std::array<std::vector<TrianglePoint>, max_line + 1> rules = [] {
    std::array<std::vector<TrianglePoint>, max_line + 1> all;
    for (const QuadraturePoint& q : triangle_rule(6))
      all[0].push_back({q.xi[0], q.xi[1], 2 * q.weight});
    for (int k = 3; k <= max_line; ++k)
      for (const LinePoint& u : gauss_unit_line(k, true))
        for (const LinePoint& v : gauss_unit_line(k, false))
          all[k].push_back({u.xi, v.xi * (1 - u.xi), u.weight * v.weight});
    return all;
  }();
  return rules[n < 3 ? 0 : n];
}

FacePiece triangle_piece(const std::array<Vector2, 4>& x, int i, int j, int k) {
  FacePiece piece;
  piece.n = 3;
  piece.corner = {i, j, k, k};
  piece.origin = x[i];
  piece.a = x[j] - x[i];
  piece.b = x[k] - x[i];
  piece.w.setZero();
  return piece;
}

FacePiece quad_piece(const std::array<Vector2, 4>& x) {
  FacePiece piece;
  piece.n = 4;
  piece.corner = {0, 1, 2, 3};
  piece.origin = (x[0] + x[1] + x[2] + x[3]) / 4;
  piece.a = (-x[0] + x[1] + x[2] - x[3]) / 4;
  piece.b = (-x[0] - x[1] + x[2] + x[3]) / 4;
  piece.w = (x[0] - x[1] + x[2] - x[3]) / 4;
  return piece;
}

// Jacobian of the map: J0 (1 + c . (s, t)); a quad is convex where |c_s| + |c_t| < 1.
bool complete(const std::array<Vector2, 4>& x, bool counter_clockwise, FacePiece& piece) {
  const double J0 = cross(piece.a, piece.b);
  piece.area = piece.n == 3 ? 0.5 * std::abs(J0) : 4 * std::abs(J0);
  const double scale = piece.a.squaredNorm() + piece.b.squaredNorm() + piece.w.squaredNorm();
  if (!(std::abs(J0) > 1e-12 * scale) || (J0 > 0) != counter_clockwise) return false;
  if (piece.n == 4)
    piece.distortion =
        (std::abs(cross(piece.a, piece.w)) + std::abs(cross(piece.w, piece.b))) / std::abs(J0);
  if (piece.distortion < 1e-12) piece.distortion = 0;
  piece.inverse << piece.b[1], -piece.b[0], -piece.a[1], piece.a[0];
  piece.inverse /= J0;
  piece.outline.n = piece.n;
  for (int a = 0; a < piece.n; ++a)
    piece.outline.x[counter_clockwise ? a : piece.n - 1 - a] = x[piece.corner[a]];
  return true;
}

// Parent coordinates of points: barycentric for a triangle, of [-1, 1]^2 for a quad.
void inverse_map(const FacePiece& piece, const Batch& x, const Batch& y, Batch& s, Batch& t) {
  const Batch dx = x - piece.origin[0], dy = y - piece.origin[1];
  const Vector2 &a = piece.a, &b = piece.b, &w = piece.w;
  if (piece.distortion == 0) {
    s = piece.inverse(0, 0) * dx + piece.inverse(0, 1) * dy;
    t = piece.inverse(1, 0) * dx + piece.inverse(1, 1) * dy;
    return;
  }
  // d = s a + t b + s t w: (d - t b) x (a + t w) = 0, the root that stays finite for w = 0
  const double J0 = cross(a, b), A = -cross(b, w), sign = J0 > 0 ? 1 : -1;
  const Batch B = J0 + dx * w[1] - dy * w[0], C = dx * a[1] - dy * a[0];
  t = -2 * C / (B + sign * (B * B - 4 * A * C).max(0).sqrt());
  const Batch ux = a[0] + t * w[0], uy = a[1] + t * w[1];
  s = ((dx - t * b[0]) * ux + (dy - t * b[1]) * uy) / (ux * ux + uy * uy);
}

void shape_functions(const FacePiece& piece, const Batch& x, const Batch& y, Shapes& N) {
  Batch s, t;
  inverse_map(piece, x, y, s, t);
  N.resize(x.size(), 4);
  if (piece.n == 3) {
    N.setZero();
    N.col(piece.corner[0]) = 1 - s - t;
    N.col(piece.corner[1]) = s;
    N.col(piece.corner[2]) = t;
    return;
  }
  N.col(0) = 0.25 * (1 - s) * (1 - t);
  N.col(1) = 0.25 * (1 + s) * (1 - t);
  N.col(2) = 0.25 * (1 + s) * (1 + t);
  N.col(3) = 0.25 * (1 - s) * (1 + t);
}

// Convergence rate of Gauss points for functions of the inverse map of a quad over a polygon. The
// inverse map is singular at r, the zero of the squared Jacobian, which is linear along any line.
// The distance r is from the middle of the line, in half lengths. The error then decreases as (r +
// sqrt(r^2 - 1))^(-2 n).
double convergence(const FacePiece& piece, const Batch& x, const Batch& y) {
  if (piece.distortion == 0) return HUGE_VAL;
  Batch s, t;
  inverse_map(piece, x, y, s, t);
  const Batch J2 =
      (cross(piece.a, piece.b) + s * cross(piece.a, piece.w) + t * cross(piece.w, piece.b))
          .square();
  const double least = J2.minCoeff(), most = J2.maxCoeff(),
               r = (most + least) / std::max(most - least, 1e-12 * most);
  return r + std::sqrt(r * r - 1);
}

// Points on a line for an error of about 1e-10. The first term beyond degree 2 n - 1 is rate^(-2 n
// + degree). `degree` is that of the product of shape functions along the line: 3, for second order
// 5. 0: the six points of degree 4 suffice.
int line_points(double rate, int degree) {
  if (degree == 3 && rate > 1e4) return 0;
  if (!(rate > 1)) return max_line;
  return std::clamp(
      static_cast<int>(std::ceil(0.5 * (degree + 10 * std::numbers::ln10 / std::log(rate)))), 3,
      max_line);
}

// Second-order shape functions of the face, from the linear ones of its corners.
NodeShapes quadratic_shapes(bool triangle, bool centre, const Shapes& N) {
  NodeShapes Q = NodeShapes::Zero(N.rows(), 9);
  if (triangle) {
    for (int a = 0; a < 3; ++a) {
      Q.col(a) = N.col(a) * (2 * N.col(a) - 1);
      Q.col(4 + a) = 4 * N.col(a) * N.col((a + 1) % 3);
    }
    return Q;
  }
  const Batch s = N.col(1) + N.col(2) - N.col(0) - N.col(3),
              t = N.col(2) + N.col(3) - N.col(0) - N.col(1);
  Q.col(4) = 0.5 * (1 - s * s) * (1 - t);
  Q.col(5) = 0.5 * (1 + s) * (1 - t * t);
  Q.col(6) = 0.5 * (1 - s * s) * (1 + t);
  Q.col(7) = 0.5 * (1 - s) * (1 - t * t);
  for (int a = 0; a < 4; ++a) Q.col(a) = N.col(a) - 0.5 * (Q.col(4 + a) + Q.col(4 + (a + 3) % 4));
  if (!centre) return Q;
  Q.col(8) = (1 - s * s) * (1 - t * t);
  for (int a = 0; a < 4; ++a) {
    Q.col(a) += 0.25 * Q.col(8);
    Q.col(4 + a) -= 0.5 * Q.col(8);
  }
  return Q;
}

void add_products(const Shapes& weighted, const Shapes& corners, const FlatFace& face,
                  CornerByNode& sum) {
  if (face.order != FaceOrder::linear) {
    const NodeShapes nodes =
        quadratic_shapes(face.triangle, face.order == FaceOrder::biquadratic, corners);
    sum += weighted.matrix().transpose().lazyProduct(nodes.matrix());
  } else {
    sum.leftCols<4>() += weighted.matrix().transpose().lazyProduct(corners.matrix());
  }
}

// Two overlapping pieces and their faces.
struct Overlap {
  const FlatFace &slave_face, &master_face;
  const FacePiece &slave, &master;
  const Polygon& shared;
};

// Adds the integrals over a batch of points with weights w.
void add_batch(const Overlap& of, const Batch& x, const Batch& y, const Batch& w,
               Segment& segment) {
  Shapes of_slave, of_master;
  shape_functions(of.slave, x, y, of_slave);
  shape_functions(of.master, x, y, of_master);
  const Shapes weighted = of_slave.colwise() * w;
  add_products(weighted, of_slave, of.slave_face, segment.D);
  add_products(weighted, of_master, of.master_face, segment.M);
  segment.area += w.sum();
}

void add_polygon(const Overlap& of, double sliver, Segment& segment) {
  const Polygon& shared = of.shared;
  Batch x(shared.n), y(shared.n), w;
  for (int i = 0; i < shared.n; ++i) {
    x[i] = shared.x[i][0];
    y[i] = shared.x[i][1];
  }
  // Six points are exact to degree 4, n on a line to 2 n - 1. A second-order face has degree 3,
  // with a central node 4
  const FaceOrder order = std::max(of.slave_face.order, of.master_face.order);
  constexpr std::array<int, 3> degrees{3, 5, 6}, least{0, 3, 4};
  const auto of_order = static_cast<std::size_t>(order);
  const double rate = std::min(convergence(of.slave, x, y), convergence(of.master, x, y));
  const int n_line = std::max(least[of_order], line_points(rate, degrees[of_order]));
  const auto& points = triangle_points(n_line);
  const Index n_points = static_cast<Index>(points.size());
  x.resize(capacity);
  y.resize(capacity);
  w.resize(capacity);
  Index n = 0;
  const auto flush = [&] {
    if (n > 0) add_batch(of, x.head(n), y.head(n), w.head(n), segment);
    n = 0;
  };
  for (int i = 2; i < shared.n; ++i) {
    const Vector2 &origin = shared.x[0], u = shared.x[i - 1] - origin, v = shared.x[i] - origin;
    const double size = 0.5 * cross(u, v);
    if (!(size > sliver)) continue;
    if (n + n_points > capacity) flush();
    for (const TrianglePoint& q : points) {
      x[n] = origin[0] + q.s * u[0] + q.t * v[0];
      y[n] = origin[1] + q.s * u[1] + q.t * v[1];
      w[n++] = q.weight * size;
    }
  }
  flush();
}

}  // namespace

double area(const Polygon& polygon) {
  double twice = 0;
  for (int i = 2; i < polygon.n; ++i)
    twice += cross(polygon.x[i - 1] - polygon.x[0], polygon.x[i] - polygon.x[0]);
  return 0.5 * twice;
}

Polygon clip(const Polygon& a, const Polygon& b) {
  assert(a.n + b.n <= 12);
  Polygon result = a;
  for (int i = 0; i < b.n && result.n >= 3; ++i)
    keep_left(b.x[i], b.x[i + 1 < b.n ? i + 1 : 0], result);
  return result;
}

FlatFace flatten(const FaceCorners& corners, bool triangle, const Matrix3& frame,
                 const Vector3& origin, bool counter_clockwise) {
  std::array<Vector2, 4> x;
  for (int a = 0; a < 4; ++a) x[a] = frame.bottomRows<2>() * (corners[a] - origin);
  FlatFace face;
  face.triangle = triangle;
  const auto add = [&](FacePiece piece) {
    if (complete(x, counter_clockwise, piece)) face.pieces[face.n_pieces++] = piece;
  };
  if (triangle) {
    add(triangle_piece(x, 0, 1, 2));
    return face;
  }
  const FacePiece quad = quad_piece(x);
  // Near the limit of convexity the inverse map loses accuracy
  const double J0 = std::abs(cross(quad.a, quad.b)),
               J1 = std::abs(cross(quad.a, quad.w)) + std::abs(cross(quad.w, quad.b));
  if (J1 < 0.95 * J0) {
    add(quad);
    return face;
  }
  // Splits along the diagonal with the more similar triangles. At a concave corner it is the inner
  // one
  const auto signed_area = [&](int i, int j, int k) {
    return cross(x[j] - x[i], x[k] - x[i]) * (counter_clockwise ? 1 : -1);
  };
  const double first = std::min(signed_area(0, 1, 2), signed_area(0, 2, 3));
  const double second = std::min(signed_area(0, 1, 3), signed_area(1, 2, 3));
  if (first >= second) {
    add(triangle_piece(x, 0, 1, 2));
    add(triangle_piece(x, 0, 2, 3));
  } else {
    add(triangle_piece(x, 0, 1, 3));
    add(triangle_piece(x, 1, 2, 3));
  }
  return face;
}

Segment integrate(const FlatFace& slave, const FlatFace& master, double sliver) {
  Segment segment;
  for (int i = 0; i < slave.n_pieces; ++i) {
    for (int j = 0; j < master.n_pieces; ++j) {
      const FacePiece &s = slave.pieces[i], &m = master.pieces[j];
      const double smallest = sliver * std::min(s.area, m.area);
      const Polygon shared = clip(s.outline, m.outline);
      if (shared.n >= 3 && area(shared) > smallest)
        add_polygon({slave, master, s, m, shared}, 1e-3 * smallest, segment);
    }
  }
  return segment;
}

}  // namespace cbr
