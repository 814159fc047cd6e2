// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/compliance_levels.hpp"

namespace cbr {

Matrix compliance_product(const std::vector<ComplianceLevel>& levels, const Matrix& X) {
  Matrix Y = Matrix::Zero(X.rows(), X.cols());
  for (const ComplianceLevel& level : levels) {
    const Matrix at_places = level.S * Matrix(level.P * X);
    Y.noalias() += level.P.transpose() * at_places;
  }
  return Y;
}

}  // namespace cbr
