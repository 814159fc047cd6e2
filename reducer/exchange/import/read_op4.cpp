// SPDX-License-Identifier: GPL-3.0-or-later
// OUTPUT4 files, text and binary: MSC Nastran DMAP Programmer's Guide, OUTPUT4. Columns are dense
// or sparse; K and M are taken, damping is noted, and other matrices are passed over.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {
namespace {

constexpr Index real_double = 2, complex_double = 4, row_limit = 65536;

struct Header {
  std::string name;
  Index columns = 0, rows = 0, type = 0;  // rows < 0: BIGMAT
  Index words() const { return type == real_double || type == complex_double ? 2 : 1; }
};

// The matrices that are wanted, as their entries arrive. `Fail` throws with the file's place.
class Found {
 public:
  // n: rows of the table. least: rows of nodes without rotations, which may be all, or n
  Found(Index least, Index n) : least_(least), n_(n) {}

  template <typename Fail>
  void begin(const Header& header, const Fail& fail) {
    current_ = nullptr;
    is_damping_ = is_one_of(header.name, {"BAAX", "BAA", "BXX", "BXX1", "K4AAX", "K4XX", "K4XX1"});
    const bool is_K = is_one_of(header.name, {"KAAX", "KAA", "KXX"});
    if (!is_K && !is_one_of(header.name, {"MAAX", "MAA", "MXX"})) return;
    std::optional<Matrix>& A = is_K ? K : M;
    const std::optional<Matrix>& other = is_K ? M : K;
    if (A) fail("a second matrix " + header.name);
    if (header.type != real_double)
      fail("type " + std::to_string(header.type) + " found, expected 2 (real, double precision)");
    const Index n = header.columns, rows = std::abs(header.rows);
    if (rows != n || (n != n_ && n != least_) || (other && other->rows() != n))
      fail("a matrix of " + std::to_string(rows) + " x " + std::to_string(n) + " found, expected " +
           std::to_string(n_) + " x " + std::to_string(n_) + ", as the table beside it has " +
           std::to_string(n_) + " rows");
    A = Matrix::Zero(n, n);
    current_ = &*A;
  }

  template <typename Fail>
  void check_column(const Header& header, Index column, Index before, const Fail& fail) const {
    if (column <= before || column > header.columns)
      fail("column " + std::to_string(column) + " found: columns ascend from 1 to " +
           std::to_string(header.columns));
  }

  template <typename Fail>
  void check_rows(Index first, Index count, const Fail& fail) const {
    if (current_ != nullptr && (first < 1 || count < 1 || count > current_->rows() ||
                                first + count - 1 > current_->rows()))
      fail("rows from " + std::to_string(first) + ", " + std::to_string(count) +
           " entries found: rows are 1 to " + std::to_string(current_->rows()));
  }

  bool wants() const { return current_ != nullptr || is_damping_; }
  void put(Index i, Index j, double value) {
    if (current_ != nullptr) (*current_)(i, j) = value;
    has_damping |= is_damping_ && value != 0;
  }

  std::optional<Matrix> K, M;
  bool has_damping = false;

 private:
  static bool is_one_of(const std::string& name, std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }

  const Index least_, n_;
  Matrix* current_ = nullptr;  // none: it is passed over
  bool is_damping_ = false;
};

class TextOp4 {
 public:
  TextOp4(const std::filesystem::path& file, Found& found) : lines_(file), found_(found) {}

  void run() {
    while (lines_.next()) read_matrix();
  }

 private:
  std::string_view field(std::size_t i) const {
    return 8 * i < lines_.line().size() ? trimmed(std::string_view(lines_.line()).substr(8 * i, 8))
                                        : std::string_view();
  }

  void next_line() {
    if (!lines_.next())
      lines_.fail("ends inside of matrix " + header_.name +
                  ": the file is damaged, export it again");
  }

  void read_matrix() {
    const auto fail = [&](const std::string& what) { lines_.fail(what); };
    header_ = {std::string(field(4)), lines_.whole(field(0)), lines_.whole(field(1)),
               lines_.whole(field(3))};
    found_.begin(header_, fail);
    read_format(lines_.line());
    for (Index before = 0;;) {
      next_line();
      const Index column = lines_.whole(field(0)), first = lines_.whole(field(1)),
                  count = lines_.whole(field(2));
      if (column == header_.columns + 1) break;
      found_.check_column(header_, column, before, fail);
      if (first == 0)
        read_strings(column, count);
      else
        read_numbers(column, first, count);
      before = column;
    }
    next_line();
    lines_.number(lines_.line());  // a damaged one is still found
  }

  // "1P,3E24.16": numbers in a line, and how wide each is.
  void read_format(const std::string& header) {
    const auto start = header.find(',', 40);
    const auto e = start == std::string::npos ? start : header.find_first_of("ED", start);
    if (e == std::string::npos) lines_.fail("no format such as 1P,3E24.16 in columns 41 to 56");
    in_line_ = lines_.whole(std::string_view(header).substr(start + 1, e - start - 1));
    width_ = lines_.whole(std::string_view(header).substr(e + 1, header.find('.', e) - e - 1));
    if (in_line_ < 1 || width_ < 8 || in_line_ * width_ > 1000)
      lines_.fail("a format such as 1P,3E24.16 expected in columns 41 to 56");
  }

