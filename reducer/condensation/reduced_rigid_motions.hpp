// SPDX-License-Identifier: GPL-3.0-or-later
// What every form of a superelement does with rigid motions of its interface.
#pragma once

#include <functional>
#include <vector>

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

}  // namespace cbr
