// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/spin_moments.hpp"

#include "reducer/modes/interior_loads.hpp"

namespace cbr {

Matrix unit_strains(const Points& X, const Vector3& center) {
  Matrix D = Matrix::Zero(3 * X.rows(), 6);
  for (Index i = 0; i < X.rows(); ++i) {
    const Vector3 x = X.row(i).transpose() - center;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, mixed = 3 + a;  // xy, yz, zx
      D(3 * i + a, a) = x[a];
      D(3 * i + a, mixed) = 0.5 * x[b];
      D(3 * i + b, mixed) = 0.5 * x[a];
    }
  }
  return D;
}

Matrix spin_moments(const Partition& p, const SparseCholesky& factor, const Points& X_I,
                    const Points& X_C, const Vector3& center, const Matrix& Phi,
                    const Matrix& M_cc) {
  Matrix D_I = unit_strains(X_I, center), D_C = unit_strains(X_C, center);
  // Rotations of shells move their mid-surface not at all
  D_I.bottomRows(3 * p.interior_rotations).setZero();
  D_C.bottomRows(3 * p.interface_rotations).setZero();
  const Matrix F_I = p.M_II * D_I + p.M_IC * D_C;
  const Matrix F_C = p.M_CC * D_C + p.M_IC.transpose() * D_I;
  return generalised_forces(p, factor, F_I, F_C, Phi, M_cc);
}

}  // namespace cbr
