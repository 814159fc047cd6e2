// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/projection.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

// Bilinear map of a quad face, by its two sides and its twist: p(xi, eta) = c + xi a + eta b + xi
// eta w, |xi|, |eta| <= 1
struct BilinearFace {
  Vector3 c, a, b, w;
  explicit BilinearFace(const FaceCorners& x)
      : c((x[0] + x[1] + x[2] + x[3]) / 4),
        a((-x[0] + x[1] + x[2] - x[3]) / 4),
        b((-x[0] - x[1] + x[2] + x[3]) / 4),
        w((x[0] - x[1] + x[2] - x[3]) / 4) {}
  Vector3 at(double xi, double eta) const { return c + xi * a + eta * b + xi * eta * w; }
  Vector3 d_xi(double eta) const { return a + eta * w; }
  Vector3 d_eta(double xi) const { return b + xi * w; }
};

Projection finish(const FaceCorners& corners, const std::array<double, 4>& weights,
                  const Vector3& area_vector, double outside, const Vector3& x) {
  Projection result;
  result.weights = weights;
  result.outside = outside;
  const double area = area_vector.norm();
  if (area > 0) result.normal = area_vector / area;
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += weights[a] * corners[a];
  result.distance = result.normal.dot(x - foot);
  return result;
}

// Closest point of segment ab to x as a fraction of ab.
double along(const Vector3& a, const Vector3& b, const Vector3& x) {
  const double length2 = (b - a).squaredNorm();
  return length2 > 0 ? std::clamp((x - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
}

Projection project_to_triangle(const FaceCorners& corners, const Vector3& x) {
  const Vector3 e1 = corners[1] - corners[0], e2 = corners[2] - corners[0], n = e1.cross(e2);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return finish(corners, {1, 0, 0, 0}, Vector3::Zero(), HUGE_VAL, x);
  const Vector3 d = x - corners[0];
  const double b1 = d.cross(e2).dot(n) / n2, b2 = e1.cross(d).dot(n) / n2, b0 = 1 - b1 - b2;
  const double outside = -std::min({b0, b1, b2});
  if (outside <= 0) return finish(corners, {b0, b1, b2, 0}, n, outside, x);
  std::array<double, 4> weights{};
  double nearest = HUGE_VAL;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double t = along(corners[a], corners[b], x);
    const double distance = (x - (1 - t) * corners[a] - t * corners[b]).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      weights = {};
      weights[a] = 1 - t;
      weights[b] = t;
    }
  }
  return finish(corners, weights, n, outside, x);
}

// Limits a coordinate: beyond the face its exact value does not matter.
double within_reach(double xi) { return std::clamp(xi, -3.0, 3.0); }

// Minimum for a nearly parallelogram face: first order in w.
void guess(const BilinearFace& p, const Vector3& x, double& xi, double& eta) {
  const double h11 = p.a.squaredNorm(), h22 = p.b.squaredNorm(), h12 = p.a.dot(p.b),
               determinant = h11 * h22 - h12 * h12;
  xi = eta = 0;
  if (!(determinant > 1e-10 * h11 * h22)) return;
  const Vector3 d = x - p.c;
  const double inverse = 1 / determinant, da = d.dot(p.a), db = d.dot(p.b), wa = p.w.dot(p.a),
               wb = p.w.dot(p.b);
  xi = within_reach((h22 * da - h12 * db) * inverse);
  eta = within_reach((h11 * db - h12 * da) * inverse);
  const double twist = xi * eta, ea = da - twist * wa, eb = db - twist * wb;
  xi = within_reach((h22 * ea - h12 * eb) * inverse);
  eta = within_reach((h11 * eb - h12 * ea) * inverse);
}

// Minimises |x - p(xi, eta)|^2 in the square |xi|, |eta| <= 3.
void closest_point(const BilinearFace& p, const Vector3& x, double& xi, double& eta) {
  Vector3 r = x - p.at(xi, eta);
  double value = r.squaredNorm();
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vector3 u = p.d_xi(eta), v = p.d_eta(xi);
    const double g1 = -r.dot(u), g2 = -r.dot(v), h11 = u.squaredNorm(), h22 = v.squaredNorm(),
                 gauss = u.dot(v);
    double h12 = gauss - r.dot(p.w), determinant = h11 * h22 - h12 * h12;
    const bool newton = determinant > 1e-10 * h11 * h22;
    if (!newton) {
      h12 = gauss;
      determinant = h11 * h22 - h12 * h12;
    }
    if (!(determinant > 1e-14 * h11 * h22)) return;  // a face without area
    const double s1 = -(h22 * g1 - h12 * g2) / determinant,
                 s2 = -(h11 * g2 - h12 * g1) / determinant;
    // The error after such a Newton step is of the order of its square. It is below the round-off
    // of `value`
    if (newton && std::max(std::abs(s1), std::abs(s2)) < 1e-8) {
      xi = within_reach(xi + s1);
      eta = within_reach(eta + s2);
      return;
    }
    double step = 1, new_xi = xi, new_eta = eta, new_value = value;
    Vector3 new_r = r;
    for (int halving = 0; halving < 12; ++halving, step *= 0.5) {
      new_xi = within_reach(xi + step * s1);
      new_eta = within_reach(eta + step * s2);
      new_r = x - p.at(new_xi, new_eta);
      new_value = new_r.squaredNorm();
      if (new_value <= value) break;
    }
    if (new_value > value) return;
    const double change = std::max(std::abs(new_xi - xi), std::abs(new_eta - eta));
    xi = new_xi;
    eta = new_eta;
    value = new_value;
    r = new_r;
    if (change < 1e-14) return;
  }
}

}  // namespace

Projection project(const FaceCorners& corners, bool triangle, const Vector3& x) {
  if (triangle) return project_to_triangle(corners, x);
  const BilinearFace p(corners);
  double xi, eta;
  guess(p, x, xi, eta);
  closest_point(p, x, xi, eta);
  // xi covers a length of two, so that the fraction of the size is half the excess over 1.
  const double outside = 0.5 * (std::max(std::abs(xi), std::abs(eta)) - 1);
  const double s = std::clamp(xi, -1.0, 1.0), t = std::clamp(eta, -1.0, 1.0);
  const std::array<double, 4> weights{0.25 * (1 - s) * (1 - t), 0.25 * (1 + s) * (1 - t),
                                      0.25 * (1 + s) * (1 + t), 0.25 * (1 - s) * (1 + t)};
  return finish(corners, weights, p.d_xi(t).cross(p.d_eta(s)), outside, x);
}

}  // namespace cbr
