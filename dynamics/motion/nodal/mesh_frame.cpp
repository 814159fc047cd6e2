// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_frame.hpp"

#include <Eigen/LU>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// 2 w of the skew part [w x] of A, as sum Y_i x z_i of A = sum z_i Y_i^T.
Vector3 twist(const Matrix3& A) {
  return {A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)};
}

// sum a_i b_i^T, column by column: the same bits wherever it is computed.
Matrix3 products(const Field& a, const Field& b) {
  Matrix3 sum;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) sum(r, c) = a.col(r).dot(b.col(c));
  return sum;
}

Matrix3 inertia_of(const Matrix3& S) { return S.trace() * Matrix3::Identity() - S; }

}  // namespace

MeshFrame::MeshFrame(const MeshModel& model)
    : mass_(model.mass), total_(model.rigid_body.mass), Y_(model.mass.size(), 3) {
  const auto& order = model.forces.order();
  for (Index i = 0; i < Y_.rows(); ++i)
    Y_.row(i) = model.coordinates.row(order[i]) - model.rigid_body.center.transpose();
  if (model.M.size() > 0) {
    const Points by_node = Y_;  // a consistent mass has its rows in the order of the nodes
    const Vector arms = model.M * Eigen::Map<const Vector>(by_node.data(), by_node.size());
    arms_ = Eigen::Map<const Points>(arms.data(), Y_.rows(), 3);
  } else {
    arms_ = model.arms;
  }
  S_0_ = products(Y_, arms_);
  S_0_ = Matrix3(0.5 * (S_0_ + S_0_.transpose()));
  const Vector3 moments = symmetric_eigenvalues3(inertia_of(S_0_));
  if (!(moments[0] > 1e-12 * moments[2]))
    throw RunError("the mesh has no inertia about one of its axes");
}

MeshFit MeshFrame::fit(const Field& u, const MeshFit& from) const {
  constexpr int most = 30;
  MeshFit fit;
  for (int c = 0; c < 3; ++c) fit.shift[c] = mass_.dot(u.col(c)) / total_;
  const Matrix3 A = S_0_ + products(u, arms_);
  // Newton's method: quadratic, from a turn of one step in two or three
  fit.q = from.q;
  for (int i = 0;; ++i) {
    fit.R = fit.q.toRotationMatrix();
    const Matrix3 S = fit.R.transpose() * A;
    const Matrix3 G = inertia_of(0.5 * (S + S.transpose()));
    fit.inverse_G = G.inverse();
    const Vector3 theta = fit.inverse_G * twist(S);
    if (!(theta.squaredNorm() > 1e-32) || i == most) break;
    Eigen::Quaterniond turn;
    turn.w() = 1;
    turn.vec() = 0.5 * theta;
    fit.q = (fit.q * turn).normalized();
  }
  const Vector3 v = fit.q.vec();
  Matrix3 cross;
  cross << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  fit.less_one = 2 * (fit.q.w() * cross + cross * cross);
  return fit;
}

void MeshFrame::strain(const MeshFit& fit, const Field& u, Field& d) const {
  const Eigen::RowVector3d shift = (fit.R.transpose() * fit.shift).transpose();
  for (int c = 0; c < 3; ++c)
    d.col(c) = (u.col(0) * fit.R(0, c) + u.col(1) * fit.R(1, c) + u.col(2) * fit.R(2, c) +
                Y_.col(0) * fit.less_one(0, c) + Y_.col(1) * fit.less_one(1, c) +
                Y_.col(2) * fit.less_one(2, c))
                   .array() -
               shift[c];
}

Vector3 MeshFrame::strain(const MeshFit& fit, const Field& u, Index row) const {
  return fit.R.transpose() * (u.row(row).transpose() - fit.shift) +
         fit.less_one.transpose() * Y_.row(row).transpose();
}

Vector3 MeshFrame::turn(const MeshFit& fit, const Field& v) const {
  return fit.inverse_G * twist(fit.R.transpose() * products(v, arms_));
}

// R^T (v - v_c) - theta x (Y + d)
void MeshFrame::strain_rates(const MeshFit& fit, const Field& u, const Field& v,
                             Field& rates) const {
  const Vector3 theta = turn(fit, v);
  Vector3 v_c;
  for (int c = 0; c < 3; ++c) v_c[c] = mass_.dot(v.col(c)) / total_;
  Field z(u.rows(), 3);
  strain(fit, u, z);
  z += Y_;
  rates.noalias() = (v.rowwise() - v_c.transpose()) * fit.R;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    rates.col(c) -= theta[a] * z.col(b) - theta[b] * z.col(a);
  }
}

void MeshFrame::pull_back(const MeshFit& fit, const Field& d, Field& f) const {
  Vector3 moment;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    moment[c] = (Y_.col(a) + d.col(a)).dot(f.col(b)) - (Y_.col(b) + d.col(b)).dot(f.col(a));
  }
  const Vector3 lambda = fit.inverse_G * moment;
  for (Index i = 0; i < f.rows(); ++i) {
    const Vector3 arm = arms_.row(i).transpose(), force = f.row(i).transpose();
    f.row(i) = (fit.R * (force - lambda.cross(arm))).transpose();
  }
}

}  // namespace cbr
