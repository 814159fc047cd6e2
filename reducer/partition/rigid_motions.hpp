// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid motions of a component, which the interior has to follow exactly whatever round-off makes
// of K_II^-1 (docs/theory.md, "Round-off of rigid motions").
#pragma once

#include <vector>

#include "common/app/report.hpp"
#include "common/base/types.hpp"

namespace cbr {

struct Partition;

// Of the connected parts that have an interior, R^T M R = 1. Sparse: a row has the columns of its
// own part.
struct RigidMotions {
  SparseMatrix R_I, R_C;  // n_I x r, c x r
  SparseMatrix P_I, P_C;  // M R
  // r x c, rigid_content() of the condensed mass; empty before the condensation
  SparseMatrix G = {};
  Index of_part = 6;  // columns of each; of one with fixed dofs those that they leave

  Index count() const { return R_C.cols(); }
  Matrix momentum(const Matrix& Phi) const { return SparseMatrix(P_I.transpose()) * Phi; }
};

// x_I, x_C: nodes in the interior and on the interface, three dofs each, the interior's from row
// first_I on (modes of domains are before them). part_I, part_C: numbers of their connected parts.
// A part has none if its interface does not determine its motions.
RigidMotions rigid_motions(const Partition& p, const Points& x_I, const std::vector<Index>& part_I,
                           Index first_I, const Points& x_C, const std::vector<Index>& part_C);

// Largest |sum_j K_ij r_j| of sum_j |K_ij| max |r| over the rows and the columns r of R (rigid
// motions), and its row. Of a dense, reduced K the largest sum of all rows counts.
struct RigidResidual {
  double value = 0;
  Index row = -1;
};
RigidResidual rigid_residual(const SparseMatrix& K, const Matrix& R);
RigidResidual rigid_residual(const Matrix& K, const Matrix& R);

// How far from rigid a rigid motion of the interface was before it was put right, and is after it.
struct RigidFigures {
  // of the inertia of T R_C, T = [Psi; 1]: largest entry of R^T M T R_C - 1 and of (T R_C)^T M (T
  // R_C) - 1
  double lag = 0;
  double force = 0;  // RigidResidual of K_cc
  double mass = 0;   // largest entry of R_C^T M_cc R_C - 1, after it
};

// Psi <- Psi + (R_I - Psi R_C) G, which follows rigid motions exactly, and moves as before where no
// rigid motion is in it: G = S^-1 m^T, m = T^T M R (c x r), S = m^T R_C, G R_C = 1. So M_cc <- Q^T
// M_cc Q + G^T G, Q = 1 - R_C G, as m^T Q = 0. K_cc loses its round-off along rigid motions by an
// orthogonal projection, which adds the least. Both stay exactly symmetric.
RigidFigures follow_rigid_motions(const RigidMotions& rigid, const Matrix& m, Matrix& K_cc,
                                  Matrix& M_cc);

// G of an M_cc that does follow: G^T = M_cc R_C   (r x c)
SparseMatrix rigid_content(const RigidMotions& rigid, const Matrix& M_cc);

// M_kc + (Phi^T P_I - M_kc R_C) G   (k x c): Phi^T (M_IC + M_II Psi) with the same Psi. momentum:
// P_I^T Phi, over all processes   (r x k)
void follow_rigid_motions(const RigidMotions& rigid, const SparseMatrix& G, const Matrix& momentum,
                          Matrix& M_kc);

// For --verbose, and warnings; InputError where round-off has left too little of the interior's own
// motions. condition: of K_II, scaled; `where`: the node that is held the weakest, or nothing.
void judge_rigid(const RigidFigures& figures, double condition, const std::string& where,
                 Report& report);

}  // namespace cbr
