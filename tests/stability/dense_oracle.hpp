// SPDX-License-Identifier: GPL-3.0-or-later
// What the product finds by sparse and clever ways, by dense matrices and brute force: reduction, frequencies, motion, response to
// impulses, contact with a plane. Nothing of the product is used but element matrices and the weights of faces.
#pragma once

#include <vector>

#include "common/assembly.hpp"
#include "common/scene.hpp"
#include "common/superelement.hpp"

namespace cbr::test {

// Component axes; dof 3 i + c is component c of node i.
struct DenseModel {
  std::vector<Index> nodes;  // of the mesh, those that volume elements use, ascending
  Matrix K, M;
};
DenseModel dense_model(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass);

// M phi = lambda phi K, ascending; V^T M V = I. Rigid motions get lambda = 0.
struct DenseModes {
  Vector lambda;
  Matrix V;
};
DenseModes dense_modes(const Matrix& K, const Matrix& M);

// Craig-Bampton: K = diag(eigenvalues, K_cc), M = [I M_kc; M_kc^T M_cc]; `interface`: dofs of the model, in the order of c.
struct DenseReduction {
  Vector eigenvalues;
  Matrix K_cc, M_cc, M_kc;
  double gap = 0;  // of the measure by which modes were chosen, between the last one in and the first one out, relative
  Matrix K() const;
  Matrix M() const;
};
DenseReduction dense_reduction(const DenseModel& model, const std::vector<Index>& interface, Index k, const std::string& pick);

// One body that moves by itself and against one plane.
struct DenseBody {
  Matrix K, M;               // of the free coordinates q
  Matrix B;                  // 3 n x q: displacements of its n visible nodes, scene axes
  Points X;                  // n x 3, scene axes
  Vector velocity;           // q' at the start
  std::vector<Vector> load;  // amplitude of each load on q
  std::vector<History> history;
  enum class Scheme { exact, central, newmark } scheme = Scheme::exact;
  bool lasting = false;      // impulses of contact have the compliance of a force that lasts (docs/theory.md, 9a)
  std::vector<Index> slave;  // visible nodes that a plane holds back
  Vector3 normal = Vector3::Zero();
  double offset = 0;  // normal . x >= offset
};

// G S(h) G^T of all visible dofs: what impulses at the start of a step do to its end.
Matrix dense_response(const DenseBody& body, double h);

struct DenseMotion {
  std::vector<Matrix> x;         // at each output: positions, n x 3
  std::vector<Vector3> impulse;  // of the plane since the last output
};
DenseMotion dense_motion(const DenseBody& body, double h, Index n_outputs, Index steps_per_output);

}  // namespace cbr::test
