// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_oracle.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "dynamics/bodies/body.hpp"
#include "reducer/reduce.hpp"

namespace cbr::test {
namespace {

using Dense = Eigen::MatrixXd;

Matrix chosen(const Matrix& A, const std::vector<Index>& rows, const std::vector<Index>& columns) { return A(rows, columns); }

// Murty's principal pivoting: 0 <= p, 0 <= g + W p, p . (g + W p) = 0. One choice at a time, the first that is wrong; finite when W
// is positive definite.
Vector complementary(const Matrix& W, const Vector& g) {
  const Index n = g.size();
  const double tolerance = 1e-14 * g.cwiseAbs().maxCoeff();
  std::vector<char> active(static_cast<std::size_t>(n), 0);
  for (Index round = 0; round < 10000; ++round) {
    std::vector<Index> in;
    for (Index i = 0; i < n; ++i)
      if (active[static_cast<std::size_t>(i)]) in.push_back(i);
    Vector p = Vector::Zero(n);
    if (!in.empty()) p(in) = -chosen(W, in, in).ldlt().solve(Vector(g(in)));
    const Vector gap = g + W * p;
    Index wrong = -1;
    for (Index i = 0; i < n && wrong < 0; ++i)
      if (active[static_cast<std::size_t>(i)] ? p[i] < 0 : gap[i] < -tolerance) wrong = i;
    if (wrong < 0) return p;
    active[static_cast<std::size_t>(wrong)] ^= 1;
  }
  throw std::runtime_error("the oracle's complementarity problem is not solved");
}

// One mode under loads that are linear in time, from t over s: (eta, v) in place.
void swing(double omega, double f0, double f1, double s, double& eta, double& v) {
  const double eta0 = eta, v0 = v;
  if (omega == 0) {
    eta = eta0 + s * (v0 + s * (f0 / 2 + s * f1 / 6));
    v = v0 + s * (f0 + s * f1 / 2);
    return;
  }
  const double w2 = omega * omega, c = std::cos(omega * s), sn = std::sin(omega * s), a = eta0 - f0 / w2, b = v0 - f1 / w2;
  eta = (f0 + f1 * s) / w2 + a * c + b * sn / omega;
  v = f1 / w2 - omega * a * sn + b * c;
}

class Stepper {
 public:
  Stepper(const DenseBody& body, double h)
      : body_(body),
        h_(h),
        modes_(dense_modes(body.K, body.M)),
        inverse_(body.M.llt()),
        W_(dense_response(body, h)),
        q_(Vector::Zero(body.K.rows())),
        v_(body.velocity) {
    omega_ = modes_.lambda.cwiseSqrt();
    a_ = acceleration(0);
    if (body.scheme == DenseBody::Scheme::central) v_ -= 0.5 * h * a_;
  }

  Vector3 step() {
    const Vector before = q_, v_before = v_;
    advance(Vector::Zero(q_.size()));
    const Index m = static_cast<Index>(body_.slave.size());
    Vector p = Vector::Zero(m);
    if (m > 0) {
      Matrix G = Matrix::Zero(m, body_.B.rows());  // m x 3 n
      for (Index i = 0; i < m; ++i) G.block(i, 3 * body_.slave[static_cast<std::size_t>(i)], 1, 3) = body_.normal.transpose();
      const Vector x = body_.X.reshaped<Eigen::RowMajor>() + body_.B * q_;
      p = complementary(G * W_ * G.transpose(), (G * x).array() - body_.offset);
      if (!p.isZero(0)) {
        q_ = before, v_ = v_before;
        advance(body_.B.transpose() * (G.transpose() * p));
      }
    }
    t_ += h_;
    if (body_.scheme == DenseBody::Scheme::central) a_ = acceleration(t_);
    return p.sum() * body_.normal;
  }

  Matrix positions() const { return body_.X + (body_.B * q_).reshaped<Eigen::RowMajor>(body_.X.rows(), 3); }

 private:
  Vector force(double t) const {
    Vector f = Vector::Zero(q_.size());
    for (std::size_t i = 0; i < body_.load.size(); ++i) f += value(body_.history[i], t) * body_.load[i];
    return f;
  }
  static double value(const History& history, double t) {
    const auto &x = history.time, &y = history.value;
    if (x.empty()) return 1;
    if (t <= x.front()) return y.front();
    for (std::size_t i = 1; i < x.size(); ++i)
      if (t <= x[i]) return y[i - 1] + (y[i] - y[i - 1]) * (t - x[i - 1]) / (x[i] - x[i - 1]);
    return y.back();
  }
  Vector acceleration(double t) const { return inverse_.solve(Vector(force(t) - body_.K * q_)); }

