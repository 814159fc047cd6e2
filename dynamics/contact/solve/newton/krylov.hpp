// SPDX-License-Identifier: GPL-3.0-or-later
// Krylov methods for systems with a unit diagonal (scaling is a Jacobi preconditioner).
#pragma once

#include <functional>

#include "common/base/types.hpp"

namespace cbr {

using Product = std::function<Vector(const Vector&)>;

// Both start at x, end at |b - A x| <= tolerance or after max_products products, and return the
// number of products. A symmetric positive semi-definite, b in its range; x changes only in the
// range of A.
int conjugate_gradients(const Product& A, const Vector& b, double tolerance, int max_products,
                        Vector& x);
// Any A: GMRES without restarts (Saad, Schultz 1986, doi 10.1137/0907058), with memory for
// max_products vectors.
int gmres(const Product& A, const Vector& b, double tolerance, int max_products, Vector& x);

}  // namespace cbr
