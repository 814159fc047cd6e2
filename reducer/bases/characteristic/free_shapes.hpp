// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic without dense matrices of the interface: shapes of the whole free component
// by sparse solves, beside the fixed-interface modes. docs/theory.md, "An interface of few shapes".
#pragma once

#include <optional>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "reducer/bases/characteristic/characteristic.hpp"
#include "reducer/bases/characteristic/compliance_probes.hpp"
#include "reducer/bases/characteristic/statics.hpp"
#include "reducer/modes/free_factor.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// Motions of all N dofs of a free component of one part, and its response to contact forces.
struct FreeShapes {
  Matrix N, P;      // N x 6: rigid motions, N^T M N = 1, and P = M N
  Matrix U;         // N x r: shapes without rigid motions in them (P^T U = 0)
  Matrix K_U, M_U;  // their forces, once follow_statically() has found them
  // ascending eigenvalues of the free component's elastic modes, some beyond those in U
  Vector lambda;
  // s x s: B^T U_B of the static forces B, inertia in balance with them; of `probes`: their answers
  Matrix compliance;
  std::optional<ComplianceProbes> probes;  // of many forces
  Matrix pushed;   // s x 6, with loads or kept dofs: N^T B of these forces, transposed
  Matrix inertia;  // 6 x 6, with pushed: P_I^T K_II^-1 P_I, by follow_statically()
  Index n_modes = 0, n_kept = 0, n_uniform = 0, n_loads = 0;  // of the columns of U
  std::vector<std::string> bare;                              // sets_without_statics()
};

// True where free_shapes() serves: a large interface, one part with an interior, few kept dofs,
// only uniform patterns.
bool few_enough(const CharacteristicOptions& options, bool one_part, Index n_interior,
                const Superelement& s);

// Shapes: the `modes` lowest elastic modes of the free component (one more where the last has a
// twin), unit displacements of kept dofs, responses to uniform pressures and to the scene's loads.
// p: partition of the interface of s; forces: of static_forces(). None when the stiffness has more
// null vectors than rigid motions. More forces than `most_dense` have probes.
// InputError: more modes than dofs. RunError: of the eigensolver.
std::optional<FreeShapes> free_shapes(const CharacteristicOptions& options,
                                      const FreeComponent& model, const FreeFactor& factor,
                                      const Partition& p, const StaticShare& forces,
                                      const Superelement& s, Report& report,
                                      Index most_dense = most_dense_forces);

// The interior of the shapes follows their interface statically, U_I = -K_II^-1 K_IC U_C, so that
// they span a subspace of Craig and Bampton's. Fixed-interface modes add the interior's dynamics. r
// solves.
void follow_statically(const Partition& p, const SparseCholesky& factor_of_K_II,
                       FreeShapes& shapes);

// The component in the Ritz space of rigid motions, shapes and fixed-interface modes Phi (n_I x k,
// of eigenvalues lambda). Sets s.eigenvalues, s.characteristic.V and statics.F. Returns the figures
// but rho. The interior's rows of all coordinates (n_I x n), if wanted.
CharacteristicFigures take_free_shapes(const FreeShapes& shapes, const Vector& lambda,
                                       const Matrix& Phi, const Partition& p, Superelement& s,
                                       Matrix* interior);

// M_kc = Phi^T (M_IC + M_II Psi) of eigenvectors, without a solve: Phi^T M_IC - Lambda^-1 Phi^T
// K_IC   (k x c)
Matrix coupling_of_eigenvectors(const Partition& p, const Vector& lambda, const Matrix& Phi);

}  // namespace cbr
