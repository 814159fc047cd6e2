// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions that many sources use. The compiler instantiates their templates once, in the
// precompiled header, and not in each source. Nobody calls this function.
#pragma once

#include <algorithm>
#include <vector>

#include "common/base/types.hpp"

namespace cbr::precompiled {

inline double common_expressions(Matrix& A, Vector& v, const SparseMatrix& S, Eigen::Matrix3d& R,
                                 Vector3& x) {
  Vector a = A * v;
  a = A.transpose() * v;
  a.noalias() = A * v;
  a.noalias() = A.transpose() * v;
  a.noalias() += A * v;
  a.noalias() -= A * v;
  a += A * v;
  a -= A * v;
  a = S * v;
  v = Vector::Zero(3);
  v = A.diagonal();
  v = a + v;
  v = a - v;
  v += 2.0 * a;
  v -= 2.0 * a;
  v = 2.0 * v;
  v = a.cwiseProduct(v);
  v.segment<3>(0) = x;
  v.segment<3>(0) += x;
  v.segment(0, 3) = a.segment(0, 3);
  A.col(0) = v;
  v = A.col(0);
  A = Matrix::Zero(3, 3);
  A = Matrix::Identity(3, 3);
  A = A.transpose() * S * A;
  x = v.segment<3>(0);
  x = R * x;
  x = R.transpose() * x;
  x = x + 2.0 * x;
  x = x - x / 2.0;
  x += 2.0 * x;
  x -= 2.0 * x;
  x = x.cross(x);
  x = Vector3::Zero();
  x = Vector3::Unit(0);
  R = R * R.transpose();
  R = R.transpose() * R;
  R = Eigen::Matrix3d::Identity();
  std::vector<Index> rows(3);
  rows.push_back(1);
  std::sort(rows.begin(), rows.end());
  return x.norm() + x.squaredNorm() + x.dot(x) + (x - x).norm() + x.maxCoeff() + v.norm() +
         v.squaredNorm() + v.dot(a) + (v - a).norm() + v.sum() + v.maxCoeff() + v.minCoeff() +
         v.cwiseAbs().maxCoeff() + A.norm() + (A - A).norm() + A.cwiseAbs().maxCoeff();
}

}  // namespace cbr::precompiled
