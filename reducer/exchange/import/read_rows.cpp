// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "common/mesh/io/bdf_cards.hpp"
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
    // The matrices have it; this finds a damaged one. Residual vectors have none
    if (dof == 0 && !fields[6].empty()) lines.number(fields[6]);
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

namespace {

constexpr int all_dofs = 123456;

class ExternalPart {
 public:
  explicit ExternalPart(const std::filesystem::path& file) : where_(file.string()), cards_(file) {
    while (const auto card = cards_.next()) {
      if (card->name == "GRID") take_grid(*card);
      if (card->name == "CORD2R") take_system(*card);
      if (card->name == "SPOINT") take_points(*card);
      if (card->name == "EXTRN")
        for (std::size_t i = 0; i + 1 < card->fields.size(); i += 2)
          if (!card->fields[i].empty())
            order_.emplace_back(cards_.whole(*card, i), cards_.whole(*card, i + 1));
      if (card->name == "SECONCT") take_connection(*card);
    }
  }

  bool has_order() const { return !order_.empty() || !connected_.empty(); }

  NastranRows rows() const {
    NastranRows found;
    found.knows_dofs = !order_.empty();
    auto order = order_;
    if (order.empty())
      for (const Index id : connected_) order.emplace_back(id, modal_.contains(id) ? 0 : all_dofs);
    for (const auto& [id, dofs] : order) {
      if (dofs == 0) {
        found.rows.push_back({.node = id});
        continue;
      }
      const auto grid = grids_.find(id);
      if (grid == grids_.end()) fail(id, "is not in the file, but a row of the matrices: damaged");
      for (const char dof : std::to_string(dofs)) {
        if (dof < '1' || dof > '6')
          fail(id, "has dofs " + std::to_string(dofs) + ", expected some of 123456");
        found.rows.push_back({.node = id, .dof = dof - '0', .position = grid->second.position});
      }
      if (const std::string& system = grid->second.system; !system.empty() && system != "0") {
        if (!systems_.contains(system))
          fail(id, "has displacements along system " + system + ", which is no CORD2R of the file");
        found.axes[id] = systems_.at(system);
      }
    }
    return found;
  }

 private:
  struct Grid {
    Vector3 position;
    std::string system;  // of its displacements
  };

  [[noreturn]] void fail(Index grid, const std::string& what) const {
    throw InputError(where_ + ": GRID " + std::to_string(grid) + " " + what);
  }

  void take_grid(const BdfCard& card) {
    if (const std::string system = cards_.text(card, 1); !system.empty() && system != "0")
      cards_.fail(card, "coordinate system " + system + " found, expected 0 (basic)");
    grids_[cards_.whole(card, 0)] = {vector(card, 2), cards_.text(card, 5)};
  }

  Vector3 vector(const BdfCard& card, std::size_t i) const {
    return {cards_.real(card, i, 0), cards_.real(card, i + 1, 0), cards_.real(card, i + 2, 0)};
  }

  // Columns are the axes of the system: z from A to B, C in the plane of x and z
  void take_system(const BdfCard& card) {
    if (const std::string to = cards_.text(card, 1); !to.empty() && to != "0") return;
    const Vector3 a = vector(card, 2), z = (vector(card, 5) - a).normalized(),
                  y = z.cross(vector(card, 8) - a).normalized();
    Matrix3 axes;
    axes << y.cross(z), y, z;
    if (!axes.allFinite()) cards_.fail(card, "its three points are on one line");
    systems_[cards_.text(card, 0)] = axes;
  }

  void take_points(const BdfCard& card) {
    Index first = 0;
    for (std::size_t i = 0; i < card.fields.size(); ++i) {
      if (card.fields[i].empty()) continue;
      if (card.fields[i] != "THRU")
        first = cards_.whole(card, i);
      else
        ++i;
      for (const Index id : range(card, first, cards_.whole(card, i))) modal_.insert(id);
    }
  }

  // After four fields of its own and four blank ones: a row here and one there, or two ranges.
  void take_connection(const BdfCard& card) {
    for (std::size_t i = 8; i < card.fields.size(); i += 2) {
      if (card.fields[i].empty()) continue;
      const bool is_range = cards_.text(card, i + 1) == "THRU";
      const Index first = cards_.whole(card, i);
      for (const Index id : range(card, first, is_range ? cards_.whole(card, i + 2) : first))
        connected_.push_back(id);
      if (is_range) i += 4;
    }
  }

  std::vector<Index> range(const BdfCard& card, Index first, Index last) const {
    constexpr Index most = 100'000;  // rows of dense matrices
    if (last < first || last - first > most)
      cards_.fail(card, "points " + std::to_string(first) + " to " + std::to_string(last) +
                            " found: damaged");
    std::vector<Index> ids;
    for (Index id = first; id <= last; ++id) ids.push_back(id);
    return ids;
  }

  const std::string where_;
  BdfCards cards_;
  std::map<Index, Grid> grids_;
  std::map<std::string, Matrix3> systems_;
  std::set<Index> modal_;
  std::vector<std::pair<Index, Index>> order_;  // node and dofs, of EXTRN
  std::vector<Index> connected_;                // of SECONCT
};

}  // namespace

NastranRows read_nastran_rows(const std::filesystem::path& stem) {
  for (const char* suffix : external_suffixes) {
    const std::filesystem::path file = stem.string() + suffix;
    if (!std::filesystem::exists(file)) continue;
    const ExternalPart part(file);
    if (part.has_order()) return part.rows();
  }
  throw InputError(stem.string() +
                   ".pch, .asm: no EXTRN and no SECONCT names the rows of the matrices: write them "
                   "with EXTSEOUT(ASMBULK,EXTBULK,MATOP4)");
}

void turn_to_basic(const std::map<Index, Matrix3>& axes, const std::string& where,
                   ReducedMatrices& reduced) {
  for (const auto& axis : axes)
    for (const int first : {1, 4}) {
      const Index node = axis.first;
      const Matrix3& T = axis.second;
      const auto is_of = [&](const ReducedRow& row) {
        return row.node == node && row.dof >= first && row.dof < first + 3;
      };
      const auto at = std::find_if(reduced.rows.begin(), reduced.rows.end(), is_of);
      const auto count = std::count_if(at, reduced.rows.end(), is_of);
      if (count != 0 && (count != 3 || !std::all_of(at, at + 3, is_of)))
        throw InputError(where + ": GRID " + std::to_string(node) +
                         " has a system of its own and not all its dofs x, y, z: retain 123 or "
                         "123456 of it");
      if (count == 0) continue;
      const auto i = static_cast<Index>(at - reduced.rows.begin());
      for (Matrix* A : {&reduced.K, &reduced.M}) {
        A->middleRows(i, 3) = (T * A->middleRows(i, 3)).eval();
        A->middleCols(i, 3) = (A->middleCols(i, 3) * T.transpose()).eval();
      }
    }
}

}  // namespace cbr
