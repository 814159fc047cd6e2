// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/missing_modes.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// times an eigenvalue: modes above are too far off to mix with it, and would cost it digits
constexpr double far = 30;
constexpr double short_of = 1e-9;   // of lowest(), where S has its pole
constexpr double precision = 1e-3;  // of the error of an eigenvalue
constexpr int most_steps = 60;

// The number-th lowest eigenvalue of diag(lambda) - S(sigma), of the m lowest modes
class Reduced {
 public:
  Reduced(const Vector& lambda, const MissingModes& missing, Index number)
      : lambda_(lambda), missing_(missing), number_(number), m_(number + 1) {
    while (m_ < lambda.size() && lambda(m_) <= far * lambda(number)) ++m_;
  }

  double eigenvalue(double sigma) const { return symmetric_eigenvalues(at(sigma))(number_); }

  Vector eigenvector(double sigma) const {
    Vector z = Vector::Zero(lambda_.size());
    z.head(m_) = symmetric_eigen(at(sigma)).vectors.col(number_);
    return z;
  }

 private:
  Matrix at(double sigma) const {
    Matrix K = -missing_.taken(sigma, m_);
    K.diagonal() += lambda_.head(m_);
    return K;
  }

  const Vector& lambda_;
  const MissingModes& missing_;
  const Index number_;
  Index m_;
};

// f(sigma) = eigenvalue(sigma) - sigma falls as sigma grows, from lambda >= 0 at 0: its zero, or
// `top` where it has none below.
double zero_of(const Reduced& reduced, double lambda, double top) {
  double high = std::min(lambda, top), f_high = reduced.eigenvalue(high) - high;
  if (!(f_high < 0)) return high;
  double low = std::max(0.0, high + f_high), f_low = reduced.eigenvalue(low) - low;
  // Regula falsi; an end that stays has its value halved (Illinois)
  int side = 0;
  for (int step = 0; step < most_steps && high - low > precision * (lambda - high); ++step) {
    const double sigma = std::clamp((low * f_high - high * f_low) / (f_high - f_low), low, high);
    const double f = reduced.eigenvalue(sigma) - sigma;
    if (std::abs(f) <= precision * (lambda - sigma)) return sigma;
    if (f > 0) {
      low = sigma;
      f_low = f;
      if (side > 0) f_high /= 2;
      side = 1;
    } else {
      high = sigma;
      f_high = f;
      if (side < 0) f_low /= 2;
      side = -1;
    }
  }
  return low;
}

}  // namespace

Matrix inertia_forces(const Interior& interior, const Matrix& U) {
  const Partition& p = interior.p;
  const RigidMotions& rigid = p.rigid;
  Matrix rest = U, Y = Matrix::Zero(interior.n_rows(), U.cols());
  if (rigid.count() > 0) {
    const Matrix rigid_part = rigid.G * U;
    rest.noalias() -= rigid.R_C * rigid_part;
    Y.noalias() += rigid.P_I * rigid_part;
  }
  Matrix X = p.K_IC * rest;
  interior.solve_in_place(X);
  Y.noalias() += p.M_IC * rest;
  interior.add_mass(-X, Y);
  return Y;
}

LeftOfAnswer left_of_answer(const Interior& interior,
                            const std::vector<Eigen::Ref<const Matrix>>& modes,
                            const Vector& lambda, const Eigen::Ref<const Matrix>& residual,
                            Matrix Y) {
  const Index m = Y.cols();
  LeftOfAnswer left{Matrix::Zero(m, m), Matrix::Zero(m, m)};
  if (interior.p.n_interior() == 0 || m == 0) return left;
  constexpr int passes = 2;
  for (int pass = 0; pass < passes; ++pass)
    for (const auto& Phi : modes) Y -= interior.times_mass(Phi * interior.inner(Phi, Y));
  Matrix X = Y;
  interior.solve_in_place(X);
  for (int pass = 0; pass < passes; ++pass)
    for (const auto& Phi : modes) X.noalias() -= Phi * interior.inner(Phi, interior.times_mass(X));
  if (residual.cols() > 0)
    X.noalias() -=
        residual * Matrix(lambda.cwiseInverse().asDiagonal() * interior.inner(residual, Y));
  left.D = interior.inner(Y, X);
  left.D_2 = interior.inner(X, interior.times_mass(X));
  left.D = (0.5 * (left.D + left.D.transpose())).eval();
  left.D_2 = (0.5 * (left.D_2 + left.D_2.transpose())).eval();
  return left;
}

double MissingModes::lowest() const {
  const double known = lambda.size() > 0 ? lambda.minCoeff() : HUGE_VAL;
  return beyond > 0 ? std::min(beyond, known) : known;
}

Matrix MissingModes::taken(double sigma, Index m) const {
  Matrix S = Matrix::Zero(m, m);
  if (beyond > 0)
    S = D.topLeftCorner(m, m) + sigma / (1 - sigma / beyond) * D_2.topLeftCorner(m, m);
  if (lambda.size() > 0) {
    const Matrix B =
        (lambda.array() - sigma).sqrt().inverse().matrix().asDiagonal() * A.leftCols(m);
    S.noalias() += B.transpose() * B;
  }
  return sigma * sigma * S;
}

Vector full_eigenvalues(const Vector& lambda, const MissingModes& missing, Index first, Index count,
                        Matrix* z) {
  const SingleThreadedBlas blas;  // thousands of small problems
  Vector sigma(count);
  if (z != nullptr) z->resize(lambda.size(), count);
  const double top = (1 - short_of) * missing.lowest();
  for (Index i = 0; i < count; ++i) {
    const Reduced reduced(lambda, missing, first + i);
    sigma(i) = zero_of(reduced, lambda(first + i), top);
    if (z != nullptr) z->col(i) = reduced.eigenvector(sigma(i));
  }
  return sigma;
}

}  // namespace cbr
