// SPDX-License-Identifier: GPL-3.0-or-later
// Nastran's direct matrix input at points. Fields of 16 columns, so that an entry has 10 digits, 9
// with an exponent of three.
#include <ostream>
#include <string>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {
namespace {

constexpr Index largest_number = 99'999'999;

// 16 columns, the exponent marked by D as in double precision
std::string field(double value) {
  std::string text = format_text("%.9E", value);
  if (text.size() > 16) text = format_text("%.8E", value);
  text[text.find('E')] = 'D';
  return format_text("%16s", text.c_str());
}

std::string coordinate(double value) { return format_text("%16.9E", value); }

std::string field(Index value) { return format_text("%16lld", static_cast<long long>(value)); }

// One column after the other; of each the entries on the diagonal and below, as the matrix is
// symmetric (IFO 6).
void write_matrix(const char* name, const Matrix& A, const std::vector<ReducedRow>& rows,
                  std::ostream& out) {
  Index n_entries = 0;  // the format itself does not reveal missing lines
  for (Index j = 0; j < A.cols(); ++j)
    n_entries += (A.col(j).tail(A.rows() - j).array() != 0).count();
  out << "$ " << name << ": " << n_entries << " entries\n";
  out << format_text("DMIG    %-8s       0       6       2       0\n", name);
  for (Index j = 0; j < A.cols(); ++j) {
    const ReducedRow& column = rows[j];
    bool has_entry = false;
    for (Index i = j; i < A.rows(); ++i) {
      if (A(i, j) == 0) continue;
      if (!has_entry) {
        out << format_text("DMIG*   %-16s", name) << field(column.node) << field(Index{column.dof})
            << '\n';
        has_entry = true;
      }
      const ReducedRow& row = rows[i];
      out << "*       " << field(row.node) << field(Index{row.dof}) << field(A(i, j)) << '\n';
    }
  }
}

// - u + T q = 0: the interface's dofs are the dependent ones.
void write_equations(const ReducedMatrices& reduced, std::ostream& out) {
  for (Index i = 0; i < reduced.T.rows(); ++i) {
    const ReducedRow& dof = reduced.interface[i];
    out << "MPC*    " << field(Index{1}) << field(dof.node) << field(Index{dof.dof}) << field(-1.0);
    for (Index j = 0; j < reduced.T.cols(); ++j)
      out << (j % 2 == 0 ? "\n*       " : "\n*                       ")
          << field(reduced.rows[j].node) << field(Index{0}) << field(reduced.T(i, j));
    out << '\n';
  }
}

// Fields of SPOINT have eight columns, and Nastran takes no larger number.
void require_numbers(const std::vector<ReducedRow>& rows) {
  for (const ReducedRow& row : rows)
    if (row.node > largest_number)
      throw InputError("node " + std::to_string(row.node) +
                       " found, but Nastran's numbers end at " + std::to_string(largest_number) +
                       (row.dof == 0 ? ": give a lower --first-modal-node"
                                     : ": renumber the mesh, or export matrix-market or op4"));
}

}  // namespace

void write_dmig(const ReducedMatrices& reduced, std::ostream& out) {
  require_numbers(reduced.rows);
  require_numbers(reduced.interface);
  out << "$ A superelement of cbr: K2GG = KAAX, M2GG = MAAX"
      << (reduced.T.size() > 0 ? ", MPC = 1" : "") << " in the case control section.\n"
      << "$ Grid points and their coordinates, and the modal coordinates: the table beside this "
         "file.\n";
  for (const ReducedRow& row : reduced.rows) {
    if (row.dof == 0) out << format_text("SPOINT  %8lld\n", static_cast<long long>(row.node));
  }
  // Points of the interface, which no mesh has
  for (const ReducedRow& row : reduced.rows) {
    if (row.dof != 6) continue;
    out << format_text("GRID*   %16lld%16s", static_cast<long long>(row.node), "")
        << coordinate(row.position(0)) << coordinate(row.position(1)) << "\n*       "
        << coordinate(row.position(2)) << '\n';
  }
  write_matrix("KAAX", reduced.K, reduced.rows, out);
  write_matrix("MAAX", reduced.M, reduced.rows, out);
  write_equations(reduced, out);
}

}  // namespace cbr
