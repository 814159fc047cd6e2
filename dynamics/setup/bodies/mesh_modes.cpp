// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/mesh_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// The shift of free meshes, of their mean stiffness over mass: far below elastic modes, far above
// round-off.
constexpr double shift = 1e-9;
// Rigid motions come out at some round-off of that.
constexpr double rigid_share = 1e-3;

// Orthonormal basis of what the held directions leave free   (3 n x free).
SparseMatrix free_basis(Index n, const std::vector<HeldDirection>& held) {
  std::vector<std::vector<Vector3>> of_node(static_cast<std::size_t>(n));
  for (const HeldDirection& direction : held)
    of_node[static_cast<std::size_t>(direction.node)].push_back(direction.direction);
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index column = 0;
  for (Index node = 0; node < n; ++node) {
    const auto& directions = of_node[static_cast<std::size_t>(node)];
    const Matrix3 Q = complete_basis(directions);
    for (Index f = static_cast<Index>(directions.size()); f < 3; ++f, ++column)
      for (int c = 0; c < 3; ++c)
        if (Q(c, f) != 0) entries.emplace_back(3 * node + c, column, Q(c, f));
  }
  SparseMatrix Z(3 * n, column);
  Z.setFromTriplets(entries.begin(), entries.end());
  return Z;
}

// The lowest so many, or more and more until one is above the frequency.
Eigenpairs lowest_pairs(const SparseMatrix& K, const SparseMatrix& M, const SparseCholesky& factor,
                        double sigma, const MeshModesWanted& wanted, const std::string& where) {
  const Index n = static_cast<Index>(K.rows());
  const double highest = std::pow(2 * std::numbers::pi * wanted.up_to_hz, 2);
  for (Index k = wanted.count.value_or(32);; k *= 2) {
    k = std::min(k, n);
    Eigenpairs pairs = sparse_eigenpairs(K, M, factor, sigma, k);
    if (!pairs.converged) throw RunError(where + ": the frequencies of the mesh did not converge");
    if (wanted.count || k == n || pairs.lambda[k - 1] > highest) return pairs;
  }
}

}  // namespace

std::shared_ptr<Superelement> mesh_nodes(const MeshedComponent& component) {
  auto s = std::make_shared<Superelement>();
  s->node_ids = component.geometry->node_ids;
  s->coordinates = component.geometry->coordinates;
  for (Index i = 0; i < s->coordinates.rows(); ++i) {
    const int first = i < component.fe->n_translations() ? 0 : 3;
    for (int c = 0; c < 3; ++c) {
      s->dof_node.push_back(i);
      s->dof_component.push_back(first + c);
    }
  }
  s->rigid_body =
      rigid_body(component.fe->M, component.geometry->coordinates, component.fe->n_rotations);
  return s;
}

MeshModes mesh_modes(const MeshedComponent& component, const std::vector<HeldDirection>& held,
                     const MeshModesWanted& wanted, const std::string& where) {
  MeshModes modes;
  auto nodes = mesh_nodes(component);
  auto form = std::make_shared<DiagonalForm>();
  const SparseMatrix Z = free_basis(nodes->coordinates.rows(), held);
  const SparseMatrix K = Z.transpose() * component.fe->K * Z,
                     M = Z.transpose() * component.fe->M * Z;
  Matrix Phi(3 * nodes->coordinates.rows(), 0);
  if (K.rows() > 0) {
    const double sigma = -shift * K.diagonal().sum() / M.diagonal().sum();
    auto factor = std::make_shared<SparseCholesky>(SparseMatrix(K - sigma * M));
    if (!factor->ok())
      throw RunError(where + ": the stiffness of the mesh is not positive semidefinite");
    const Eigenpairs pairs = lowest_pairs(K, M, *factor, sigma, wanted, where);
    form->omega.resize(pairs.lambda.size());
    for (Index j = 0; j < form->omega.size(); ++j)
      form->omega[j] = pairs.lambda[j] > -rigid_share * sigma ? std::sqrt(pairs.lambda[j]) : 0;
    form->n_rigid = (form->omega.array() == 0).count();
    Phi = Z * pairs.Phi;
    modes.factor_ = factor;
    modes.sigma_ = sigma;
  }
  form->V = Phi;
  const Matrix momenta = component.fe->M * rigid_modes(nodes->coordinates, nodes->rigid_body.center,
                                                       component.fe->n_rotations);
  form->E = Phi.transpose() * momenta;
  modes.inertia_ = momenta.leftCols(3);
  modes.Z_ = Z;
  modes.M_ = M;
  modes.nodes = nodes;
  modes.form = form;
  return modes;
}

Matrix MeshModes::left_out(const Matrix& forces, int order) const {
  if (!factor_) return Matrix::Zero(forces.rows(), forces.cols());
  Matrix u = factor_->solve(Matrix(Z_.transpose() * forces));
  if (order == 1) u = factor_->solve(Matrix(M_ * u));
  const Vector weight = (form->omega.array().square() - sigma_).pow(-1 - order);
  return Z_ * u - form->V * (weight.asDiagonal() * (form->V.transpose() * forces));
}

}  // namespace cbr
