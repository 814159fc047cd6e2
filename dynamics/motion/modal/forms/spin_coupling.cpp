// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/spin_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace cbr {

Vector centrifugal(const Vector3& w) {
  const double ww = w.squaredNorm();
  Vector g(6);
  g << ww - w[0] * w[0], ww - w[1] * w[1], ww - w[2] * w[2], -2 * w[0] * w[1], -2 * w[1] * w[2],
      -2 * w[0] * w[2];
  return g;
}

namespace {

// A^T x: of matrices that are A or -A themselves, and too small for BLAS.
auto by_columns(const Matrix& A, const auto& x) { return A.transpose().lazyProduct(x); }

}  // namespace

SpinCoupling::SpinCoupling(const Matrix& P, Index n_rigid, Index n) : first_(n_rigid) {
  const Index m = std::min(P.rows() / 3, n - n_rigid);
  const auto part = [&](Index a, Index b) -> Matrix {
    return P(Eigen::seqN(a, m, 3), Eigen::seqN(b, m, 3));
  };
  for (Index a = 0; a < 3; ++a) {
    const Index b = (a + 1) % 3, c = (a + 2) % 3;
    const auto i = static_cast<std::size_t>(a);
    G_[i] = part(b, c) - part(c, b);
    P_[i] = part(a, a);
    P_[i + 3] = 0.5 * (part(a, b) + part(b, a));
  }
}

Matrix SpinCoupling::drift(const Vector& eta) const {
  Matrix drift(size(), 3);
  for (Index a = 0; a < 3; ++a) drift.col(a) = -by_columns(G_[a], eta.segment(first_, size()));
  return drift;
}

SpinCoupling::Shape SpinCoupling::shape(const Vector& eta, const Vector& p) const {
  Shape shape;
  shape.drift = drift(eta);
  shape.momentum = momentum(shape.drift, p);
  const auto e = eta.segment(first_, size());
  std::array<double, 6> s;
  for (std::size_t i = 0; i < 6; ++i) s[i] = e.dot(by_columns(P_[i], e));
  Matrix3 S;
  S << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  shape.inertia = S.trace() * Matrix3::Identity() - S - shape.drift.transpose() * shape.drift;
  return shape;
}

SpinCoupling::Pull SpinCoupling::pull(const Vector3& w) const {
  Pull pull;
  pull.w = w.norm();
  pull.G = w[0] * G_[0] + w[1] * G_[1] + w[2] * G_[2];
  const Vector g = centrifugal(w);
  pull.C = g[0] * P_[0] + g[1] * P_[1] + g[2] * P_[2] + g[3] * P_[3] + g[4] * P_[4] + g[5] * P_[5];
  return pull;
}

// Taylor series: |G| <= |w|, and |C + G^2| <= |w|^2.
void SpinCoupling::move(const Pull& pull, double time, const Vector& damping, Vector& eta,
                        Vector& p) const {
  constexpr double round_off = 1e-16;
  constexpr int most_terms = 60;  // of turns up to 10 rad
  const double x = pull.w * std::abs(time);
  Matrix now(size(), 2), next(size(), 2);
  now << eta.segment(first_, size()), p.segment(first_, size());
  double left = x;  // |next term|
  for (int n = 1; left > round_off && n < most_terms; ++n) {
    const double share = time / n;
    next = -share * by_columns(pull.G, now);
    next.col(1) -= by_columns(pull.G, next.col(0));
    next.col(1) += share * by_columns(pull.C, now.col(0));
    if (damping.size() > 0)
      next.col(1).array() -= damping.segment(first_, size()).array() * next.col(0).array();
    eta.segment(first_, size()) += next.col(0);
    p.segment(first_, size()) += next.col(1);
    now.swap(next);
    left *= x / (n + 1);
  }
}

}  // namespace cbr
