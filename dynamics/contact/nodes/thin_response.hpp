// SPDX-License-Identifier: GPL-3.0-or-later
// Response of a body with few coordinates and with residual compliance of node directions.
#pragma once

#include <memory>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/compliance_levels.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {

// F (s x s), length / force, symmetric, positive semi-definite. Copies share it.
class StaticCompliance {
 public:
  StaticCompliance() : dense_(std::make_shared<const Matrix>()) {}
  StaticCompliance(std::shared_ptr<const Matrix> F) : dense_(std::move(F)) {}
  explicit StaticCompliance(const std::vector<ComplianceLevel>& levels);

  Index size() const { return dense_ ? dense_->rows() : levels_.front().P.cols(); }
  const Matrix* dense() const { return dense_.get(); }  // null: levels
  Matrix formed() const;
  StaticCompliance of_rows(const std::vector<Index>& rows) const;  // F(rows, rows)

  Matrix operator*(const Matrix& X) const;
  // y_k += F x_k for vectors x_k of a few rows
  void add_products(const std::vector<std::vector<RowWeight>>& x,
                    const std::vector<double*>& y) const;
  void add_product(const std::vector<RowWeight>& x, double* y) const { add_products({x}, {y}); }
  // y[i] += (F x)[rows[i]]. Of levels; for a few rows.
  void add_product_at(const std::vector<RowWeight>& x, const std::vector<Index>& rows,
                      Vector& y) const;

 private:
  struct Level {
    SparseMatrix P;
    std::shared_ptr<const SparseMatrix> S;
    Vector at_places(const std::vector<RowWeight>& x) const;  // S P x
  };
  std::shared_ptr<const Matrix> dense_;
  std::vector<Level> levels_;
};

// Residual compliance: directions of contact nodes that forces move without inertia. u = B F B^T f,
// column i of B (3 m x s) with direction i on the three dofs of its node.
struct StaticRows {
  std::vector<Index> node;   // s, ascending
  Points direction;          // s x 3, unit, in the axes of the response
  std::vector<Index> first;  // m + 1: the rows of node i are first[i] .. first[i + 1] - 1
  StaticCompliance F;

  Index size() const { return static_cast<Index>(node.size()); }
  // B^T f for columns f of nodal forces (3 m x q)   (s x q)
  void gather(const Matrix& f, Matrix& rows) const;
  // u += B w   (3 m x q)
  void add_spread(const Matrix& w, Matrix& u) const;
};

// For nodes without residual compliance.
std::shared_ptr<const StaticRows> no_static_rows(std::size_t n_nodes);

// S = A^T C A + B F B^T / h   (3 m x 3 m), never formed. Shared by the instances of a component.
struct ThinResponse {
  std::shared_ptr<const Matrix> A;  // r x 3 m, nodal displacements per coordinate; r may be 0
  Matrix C;  // r x r, symmetric: response of the coordinates to forces on them
  std::shared_ptr<const StaticRows> rows;
  double h = 0;
  bool C_is_diagonal = false;  // modal coordinates: products with C are cheap

  Index n_dofs() const { return A->cols(); }
  // C x of columns x   (r x q)
  Matrix weighed(const Matrix& x) const;
};

// Workspace of respond(), owned by the caller.
struct ThinWork {
  Vector kick;
  Matrix pressed;
  std::vector<Index> columns;
};

// move = S p and its static part still = F B^T p / h   (s x q), for q = 1 or 2 columns of impulses
// p (3 m x q). `still_is_known`: `still` is an input. Returns the number of bytes of the response
// read.
double respond(const ThinResponse& S, const Matrix& p, Matrix& move, Matrix& still, ThinWork& work,
               bool still_is_known = false);
// still (s x q) = F rows, for rows (s x q), by the same choice of reads.
double press(const StaticRows& rows, const Matrix& pressed, Matrix& still,
             std::vector<Index>& columns);

}  // namespace cbr
