// SPDX-License-Identifier: GPL-3.0-or-later
// The inner loops of a full mesh's step, compiled for the instruction sets of x86-64-v4, -v3 and
// the plain one; which of them runs is found out once. Fields are three planes: component c of node
// i is at field[c * stride + i].
#pragma once

#include <cstddef>

#include "dynamics/motion/nodal/block_matrix.hpp"
#include "dynamics/motion/nodal/shared_elements.hpp"

namespace cbr {

// f += K_e u of batches first .. last - 1. f: planes of their own stride, whose entry 0 is node
// `f_begin`.
void add_box_forces(const SharedElements& shared, std::size_t first, std::size_t last,
                    const double* u, Index u_stride, double* f, Index f_stride, Index f_begin);

// Rows begin .. end - 1 of A x to y; x and y: three numbers a row.
void block_products(const BlockMatrix& A, const double* x, Index begin, Index end, double* y);

// Rows begin .. end - 1 of A x, when rows below begin have left in y what they add to them:
// component c of row i to f[c * stride + i - begin]. y: four numbers a row, row y_begin first; of
// these rows it is cleared, and what they add to rows above is left there. x: four numbers a row,
// the last of them zero.
void symmetric_block_products(const SymmetricBlockMatrix& A, const double* x, Index begin,
                              Index end, double* y, Index y_begin, double* f, Index stride);
// What rows begin .. end - 1 add to rows from `end` on, left in y, whose first row is `end`.
void symmetric_block_carry(const SymmetricBlockMatrix& A, const double* x, Index begin, Index end,
                           double* y);

// One component of nodes 0 .. n - 1:  v += s (load - f) / m,  u_end = u + h v.  load may be null:
// zero.
struct LeapfrogSpan {
  const double *f, *load, *inverse_mass, *u;
  double *v, *u_end;
};
void leapfrog(const LeapfrogSpan& span, Index n, double s, double h);

// Of a mesh that turns (mesh_frame.hpp), nodes 0 .. n - 1; planes have one stride, matrices are
// column-major.
// d = A^T u + B^T Y - shift
void turned_strain(const double* u, const double* Y, Index stride, const double* A, const double* B,
                   const double* shift, double* d, Index n);
// sums = sum (Y + d) x f   (3)
void moment_sums(const double* Y, const double* d, const double* f, Index stride, Index n,
                 double* sums);
// sums = sum m u (3), then sum u arm^T (9)
void fit_sums(const double* u, const double* arms, const double* mass, Index stride, Index n,
              double* sums);
// v += s ((load - R f) / m + W Y),  u_end = u + h v.  load may be null: zero. sums: fit_sums() of
// u_end, with arms m Y.
struct TurnedSpan {
  const double *f, *load, *mass, *inverse_mass, *u, *Y;
  double *v, *u_end;
};
void turned_leapfrog(const TurnedSpan& span, Index stride, Index n, const double* R,
                     const double* W, double s, double h, double* sums);

}  // namespace cbr
