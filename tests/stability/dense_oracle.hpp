// SPDX-License-Identifier: GPL-3.0-or-later
// What the product finds by sparse and clever ways, by dense matrices and brute force: models,
// frequencies, reduction here, motion in dense_body.hpp, contact in dense_search.hpp,
// dense_laws.hpp and dense_run.hpp. Nothing of the product is used but element matrices and the
// weights of faces.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr::test {

// Component axes; dof 3 i + c is component c of node i.
struct DenseModel {
  std::vector<Index> nodes;  // of the mesh, those that volume elements use, ascending
  Matrix K, M;
};
DenseModel dense_model(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                       MassKind mass);

// M phi = lambda phi K, ascending; V^T M V = I. Rigid motions get lambda = 0.
struct DenseModes {
  Vector lambda;
  Matrix V;
};
DenseModes dense_modes(const Matrix& K, const Matrix& M);

// Craig-Bampton: K = diag(eigenvalues, K_cc), M = [I M_kc; M_kc^T M_cc]; `interface`: dofs of the
// model, in the order of c.
struct DenseReduction {
  Vector eigenvalues;
  Matrix K_cc, M_cc, M_kc;
  // of the measure by which modes were chosen, between the last one in and the first one out,
  // relative
  double gap = 0;
  Matrix K() const;
  Matrix M() const;
};
DenseReduction dense_reduction(const DenseModel& model, const std::vector<Index>& interface,
                               Index k, const std::string& pick);

}  // namespace cbr::test
