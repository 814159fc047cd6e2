// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/stress_values.hpp"

#include <cmath>

#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

template <typename Row>
Matrix3 tensor(const Row& s) {
  Matrix3 sigma;
  sigma << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  return sigma;
}

}  // namespace

Matrix stress_values(const Matrix& stress) {
  Matrix out(stress.rows(), n_stress_values);
  out.leftCols(6) = stress;
  for (Index e = 0; e < stress.rows(); ++e) {
    const auto s = stress.row(e);
    const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
    const double shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    out(e, von_mises_column) = std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3 * shear);
    out.row(e).tail<3>() = symmetric_eigenvalues3(tensor(s)).reverse().transpose();
  }
  return out;
}

Matrix turned_stress(const Matrix& stress, const Matrix3& T) {
  Matrix out(stress.rows(), 6);
  for (Index e = 0; e < stress.rows(); ++e) {
    const Matrix3 s = T * tensor(stress.row(e)) * T.transpose();
    out.row(e) << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2);
  }
  return out;
}

}  // namespace cbr
