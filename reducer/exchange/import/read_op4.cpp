// SPDX-License-Identifier: GPL-3.0-or-later
// OUTPUT4 files, text and binary, with dense matrices KAAX and MAAX.
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {
namespace {

constexpr int real_double = 2;

using Matrices = std::map<std::string, Matrix>;

// Checks a matrix's name, type and size, which both kinds of file hold.
template <typename Fail>
Matrix empty_matrix(const std::string& name, const Matrices& found, Index columns, Index rows,
                    Index type, Index n, const Fail& fail) {
  if (name != "KAAX" && name != "MAAX")
    fail("matrix '" + name.substr(0, 8) + "' found, expected KAAX or MAAX");
  if (found.count(name) > 0) fail("a second matrix " + name);
  if (type != real_double)
    fail("type " + std::to_string(type) + " found, expected 2 (real, double precision)");
  if (columns != n || rows != n)
    fail("a matrix of " + std::to_string(rows) + " x " + std::to_string(columns) +
         " found, expected " + std::to_string(n) + " x " + std::to_string(n) +
         ", as the table beside it has " + std::to_string(n) + " rows");
  return Matrix::Zero(n, n);
}

template <typename Fail>
void check_column(Index column, Index before, Index first, Index count, Index n, const Fail& fail) {
  if (first == 0)
    fail("a sparse column found, expected dense ones: write the file without SPARSE and BIGMAT");
  if (column <= before || column > n || first < 1 || count < 1 || count > n ||
      first + count - 1 > n)
    fail("column " + std::to_string(column) + ", rows from " + std::to_string(first) + ", " +
         std::to_string(count) + " entries found: columns ascend, and columns and rows are 1 to " +
         std::to_string(n));
}

class TextOp4 {
 public:
  TextOp4(const std::filesystem::path& file, Index n) : lines_(file), n_(n) {}

  Matrices run() {
    while (lines_.next()) read_matrix();
    return std::move(found_);
  }

 private:
  std::string_view field(std::size_t i) const {
    return 8 * i < lines_.line().size() ? trimmed(std::string_view(lines_.line()).substr(8 * i, 8))
                                        : std::string_view();
  }

  void read_matrix() {
    const auto fail = [&](const std::string& what) { lines_.fail(what); };
    const std::string name(field(4));
    Matrix A = empty_matrix(name, found_, lines_.whole(field(0)), lines_.whole(field(1)),
                            lines_.whole(field(3)), n_, fail);
    read_format(lines_.line());
    Index before = 0;
    while (true) {
      if (!lines_.next())
        lines_.fail("ends inside of matrix " + name + ": the file is damaged, export it again");
      const Index column = lines_.whole(field(0)), first = lines_.whole(field(1)),
                  count = lines_.whole(field(2));
      if (column == n_ + 1) break;
      check_column(column, before, first, count, n_, fail);
      read_column(A, column - 1, first - 1, count, name);
      before = column;
    }
    if (!lines_.next())
      lines_.fail("ends inside of matrix " + name + ": the file is damaged, export it again");
    lines_.number(lines_.line());  // a damaged one is still found
    found_.emplace(name, std::move(A));
  }

  // "1P,3E24.16": numbers in a line, and how wide each is.
  void read_format(const std::string& header) {
    const auto start = header.find(',', 40);
    const auto e = start == std::string::npos ? start : header.find('E', start);
    if (e == std::string::npos) lines_.fail("no format such as 1P,3E24.16 in columns 41 to 56");
    in_line_ = lines_.whole(std::string_view(header).substr(start + 1, e - start - 1));
    width_ = lines_.whole(std::string_view(header).substr(e + 1, header.find('.', e) - e - 1));
    if (in_line_ < 1 || width_ < 8 || in_line_ * width_ > 1000)
      lines_.fail("a format such as 1P,3E24.16 expected in columns 41 to 56");
  }

  void read_column(Matrix& A, Index j, Index first, Index count, const std::string& name) {
    for (Index i = 0; i < count; ++i) {
      if (i % in_line_ == 0 && !lines_.next())
        lines_.fail("ends inside of matrix " + name + ": the file is damaged, export it again");
      const auto start = static_cast<std::size_t>(i % in_line_ * width_);
      if (start >= lines_.line().size()) lines_.fail("too few numbers in the line");
      A(first + i, j) = lines_.number(
          std::string_view(lines_.line()).substr(start, static_cast<std::size_t>(width_)));
    }
  }

  TextLines lines_;
  const Index n_;
  Matrices found_;
  Index in_line_ = 0, width_ = 0;
};

class BinaryOp4 {
 public:
  BinaryOp4(const std::filesystem::path& file, Index n)
      : file_(file), in_(file, std::ios::binary), n_(n) {}

  Matrices run() {
    while (in_.peek() != std::ifstream::traits_type::eof()) read_matrix();
    return std::move(found_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_.string() + ": " + what);
  }

  void get(void* data, std::size_t bytes) {
    if (!in_.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes)))
      fail("is cut off: export it again");
  }
  Index word() {
    std::int32_t value = 0;
    get(&value, sizeof value);
    return value;
  }
  void end_record(Index length) {
    if (word() != length)
      fail("the lengths before and after a record differ: the file is damaged, export it again");
  }

  void read_matrix() {
    const auto fails = [&](const std::string& what) { fail(what); };
    if (word() != 24)
      fail("a header of another length than 24 bytes: damaged, or written with words of 8 bytes");
    const Index columns = word(), rows = word();
    word();  // the form
    const Index type = word();
    std::string name(8, ' ');
    get(name.data(), name.size());
    end_record(24);
    name = std::string(trimmed(name));
    Matrix A = empty_matrix(name, found_, columns, rows, type, n_, fails);
    for (Index before = 0; before <= n_;) before = read_column(A, before);
    if (!A.allFinite()) fail("matrix " + name + " has entries that are not finite");
    found_.emplace(name, std::move(A));
  }

  // The column's number; above n: the one that ends the matrix.
  Index read_column(Matrix& A, Index before) {
    const Index length = word(), column = word(), first = word(), words = word();
    if (words < 0 || words > 2 * n_ + 2 || length != 12 + 4 * words)
      fail("a record of a wrong length: the file is damaged, export it again");
    if (column == n_ + 1) {
      in_.ignore(4 * words);
    } else {
      check_column(column, before, first, words / 2, n_,
                   [&](const std::string& what) { fail(what); });
      get(&A(first - 1, column - 1), sizeof(double) * static_cast<std::size_t>(words / 2));
    }
    end_record(length);
    return column;
  }

  const std::filesystem::path file_;
  std::ifstream in_;
  const Index n_;
  Matrices found_;
};

bool is_binary(const std::filesystem::path& file) {
  std::int32_t length = 0;
  std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(&length), sizeof length);
  return length == 24;
}

}  // namespace

ReducedMatrices read_op4(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  reduced.rows = read_rows(stem.string() + ".dofs.csv");
  const std::filesystem::path file = stem.string() + ".op4";
  const auto n = static_cast<Index>(reduced.rows.size());
  Matrices found = is_binary(file) ? BinaryOp4(file, n).run() : TextOp4(file, n).run();
  for (const char* name : {"KAAX", "MAAX"})
    if (found.count(name) == 0) throw InputError(file.string() + ": has no matrix " + name);
  reduced.K = std::move(found.at("KAAX"));
  reduced.M = std::move(found.at("MAAX"));
  return reduced;
}

}  // namespace cbr
