// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/base: types, errors, text of numbers, threads, memory: what everything else
// stands on.
//
// The array types that every other header speaks in, and lists of indices. Storage order is settled
// here and nowhere else.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>
#include <vector>

namespace cbr {

using Index = std::int64_t;
inline int as_int(Index n) { return static_cast<int>(n); }  // for BLAS and LAPACK
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;  // column-major, as BLAS, LAPACK and ARPACK want it
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
// Of six motions: x, y, z, and rotations about them.
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Compressed by columns, 64-bit indices: a million dofs overflow 32 bits in the factor.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;

// One contiguous row per coordinate, as in the files, for access to a few rows (V of a diagonal
// form).
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One row per point, so that a row is contiguous and a file's n x 3 dataset is this memory.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
// One row per element or face: node indices from 0.
using IndexTable = Eigen::Matrix<Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Called with the share of the work that is done, 0 to 1, by the thread that asked for the work.
// May be empty.
using Progress = std::function<void(double)>;

// 0, 1, ... n - 1.
inline std::vector<Index> first_numbers(Index n) {
  std::vector<Index> list(n);
  std::iota(list.begin(), list.end(), Index{0});
  return list;
}

// These by `before`; equal ones ascend.
template <class Before>
std::vector<Index> order_by(Index n, const Before& before) {
  std::vector<Index> order = first_numbers(n);
  std::stable_sort(order.begin(), order.end(), before);
  return order;
}

// Sorted, each entry once.
template <class List>
void sort_uniquely(List& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace cbr
