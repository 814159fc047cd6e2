// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model made dense: its diagonal form.

#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/motion/coupled/coupled_model.hpp"

namespace cbr {
namespace {

void add_sparse(const SparseMatrix& A, Index shift, Matrix& to) {
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      to(shift + it.row(), shift + j) += it.value();
}

// Of all coordinates, n x n.
Matrix dense_stiffness(const CoupledModel& model) {
  const Index n_modal = model.n_modal();
  Matrix K = Matrix::Zero(model.n(), model.n());
  Index first = 0;
  for (const CoupledPart& part : model.parts) {
    const Superelement& s = *part.superelement;
    for (Index j = 0; j < s.k(); ++j) K(first + j, first + j) = s.eigenvalues[j];
    for (Index j = 0; j < s.c(); ++j)
      for (Index i = 0; i < s.c(); ++i)
        K(n_modal + part.dof[i], n_modal + part.dof[j]) += s.K_cc(i, j);
    first += s.k();
  }
  add_sparse(model.K, n_modal, K);
  return K;
}

Matrix dense_mass(const CoupledModel& model) {
  const Index n_modal = model.n_modal();
  Matrix M = Matrix::Zero(model.n(), model.n());
  M.topLeftCorner(n_modal, n_modal).setIdentity();
  Index first = 0;
  for (const CoupledPart& part : model.parts) {
    const Superelement& s = *part.superelement;
    for (Index j = 0; j < s.c(); ++j) {
      const Index column = n_modal + part.dof[j];
      M.col(column).segment(first, s.k()) += s.M_kc.col(j);
      for (Index i = 0; i < s.c(); ++i) M(n_modal + part.dof[i], column) += s.M_cc(i, j);
    }
    first += s.k();
  }
  add_sparse(model.M, n_modal, M);
  M.bottomLeftCorner(model.n_nodal(), n_modal) =
      M.topRightCorner(n_modal, model.n_nodal()).transpose();
  return M;
}

// [I, 0; 0, Z]^T A [I, 0; 0, Z]
Matrix on_free(const Matrix& A, const FreeDofs& free, Index n_modal) {
  const Index n_free = free.Z.cols(), n_nodal = free.Z.rows();
  Matrix B(n_modal + n_free, n_modal + n_free);
  const Matrix A_Z = A.rightCols(n_nodal) * free.Z;
  B.topLeftCorner(n_modal, n_modal) = A.topLeftCorner(n_modal, n_modal);
  B.topRightCorner(n_modal, n_free) = A_Z.topRows(n_modal);
  B.bottomLeftCorner(n_free, n_modal) = A_Z.topRows(n_modal).transpose();
  B.bottomRightCorner(n_free, n_free) = free.Z.transpose() * A_Z.bottomRows(n_nodal);
  return B;
}

}  // namespace

ModalForm modal_form(const CoupledModel& model, const std::vector<HeldDirection>& held,
                     const std::string& where) {
  const Index n_modal = model.n_modal();
  const FreeDofs free = free_dofs(model, held);
  const Matrix R = rigid_motions(model);
  Matrix K = dense_stiffness(model), M = dense_mass(model);
  const Matrix resisted =
      resisted_rigid_motions(K, R * rigid_scales(model.rigid_body).asDiagonal());
  const bool is_free = held.empty() && resisted.rows() == 0;
  const Matrix MR = M * R;
  if (!free.is_all) {
    K = on_free(K, free, n_modal);
    M = on_free(M, free, n_modal);
  }
  const Index n = K.rows();
  IndexTable rows(model.coordinates.rows(), 3);
  for (Index i = 0; i < rows.size(); ++i) rows.data()[i] = n_modal + i;
  Matrix N = free_rigid_motions(R, model.rigid_body, rows, held, resisted);
  if (N.cols() > 0 && PivotedQr((R * N).colwise().normalized()).rank() < N.cols()) N.resize(6, 0);
  Matrix R_f = R * N;
  if (!free.is_all && N.cols() > 0) {
    R_f.resize(n, N.cols());
    R_f.topRows(n_modal).setZero();
    R_f.bottomRows(free.Z.cols()) = free.Z.transpose() * (R.bottomRows(model.n_nodal()) * N);
  }
  Eigenpairs pairs = dense_eigenpairs_beside(std::move(K), std::move(M),
                                             free.is_all || N.cols() > 0 ? R_f : Matrix(n, 0));
  if (!pairs.converged || pairs.n_converged < n)
    throw RunError(where +
                   ": the diagonal form cannot be computed: the mass is not positive definite");
  ModalForm form;
  take_frequencies(pairs.lambda, N.cols(), form);
  if (free.is_all) {
    form.V = std::move(pairs.Phi);
  } else {
    form.V.resize(model.n(), n);
    form.V.topRows(n_modal) = pairs.Phi.topRows(n_modal);
    form.V.bottomRows(model.n_nodal()).noalias() = free.Z * pairs.Phi.bottomRows(free.Z.cols());
  }
  if (held.empty() && use_exact_rigid_modes(R, model.rigid_body, form)) return form;
  if (is_free) refuse_rigid_modes(where);
  // E = V^T M R   (n x 6)
  form.E.noalias() = form.V.transpose() * MR;
  return form;
}

Superelement nodes_only(const CoupledModel& model) {
  const Index n = model.coordinates.rows(), n_modal = model.n_modal();
  Superelement s;
  s.eigenvalues.resize(n_modal);
  Index first = 0;
  for (const CoupledPart& part : model.parts) {
    s.eigenvalues.segment(first, part.superelement->k()) = part.superelement->eigenvalues;
    first += part.superelement->k();
  }
  for (Index i = 0; i < n; ++i) {
    s.node_ids.push_back(i + 1);
    for (int c = 0; c < 3; ++c) {
      s.dof_node.push_back(i);
      s.dof_component.push_back(c);
    }
  }
  s.coordinates = model.coordinates;
  s.rigid_body = model.rigid_body;
  return s;
}

}  // namespace cbr
