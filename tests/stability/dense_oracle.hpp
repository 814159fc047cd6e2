// SPDX-License-Identifier: GPL-3.0-or-later
// Reference results by dense matrices and brute force: models, frequencies and reduction here,
// motion in dense_body.hpp, contact in dense_search.hpp, dense_laws.hpp and dense_run.hpp. Only
// element matrices and weights of faces are the product's.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr::test {

// Component axes; dof 3 i + c is component c of node i.
struct DenseModel {
  std::vector<Index> nodes;  // of the mesh, those in volume elements, ascending
  Matrix K, M;
};
DenseModel dense_model(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                       MassKind mass);

// K phi = lambda M phi, ascending; V^T M V = I. Rigid motions have lambda = 0.
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
  // relative difference of the measure for the choice of modes, between the last one in and the
  // first one out
  double gap = 0;
  Matrix K() const;
  Matrix M() const;
};
DenseReduction dense_reduction(const DenseModel& model, const std::vector<Index>& interface,
                               Index k, const std::string& pick);

}  // namespace cbr::test