  // From t to t + h with an impulse at the start.
  void advance(const Vector& impulse) {
    switch (body_.scheme) {
      case DenseBody::Scheme::exact:
        return advance_exactly(impulse);
      case DenseBody::Scheme::central:
        v_ += h_ * a_ + inverse_.solve(impulse);
        q_ += h_ * v_;
        return;
      case DenseBody::Scheme::newmark: {  // average acceleration, impulse not expected
        const Matrix A = body_.M + 0.25 * h_ * h_ * body_.K;
        const Vector guess = q_ + h_ * v_ + 0.25 * h_ * h_ * a_;
        const Vector next = A.llt().solve(Vector(force(t_ + h_) - body_.K * guess));
        q_ = guess + 0.25 * h_ * h_ * next;
        v_ += 0.5 * h_ * (a_ + next);
        a_ = next;
      }
    }
  }

  void advance_exactly(const Vector& impulse) {
    const Matrix VtM = modes_.V.transpose() * body_.M;
    Vector eta = VtM * q_, v = VtM * v_;
    Vector kick = modes_.V.transpose() * impulse;
    if (body_.lasting)
      for (Index j = 0; j < kick.size(); ++j)
        if (const double x = 0.5 * omega_[j] * h_; x > 0) kick[j] *= std::tan(x) / x;
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
      const Vector f0 = modes_.V.transpose() * force(cuts[i - 1]), f1 = (modes_.V.transpose() * force(cuts[i]) - f0) / s;
      for (Index j = 0; j < eta.size(); ++j) swing(omega_[j], f0[j], f1[j], s, eta[j], v[j]);
    }
    q_ = modes_.V * eta, v_ = modes_.V * v;
  }

  const DenseBody& body_;
  double h_, t_ = 0;
  DenseModes modes_;
  Vector omega_;
  Eigen::LLT<Dense> inverse_;
  Matrix W_;
  Vector q_, v_, a_;
};

}  // namespace

DenseModel dense_model(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass) {
  DenseModel model;
  std::vector<Index> place(static_cast<std::size_t>(mesh.coordinates.rows()), -1);
  for (const Block& block : mesh.blocks)
    for (Index i = 0; i < block.connectivity.size(); ++i) place[static_cast<std::size_t>(block.connectivity.data()[i])] = 0;
  for (std::size_t i = 0; i < place.size(); ++i)
    if (place[i] == 0) place[i] = static_cast<Index>(model.nodes.size()), model.nodes.push_back(static_cast<Index>(i));
  const Index n = 3 * static_cast<Index>(model.nodes.size());
  model.K = model.M = Matrix::Zero(n, n);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const std::vector<Index> nodes(block.connectivity.row(e).begin(), block.connectivity.row(e).end());
      const Points X = mesh.coordinates(nodes, Eigen::all);
      const Matrix K = element_stiffness(block.type, properties[b].hex8, X, properties[b].material);
      const Matrix M = mass == MassKind::lumped
                           ? Matrix(element_lumped_mass(block.type, X, properties[b].material.density).asDiagonal())
                           : element_mass(block.type, X, properties[b].material.density);
      for (Index i = 0; i < X.rows(); ++i)
        for (Index j = 0; j < X.rows(); ++j) {
          const Index row = 3 * place[static_cast<std::size_t>(nodes[i])], column = 3 * place[static_cast<std::size_t>(nodes[j])];
          model.K.block<3, 3>(row, column) += K.block<3, 3>(3 * i, 3 * j);
          model.M.block<3, 3>(row, column) += M(i, j) * Matrix3::Identity();
        }
    }
  }
  return model;
}

DenseModes dense_modes(const Matrix& K, const Matrix& M) {
  if (K.rows() == 0) return {};
  const Eigen::GeneralizedSelfAdjointEigenSolver<Dense> solver(K, M);
  DenseModes modes{solver.eigenvalues(), solver.eigenvectors()};
  const double largest = modes.lambda.maxCoeff();
  for (double& lambda : modes.lambda)
    if (lambda < 1e-10 * largest) lambda = 0;
  return modes;
}

Matrix DenseReduction::K() const {
  const Index k = eigenvalues.size(), c = K_cc.rows();
  Matrix A = Matrix::Zero(k + c, k + c);
  A.topLeftCorner(k, k) = eigenvalues.asDiagonal();
  A.bottomRightCorner(c, c) = K_cc;
  return A;
}

