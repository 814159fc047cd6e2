// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/coupled/coupled_model.hpp"

#include <cassert>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

SparseMatrix from_triplets(Index n, const Triplets& entries) {
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

void append(const SparseMatrix& A, const std::vector<Index>& dof, Triplets& entries) {
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      entries.emplace_back(dof[it.row()], dof[j], it.value());
}

std::vector<Index> shifted(Index n, Index by) {
  std::vector<Index> dof(n);
  for (Index i = 0; i < n; ++i) dof[i] = by + i;
  return dof;
}

// A of a larger model, whose first dofs are those of A, plus B on the dofs `dof`.
SparseMatrix extended(const SparseMatrix& A, const SparseMatrix& B, const std::vector<Index>& dof,
                      Index n) {
  Triplets entries;
  append(A, shifted(A.cols(), 0), entries);
  append(B, dof, entries);
  return from_triplets(n, entries);
}

// Masses at points join a rigid body: the parallel axis theorem for both.
void add_points(const Points& points, const Vector& mass, const Vector& rotary, RigidBody& body) {
  const auto about = [](double m, const Vector3& r) {
    return Matrix3(m * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose()));
  };
  const double total = body.mass + mass.sum();
  if (!(total > 0)) return;
  const Vector3 center = (body.mass * body.center + points.transpose() * mass) / total;
  body.inertia += about(body.mass, body.center - center) + rotary.sum() * Matrix3::Identity();
  for (Index i = 0; i < mass.size(); ++i)
    body.inertia += about(mass[i], points.row(i).transpose() - center);
  body.mass = total;
  body.center = center;
}

// Nodal dofs that a part has, or an entry of a sparse matrix.
std::vector<char> present_dofs(const CoupledModel& model) {
  std::vector<char> present(model.n_nodal(), 0);
  for (const CoupledPart& part : model.parts)
    for (const Index dof : part.dof) present[dof] = 1;
  for (const SparseMatrix* A : {&model.K, &model.M})
    for (Index j = 0; j < A->cols(); ++j)
      if (SparseMatrix::InnerIterator(*A, j)) present[j] = 1;
  return present;
}

// Orthonormal basis of what is left of a node's dofs: 3 x free.
Matrix free_basis(const char* present, const std::vector<Vector3>& directions) {
  const bool whole = present[0] && present[1] && present[2];
  if (whole) {
    const Index n_held = static_cast<Index>(directions.size());
    return complete_basis(directions).rightCols(3 - n_held);
  }
  // Dofs that are not there are held too; directions may become dependent.
  Matrix H = Matrix::Zero(3, 3 + static_cast<Index>(directions.size()));
  for (int c = 0; c < 3; ++c) H(c, c) = present[c] ? 0 : 1;
  for (std::size_t i = 0; i < directions.size(); ++i)
    H.col(3 + static_cast<Index>(i)) = directions[i];
  if (directions.empty()) {
    Matrix basis(3, present[0] + present[1] + present[2]);
    for (Index c = 0, column = 0; c < 3; ++c)
      if (present[c]) basis.col(column++) = Vector3::Unit(c);
    return basis;
  }
  const PivotedQr qr(H, 1e-9);
  return qr.axes().rightCols(3 - qr.rank());
}

}  // namespace

Index CoupledModel::n_modal() const {
  Index n = 0;
  for (const CoupledPart& part : parts) n += part.superelement->k();
  return n;
}

CoupledModel coupled_model(std::shared_ptr<const Superelement> superelement) {
  const std::vector<Index> place = shifted(superelement->coordinates.rows(), 0);
  const Points coordinates = superelement->coordinates;
  const RigidBody body = superelement->rigid_body;
  return coupled_model({std::move(superelement)}, coordinates, {place}, body);
}

CoupledModel coupled_model(const FiniteElementModel& fe, const Points& coordinates) {
  assert(fe.K.rows() == 3 * coordinates.rows());
  CoupledModel model;
  model.coordinates = coordinates;
  model.K = fe.K;
  model.M = fe.M;
  for (Index i = fe.n_translations(); i < coordinates.rows(); ++i) model.turning.push_back(i);
  model.rigid_body = rigid_body(fe.M, coordinates, fe.n_rotations);
  return model;
}

