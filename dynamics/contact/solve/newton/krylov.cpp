// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/krylov.hpp"

#include <Eigen/Jacobi>

#include <cmath>
#include <vector>

namespace cbr {

int conjugate_gradients(const Product& A, const Vector& b, double tolerance, int max_products,
                        Vector& x) {
  Vector r = b - A(x), d = r;
  double rr = r.squaredNorm();
  int products = 1;
  while (products < max_products && rr > tolerance * tolerance) {
    const Vector Ad = A(d);
    ++products;
    const double curvature = d.dot(Ad);
    if (!(curvature > 0)) break;
    const double step = rr / curvature;
    x += step * d;
    r -= step * Ad;
    const double next = r.squaredNorm();
    d = r + (next / rr) * d;
    rr = next;
  }
  return products;
}

int gmres(const Product& A, const Vector& b, double tolerance, int max_products, Vector& x) {
  Vector r = b - A(x);
  double beta = r.norm();
  if (!(beta > tolerance)) return 1;
  std::vector<Vector> V{r / beta};
  std::vector<Eigen::JacobiRotation<double>> rotations;
  Matrix H = Matrix::Zero(max_products + 1, max_products);
  Vector s = Vector::Zero(max_products + 1);
  s[0] = beta;
  Index k = 0;
  while (k + 1 < max_products && std::abs(s[k]) > tolerance) {
    Vector v = A(V[k]);
    // Gram-Schmidt twice keeps V orthogonal within round-off
    for (int pass = 0; pass < 2; ++pass) {
      for (Index i = 0; i <= k; ++i) {
        const double h = V[i].dot(v);
        H(i, k) += h;
        v -= h * V[i];
      }
    }
    const double length = v.norm();
    for (Index i = 0; i < k; ++i) H.col(k).applyOnTheLeft(i, i + 1, rotations[i].adjoint());
    H(k + 1, k) = length;
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(H(k, k), H(k + 1, k));
    rotations.push_back(rotation);
    H.col(k).applyOnTheLeft(k, k + 1, rotation.adjoint());
    s.applyOnTheLeft(k, k + 1, rotation.adjoint());
    ++k;
    if (!(length > 0)) break;
    V.push_back(v / length);
  }
  // The last column of a singular A may have a zero diagonal: drop it
  while (k > 0 && H(k - 1, k - 1) == 0) --k;
  const Vector y = H.topLeftCorner(k, k).triangularView<Eigen::Upper>().solve(s.head(k));
  for (Index i = 0; i < k; ++i) x += y[i] * V[i];
  return static_cast<int>(k) + 1;
}

}  // namespace cbr
