// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <ostream>

#include "common/base/format_text.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {
namespace {

// Lower triangle: *MATRIX INPUT, TYPE=SYMMETRIC completes it. Entries where A or B is not 0.
void write(const Matrix& A, const Matrix& B, const std::vector<ReducedRow>& rows,
           std::ostream& out) {
  for (Index j = 0; j < A.cols(); ++j) {
    const ReducedRow& column = rows[j];
    for (Index i = j; i < A.rows(); ++i) {
      if (A(i, j) == 0 && B(i, j) == 0) continue;
      const ReducedRow& row = rows[i];
      out << row.node << ", " << std::max(row.dof, 1) << ", " << column.node << ", "
          << std::max(column.dof, 1) << ", " << format_text("%.17g", A(i, j)) << '\n';
    }
  }
}

}  // namespace

void write_abaqus_K(const ReducedMatrices& reduced, std::ostream& out) {
  write(reduced.K, reduced.K, reduced.rows, out);
}

void write_calculix_stiffness(const ReducedMatrices& reduced, std::ostream& out) {
  write(reduced.K, reduced.M, reduced.rows, out);
  // CalculiX takes matrices with three dofs at some node. This one moves nothing else
  if (reduced.T.size() == 0) return;
  const Index node = reduced.rows.back().node;
  out << node << ", 3, " << node << ", 3, " << format_text("%.17g", reduced.K.diagonal().maxCoeff())
      << '\n';
}

void write_abaqus_M(const ReducedMatrices& reduced, std::ostream& out) {
  write(reduced.M, reduced.M, reduced.rows, out);
}

}  // namespace cbr
