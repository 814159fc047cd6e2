// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/cone/interior_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cbr {
namespace {

constexpr int most_steps_of_path = 60, most_idle_steps = 15;
// stands in for what is singular among tied rows; each step takes it back
constexpr double tied_shift = 1e-8;
constexpr double least_centring = 0.01, short_step = 0.2, shortest_move = 1e-8, damping = 0.1;
constexpr double end_of_path = 1e-17;
// scaled cones below lose all digits; proximal Newton takes the true one
constexpr double least_friction = 1e-6;

Vector3 reflected(const Vector3& x) { return {x[0], -x[1], -x[2]}; }

double determinant(const Vector3& x) {
  const double length = std::hypot(x[1], x[2]);
  return (x[0] - length) * (x[0] + length);
}

bool inside(const Vector3& x) { return x[0] > std::hypot(x[1], x[2]); }

Vector3 jordan_product(const Vector3& a, const Vector3& b) {
  return {a.dot(b), a[0] * b[1] + b[0] * a[1], a[0] * b[2] + b[0] * a[2]};
}

// y with a o y = b.
Vector3 jordan_quotient(const Vector3& b, const Vector3& a) {
  const double first = (a[0] * b[0] - a[1] * b[1] - a[2] * b[2]) / determinant(a);
  return {first, (b[1] - first * a[1]) / a[0], (b[2] - first * a[2]) / a[0]};
}

// Largest t up to which x + t d stays in the cone.
double way_out(const Vector3& x, const Vector3& d) {
  const double a = d[0] * d[0] - d[1] * d[1] - d[2] * d[2],
               b = x[0] * d[0] - x[1] * d[1] - x[2] * d[2], c = determinant(x);
  double t = d[0] < 0 ? -x[0] / d[0] : std::numeric_limits<double>::infinity();
  const double under = b * b - a * c;
  if (!(under >= 0)) return t;
  const double q = -(b + std::copysign(std::sqrt(under), b));
  for (const double root : {a != 0 ? q / a : 0.0, q != 0 ? c / q : 0.0})
    if (root > 0) t = std::min(t, root);
  return t;
}

// W = eta V, W x = W^-1 z = lambda, of one point.
struct Scaling {
  double eta = 1;
  Vector3 w = Vector3::UnitX(), lambda = Vector3::UnitX();

  Scaling() = default;
  Scaling(const Vector3& x, const Vector3& z) {
    const double dx = determinant(x), dz = determinant(z);
    const Vector3 xb = x / std::sqrt(dx), zb = z / std::sqrt(dz);
    w = (zb + reflected(xb)) / (2 * std::sqrt((1 + xb.dot(zb)) / 2));
    eta = std::sqrt(std::sqrt(dz / dx));
    lambda = apply(x);
  }
  // V x, V = [w_0, w_t^T; w_t, I + w_t w_t^T / (1 + w_0)]
  Vector3 turned(const Vector3& x) const {
    const double dot = w[1] * x[1] + w[2] * x[2], share = x[0] + dot / (1 + w[0]);
    return {w[0] * x[0] + dot, x[1] + share * w[1], x[2] + share * w[2]};
  }
  Vector3 apply(const Vector3& x) const { return eta * turned(x); }
  Vector3 inverse(const Vector3& x) const { return reflected(turned(reflected(x))) / eta; }
  // W^-2
  Matrix3 inverse_square() const {
    const Vector3 v = reflected(w);
    Matrix3 M = 2 * v * v.transpose();
    M(0, 0) -= 1;
    M(1, 1) += 1;
    M(2, 2) += 1;
    return M / (eta * eta);
  }
};

class Path {
 public:
  Path(const ConeProblem& cones, const ConeGaps& gaps)
      : cones_(cones), gaps_(gaps), n_(cones.n_points()), H_(n_), J_(n_), M_(n_), scaling_(n_) {
    x_.setZero(n_, 3);
    z_.setZero(n_, 3);
    u_.setZero(n_, 3);
    left_.setZero(n_, 3);
    for (Index i = 0; i < n_; ++i) {
      if (!cone(i)) continue;
      x_(i, 0) = friction(i) / std::sqrt(static_cast<double>(n_));
      z_(i, 0) = 1;
      ++n_cones_;
    }
    y_ = cones_.L.transpose() * flat(impulses());
  }

  Points impulses() const {
    Points p = x_;
    for (Index i = 0; i < n_; ++i)
      if (cone(i)) p(i, 0) /= friction(i);
    return p;
  }
  double complementarity() const {
    return n_cones_ > 0 ? x_.cwiseProduct(z_).sum() / static_cast<double>(n_cones_) : 0.0;
  }

  // False when it cannot go on.
  bool step() {
    linearise();
    const ConeSystem system(cones_, H_);
    if (!system.ok()) return false;
    const double tau = complementarity();
    Points target(n_, 3);  // lambda \ right-hand side
    for (Index i = 0; i < n_; ++i) target.row(i) = -scaling_[i].lambda.transpose();
    if (!direct(system, target)) return false;
    const double t = longest();
    const double ahead = (x_ + t * dx_).cwiseProduct(z_ + t * dz_).sum() /
                         std::max<double>(1.0, static_cast<double>(n_cones_));
    double centring =
        std::max(least_centring, std::pow(std::clamp(tau > 0 ? ahead / tau : 0.0, 0.0, 1.0), 3));
    const bool centre = last_ < short_step;
    if (centre) centring = last_ < short_step / 4 ? 1.0 : 0.5;
    for (Index i = 0; i < n_; ++i) {
      if (!cone(i)) continue;
      const Scaling& s = scaling_[i];
      Vector3 wanted = -jordan_product(s.lambda, s.lambda);
      if (!centre) wanted -= jordan_product(s.apply(dx_.row(i)), s.inverse(dz_.row(i)));
      wanted[0] += centring * tau;
      target.row(i) = jordan_quotient(wanted, s.lambda).transpose();
    }
    if (!direct(system, target)) return false;
    return advance(tau);
  }

