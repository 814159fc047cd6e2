// SPDX-License-Identifier: GPL-3.0-or-later
// Krylov methods for systems of unit diagonal (Jacobi's preconditioner is in the scaling).
#pragma once

#include <functional>

#include "common/base/types.hpp"

namespace cbr {

using Product = std::function<Vector(const Vector&)>;

// Both start from x, end when |b - A x| <= tolerance or after max_products products, and return the
// number of products. A symmetric positive semi-definite, b in its range: x moves in the range of A
// only.
int conjugate_gradients(const Product& A, const Vector& b, double tolerance, int max_products,
                        Vector& x);
// Any A: GMRES without restarts (Saad, Schultz 1986, doi 10.1137/0907058), max_products vectors of
// memory.
int gmres(const Product& A, const Vector& b, double tolerance, int max_products, Vector& x);

// y = A x, of the size of x.
using FloatProduct = std::function<void(const Eigen::VectorXf&, Eigen::VectorXf&)>;
// The same in single precision, from zero, until |b - A x| <= reduction |b|. Keeps its memory for
// the next call.
class FloatGmres {
 public:
  int solve(const FloatProduct& A, const Eigen::VectorXf& b, float reduction, int max_products,
            Eigen::VectorXf& x);
  // x = sum of weights()[i] x (what the i-th product was of).
  const Eigen::VectorXf& weights() const { return y_; }

 private:
  Eigen::MatrixXf V_, H_;
  Eigen::VectorXf v_, s_, y_;
};

}  // namespace cbr
