// SPDX-License-Identifier: GPL-3.0-or-later
// All matrices of a CalculiX model (*FREQUENCY, SOLVER=MATRIXSTORAGE): NAME.sti and NAME.mas of
// lines "row column entry", one triangle; NAME.dof of lines "node.dof", one a row.
#include "reducer/exchange/import/import.hpp"
#include "reducer/exchange/import/row_places.hpp"

namespace cbr {
namespace {

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
