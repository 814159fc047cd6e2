// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_oracle.hpp"

#include <algorithm>

#include "common/linalg/dense.hpp"
#include "reducer/bases/reduce.hpp"

namespace cbr::test {
namespace {

using Dense = Eigen::MatrixXd;

Matrix chosen(const Matrix& A, const std::vector<Index>& rows, const std::vector<Index>& columns) {
  return A(rows, columns);
}

}  // namespace

DenseModel dense_model(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                       MassKind mass) {
  DenseModel model;
  std::vector<Index> place(mesh.coordinates.rows(), -1);
  for (const Block& block : mesh.blocks)
    for (Index i = 0; i < block.connectivity.size(); ++i) place[block.connectivity.data()[i]] = 0;
  for (std::size_t i = 0; i < place.size(); ++i)
    if (place[i] == 0) {
      place[i] = static_cast<Index>(model.nodes.size());
      model.nodes.push_back(static_cast<Index>(i));
    }
  const Index n = 3 * static_cast<Index>(model.nodes.size());
  model.K = model.M = Matrix::Zero(n, n);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const std::vector<Index> nodes(block.connectivity.row(e).begin(),
                                     block.connectivity.row(e).end());
      const Points X = mesh.coordinates(nodes, Eigen::all);
      const Matrix K = element_stiffness(block.type, properties[b].hex, X, properties[b].material);
      const Matrix M =
          mass == MassKind::lumped
              ? Matrix(
                    element_lumped_mass(block.type, X, properties[b].material.density).asDiagonal())
              : element_mass(block.type, X, properties[b].material.density);
      for (Index i = 0; i < X.rows(); ++i)
        for (Index j = 0; j < X.rows(); ++j) {
          const Index row = 3 * place[nodes[i]], column = 3 * place[nodes[j]];
          model.K.block<3, 3>(row, column) += K.block<3, 3>(3 * i, 3 * j);
          model.M.block<3, 3>(row, column) += M(i, j) * Matrix3::Identity();
        }
    }
  }
  return model;
}

DenseModes dense_modes(const Matrix& K, const Matrix& M) {
  if (K.rows() == 0) return {};
  const SymmetricEigen solver = generalized_eigen(K, M);
  DenseModes modes{solver.values, solver.vectors};
  const double largest = modes.lambda.maxCoeff();
  for (double& lambda : modes.lambda)
    if (lambda < 1e-10 * largest) lambda = 0;
  return modes;
}

Matrix DenseReduction::K() const {
  const Index k = eigenvalues.size(), c = K_cc.rows();
  Matrix A = Matrix::Zero(k + c, k + c);
  A.topLeftCorner(k, k) = eigenvalues.asDiagonal();
  A.bottomRightCorner(c, c) = K_cc;
  return A;
}

Matrix DenseReduction::M() const {
  const Index k = eigenvalues.size(), c = K_cc.rows();
  Matrix A(k + c, k + c);
  A.topLeftCorner(k, k).setIdentity();
  A.topRightCorner(k, c) = M_kc;
  A.bottomLeftCorner(c, k) = M_kc.transpose();
  A.bottomRightCorner(c, c) = M_cc;
  return A;
}

DenseReduction dense_reduction(const DenseModel& model, const std::vector<Index>& interface,
                               Index k, const std::string& pick) {
  std::vector<char> kept(model.K.rows(), 0);
  for (const Index dof : interface) kept[dof] = 1;
  std::vector<Index> interior;
  for (Index i = 0; i < model.K.rows(); ++i)
    if (!kept[i]) interior.push_back(i);
  const Index n_I = interior.size(), c = static_cast<Index>(interface.size());
  const DenseModes modes =
      dense_modes(chosen(model.K, interior, interior), chosen(model.M, interior, interior));
  // T = [Phi Psi; 0 I] over all fixed-interface modes, then those that are kept
  Matrix T = Matrix::Zero(model.K.rows(), n_I + c);
  if (n_I > 0) {
    T(interior, Eigen::seqN(0, n_I)) = modes.V;
    T(interior, Eigen::seqN(n_I, c)) = -Ldlt(chosen(model.K, interior, interior))
                                            .solve(Dense(chosen(model.K, interior, interface)));
  }
  for (Index i = 0; i < c; ++i) T(interface[i], n_I + i) = 1;
  const Matrix K = T.transpose() * model.K * T, M = T.transpose() * model.M * T;
  std::vector<Index> order = first_numbers(n_I);
  DenseReduction reduced;
  reduced.gap = 1;
  if (pick == "participation" && k < n_I) {
    const Index candidates = n_mode_candidates(Pick::participation, k, n_I);
    if (candidates > 0 && candidates < n_I) {
      const double last = modes.lambda[candidates - 1], next = modes.lambda[candidates];
      reduced.gap = (next - last) / next;
    }
    const Vector share = M.topRightCorner(n_I, c).rowwise().squaredNorm();
    std::sort(order.begin(), order.begin() + candidates,
              [&](Index i, Index j) { return share[i] > share[j]; });
    if (k > 0 && k < candidates)
      reduced.gap = std::min(reduced.gap, 1 - share[order[k]] / share[order[k - 1]]);
    std::sort(order.begin(), order.begin() + k);
  } else if (k > 0 && k < n_I) {
    reduced.gap = (modes.lambda[k] - modes.lambda[k - 1]) / modes.lambda[k];
  }
  order.resize(k);
  reduced.eigenvalues = modes.lambda(order);
  reduced.M_kc = Matrix(M.topRightCorner(n_I, c))(order, Eigen::all);
  reduced.K_cc = K.bottomRightCorner(c, c);
  reduced.M_cc = M.bottomRightCorner(c, c);
  return reduced;
}

}  // namespace cbr::test
