// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/mesh_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// Shift for free meshes, relative to mean stiffness over mass: far below elastic modes, far above
// round-off.
constexpr double shift = 1e-9;
// Shift of the residual series for a mesh with rigid motions, relative to the lowest elastic
// eigenvalue, so that rigid motions do not dominate it.
constexpr double series_shift = 0.1;

// Orthonormal basis of the unconstrained directions   (3 n x free).
SparseMatrix free_basis(Index n, const std::vector<HeldDirection>& held) {
  std::vector<std::vector<Vector3>> of_node(static_cast<std::size_t>(n));
  for (const HeldDirection& direction : held)
    of_node[direction.node].push_back(direction.direction);
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index column = 0;
  for (Index node = 0; node < n; ++node) {
    const auto& directions = of_node[node];
    const Matrix3 Q = complete_basis(directions);
    for (Index f = static_cast<Index>(directions.size()); f < 3; ++f, ++column)
      for (int c = 0; c < 3; ++c)
        if (Q(c, f) != 0) entries.emplace_back(3 * node + c, column, Q(c, f));
  }
  SparseMatrix Z(3 * n, column);
  Z.setFromTriplets(entries.begin(), entries.end());
  return Z;
}

// The lowest `count`, or increasing numbers until an elastic mode exceeds the frequency.
Eigenpairs lowest_pairs(const SparseMatrix& K, const SparseMatrix& M, const SparseCholesky& factor,
                        double sigma, const MeshModesWanted& wanted, const std::string& where) {
  const Index n = static_cast<Index>(K.rows());
  const double highest = std::pow(2 * std::numbers::pi * wanted.up_to_hz, 2);
  Index k = wanted.count.value_or(32);
  if (wanted.is_joined && takes_all_modes(n, k)) k = n;
  for (;; k *= 2) {
    k = std::min(k, n);
    Eigenpairs pairs = sparse_eigenpairs(K, M, factor, sigma, k);
    if (!pairs.converged) throw RunError(where + ": the frequencies of the mesh did not converge");
    if (k == n || (wanted.count && wanted.up_to_hz == 0)) return pairs;
    const double last = pairs.lambda[k - 1];
    if ((wanted.count || last > highest) &&
        last > round_off_of_energy(K, pairs.Phi.rightCols(1))[0])
      return pairs;
  }
}

}  // namespace

Vector round_off_of_energy(const SparseMatrix& K, const Matrix& Phi) {
  const Matrix size = Phi.cwiseAbs();
  const SparseMatrix K_size = K.cwiseAbs();
  return energy_round_off * size.cwiseProduct(K_size * size).colwise().sum().transpose();
}

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
  auto form = std::make_shared<ModalForm>();
  modes.Z = free_basis(nodes->coordinates.rows(), held);
  modes.K = modes.Z.transpose() * component.fe->K * modes.Z;
  modes.M = modes.Z.transpose() * component.fe->M * modes.Z;
  const SparseMatrix &Z = modes.Z, &K = modes.K, &M = modes.M;
  Matrix Phi(3 * nodes->coordinates.rows(), 0);
  if (K.rows() > 0) {
    const double sigma = -shift * K.diagonal().sum() / M.diagonal().sum();
    auto factor = std::make_shared<SparseCholesky>(SparseMatrix(K - sigma * M));
    if (!factor->ok()) throw RunError(where + ": " + no_factor);
    const Eigenpairs pairs = lowest_pairs(K, M, *factor, sigma, wanted, where);
    form->omega = (pairs.lambda.array() > round_off_of_energy(K, pairs.Phi).array())
                      .select(pairs.lambda.cwiseMax(0).cwiseSqrt(), 0);
    form->n_rigid = (form->omega.array() == 0).count();
    Phi = Z * pairs.Phi;
    modes.factor_ = factor;
    modes.sigma_ = sigma;
    const Index n_elastic = form->omega.size() - form->n_rigid;
    if (wanted.up_to_hz > 0 && form->n_rigid > 0 && n_elastic > 0) {
      modes.sigma_ = -series_shift * std::pow(form->omega[form->n_rigid], 2);
      modes.factor_ = std::make_shared<SparseCholesky>(SparseMatrix(K - modes.sigma_ * M));
    }
  }
  form->V = Phi;
  const Matrix momenta = component.fe->M * rigid_modes(nodes->coordinates, nodes->rigid_body.center,
                                                       component.fe->n_rotations);
  form->E = Phi.transpose() * momenta;
  modes.inertia_ = momenta.leftCols(3);
  modes.nodes = nodes;
  modes.form = form;
  return modes;
}

// Removes modes after each solve, as the next solve would amplify their round-off.
std::vector<Matrix> MeshModes::left_out(const Matrix& forces, int terms) const {
  std::vector<Matrix> series;
  const Matrix Phi = Z.transpose() * form->V;
  const Matrix M_Phi = M * Phi;
  Matrix f = Z.transpose() * forces;
  f -= M_Phi * (Phi.transpose() * f);
  for (int i = 0; i < terms; ++i) {
    if (!factor_) {
      series.emplace_back(Matrix::Zero(forces.rows(), forces.cols()));
      continue;
    }
    Matrix u = factor_->solve(f);
    u -= Phi * (M_Phi.transpose() * u);
    series.emplace_back(Z * u);
    f = M * u;
  }
  return series;
}

}  // namespace cbr
