// SPDX-License-Identifier: GPL-3.0-or-later
// Compliance of static rows: a dense matrix, or the levels of many rows.
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

}  // namespace cbr
