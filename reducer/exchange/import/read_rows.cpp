// SPDX-License-Identifier: GPL-3.0-or-later
#include <set>
#include <utility>

#include "common/base/text_lines.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {

std::vector<ReducedRow> read_rows(const std::filesystem::path& file) {
  TextLines lines(file);
  if (!lines.next() || lines.line() != "row,node,dof,x,y,z,frequency_hz")
    lines.fail(
        "expected the line row,node,dof,x,y,z,frequency_hz, as cbr-reduce --export writes it");
  std::vector<ReducedRow> rows;
  std::set<std::pair<Index, int>> seen;
  while (lines.next()) {
    const auto fields = fields_of(lines.line(), ',');
    if (fields.size() != 7) lines.fail(std::to_string(fields.size()) + " fields found, expected 7");
    if (lines.whole(fields[0]) != static_cast<Index>(rows.size()) + 1)
      lines.fail("row " + std::string(fields[0]) + " found, expected " +
                 std::to_string(rows.size() + 1));
    ReducedRow row;
    row.node = lines.whole(fields[1]);
    const Index dof = lines.whole(fields[2]);
    if (dof < 0 || dof > 6)
      lines.fail("dof " + std::to_string(dof) +
                 " found, expected 1, 2, 3 (x, y, z), 4, 5, 6 (rotations) or 0 (modal)");
    row.dof = static_cast<int>(dof);
    if (dof == 0) lines.number(fields[6]);  // the matrices have it; this finds a damaged one
    if (dof > 0)
      row.position = {lines.number(fields[3]), lines.number(fields[4]), lines.number(fields[5])};
    if (!seen.emplace(row.node, row.dof).second)
      lines.fail("dof " + std::to_string(dof) + " of node " + std::to_string(row.node) +
                 " is in the table twice");
    rows.push_back(row);
  }
  if (rows.empty()) lines.fail("holds no rows");
  return rows;
}

}  // namespace cbr
