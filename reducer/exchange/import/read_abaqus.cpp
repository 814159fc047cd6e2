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

namespace {

// All matrices of a CalculiX model (*FREQUENCY, SOLVER=MATRIXSTORAGE): NAME.sti and NAME.mas of
// lines "row column entry", one triangle; NAME.dof of lines "node.dof", one a row.
constexpr std::size_t most_rows = 10000;  // K and M are dense here: 1.6 GB

std::vector<ReducedRow> read_dofs(const std::filesystem::path& file) {
  TextLines lines(file);
  std::vector<ReducedRow> rows;
  while (lines.next()) {
    const auto fields = fields_of(lines.line(), '.');
    if (fields.size() != 2) lines.fail("expected NODE.DOF");
    const Index dof = lines.whole(fields[1]);
    if (dof < 1 || dof > 3)
      lines.fail("dof " + std::to_string(dof) + " found, expected 1, 2, 3 (x, y, z)");
    rows.push_back({.node = lines.whole(fields[0]), .dof = static_cast<int>(dof)});
    if (rows.size() > most_rows)
      lines.fail("more than " + std::to_string(most_rows) +
                 " dofs, which would not be condensed: reduce the mesh itself with cbr-reduce");
  }
  if (rows.empty()) lines.fail("holds no dofs");
  return rows;
}

Matrix read_entries(const std::filesystem::path& file, Index n) {
  TextLines lines(file);
  SymmetricEntries entries(n);
  while (lines.next()) {
    const auto fields = fields_of(lines.line(), ' ');
    if (fields.size() != 3) lines.fail("expected three fields: row, column, entry");
    const Index i = lines.whole(fields[0]), j = lines.whole(fields[1]);
    for (const Index row : {i, j})
      if (row < 1 || row > n)
        lines.fail("row " + std::to_string(row) + " found, allowed are 1 to " + std::to_string(n));
    entries.set(lines, i - 1, j - 1, lines.number(fields[2]));
  }
  return entries.take();
}

}  // namespace

ReducedMatrices read_matrix_storage(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  reduced.rows = read_dofs(stem.string() + ".dof");
  const auto n = static_cast<Index>(reduced.rows.size());
  reduced.K = read_entries(stem.string() + ".sti", n);
  reduced.M = read_entries(stem.string() + ".mas", n);
  return reduced;
}

}  // namespace cbr
