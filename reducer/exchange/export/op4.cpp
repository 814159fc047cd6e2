// SPDX-License-Identifier: GPL-3.0-or-later
// Nastran's OUTPUT4 format, dense: MSC Nastran DMAP Programmer's Guide, OUTPUT4. Of each column the
// entries from the first to the last that is not 0.
#include <cstdint>
#include <ostream>
#include <string>

#include "common/base/format_text.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {
namespace {

constexpr int symmetric = 6, rectangular = 2, real_double = 2, words_of_double = 2;

struct Column {
  Index first = 0, count = 0;  // from 0; count 0: all are 0
};

Column column_of(const Matrix& A, Index j) {
  Index first = 0, end = A.rows();
  while (end > 0 && A(end - 1, j) == 0) --end;
  while (first < end && A(first, j) == 0) ++first;
  return {first, end - first};
}

std::string head(Index a, Index b, Index c) {
  return format_text("%8lld%8lld%8lld\n", static_cast<long long>(a), static_cast<long long>(b),
                     static_cast<long long>(c));
}

void write_text(const char* name, const Matrix& A, int form, std::ostream& out) {
  constexpr Index in_line = 3;
  out << format_text("%8lld%8lld%8d%8d%-8s1P,3E24.16\n", static_cast<long long>(A.cols()),
                     static_cast<long long>(A.rows()), form, real_double, name);
  for (Index j = 0; j < A.cols(); ++j) {
    const Column column = column_of(A, j);
    if (column.count == 0) continue;
    out << head(j + 1, column.first + 1, column.count);
    for (Index i = 0; i < column.count; ++i)
      out << format_text("%24.16E", A(column.first + i, j))
          << (i % in_line == in_line - 1 || i + 1 == column.count ? "\n" : "");
  }
  // A column too many, of one number that nobody reads, ends a matrix
  out << head(A.cols() + 1, 1, 1) << format_text("%24.16E\n", 1.0);
}

class Records {
 public:
  explicit Records(std::ostream& out) : out_(out) {}
  // One of Fortran's unformatted records: its length before and after it.
  void write(std::initializer_list<std::int32_t> words, const void* rest, std::size_t bytes) {
    const auto length = static_cast<std::int32_t>(words.size() * sizeof(std::int32_t) + bytes);
    put(&length, sizeof length);
    for (const std::int32_t word : words) put(&word, sizeof word);
    put(rest, bytes);
    put(&length, sizeof length);
  }

 private:
  void put(const void* data, std::size_t bytes) {
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  }
  std::ostream& out_;
};

void write_binary(const char* name, const Matrix& A, int form, std::ostream& out) {
  Records records(out);
  const auto n = static_cast<std::int32_t>(A.cols());
  records.write({n, static_cast<std::int32_t>(A.rows()), form, real_double},
                format_text("%-8s", name).data(), 8);
  for (Index j = 0; j < A.cols(); ++j) {
    const Column column = column_of(A, j);
    if (column.count == 0) continue;
    records.write({static_cast<std::int32_t>(j + 1), static_cast<std::int32_t>(column.first + 1),
                   static_cast<std::int32_t>(words_of_double * column.count)},
                  &A(column.first, j), sizeof(double) * static_cast<std::size_t>(column.count));
  }
  const double last = 1;
  records.write({n + 1, 1, words_of_double}, &last, sizeof last);
}

using Write = void (*)(const char* name, const Matrix& A, int form, std::ostream& out);

void write_all(Write write, const ReducedMatrices& reduced, std::ostream& out) {
  write("KAAX", reduced.K, symmetric, out);
  write("MAAX", reduced.M, symmetric, out);
  if (reduced.T.size() > 0) write("TCAX", reduced.T, rectangular, out);
}

}  // namespace

void write_op4(const ReducedMatrices& reduced, std::ostream& out) {
  write_all(write_text, reduced, out);
}

void write_op4_binary(const ReducedMatrices& reduced, std::ostream& out) {
  write_all(write_binary, reduced, out);
}

}  // namespace cbr