CoupledModel coupled_model(const std::vector<std::shared_ptr<const Superelement>>& domains,
                           const Points& coordinates, const std::vector<std::vector<Index>>& place,
                           const RigidBody& body) {
  CoupledModel model;
  model.coordinates = coordinates;
  model.rigid_body = body;
  for (std::size_t d = 0; d < domains.size(); ++d) {
    const Superelement& s = *domains[d];
    assert(s.K_cc.rows() == s.c() && s.M_cc.rows() == s.c());
    CoupledPart part{domains[d], std::vector<Index>(s.c())};
    for (Index i = 0; i < s.c(); ++i) {
      part.dof[i] = 3 * place[d][s.dof_node[i]] + s.dof_component[i] % 3;
      if (s.dof_component[i] == 3) model.turning.push_back(place[d][s.dof_node[i]]);
    }
    model.parts.push_back(std::move(part));
  }
  return model;
}

void add_shells(const ShellModel& shells, CoupledModel& model) {
  if (shells.empty()) return;
  const Index m = static_cast<Index>(shells.nodes.size()),
              first = 3 * (model.coordinates.rows() + model.n_rotations);
  std::vector<Index> dof(6 * m);
  for (Index i = 0; i < m; ++i)
    for (int c = 0; c < 3; ++c) {
      dof[3 * i + c] = 3 * shells.nodes[i] + c;
      dof[3 * (m + i) + c] = first + 3 * i + c;
    }
  if (shells.has_rotations()) model.n_rotations += m;
  const Index n = model.n_nodal();
  Triplets mass;
  for (Index i = 0; i < shells.mass.size(); ++i)
    for (int c = 0; c < 3; ++c) mass.emplace_back(3 * i + c, 3 * i + c, shells.mass[i]);
  for (Index i = 0; i < shells.rotary.size(); ++i)
    for (int c = 0; c < 3; ++c)
      mass.emplace_back(3 * (m + i) + c, 3 * (m + i) + c, shells.rotary[i]);
  model.K = extended(model.K, shells.K, dof, n);
  model.M = extended(model.M, from_triplets(6 * m, mass), dof, n);
  if (shells.mass.size() > 0)
    add_points(model.coordinates(shells.nodes, Eigen::all), shells.mass, shells.rotary,
               model.rigid_body);
}

Matrix rigid_motions(const CoupledModel& model) {
  const Index k = model.n_modal(), n = model.coordinates.rows();
  Matrix R = Matrix::Zero(model.n(), 6);
  R.middleRows(k, 3 * n) = rigid_modes(model.coordinates, model.rigid_body.center);
  for (const Index node : model.turning)
    R.middleRows(k + 3 * node, 3) << Matrix3::Zero(), Matrix3::Identity();
  for (Index i = 0; i < model.n_rotations; ++i) R.block<3, 3>(k + 3 * (n + i), 3).setIdentity();
  const std::vector<char> present = present_dofs(model);
  for (std::size_t i = 0; i < present.size(); ++i)
    if (!present[i]) R.row(k + static_cast<Index>(i)).setZero();
  return R;
}

FreeDofs free_dofs(const CoupledModel& model, const std::vector<HeldDirection>& held) {
  const Index n = model.coordinates.rows() + model.n_rotations;
  std::vector<std::vector<Vector3>> of_node(n);
  for (const HeldDirection& h : held) of_node[h.node].push_back(h.direction);
  const std::vector<char> present = present_dofs(model);
  Triplets entries;
  Index column = 0;
  for (Index node = 0; node < n; ++node) {
    const Matrix basis = free_basis(present.data() + 3 * node, of_node[node]);
    for (Index f = 0; f < basis.cols(); ++f, ++column)
      for (int c = 0; c < 3; ++c)
        if (basis(c, f) != 0) entries.emplace_back(3 * node + c, column, basis(c, f));
  }
  FreeDofs free;
  free.Z.resize(3 * n, column);
  free.Z.setFromTriplets(entries.begin(), entries.end());
  free.is_all = held.empty() && column == 3 * n;
  return free;
}

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
