// SPDX-License-Identifier: GPL-3.0-or-later
// Nastran's DMIG as --export writes it: a header in fields of 8 columns, then columns of the matrix
// in fields of 16.
#include <map>
#include <optional>
#include <string>

#include "reducer/exchange/import/import.hpp"
#include "reducer/exchange/import/row_places.hpp"

namespace cbr {
namespace {

std::string_view field(const std::string& line, std::size_t first, std::size_t width) {
  return first < line.size() ? trimmed(std::string_view(line).substr(first, width))
                             : std::string_view();
}

class DmigReader {
 public:
  DmigReader(const std::filesystem::path& file, const std::vector<ReducedRow>& rows)
      : lines_(file), places_(rows, 0), n_(static_cast<Index>(rows.size())) {}

  void read(ReducedMatrices& reduced) {
    while (lines_.next()) take();
    for (const auto& matrix : {&K_, &M_})
      if (!*matrix) lines_.fail(std::string("has no matrix ") + (matrix == &K_ ? "KAAX" : "MAAX"));
    require_all();
    reduced.K = K_->take();
    reduced.M = M_->take();
  }

 private:
  void take() {
    const std::string& line = lines_.line();
    const std::string_view card = field(line, 0, 8);
    if (card.starts_with("$")) return note(line);
    if (card.empty() || card == "SPOINT") return;
    // A point's place, on two lines; the table has it too
    if (card == "GRID*" || (card == "*" && in_grid_)) {
      in_grid_ = card == "GRID*";
      return;
    }
    if (card == "DMIG") return begin();
    if (card == "DMIG*") {
      matrix_ = &matrix_named(field(line, 8, 16));
      if (!*matrix_) lines_.fail("a column before the header of its matrix");
      column_ = place(field(line, 24, 16), field(line, 40, 16));
    } else if (card == "*") {
      if (column_ < 0) lines_.fail("an entry before its column");
      if (!field(line, 56, 16).empty())
        lines_.fail("a fourth field found, expected node, dof and a real entry");
      (*matrix_)->set(lines_, place(field(line, 8, 16), field(line, 24, 16)), column_,
                      lines_.number(field(line, 40, 16)));
      ++n_found_[matrix_ == &K_ ? "KAAX" : "MAAX"];
    } else {
      lines_.fail("'" + std::string(card) +
                  "' found, expected DMIG in large fields (DMIG*, *), SPOINT or a comment ($)");
    }
  }

  // "$ KAAX: 1234 entries", which --export writes since 0.1.0; other files have none
  void note(const std::string& line) {
    for (const char* name : {"KAAX", "MAAX"}) {
      const std::string start = std::string("$ ") + name + ": ", end = " entries";
      if (line.size() > start.size() + end.size() && line.starts_with(start) && line.ends_with(end))
        n_wanted_[name] =
            lines_.whole(line.substr(start.size(), line.size() - start.size() - end.size()));
    }
  }

  void require_all() {
    for (const auto& [name, wanted] : n_wanted_)
      if (n_found_[name] != wanted)
        lines_.fail(name + " has " + std::to_string(n_found_[name]) +
                    " entries, its comment says " + std::to_string(wanted) +
                    ": lines are missing, export it again");
  }

  void begin() {
    const std::string& line = lines_.line();
    auto& matrix = matrix_named(field(line, 8, 8));
    if (matrix) lines_.fail("a second header of " + std::string(field(line, 8, 8)));
    if (field(line, 24, 8) != "6" || field(line, 32, 8) != "2")
      lines_.fail("form " + std::string(field(line, 24, 8)) + " and type " +
                  std::string(field(line, 32, 8)) +
                  " found, expected 6 (symmetric) and 2 (real, double)");
    matrix.emplace(n_);
    column_ = -1;
  }

  std::optional<SymmetricEntries>& matrix_named(std::string_view name) {
    if (name != "KAAX" && name != "MAAX")
      lines_.fail("matrix '" + std::string(name) + "' found, expected KAAX or MAAX");
    return name == "KAAX" ? K_ : M_;
  }

  Index place(std::string_view node, std::string_view dof) const {
    return places_.place(lines_, lines_.whole(node), lines_.whole(dof));
  }

  TextLines lines_;
  const RowPlaces places_;
  const Index n_;
  std::optional<SymmetricEntries> K_, M_;
  std::optional<SymmetricEntries>* matrix_ = nullptr;
  Index column_ = -1;
  bool in_grid_ = false;
  std::map<std::string, Index> n_wanted_, n_found_;
};

}  // namespace

ReducedMatrices read_dmig(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  reduced.rows = read_rows(stem.string() + ".dofs.csv");
  DmigReader(stem.string() + ".dmig", reduced.rows).read(reduced);
  return reduced;
}

}  // namespace cbr
