// SPDX-License-Identifier: GPL-3.0-or-later
// Lines "row node, dof, column node, dof, entry" of Abaqus's *MATRIX INPUT and CalculiX's
// *MATRIX ASSEMBLE; comments begin with two asterisks.
#include "reducer/exchange/import/import.hpp"
#include "reducer/exchange/import/row_places.hpp"

namespace cbr {
namespace {

Matrix read_matrix(const std::filesystem::path& file, const std::vector<ReducedRow>& rows) {
  const RowPlaces places(rows, 1);
  TextLines lines(file);
  SymmetricEntries entries(static_cast<Index>(rows.size()));
  while (lines.next()) {
    if (lines.line().empty() || lines.line().starts_with("**")) continue;
    const auto fields = fields_of(lines.line(), ',');
    if (fields.size() != 5)
      lines.fail("expected five fields: row node, dof, column node, dof, entry");
    const Index i = places.place(lines, lines.whole(fields[0]), lines.whole(fields[1]));
    const Index j = places.place(lines, lines.whole(fields[2]), lines.whole(fields[3]));
    entries.set(lines, i, j, lines.number(fields[4]));
  }
  return entries.take();
}

ReducedMatrices read(const std::filesystem::path& stem, const std::string& program) {
  ReducedMatrices reduced;
  reduced.rows = read_rows(stem.string() + ".dofs.csv");
  reduced.K = read_matrix(stem.string() + ".K." + program + ".mtx", reduced.rows);
  reduced.M = read_matrix(stem.string() + ".M." + program + ".mtx", reduced.rows);
  return reduced;
}

}  // namespace

ReducedMatrices read_abaqus(const std::filesystem::path& stem) { return read(stem, "abaqus"); }
ReducedMatrices read_calculix(const std::filesystem::path& stem) { return read(stem, "ccx"); }

}  // namespace cbr
