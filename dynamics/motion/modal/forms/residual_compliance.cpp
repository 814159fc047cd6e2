// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/residual_compliance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// of a few sets: step, last step, and one that an output cuts
constexpr std::size_t most_known = 6;
// of a row's compliance, that is left when others are held; less is round-off
constexpr double least_share = 1e-12;

StaticRows rows_of_massless(const Superelement& s, std::shared_ptr<const Matrix> F) {
  Points direction = Points::Zero(s.c(), 3);
  for (Index i = 0; i < s.c(); ++i) direction(i, s.dof_component[i]) = 1;
  return static_rows(s.dof_node, direction, std::move(F), s.coordinates.rows());
}

// The matrix stays where it is, in the superelement.
StaticRows rows_of_characteristic(const std::shared_ptr<const Superelement>& s) {
  const StaticShare& statics = s->characteristic.statics;
  const StaticCompliance F = statics.levels.empty()
                                 ? StaticCompliance(std::shared_ptr<const Matrix>(s, &statics.F))
                                 : StaticCompliance(statics.levels);
  return static_rows(statics.node, statics.direction, F, s->coordinates.rows());
}

// F - F_:j F_j: / F_jj: row j is held, and moves no more. A pivot below `least` is 0.
void hold_row(Index j, double least, Matrix& F) {
  const double pivot = F(j, j);
  const Vector column = F.col(j);
  if (pivot > least) F.noalias() -= column * (column / pivot).transpose();
  F.row(j).setZero();
  F.col(j).setZero();
}

std::shared_ptr<const ModalForm> with_residual(ModalForm form, ResidualCompliance residual) {
  form.residual = std::make_shared<const ResidualCompliance>(std::move(residual));
  return std::make_shared<const ModalForm>(std::move(form));
}

std::shared_ptr<const ModalForm> held_characteristic(const Superelement& s, const StaticRows& free,
                                                     const std::vector<HeldDirection>& held,
                                                     const std::string& where) {
  ModalForm form = held_characteristic_form(s, held, where);
  ResidualCompliance residual;
  residual.rows = free;
  residual.omega_limit = form.highest();
  std::vector<Index> changed;
  for (const HeldDirection& direction : held)
    for (Index j = free.first[direction.node]; j < free.first[direction.node + 1]; ++j)
      if (std::abs(free.direction.row(j).dot(direction.direction)) >= 1e-6) changed.push_back(j);
  if (!changed.empty()) {
    Matrix F = free.F.formed();
    const Vector whole = F.diagonal();
    for (const Index j : changed) hold_row(j, least_share * whole[j], F);
    residual.rows.F = std::make_shared<const Matrix>(0.5 * (F + F.transpose()));
  }
  return with_residual(std::move(form), std::move(residual));
}

std::shared_ptr<const ModalForm> held_massless(const Superelement& s, const ModalForm& free,
                                               const std::vector<HeldDirection>& held,
                                               const std::string& where) {
  const IndexTable rows = displacement_rows(s);
  const Index k = s.k(), c = s.c(), n = free.omega.size();
  Matrix C = Matrix::Zero(static_cast<Index>(held.size()), c);  // C u_c = 0
  for (Index i = 0; i < C.rows(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index row = rows(held[i].node, d); row >= 0) C(i, row - k) = held[i].direction[d];
  ResidualCompliance residual;
  residual.is_massless = free.residual->is_massless;
  // With D = C F C^T and the reactions -D^-1 C (V_c eta + F f):
  //   F <- F - F C^T D^-1 C F,   V_c <- V_c - F C^T D^-1 C V_c,   K = diag(omega^2) + (C V_c)^T
  //   D^-1 C V_c
  const Matrix FC = s.massless.F * C.transpose();
  const Cholesky D(C * FC);
  if (!D.ok())
    throw InputError(where + ": the conditions on its nodes cannot be told from each other");
  const Matrix V_c = free.V.bottomRows(c), CV = C * V_c, DCV = D.solve(CV);
  Matrix F = s.massless.F - FC * D.solve(FC.transpose());
  F = 0.5 * (F + F.transpose()).eval();
  residual.rows = rows_of_massless(s, std::make_shared<const Matrix>(std::move(F)));
  const Matrix V_held = V_c - FC * DCV;
  Matrix K = CV.transpose() * DCV;
  K = 0.5 * (K + K.transpose()).eval();
  K.diagonal() += free.omega.cwiseAbs2();
  // Rigid motions that are left: E y
  const Matrix N = free_rigid_motions(reduced_rigid_modes(s, s.rigid_body.center), s.rigid_body,
                                      rows, held, s.fixed.resisted);
  Matrix Q = free.E * N;
  if (Q.cols() > 0) Q = orthonormal_basis(Q);
  const Eigenpairs pairs = dense_eigenpairs_beside(std::move(K), Q);
  if (!pairs.converged)
    throw RunError(where + ": the modes of the held superelement could not be found");
  ModalForm modal;
  take_frequencies(pairs.lambda, N.cols(), modal);
  modal.V.resize(k + c, n);
  modal.V.topRows(k) = pairs.Phi;
  modal.V.bottomRows(c) = V_held * pairs.Phi;
  modal.E = pairs.Phi.transpose() * free.E;
  residual.omega_limit = residual.is_massless ? free.residual->omega_limit : modal.highest();
  return with_residual(std::move(modal), std::move(residual));
}

}  // namespace