  // A sparse column: strings of entries that follow one another, each with its length and row
  void read_strings(Index column, Index words) {
    while (words > 0) {
      next_line();
      const bool is_big = header_.rows < 0;
      const Index mark = lines_.whole(is_big ? field(0) : std::string_view(lines_.line()));
      const Index length = is_big ? mark : mark / row_limit,
                  row = is_big ? lines_.whole(field(1)) : mark % row_limit;
      if (length < 2) lines_.fail("a string of " + std::to_string(length - 1) + " words found");
      words -= length + (is_big ? 1 : 0);
      read_numbers(column, row, (length - 1) / header_.words());
    }
  }

  void read_numbers(Index column, Index first, Index count) {
    found_.check_rows(first, count, [&](const std::string& what) { lines_.fail(what); });
    for (Index i = 0; i < count; ++i) {
      if (i % in_line_ == 0) next_line();
      if (!found_.wants()) continue;
      const auto start = static_cast<std::size_t>(i % in_line_ * width_);
      if (start >= lines_.line().size()) lines_.fail("too few numbers in the line");
      found_.put(
          first - 1 + i, column - 1,
          lines_.number(
              std::string_view(lines_.line()).substr(start, static_cast<std::size_t>(width_))));
    }
  }

  TextLines lines_;
  Found& found_;
  Header header_;
  Index in_line_ = 0, width_ = 0;
};

class BinaryOp4 {
 public:
  BinaryOp4(const std::filesystem::path& file, Found& found)
      : file_(file),
        in_(file, std::ios::binary),
        size_(static_cast<Index>(std::filesystem::file_size(file))),
        found_(found) {}

  void run() {
    while (in_.peek() != std::ifstream::traits_type::eof()) read_matrix();
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
    if (word() != 24)
      fail("a header of another length than 24 bytes: damaged, or written with words of 8 bytes");
    header_.columns = word();
    header_.rows = word();
    word();  // the form
    header_.type = word();
    std::string name(8, ' ');
    get(name.data(), name.size());
    end_record(24);
    header_.name = std::string(trimmed(name));
    found_.begin(header_, [&](const std::string& what) { fail(what); });
    for (Index before = 0; before <= header_.columns;) before = read_column(before);
  }

  // The column's number; above all columns: the one that ends the matrix.
  Index read_column(Index before) {
    const Index length = word(), column = word(), first = word(), words = word(),
                bytes = length - 12;
    const bool is_last = column == header_.columns + 1;  // its words may be counted otherwise
    if (bytes < 0 || bytes > size_ || (bytes != 4 * words && !is_last))
      fail("a record of a wrong length: the file is damaged, export it again");
    if (is_last || !found_.wants()) {
      in_.ignore(bytes);
    } else {
      found_.check_column(header_, column, before, [&](const std::string& what) { fail(what); });
      words_.resize(words);
      get(words_.data(), sizeof(std::int32_t) * words_.size());
      if (first == 0)
        take_strings(column);
      else
        take(column, first, 0, words / header_.words());
    }
    end_record(length);
    return column;
  }

  void take_strings(Index column) {
    for (std::size_t at = 0; at < words_.size();) {
      const Index mark = words_[at++];
      const bool is_big = header_.rows < 0;
      const Index length = is_big ? mark : mark / row_limit;
      if (length < 2 || at + static_cast<std::size_t>(length - 1 + is_big) > words_.size())
        fail("a string of a wrong length: the file is damaged, export it again");
      const Index row = is_big ? words_[at++] : mark % row_limit;
      take(column, row, at, (length - 1) / header_.words());
      at += static_cast<std::size_t>(length - 1);
    }
  }

  void take(Index column, Index first, std::size_t at, Index count) {
    found_.check_rows(first, count, [&](const std::string& what) { fail(what); });
    for (Index i = 0; i < count; ++i) {
      double value = 0;
      if (header_.words() == 2)
        std::memcpy(&value, &words_[at + 2 * static_cast<std::size_t>(i)], sizeof value);
      if (!std::isfinite(value))
        fail("matrix " + header_.name + " has entries that are not finite");
      found_.put(first - 1 + i, column - 1, value);
    }
  }

  const std::filesystem::path file_;
  std::ifstream in_;
  const Index size_;
  Found& found_;
  Header header_;
  std::vector<std::int32_t> words_;  // of a column
};

bool is_binary(const std::filesystem::path& file) {
  std::int32_t length = 0;
  std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(&length), sizeof length);
  return length == 24;
}

}  // namespace

ReducedMatrices read_op4(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  const std::filesystem::path table = stem.string() + ".dofs.csv", file = stem.string() + ".op4";
  const bool is_ours = std::filesystem::exists(table);
  NastranRows external;
  if (is_ours)
    external = {read_rows(table), {}, true};
  else
    external = read_nastran_rows(stem);
  reduced.rows = external.rows;
  const auto is_rotation = [](const ReducedRow& row) { return row.dof > 3; };
  const auto n = static_cast<Index>(reduced.rows.size());
  const Index n_rotations = std::count_if(reduced.rows.begin(), reduced.rows.end(), is_rotation);
  Found found(external.knows_dofs ? n : n - n_rotations, n);
  if (is_binary(file))
    BinaryOp4(file, found).run();
  else
    TextOp4(file, found).run();
  for (const auto* A : {&found.K, &found.M})
    if (!*A)
      throw InputError(file.string() + ": has no matrix " +
                       (A == &found.K ? "KAAX, KAA or KXX" : "MAAX, MAA or MXX"));
  reduced.K = std::move(*found.K);
  reduced.M = std::move(*found.M);
  reduced.has_damping = found.has_damping;
  if (reduced.K.rows() < n) std::erase_if(reduced.rows, is_rotation);
  turn_to_basic(external.axes, file.string(), reduced);
  return reduced;
}

}  // namespace cbr
