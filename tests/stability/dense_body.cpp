// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_body.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/dense.hpp"

namespace cbr::test {
namespace {

using Scheme = DenseBody::Scheme;

// One mode under loads that are linear in time, from t over s: (eta, v) in place.
void swing(double omega, double f0, double f1, double s, double& eta, double& v) {
  const double eta0 = eta, v0 = v;
  if (omega == 0) {
    eta = eta0 + s * (v0 + s * (f0 / 2 + s * f1 / 6));
    v = v0 + s * (f0 + s * f1 / 2);
    return;
  }
  const double w2 = omega * omega, c = std::cos(omega * s), sn = std::sin(omega * s),
               a = eta0 - f0 / w2, b = v0 - f1 / w2;
  eta = (f0 + f1 * s) / w2 + a * c + b * sn / omega;
  v = f1 / w2 - omega * a * sn + b * c;
}

double value(const History& history, double t) {
  const auto &x = history.time, &y = history.value;
  if (x.empty()) return 1;
  if (t <= x.front()) return y.front();
  for (std::size_t i = 1; i < x.size(); ++i)
    if (t <= x[i]) return y[i - 1] + (y[i] - y[i - 1]) * (t - x[i - 1]) / (x[i] - x[i - 1]);
  return y.back();
}

}  // namespace

DenseMotionModes dense_motion_modes(const DenseBody& body) {
  const DenseModes modes = dense_modes(body.K, body.M);
  return {modes.lambda.cwiseSqrt(), modes.V, modes.V.transpose() * body.M};
}

Matrix dense_response(const DenseBody& body, double h) {
  Matrix S;  // q x q
  if (body.scheme == Scheme::central) {
    S = h * Cholesky(body.M).solve(Matrix::Identity(body.M.rows(), body.M.rows()));
  } else if (body.scheme == Scheme::newmark) {
    S = 0.5 * h *
        Cholesky(body.M + 0.25 * h * h * body.K)
            .solve(Matrix::Identity(body.M.rows(), body.M.rows()));
  } else {
    const DenseMotionModes modes = dense_motion_modes(body);
    Vector s(modes.omega.size());
    for (Index j = 0; j < s.size(); ++j) {
      const double omega = modes.omega[j], x = 0.5 * omega * h;
      s[j] = omega > 0 ? std::sin(omega * h) / omega : h;
      if (body.lasting && x > 0) s[j] *= std::tan(x) / x;
    }
    S = modes.V * s.asDiagonal() * modes.V.transpose();
  }
  return body.B * S * body.B.transpose();
}

DenseStepper::DenseStepper(const DenseBody& body, double h)
    : body_(body),
      h_(h),
      modes_(dense_motion_modes(body)),
      inverse_(body.M),
      inverse_A_(body.M + 0.25 * h * h * body.K),
      W_(dense_response(body, h)),
      q_(Vector::Zero(body.K.rows())),
      v_(body.velocity) {
  a_ = inverse_.solve(force(0));
  if (body.scheme == Scheme::central) v_ -= 0.5 * h * a_;
  start_ = end_ = positions(q_);
}

Vector DenseStepper::force(double t) const {
  Vector f = Vector::Zero(body_.K.rows());
  for (std::size_t i = 0; i < body_.load.size(); ++i)
    f += value(body_.history[i], t) * body_.load[i];
  return f;
}

void DenseStepper::predict() {
  q0_ = q_;
  v0_ = v_;
  a0_ = a_;
  start_ = positions(q_);
  impulse_ = Vector::Zero(q_.size());
  advance();
}

void DenseStepper::push(const Vector& impulse) {
  impulse_ += body_.B.transpose() * impulse;
  advance();
}

void DenseStepper::push_velocities(const Vector& impulse) {
  v_ += inverse_.solve(Vector(body_.B.transpose() * impulse));
}

void DenseStepper::accept() {
  t_ += h_;
  if (body_.scheme == Scheme::central) a_ = inverse_.solve(Vector(force(t_) - body_.K * q_));
}

void DenseStepper::advance() {
  switch (body_.scheme) {
    case Scheme::exact:
      advance_exactly(impulse_);
      break;
    case Scheme::central:
      v_ = v0_ + h_ * a0_ + inverse_.solve(impulse_);
      q_ = q0_ + h_ * v_;
      break;
    case Scheme::newmark: {  // average acceleration; the impulse is no part of the accelerations
      const Vector guess = q0_ + h_ * v0_ + 0.25 * h_ * h_ * a0_;
      q_ = guess + inverse_A_.solve(Vector(0.25 * h_ * h_ * (force(t_ + h_) - body_.K * guess) +
                                           0.5 * h_ * impulse_));
      a_ = inverse_.solve(Vector(force(t_ + h_) - body_.K * q_));
      v_ = 2 / h_ * (q_ - q0_) - v0_;
    }
  }
  end_ = positions(q_);
}

void DenseStepper::advance_exactly(const Vector& impulse) {
  Vector eta = modes_.inverse * q0_, v = modes_.inverse * v0_;
  Vector kick = modes_.V.transpose() * impulse;
  if (body_.lasting)
    for (Index j = 0; j < kick.size(); ++j)
      if (const double x = 0.5 * modes_.omega[j] * h_; x > 0) kick[j] *= std::tan(x) / x;
  v += kick;
  std::vector<double> cuts{t_, t_ + h_};
  for (const History& history : body_.history)
    for (const double t : history.time)
      if (t > t_ && t < t_ + h_) cuts.push_back(t);
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double s = cuts[i] - cuts[i - 1];
    if (s <= 0) continue;
    // Just inside, where histories have corners
    const Vector f0 = modes_.V.transpose() * force(cuts[i - 1]),
                 f1 = (modes_.V.transpose() * force(cuts[i]) - f0) / s;
    for (Index j = 0; j < eta.size(); ++j) swing(modes_.omega[j], f0[j], f1[j], s, eta[j], v[j]);
  }
  q_ = modes_.V * eta;
  v_ = modes_.V * v;
}

}  // namespace cbr::test
