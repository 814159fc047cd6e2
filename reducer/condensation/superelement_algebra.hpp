// SPDX-License-Identifier: GPL-3.0-or-later
// Algebra of a superelement's reduced matrices: rigid motions of its interface, its residual mass.
#pragma once

#include <functional>
#include <vector>

#include "common/linalg/dense.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// Rigid motions of each part in reduced coordinates, n x 6 parts (fewer when a part's nodes are on
// one line). `part` (one per superelement node): which connected part of the component the node
// belongs to.
Matrix rigid_motions_of_parts(const Superelement& superelement, const std::vector<Index>& part);

// X <- X L^-T with X^T M X = L L^T; twice, as one pass has an error of cond(X) times round-off.
// RunError, naming `what`: M is not positive definite on X.
void orthonormalise(const std::function<Matrix(const Matrix&)>& times_M, Matrix& X,
                    const char* what);
void orthonormalise(const Matrix& M, Matrix& X, const char* what);

// K = K_cc + scale N N^T, N an orthonormal basis of the rigid motions R (c x r), scale the mean of
// K_cc's diagonal. Positive definite unless K_cc has other null vectors; its inverse is a
// generalised one of K_cc.
struct HeldStiffness {
  Matrix K, N;
  double scale = 1;
};
HeldStiffness hold_rigid_motions(const Matrix& K_cc, const Matrix& R);

// L of the Schur complement M_res = M_cc - M_kc^T M_kc = L L^T, the interface's mass without the
// modes' (c x c). 2 k c^2 + c^3 / 3 flops, so that callers pass it on. Not ok(): the reduced mass
// is not positive definite.
Cholesky residual_mass_factor(const Superelement& superelement);

}  // namespace cbr
