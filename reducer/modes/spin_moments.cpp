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

Matrix spin_moments(const Interior& interior, const Points& X_I, const Points& X_C,
                    const Vector3& center, const Matrix& Phi) {
  const Partition& p = interior.p;
  Matrix D_I = unit_strains(X_I, center), D_C = unit_strains(X_C, center);
  // Rotations of shells move their mid-surface not at all
  D_I.bottomRows(3 * p.interior_rotations).setZero();
  D_C.bottomRows(3 * p.interface_rotations).setZero();
  Matrix F_I = interior.times_mass(D_I);
  F_I.noalias() += p.M_IC * D_C;
  const Matrix F_C = interior.sum(p.M_CC * D_C + p.M_IC.transpose() * D_I);
  return generalised_forces(interior, F_I, F_C, Phi);
}

namespace {

// P(3 i + a, 3 j + b) += sum over the nodes of X(., i)^a Y(., j)^b
void add_node_products(const Matrix& X, const Matrix& Y, Matrix& P) {
  using Eigen::all, Eigen::last, Eigen::seq;
  if (X.rows() == 0) return;
  for (Index a = 0; a < 3; ++a) {
    const Matrix X_a = X(seq(a, last, 3), all);
    for (Index b = 0; b < 3; ++b)
      P(seq(a, last, 3), seq(b, last, 3)) += X_a.transpose() * Matrix(Y(seq(b, last, 3), all));
  }
}

}  // namespace

Matrix spin_couplings(const Interior& interior, const Matrix& Phi, const Matrix& V) {
  const Partition& p = interior.p;
  Matrix X_C = V.bottomRows(p.n_interface());
  Matrix X_I = p.K_IC * X_C;
  interior.solve_in_place(X_I);
  X_I = Phi * V.topRows(Phi.cols()) - X_I;
  // As above; masses of translations are the same in x, y and z, and mix none of them
  X_I.bottomRows(3 * p.interior_rotations).setZero();
  X_C.bottomRows(3 * p.interface_rotations).setZero();
  Matrix P = Matrix::Zero(3 * V.cols(), 3 * V.cols());
  Matrix Y_I = interior.times_mass(X_I);
  Y_I.noalias() += p.M_IC * X_C;
  add_node_products(X_I, Y_I, P);
  add_node_products(X_C, p.M_CC * X_C + p.M_IC.transpose() * X_I, P);
  P = interior.sum(std::move(P));
  return 0.5 * (P + P.transpose());
}

}  // namespace cbr
