// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors of a Krylov space that grows, and their products. For the .cpp of this folder.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Columns of length n in panels, so that growth copies nothing. Our own threads multiply slabs of
// rows and sum fixed parts: the bytes do not depend on the number of threads. BLAS must have one
// thread meanwhile.
class TallBasis {
 public:
  // Columns come in blocks of `block`, at most `most` of them.
  TallBasis(Index n, Index block, Index most);

  Index rows() const { return n_; }
  // Columns first ... first + block - 1, where first is a whole number of blocks; made when there
  // are none.
  Eigen::Ref<Matrix> block(Index first);

  // V^T P of the first columns, V: n x columns   (columns x p)
  Matrix transposed_product(Index columns, const Eigen::Ref<const Matrix>& P) const;
  // U <- U - V h, h: columns x p
  void subtract(const Matrix& h, Eigen::Ref<Matrix> U) const;
  // V S of the first columns, S: columns x p   (n x p)
  Matrix combined(const Eigen::Ref<const Matrix>& S) const;
  // The first p columns of V become V S, p at most columns and a whole number of blocks. Other
  // columns stay.
  void rotate(const Eigen::Ref<const Matrix>& S);

 private:
  Index n_slabs() const;
  Matrix gathered(Index first_row, Index n_rows, Index columns) const;

  Index n_ = 0, block_ = 0, panel_ = 0;
  std::vector<Matrix> panels_;
};

// U^T P by slabs, as above   (u x p)
Matrix tall_product(const Eigen::Ref<const Matrix>& U, const Eigen::Ref<const Matrix>& P);
// U <- U - V h
void subtract_product(const Eigen::Ref<const Matrix>& V, const Eigen::Ref<const Matrix>& h,
                      Eigen::Ref<Matrix> U);
// U <- U T, T: a few columns
void multiply_on_right(const Eigen::Ref<const Matrix>& T, Eigen::Ref<Matrix> U);

// M U of a symmetric sparse M with both triangles stored, on our threads   (n x p)
void multiply_symmetric(const SparseMatrix& M, const Eigen::Ref<const Matrix>& U, Matrix& P);

}  // namespace cbr
