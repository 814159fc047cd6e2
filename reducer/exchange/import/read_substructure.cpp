// SPDX-License-Identifier: GPL-3.0-or-later
// The file of *SUBSTRUCTURE MATRIX OUTPUT of Abaqus and CalculiX: a *USER ELEMENT with its dofs,
// its nodes in comments, and *MATRIX cards of one triangle each, row by row. Abaqus Keywords
// Reference Guide, *USER ELEMENT; Dhondt, CalculiX CrunchiX User's Manual, *SUBSTRUCTURE MATRIX
// OUTPUT.
#include <algorithm>
#include <cctype>
#include <map>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {
namespace {

std::string in_capitals(std::string_view text) {
  std::string capitals;
  for (const char c : text)
    if (std::isspace(static_cast<unsigned char>(c)) == 0)
      capitals += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

// Numbers between commas, of which the last may be missing.
std::vector<std::string_view> numbers_of(std::string_view line) {
  std::vector<std::string_view> fields = fields_of(line, ',');
  while (!fields.empty() && fields.back().empty()) fields.pop_back();
  return fields;
}

class SubstructureFile {
 public:
  explicit SubstructureFile(const std::filesystem::path& file)
      : where_(file.string()), lines_(file) {}

  ReducedMatrices run() {
    while (lines_.next()) {
      const std::string_view line = trimmed(lines_.line());
      if (line.empty()) continue;
      if (line.starts_with("**"))
        take_comment(line.substr(2));
      else if (line.starts_with("*"))
        take_card(in_capitals(line));
      else if (in_element_)
        take_dofs(line);
      else if (values_ != nullptr)
        take_values(line);
    }
    add_rows();
    reduced_.K = matrix("STIFFNESS");
    reduced_.M = matrix("MASS");
    return std::move(reduced_);
  }

 private:
  // ** ELEMENT NODES, then lines of their numbers
  void take_comment(std::string_view text) {
    if (in_capitals(text) == "ELEMENTNODES") {
      in_nodes_ = true;
      return;
    }
    if (!in_nodes_) return;
    const bool is_list =
        !trimmed(text).empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
          return std::isdigit(c) != 0 || std::isspace(c) != 0 || c == ',';
        });
    if (!is_list)
      in_nodes_ = false;
    else
      for (const std::string_view field : numbers_of(text)) nodes_.push_back(lines_.whole(field));
  }

  void take_card(const std::string& card) {
    in_nodes_ = in_element_ = false;
    values_ = nullptr;
    if (card.starts_with("*USERELEMENT")) {
      if (has_element_) lines_.fail("a second *USER ELEMENT found, expected one substructure");
      has_element_ = in_element_ = true;
      if (card.find("UNSYMM") != std::string::npos)
        lines_.fail("UNSYMM found: superelements have symmetric matrices");
    } else if (card.starts_with("*MATRIX")) {
      const std::size_t at = card.find("TYPE=");
      const std::string type =
          at == std::string::npos ? "" : card.substr(at + 5, card.find(',', at) - at - 5);
      if (type == "STIFFNESS" || type == "MASS")
        values_ = &matrices_[type];
      else if (type.find("DAMPING") != std::string::npos)
        reduced_.has_damping = true;
      else
        lines_.fail("*MATRIX of type '" + type + "' found, expected STIFFNESS or MASS");
      if (values_ != nullptr && !values_->empty()) lines_.fail("the matrix is in the file twice");
    }
  }

  // The dofs of the first node; then a node's place and the dofs from there on
  void take_dofs(std::string_view line) {
    const auto fields = numbers_of(line);
    std::vector<Index> numbers;
    for (const std::string_view field : fields) numbers.push_back(lines_.whole(field));
    Index place = 1;
    if (!dofs_.empty()) {
      place = numbers.front();
      numbers.erase(numbers.begin());
      if (place <= dofs_.rbegin()->first)
        lines_.fail("place " + std::to_string(place) + " found, expected above " +
                    std::to_string(dofs_.rbegin()->first));
    }
    if (numbers.empty()) lines_.fail("names no dof");
    dofs_[place] = numbers;
  }

  void take_values(std::string_view line) {
    for (const std::string_view field : numbers_of(line)) values_->push_back(lines_.number(field));
  }

  void add_rows() {
    if (!has_element_ || nodes_.empty() || dofs_.empty())
      throw InputError(where_ +
                       ": has no *USER ELEMENT with its nodes and dofs, as *SUBSTRUCTURE MATRIX "
                       "OUTPUT writes them (OUTPUT FILE=USER DEFINED)");
    if (dofs_.rbegin()->first > static_cast<Index>(nodes_.size()))
      throw InputError(where_ + ": has dofs for node " + std::to_string(dofs_.rbegin()->first) +
                       " of " + std::to_string(nodes_.size()) + ": damaged");
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto next = dofs_.upper_bound(static_cast<Index>(i) + 1);
      for (const Index dof : std::prev(next)->second) {
        if (dof < 1 || dof > 3)
          throw InputError(where_ + ": dof " + std::to_string(dof) + " of node " +
                           std::to_string(nodes_[i]) +
                           " found, expected 1, 2, 3 (x, y, z): retain no rotations");
        reduced_.rows.push_back({.node = nodes_[i], .dof = static_cast<int>(dof)});
      }
    }
  }

  Matrix matrix(const std::string& type) const {
    const auto found = matrices_.find(type);
    if (found == matrices_.end())
      throw InputError(where_ + ": has no *MATRIX, TYPE=" + type + ": ask for " + type +
                       "=YES; CalculiX writes the stiffness alone, import its matrix storage");
    const auto n = static_cast<Index>(reduced_.rows.size());
    const std::vector<double>& values = found->second;
    if (static_cast<Index>(values.size()) != n * (n + 1) / 2)
      throw InputError(where_ + ": *MATRIX, TYPE=" + type + " has " +
                       std::to_string(values.size()) + " numbers, expected " +
                       std::to_string(n * (n + 1) / 2) + " for " + std::to_string(n) +
                       " dofs: damaged");
    Matrix A(n, n);
    std::size_t next = 0;
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j <= i; ++j) A(i, j) = A(j, i) = values[next++];
    return A;
  }

  std::string where_;
  TextLines lines_;
  ReducedMatrices reduced_;
  std::vector<Index> nodes_;
  std::map<Index, std::vector<Index>> dofs_;  // by the place from which on they hold
  std::map<std::string, std::vector<double>> matrices_;
  std::vector<double>* values_ = nullptr;
  bool has_element_ = false, in_element_ = false, in_nodes_ = false;
};

}  // namespace

ReducedMatrices read_substructure(const std::filesystem::path& file) {
  return SubstructureFile(file).run();
}

}  // namespace cbr
