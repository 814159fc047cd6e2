// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/condensation: the interior condensed statically, and rigid motions kept
// exact in it.
//
// K and M of the interface with the interior condensed statically, and its inertia coupling to the
// fixed-interface modes.
#pragma once

#include "common/app/report.hpp"
#include "common/base/types.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/partition/interior.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

enum class CondensationWay {
  automatic,  // the cheaper one in flops that fits the memory
  product,    // Psi whole, Psi^T M_II Psi as one symmetric product: n_I c^2 flops and 8 n_I c bytes
  fronts,  // with the factorisation, K and M front by front, no Psi: SparseCholesky::condensing()
  second_solve,  // Psi in panels, Psi^T Y = -K_CI K_II^-1 Y by another solve: 4 nnz(L) c flops, 16
                 // n_I bytes per column of a panel
};

// Columns of a panel where memory allows: enough for BLAS, few enough that a supernode's rows of a
// panel stay in the cache.
constexpr Index good_panel = 128;

struct CondensationOptions {
  double memory = 4e9;  // bytes for Psi and its companions
  CondensationWay way = CondensationWay::automatic;
  Index panel = 0;        // columns, 0: chosen from memory
  bool keep_Psi = false;  // for the recovery of the interior
  // M_kc by the very Psi that M_cc is made with, which an ill-conditioned K_II makes two of
  bool one_Psi = false;
};

// For CondensationOptions::one_Psi. condition: of K_II, scaled by its diagonal.
inline bool needs_one_Psi(double condition) { return condition > 1e9; }

struct CondensationFigures {
  CondensationWay way = CondensationWay::product;
  Index panel = 0;
  double solve_flops = 0, product_flops = 0;
  double front_flops = 0;  // of a condensation that came with the factorisation
  RigidFigures rigid;
};

struct Condensation : CondensationFigures {
  Matrix K_cc, M_cc;  // c x c, exactly symmetric
  Matrix M_kc;        // k x c
  Matrix Psi;         // n_I x c when kept, else empty
  SparseMatrix G;     // rigid_content() of M_cc, for RigidMotions
};

// Psi = -K_II^-1 K_IC; K_cc = K_CC + K_CI Psi; M_cc = M_CC + Psi^T M_IC + M_CI Psi + Psi^T M_II
// Psi; M_kc = Phi^T (M_IC + M_II Psi)   (Craig, Bampton 1968, doi 10.2514/3.4741; the paper's Eqs
// 2-4). Phi: n_I x k, may have no columns. Psi follows partition.rigid exactly, in all of them.
Condensation condense(const Partition& partition, const SparseCholesky& factor, const Matrix& Phi,
                      const CondensationOptions& options, Report& report);

// The rest of it where K_cc and M_cc came with the factor: one solve of each of Phi's columns and
// of the rigid motions.
Condensation complete(const Partition& partition, const SparseCholesky& factor, const Matrix& Phi,
                      Condensed&& condensed);

// M_kc = Phi^T M_IC - (K_II^-1 M_II Phi)^T K_IC   (k x c): the same for vectors that come later. k
// solves.
Matrix mode_coupling(const Interior& interior, const Matrix& Phi);

// The same by the very Psi of condense(), in panels that are for M_kc alone: without the products
// for K_cc and M_cc.
Matrix mode_coupling_of_one_Psi(const Partition& partition, const SparseCholesky& factor,
                                const Matrix& Phi, const CondensationOptions& options,
                                Report& report);

// Value of `memory` 0: half of this machine's, in bytes.
double half_of_memory();
// InputError when K_cc and M_cc of c interface dofs, dense, need more than `memory` bytes.
void require_memory_for_interface(Index c, double memory);
// Bytes for panels of constraint modes: `given`, or for 0 half of this machine's. Less when the
// factor leaves too little memory. A panel of useful width takes 16 n_I bytes a column and thread.
double panel_memory(double given, const Partition& p, const SparseCholesky& factor,
                    const Matrix& Phi);

// B^T A^-1 B   (s x s), exactly symmetric, for B (n x s) with entries in few rows. Of L only the
// part is visited that these rows reach (Gilbert, Liu 1993, doi 10.1137/0614019), in panels with
// all threads. bytes: of the panels of all threads together.
Matrix reached_compliance(const SparseCholesky& factor_of_A, const SparseMatrix& B,
                          double bytes = 1e9);

}  // namespace cbr
