// SPDX-License-Identifier: GPL-3.0-or-later
// Dense Cholesky factors, for matrices of some thousand rows that leave no room for copies.
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// A = L L^T in place (n x n, the lower triangle is read and overwritten, the rest left alone).
// False when A is not positive definite.
bool dense_cholesky(Matrix& A);

// From L in the lower triangle to (L L^T)^-1, both triangles, in place.
void dense_inverse_of_cholesky(Matrix& L);

// The upper triangle becomes that of a symmetric matrix whose lower triangle is given; by tiles, as
// columns alone thrash the cache.
void mirror_lower(Matrix& A);

}  // namespace cbr