 private:
  bool cone(Index i) const { return cones_.tied[i] == 0 && cones_.moves[i] != 0; }
  double friction(Index i) const { return std::max(cones_.friction[i], least_friction); }
  static Eigen::Map<const Vector> flat(const Points& p) { return {p.data(), p.size()}; }

  // u = g + L y, what is left of z = (u_n / mu + |u_t|, u_t), and H of dp = b - H L dy.
  void linearise() {
    u_ = gaps_.g;
    Eigen::Map<Vector>(u_.data(), u_.size()) += cones_.L * y_;
    const double tau = complementarity();
    for (Index i = 0; i < n_; ++i) {
      H_[i].setZero();
      J_[i].setZero();
      M_[i].setZero();
      if (cones_.tied[i] != 0 && cones_.moves[i] != 0) H_[i].diagonal().setConstant(1 / tied_shift);
      if (!cone(i)) continue;
      const double mu = friction(i), slip = std::hypot(u_(i, 1), u_(i, 2));
      J_[i].diagonal() << 1 / mu, 1, 1;
      // Not where slip is small beside what complementarity is left
      if (slip > 0)
        J_[i].row(0).tail<2>() =
            slip / (slip * slip + damping * damping * tau) * u_.row(i).tail<2>();
      left_.row(i) << z_(i, 0) - u_(i, 0) / mu - slip, z_(i, 1) - u_(i, 1), z_(i, 2) - u_(i, 2);
      scaling_[i] = Scaling(x_.row(i), z_.row(i));
      M_[i] = scaling_[i].inverse_square();
      H_[i] = M_[i] * J_[i];
      H_[i].row(0) /= mu;
    }
  }

  // dx, dz, dy of the right-hand side lambda \ (lambda o (W dx + W^-1 dz)) = `target`.
  bool direct(const ConeSystem& system, const Points& target) {
    Points b = Points::Zero(n_, 3);
    for (Index i = 0; i < n_; ++i) {
      if (cones_.tied[i] != 0 && cones_.moves[i] != 0) b.row(i) = -u_.row(i) / tied_shift;
      if (!cone(i)) continue;
      b.row(i) = M_[i] * (scaling_[i].apply(target.row(i)) + left_.row(i).transpose());
    }
    dx_ = b;  // of cones: before division by mu
    for (Index i = 0; i < n_; ++i)
      if (cone(i)) b(i, 0) /= friction(i);
    dy_ = system.solve(b, y_ - cones_.L.transpose() * flat(impulses()));
    if (!dy_.allFinite()) return false;
    const Vector du = cones_.L * dy_;
    dz_.setZero(n_, 3);
    for (Index i = 0; i < n_; ++i) {
      const Vector3 d = du.segment<3>(3 * i);
      if (!cone(i)) {
        dx_.row(i) -= (H_[i] * d).transpose();
        continue;
      }
      const Vector3 Jd = J_[i] * d;
      dx_.row(i) -= (M_[i] * Jd).transpose();
      dz_.row(i) = Jd.transpose() - left_.row(i);
    }
    return dx_.allFinite() && dz_.allFinite();
  }

  double longest() const {
    double t = std::numeric_limits<double>::infinity();
    for (Index i = 0; i < n_; ++i)
      if (cone(i))
        t = std::min({t, way_out(x_.row(i), dx_.row(i)), way_out(z_.row(i), dz_.row(i))});
    return std::min(1.0, t);
  }

  bool advance(double tau) {
    double t = longest();
    if (t < 1) t *= tau < 1e-3 ? 0.99 : 0.95;
    const auto stays = [&](double s) {
      for (Index i = 0; i < n_; ++i)
        if (cone(i) && !(inside(x_.row(i) + s * dx_.row(i)) && inside(z_.row(i) + s * dz_.row(i))))
          return false;
      return true;
    };
    while (t > shortest_move && !stays(t)) t *= 0.9;
    if (!(t > shortest_move)) return false;
    x_ += t * dx_;
    z_ += t * dz_;
    y_ += t * dy_;
    last_ = t;
    return true;
  }

  const ConeProblem& cones_;
  const ConeGaps& gaps_;
  Index n_, n_cones_ = 0;
  Points x_, z_, u_, left_, dx_, dz_;
  Vector y_, dy_;
  std::vector<Matrix3> H_, J_, M_;
  std::vector<Scaling> scaling_;
  double last_ = 1;
};

}  // namespace

InteriorPoint interior_point(const ConeProblem& cones, const ConeGaps& gaps, double tolerance) {
  Path path(cones, gaps);
  InteriorPoint result;
  result.p.setZero(cones.n_points(), 3);
  result.violation = violation(cones, gaps, result.p);
  int idle = 0;
  while (result.steps < most_steps_of_path && idle < most_idle_steps) {
    ++result.steps;
    ++idle;
    if (!path.step()) break;
    Points p = path.impulses();
    const double now = violation(cones, gaps, p);
    if (now < result.violation) {
      result.p = std::move(p);
      result.violation = now;
      idle = 0;
    }
    if (now <= tolerance || !(path.complementarity() > end_of_path)) break;
  }
  return result;
}

}  // namespace cbr
