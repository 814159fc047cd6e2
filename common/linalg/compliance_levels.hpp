// SPDX-License-Identifier: GPL-3.0-or-later
// Residual compliance of many forces in few numbers: far forces act by smooth shares.
// docs/theory.md, "Compliance in levels".
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// One term P^T S P of a compliance F (s x s). Its places are some of the forces; coarse levels have
// few, the last one all. Level 0 has vectors in the place of shares, and a diagonal S.
struct ComplianceLevel {
  SparseMatrix P;  // k x s: column i has the shares of force i at places near it, which add up to 1
  SparseMatrix S;  // k x k, symmetric, both triangles; from level 2 on of near places alone
};

// F X = sum of P^T S P X over the levels   (s x q)
inline Matrix compliance_product(const std::vector<ComplianceLevel>& levels, const Matrix& X) {
  Matrix Y = Matrix::Zero(X.rows(), X.cols());
  for (const ComplianceLevel& level : levels) {
    const Matrix at_places = level.S * Matrix(level.P * X);
    Y.noalias() += level.P.transpose() * at_places;
  }
  return Y;
}

}  // namespace cbr
