// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/modal_form.hpp"

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// of the held directions' rows: below, one of them is in the span of the others
constexpr double least_pivot = 1e-9;

}  // namespace

ModalForm form_of_modes(const Superelement& s, const Matrix& V_c, const std::string& dataset,
                        const std::string& where) {
  ModalForm form;
  form.omega = s.eigenvalues.cwiseSqrt();
  const Index r = form.n_rigid = (form.omega.array() == 0).count();
  form.V.setZero(s.k() + s.c(), s.k());
  form.V.topRows(s.k()).setIdentity();
  form.V.bottomRows(s.c()) = V_c;
  form.E = s.fixed.momentum;
  if (s.fixed.any()) return form;
  // R_c = V_r E_r: impulses change the momentum by their sum
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  const Vector scales = rigid_scales(s.rigid_body);
  const Matrix V_r = V_c.leftCols(r), R_s = R * scales.asDiagonal();
  Matrix E_s = Matrix::Zero(s.k(), 6);
  if (r > 0) E_s.topRows(r) = PivotedQr(V_r).solve(R_s);
  Matrix mass = Matrix::Zero(6, 6);
  mass.topLeftCorner(3, 3).diagonal().setConstant(s.rigid_body.mass);
  mass.bottomRightCorner(3, 3) = s.rigid_body.inertia;
  mass = (scales.asDiagonal() * mass * scales.asDiagonal()).eval();
  const Matrix found = E_s.transpose() * E_s;
  const auto differ = [&](auto block) {
    return (block(found) - block(mass)).norm() > 1e-6 * block(mass).norm();
  };
  if ((V_c * E_s - R_s).norm() > 1e-8 * R_s.norm() ||
      differ([](const Matrix& A) { return Matrix(A.topLeftCorner(3, 3)); }) ||
      differ([](const Matrix& A) { return Matrix(A.bottomRightCorner(3, 3)); }))
    throw InputError(where + ": the rigid modes in " + dataset +
                     " do not agree with /rigid_body and /nodes/coordinates to 1e-6");
  // E^T E = R^T M R to the last digit: E <- E L_f^-T L^T
  const Cholesky whole(mass);
  const Cholesky own(found);
  if (whole.ok() && own.ok()) {
    own.divide_by_upper(E_s);
    E_s = (E_s * whole.upper()).eval();
  }
  form.E = E_s * scales.cwiseInverse().asDiagonal();
  return form;
}

ModalForm free_characteristic_form(const Superelement& s, const std::string& where) {
  return form_of_modes(s, s.characteristic.V, "/characteristic/V", where);
}

ModalForm held_characteristic_form(const Superelement& s, const std::vector<HeldDirection>& held,
                                   const std::string& where) {
  const ModalForm free = free_characteristic_form(s, where);
  const IndexTable rows = displacement_rows(s);
  const Index k = s.k();
  // C q = 0, rows of one length   (held x k)
  Matrix C = Matrix::Zero(static_cast<Index>(held.size()), k);
  for (Index i = 0; i < C.rows(); ++i) {
    for (int d = 0; d < 3; ++d)
      if (const Index row = rows(held[i].node, d); row >= 0)
        C.row(i) += held[i].direction[d] * free.V.row(row);
    C.row(i).normalize();
  }
  const PivotedQr qr(C.transpose(), least_pivot);
  const Index r = qr.rank(), n = k - r;
  if (r < C.rows())
    throw InputError(
        where + ": basis characteristic has no coordinate for each of the " +
        std::to_string(C.rows()) +
        " displacements that are held, so that more than these would be: name the held nodes under "
        "characteristic.keep, or use basis: craig-bampton");
  // q = Z y, an orthonormal basis of what is free   (k x n)
  const Matrix Z = qr.Q().rightCols(n);
  const Matrix K = Z.transpose() * free.omega.cwiseAbs2().asDiagonal() * Z;
  const Matrix N = free_rigid_motions(reduced_rigid_modes(s, s.rigid_body.center), s.rigid_body,
                                      rows, held, s.fixed.resisted);
  Matrix Q = Z.transpose() * (free.E * N);
  if (Q.cols() > 0) Q = orthonormal_basis(Q);
  const Eigenpairs pairs = dense_eigenpairs_beside(K, Q);
  if (!pairs.converged)
    throw RunError(where + ": the modes of the held superelement could not be found");
  ModalForm form;
  take_frequencies(pairs.lambda, N.cols(), form);
  const Matrix Y = Z * pairs.Phi;
  form.V.noalias() = free.V * Y;
  form.E.noalias() = Y.transpose() * free.E;
  return form;
}

}  // namespace cbr
