// SPDX-License-Identifier: GPL-3.0-or-later
// Abaqus's *MATRIX INPUT. CalculiX takes the same lines with *MATRIX ASSEMBLE (from 2.21 on):
// Dhondt, CalculiX CrunchiX User's Manual.
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

void write_calculix_input(const ReducedMatrices& reduced, const std::string& name,
                          std::ostream& out) {
  out << "** A superelement of cbr: *INCLUDE this file in the model. Nodes without a place "
         "of their own are modal\n"
      << "** coordinates; their dof is 1. A *FREQUENCY or *DYNAMIC step needs a material with a "
         "*DENSITY in the model.\n*NODE, NSET=CBR\n";
  Index last = -1;
  for (const auto* rows : {&reduced.interface, &reduced.rows})
    for (const ReducedRow& row : *rows) {
      if (row.node == last) continue;
      last = row.node;
      out << row.node
          << format_text(", %.17g, %.17g, %.17g\n", row.position(0), row.position(1),
                         row.position(2));
    }
  out << "*MATRIX ASSEMBLE, NAME=CBR, STIFFNESS FILE=" << name << calculix_K
      << ", MASS FILE=" << name << calculix_M << '\n';
  // - u + T q = 0, four terms a line, whose fields have at most 20 columns
  for (Index i = 0; i < reduced.T.rows(); ++i) {
    const ReducedRow& dof = reduced.interface[i];
    out << "*EQUATION\n" << reduced.T.cols() + 1 << '\n' << dof.node << ',' << dof.dof << ",-1";
    for (Index j = 0; j < reduced.T.cols(); ++j)
      out << (j % 4 == 3 ? ",\n" : ",") << reduced.rows[j].node
          << format_text(",1,%.13g", reduced.T(i, j));
    out << '\n';
  }
}

}  // namespace cbr
