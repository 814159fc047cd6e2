// SPDX-License-Identifier: GPL-3.0-or-later
// Boisvert, Pozo, Remington 1996, NISTIR 5935: a header, comments, the size line, then an entry a
// line.
#include "reducer/exchange/import/import.hpp"
#include "reducer/exchange/import/row_places.hpp"

namespace cbr {
namespace {

Matrix read_matrix(const std::filesystem::path& file, Index n) {
  TextLines lines(file);
  if (!lines.next() || lines.line() != "%%MatrixMarket matrix coordinate real symmetric")
    lines.fail("expected the line %%MatrixMarket matrix coordinate real symmetric");
  do {
    if (!lines.next()) lines.fail("ends before its size line");
  } while (lines.line().starts_with("%"));
  const auto sizes = fields_of(lines.line(), ' ');
  if (sizes.size() != 3) lines.fail("expected three numbers: rows, columns, entries");
  if (lines.whole(sizes[0]) != n || lines.whole(sizes[1]) != n)
    lines.fail("a matrix of " + std::string(sizes[0]) + " x " + std::string(sizes[1]) +
               " found, expected " + std::to_string(n) + " x " + std::to_string(n) +
               ", as the table beside it has " + std::to_string(n) + " rows");
  const Index n_entries = lines.whole(sizes[2]);
  SymmetricEntries entries(n);
  Index count = 0;
  while (lines.next()) {
    const auto fields = fields_of(lines.line(), ' ');
    if (fields.size() != 3) lines.fail("expected three numbers: row, column, entry");
    const Index i = lines.whole(fields[0]), j = lines.whole(fields[1]);
    if (i < 1 || i > n || j < 1 || j > n)
      lines.fail("rows and columns are 1 to " + std::to_string(n));
    entries.set(lines, i - 1, j - 1, lines.number(fields[2]));
    ++count;
  }
  if (count != n_entries)
    lines.fail(std::to_string(count) + " entries found, expected " + std::to_string(n_entries) +
               " by the size line: the file is " + "damaged, export it again");
  return entries.take();
}

}  // namespace

ReducedMatrices read_matrix_market(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  reduced.rows = read_rows(stem.string() + ".dofs.csv");
  const auto n = static_cast<Index>(reduced.rows.size());
  reduced.K = read_matrix(stem.string() + ".K.mtx", n);
  reduced.M = read_matrix(stem.string() + ".M.mtx", n);
  return reduced;
}

}  // namespace cbr
