// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/massless_form.hpp"

#include "common/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigenpairs.hpp"
#include "dynamics/bodies/characteristic_form.hpp"

namespace cbr {
namespace {

constexpr std::size_t most_known = 6;  // of a few sets: step, last step, and one that an output cuts

}  // namespace

std::shared_ptr<const Matrix> MasslessForm::response(const IndexTable& rows, const std::vector<Index>& nodes, double h) const {
  for (const Known& known : known_)
    if (known.h == h && known.nodes == nodes) return known.block;
  std::vector<Index> dofs;
  const Index k = modal.V.rows() - F.rows();
  for (const Index node : nodes)
    for (int d = 0; d < 3; ++d) dofs.push_back(rows(node, d) >= 0 ? rows(node, d) - k : -1);
  const auto m = static_cast<Index>(dofs.size());
  Matrix S = Matrix::Zero(m, m);
  for (Index j = 0; j < m; ++j)
    for (Index i = 0; dofs[j] >= 0 && i < m; ++i)
      if (dofs[i] >= 0) S(i, j) = F(dofs[i], dofs[j]) / h;
  if (known_.size() == most_known) known_.erase(known_.begin());
  known_.push_back({nodes, h, std::make_shared<const Matrix>(std::move(S))});
  return known_.back().block;
}

std::shared_ptr<const MasslessForm> free_massless_form(const Superelement& s, const std::string& where) {
  auto form = std::make_shared<MasslessForm>();
  form->modal = form_of_modes(s, s.massless.V, "/massless/V", where);
  form->F = s.massless.F;
  form->omega_closed = s.massless.omega_closed;
  return form;
}

std::shared_ptr<const MasslessForm> held_massless_form(const Superelement& s, const MasslessForm& free,
                                                       const std::vector<HeldDirection>& held, const std::string& where) {
  const IndexTable rows = displacement_rows(s);
  const Index k = s.k(), c = s.c(), n = free.modal.omega.size();
  Matrix C = Matrix::Zero(static_cast<Index>(held.size()), c);  // C u_c = 0
  for (Index i = 0; i < C.rows(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index row = rows(held[i].node, d); row >= 0) C(i, row - k) = held[i].direction[d];
  auto form = std::make_shared<MasslessForm>();
  form->omega_closed = free.omega_closed;
  // With D = C F C^T and the reactions -D^-1 C (V_c eta + F f):
  //   F <- F - F C^T D^-1 C F,   V_c <- V_c - F C^T D^-1 C V_c,   K = diag(omega^2) + (C V_c)^T D^-1 C V_c
  const Matrix FC = free.F * C.transpose();
  const Cholesky D(C * FC);
  if (!D.ok()) throw InputError(where + ": the conditions on its nodes cannot be told from each other");
  const Matrix V_c = free.modal.V.bottomRows(c), CV = C * V_c, DCV = D.solve(CV);
  form->F = free.F - FC * D.solve(FC.transpose());
  form->F = 0.5 * (form->F + form->F.transpose()).eval();
  const Matrix V_held = V_c - FC * DCV;
  Matrix K = CV.transpose() * DCV;
  K = 0.5 * (K + K.transpose()).eval();
  K.diagonal() += free.modal.omega.cwiseAbs2();
  // Rigid motions that are left: E y
  const Matrix N = free_rigid_motions(reduced_rigid_modes(s, s.rigid_body.center), s.rigid_body, rows, held);
  Matrix Q = free.modal.E * N;
  if (Q.cols() > 0) Q = orthonormal_basis(Q);
  const Eigenpairs pairs = dense_eigenpairs_beside(std::move(K), Q);
  if (!pairs.converged) throw RunError(where + ": the modes of the held superelement could not be found");
  DiagonalForm& modal = form->modal;
  take_frequencies(pairs.lambda, N.cols(), modal);
  modal.V.resize(k + c, n);
  modal.V.topRows(k) = pairs.Phi;
  modal.V.bottomRows(c) = V_held * pairs.Phi;
  modal.E = pairs.Phi.transpose() * free.modal.E;
  return form;
}

}  // namespace cbr
