// SPDX-License-Identifier: GPL-3.0-or-later
// The interior of a component: products with K_II and M_II, and solves. One interface for one
// process and for several that share its rows.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// Of matrices of vectors each process has its own rows (n_rows() x m). All processes call each
// function at the same time, with as many columns.
class Interior {
 public:
  explicit Interior(const Partition& partition) : p(partition) {}
  virtual ~Interior() = default;

  // K_IC, M_IC, R_I and P_I have this process's rows, R_C and P_C all rows. K_CC and M_CC are 0
  // but in the first process.
  const Partition& p;

  Index n_rows() const { return p.K_IC.rows(); }
  // Numbers of this process's nodes among the interior's; null: all.
  virtual const std::vector<Index>* own_nodes() const { return nullptr; }

  virtual Matrix times_stiffness(const Matrix& X) const = 0;    // K_II X
  virtual void add_mass(const Matrix& X, Matrix& Y) const = 0;  // Y += M_II X
  virtual void solve_in_place(Matrix& X) const = 0;             // X <- K_II^-1 X
  virtual Matrix sum(Matrix part) const { return part; }        // over the processes, to all
  virtual Matrix gather(Matrix own) const { return own; }       // all rows, in the first
  // Does the work in the first process. An error is thrown in all.
  virtual void in_first(const std::function<void()>& work) const { work(); }
  // The first process's result, to all.
  virtual Matrix from_first(const std::function<Matrix()>& result) const { return result(); }

  std::vector<Index> list_from_first(const std::function<std::vector<Index>()>& result) const {
    const Matrix numbers = from_first([&] {
      const std::vector<Index> list = result();
      return Matrix(Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>>(
                        list.data(), static_cast<Index>(list.size()))
                        .cast<double>());
    });
    std::vector<Index> list;
    for (const double number : numbers.reshaped()) list.push_back(static_cast<Index>(number));
    return list;
  }

  Matrix times_mass(const Matrix& X) const {
    Matrix Y = Matrix::Zero(X.rows(), X.cols());
    add_mass(X, Y);
    return Y;
  }
  // A^T B over all rows
  Matrix inner(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Matrix>& B) const {
    return sum(A.transpose() * B);
  }
  double norm(const Matrix& x) const {
    return std::sqrt(sum(Matrix::Constant(1, 1, x.squaredNorm()))(0, 0));
  }
};

// All rows in one process.
class LocalInterior final : public Interior {
 public:
  LocalInterior(const Partition& partition, const SparseCholesky& factor)
      : Interior(partition), factor_(factor) {}

  Matrix times_stiffness(const Matrix& X) const override { return p.K_II * X; }
  void add_mass(const Matrix& X, Matrix& Y) const override { Y.noalias() += p.M_II * X; }
  void solve_in_place(Matrix& X) const override { factor_.solve_in_place(X); }

 private:
  const SparseCholesky& factor_;
};

}  // namespace cbr
