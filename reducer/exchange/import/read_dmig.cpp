// SPDX-License-Identifier: GPL-3.0-or-later
// Nastran's DMIG as --export and EXTSEOUT write it: a header in fields of 8 columns, then columns
// of the matrix in fields of 16.
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
  // is_external: other cards and matrices are passed over.
  DmigReader(const std::filesystem::path& file, const std::vector<ReducedRow>& rows,
             bool is_external)
      : lines_(file),
        places_(rows, 0),
        n_(static_cast<Index>(rows.size())),
        is_external_(is_external) {}

  void read(ReducedMatrices& reduced) {
    while (lines_.next()) take();
    for (const auto& matrix : {&K_, &M_})
      if (!*matrix) lines_.fail(std::string("has no matrix ") + (matrix == &K_ ? "KAAX" : "MAAX"));
    require_all();
    reduced.has_damping = has_damping_;
    reduced.K = K_->take();
    reduced.M = M_->take();
  }

 private:
  void take() {
    const std::string& line = lines_.line();
    const std::string_view card = field(line, 0, 8);
    if (card.starts_with("$")) return note(line);
    if (card.empty() || card == "SPOINT") return;
    if (is_external_ && passes_over(card, line)) return;
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

  // With the lines that continue it
  bool passes_over(std::string_view card, const std::string& line) {
    if (card == "*") return passes_over_;
    const std::string_view name = field(line, 8, card == "DMIG" ? 8 : 16);
    passes_over_ = !card.starts_with("DMIG") || (name != "KAAX" && name != "MAAX");
    has_damping_ |= card == "DMIG*" && (name == "BAAX" || name == "K4AAX");
    return passes_over_;
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
  bool in_grid_ = false, passes_over_ = false, has_damping_ = false;
  const bool is_external_;
  std::map<std::string, Index> n_wanted_, n_found_;
};

}  // namespace

ReducedMatrices read_dmig(const std::filesystem::path& stem) {
  ReducedMatrices reduced;
  const std::filesystem::path table = stem.string() + ".dofs.csv", pch = stem.string() + ".pch";
  if (std::filesystem::exists(table)) {
    reduced.rows = read_rows(table);
    DmigReader(stem.string() + ".dmig", reduced.rows, false).read(reduced);
    return reduced;
  }
  const NastranRows external = read_nastran_rows(stem);
  reduced.rows = external.rows;
  DmigReader(pch, reduced.rows, true).read(reduced);
  turn_to_basic(external.axes, pch.string(), reduced);
  return reduced;
}

}  // namespace cbr