StaticRows static_rows(const std::vector<Index>& node, const Points& direction, StaticCompliance F,
                       Index n) {
  const std::vector<Index> order =
      order_by(node.size(), [&](Index a, Index b) { return node[a] < node[b]; });
  StaticRows rows;
  rows.first.assign(static_cast<std::size_t>(n) + 1, 0);
  rows.direction = direction(order, Eigen::all);
  for (const Index i : order) rows.node.push_back(node[i]);
  for (const Index at : node) ++rows.first[at + 1];
  std::partial_sum(rows.first.begin(), rows.first.end(), rows.first.begin());
  const bool sorted = std::is_sorted(order.begin(), order.end());
  rows.F = sorted ? std::move(F) : F.of_rows(order);
  return rows;
}

std::shared_ptr<const ResidualCompliance::OfNodes> ResidualCompliance::of_nodes(
    const NodeRows& modal_rows) const {
  for (const auto& known : sets_)
    if (known->nodes == modal_rows.nodes()) return known;
  auto of = std::make_shared<OfNodes>();
  of->nodes = modal_rows.nodes();
  auto part = std::make_shared<StaticRows>();
  part->first.push_back(0);
  for (std::size_t i = 0; i < of->nodes.size(); ++i) {
    for (Index row = rows.first[of->nodes[i]]; row < rows.first[of->nodes[i] + 1]; ++row) {
      of->row.push_back(row);
      part->node.push_back(static_cast<Index>(i));
    }
    part->first.push_back(static_cast<Index>(of->row.size()));
  }
  part->direction = rows.direction(of->row, Eigen::all);
  const bool all = part->size() == rows.size() && std::is_sorted(of->row.begin(), of->row.end());
  part->F = all ? rows.F : rows.F.of_rows(of->row);
  of->rows = std::move(part);
  if (is_massless) {
    of->A = std::make_shared<const Matrix>(0, modal_rows.n_dofs());
  } else if (const NodeRows::Shapes* shapes = modal_rows.shapes()) {
    of->Q = shapes->Q;
    of->A = shapes->A;
  } else {
    of->A = std::make_shared<const Matrix>(modal_rows.Vt());
  }
  sets_.push_back(of);
  return of;
}

double ResidualCompliance::following(double h, double beta) const {
  constexpr double most_share = 1.8;
  if (is_massless || omega_limit == 0) return h + beta;
  return std::max({h / most_share, 1 / omega_limit, 0.5 * h + beta});
}

std::shared_ptr<const ThinResponse> ResidualCompliance::response(
    const std::shared_ptr<const OfNodes>& nodes, const ResponseOf& of, const Vector& weight,
    double beta) const {
  for (const Known& known : known_)
    if (known.nodes == nodes && known.of == of) return known.response;
  if (known_.size() == most_known) known_.erase(known_.begin());
  const bool of_velocity = of.weight == ResponseOf::Weight::velocity;
  Matrix C;
  if (nodes->A->rows() > 0)
    C = nodes->Q.size() > 0 ? Matrix(nodes->Q.transpose() * weight.asDiagonal() * nodes->Q)
                            : Matrix(weight.asDiagonal());
  const double h = of.weight == ResponseOf::Weight::statics ? 1 : following(of.h, beta);
  auto response = std::make_shared<ThinResponse>(
      ThinResponse{nodes->A, C, nodes->rows, h, nodes->Q.size() == 0});
  if (of_velocity) {
    response->rows = no_static_rows(nodes->nodes.size());
    response->h = 1;
  }
  known_.push_back({nodes, of, response});
  return response;
}