Matrix DenseReduction::M() const {
  const Index k = eigenvalues.size(), c = K_cc.rows();
  Matrix A(k + c, k + c);
  A.topLeftCorner(k, k).setIdentity();
  A.topRightCorner(k, c) = M_kc;
  A.bottomLeftCorner(c, k) = M_kc.transpose();
  A.bottomRightCorner(c, c) = M_cc;
  return A;
}

DenseReduction dense_reduction(const DenseModel& model, const std::vector<Index>& interface, Index k, const std::string& pick) {
  std::vector<char> kept(static_cast<std::size_t>(model.K.rows()), 0);
  for (const Index dof : interface) kept[static_cast<std::size_t>(dof)] = 1;
  std::vector<Index> interior;
  for (Index i = 0; i < model.K.rows(); ++i)
    if (!kept[static_cast<std::size_t>(i)]) interior.push_back(i);
  const Index n_I = static_cast<Index>(interior.size()), c = static_cast<Index>(interface.size());
  const DenseModes modes = dense_modes(chosen(model.K, interior, interior), chosen(model.M, interior, interior));
  // T = [Phi Psi; 0 I] over all fixed-interface modes, then those that are kept
  Matrix T = Matrix::Zero(model.K.rows(), n_I + c);
  if (n_I > 0) {
    T(interior, Eigen::seqN(0, n_I)) = modes.V;
    T(interior, Eigen::seqN(n_I, c)) =
        -chosen(model.K, interior, interior).ldlt().solve(Dense(chosen(model.K, interior, interface)));
  }
  for (Index i = 0; i < c; ++i) T(interface[static_cast<std::size_t>(i)], n_I + i) = 1;
  const Matrix K = T.transpose() * model.K * T, M = T.transpose() * model.M * T;
  std::vector<Index> order(static_cast<std::size_t>(n_I));
  std::iota(order.begin(), order.end(), Index{0});
  DenseReduction reduced;
  reduced.gap = 1;
  if (pick == "participation" && k < n_I) {
    const Index candidates = n_mode_candidates(pick, k, n_I);
    if (candidates > 0 && candidates < n_I) {
      const double last = modes.lambda[candidates - 1], next = modes.lambda[candidates];
      reduced.gap = (next - last) / next;
    }
    const Vector share = M.topRightCorner(n_I, c).rowwise().squaredNorm();
    std::sort(order.begin(), order.begin() + candidates, [&](Index i, Index j) { return share[i] > share[j]; });
    if (k > 0 && k < candidates) reduced.gap = std::min(reduced.gap, 1 - share[order[k]] / share[order[k - 1]]);
    std::sort(order.begin(), order.begin() + k);
  } else if (k > 0 && k < n_I) {
    reduced.gap = (modes.lambda[k] - modes.lambda[k - 1]) / modes.lambda[k];
  }
  order.resize(static_cast<std::size_t>(k));
  reduced.eigenvalues = modes.lambda(order);
  reduced.M_kc = Matrix(M.topRightCorner(n_I, c))(order, Eigen::all);
  reduced.K_cc = K.bottomRightCorner(c, c), reduced.M_cc = M.bottomRightCorner(c, c);
  return reduced;
}

Matrix dense_response(const DenseBody& body, double h) {
  Matrix S;  // q x q
  if (body.scheme == DenseBody::Scheme::central) {
    S = h * body.M.llt().solve(Dense::Identity(body.M.rows(), body.M.rows()));
  } else if (body.scheme == DenseBody::Scheme::newmark) {
    S = 0.5 * h * Matrix(body.M + 0.25 * h * h * body.K).llt().solve(Dense::Identity(body.M.rows(), body.M.rows()));
  } else {
    const DenseModes modes = dense_modes(body.K, body.M);
    Vector s(modes.lambda.size());
    for (Index j = 0; j < s.size(); ++j) {
      const double omega = std::sqrt(modes.lambda[j]), x = 0.5 * omega * h;
      s[j] = omega > 0 ? std::sin(omega * h) / omega : h;
      if (body.lasting && x > 0) s[j] *= std::tan(x) / x;
    }
    S = modes.V * s.asDiagonal() * modes.V.transpose();
  }
  return body.B * S * body.B.transpose();
}

DenseMotion dense_motion(const DenseBody& body, double h, Index n_outputs, Index steps_per_output) {
  Stepper stepper(body, h);
  DenseMotion motion{{stepper.positions()}, {Vector3::Zero()}};
  for (Index output = 1; output < n_outputs; ++output) {
    Vector3 impulse = Vector3::Zero();
    for (Index i = 0; i < steps_per_output; ++i) impulse += stepper.step();
    motion.x.push_back(stepper.positions());
    motion.impulse.push_back(impulse);
  }
  return motion;
}

}  // namespace cbr::test