std::shared_ptr<const ModalForm> free_residual_form(
    const std::shared_ptr<const Superelement>& superelement, const std::string& where,
    bool meets_others) {
  const Superelement& s = *superelement;
  ResidualCompliance residual;
  residual.is_massless = s.is_massless() && !meets_others;
  ModalForm form;
  if (s.is_massless()) {
    form = form_of_modes(s, s.massless.V, "/massless/V", where);
    residual.rows = rows_of_massless(s, {superelement, &s.massless.F});
    residual.omega_limit = meets_others ? form.highest() : s.massless.omega_closed;
  } else {
    form = free_characteristic_form(s, where);
    residual.rows = rows_of_characteristic(superelement);
    residual.omega_limit = form.highest();
  }
  return with_residual(std::move(form), std::move(residual));
}

std::shared_ptr<const ModalForm> held_residual_form(const Superelement& s, const ModalForm& free,
                                                    const std::vector<HeldDirection>& held,
                                                    const std::string& where) {
  return s.is_massless() ? held_massless(s, free, held, where)
                         : held_characteristic(s, free.residual->rows, held, where);
}

namespace {

constexpr double share_of_fixed_modes = 2.5;
constexpr std::size_t least_nodes = 100;

Index modes_up_to(double highest, const ModalForm& all) {
  return std::upper_bound(all.omega.begin(), all.omega.end(), highest) - all.omega.begin();
}

// diag(1 / omega_h) V_h^T B, of the modes from `first` on   (h x s)
Matrix along_forces(const ModalForm& all, Index first, const StaticShare& forces,
                    const IndexTable& row) {
  const Index h = all.omega.size() - first;
  Matrix G = Matrix::Zero(h, forces.size());
  for (Index i = 0; i < forces.size(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index r = row(forces.node[i], d); r >= 0 && forces.direction(i, d) != 0)
        G.col(i) += forces.direction(i, d) * all.V.row(r).tail(h).transpose();
  return all.omega.tail(h).cwiseInverse().asDiagonal() * G;
}

}  // namespace

std::optional<double> automatic_limit(const Vector& eigenvalues, const ModalForm& all) {
  if (eigenvalues.size() == 0) return std::nullopt;
  const double limit = share_of_fixed_modes * std::sqrt(std::max(0.0, eigenvalues.maxCoeff()));
  const Index n = modes_up_to(limit, all), h = all.omega.size() - n;
  const bool pays = n > all.n_rigid && 2 * h >= n && all.E.bottomRows(h).isZero(0);
  return pays ? std::optional(all.omega[n - 1]) : std::nullopt;
}

bool is_large_face(const StaticShare& forces) {
  return std::set<Index>(forces.node.begin(), forces.node.end()).size() >= least_nodes;
}

std::shared_ptr<const ModalForm> truncated_form(double highest,
                                                std::shared_ptr<const ModalForm> all,
                                                const StaticShare& forces, const Superelement& s) {
  const Index n = modes_up_to(highest, *all), h = all->omega.size() - n;
  auto form = std::make_shared<ModalForm>();
  form->omega = all->omega.head(n);
  form->V = all->V.leftCols(n);
  form->E = all->E.topRows(n);
  form->n_rigid = all->n_rigid;
  auto residual = std::make_shared<ResidualCompliance>();
  residual->quasi_static = along_forces(*all, n, forces, displacement_rows(s));
  Matrix F = Matrix::Zero(forces.size(), forces.size());
  F.selfadjointView<Eigen::Lower>().rankUpdate(residual->quasi_static.transpose());
  mirror_lower(F);
  residual->rows = static_rows(forces.node, forces.direction,
                               std::make_shared<const Matrix>(std::move(F)), s.coordinates.rows());
  residual->quasi_static.array().colwise() /= all->omega.tail(h).array();
  residual->omega_limit = highest;
  residual->whole = std::move(all);
  form->residual = std::move(residual);
  return form;
}

}  // namespace cbr
