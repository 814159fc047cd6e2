// SPDX-License-Identifier: GPL-3.0-or-later
#include <map>

#include "common/superelement/sierra_superelement.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {
namespace {

// Modes first.
Matrix modes_first(const Matrix& A, Index k) {
  const Index c = A.rows() - k;
  Matrix out(A.rows(), A.cols());
  out << A.bottomRightCorner(k, k), A.bottomLeftCorner(k, c), A.topRightCorner(c, k),
      A.topLeftCorner(c, c);
  return out;
}

}  // namespace

void write_sierra(const ReducedMatrices& reduced, bool is_newer, const std::filesystem::path& file,
                  const std::string& where) {
  SierraSuperelement s;
  std::map<Index, Vector3> position;
  for (const ReducedRow& row : reduced.rows) {
    if (row.dof == 0) {
      ++s.n_modes;
      continue;
    }
    s.dof_node.push_back(row.node);
    s.dof_component.push_back(row.dof - 1);
    position.emplace(row.node, row.position);
  }
  s.Kr = modes_first(reduced.K, s.n_modes);
  s.Mr = modes_first(reduced.M, s.n_modes);
  s.coordinates.resize(static_cast<Index>(position.size()), 3);
  for (const auto& [id, x] : position) {
    s.coordinates.row(static_cast<Index>(s.node_ids.size())) = x.transpose();
    s.node_ids.push_back(id);
  }
  write_sierra_superelement(s, is_newer ? SierraLayout::newer : SierraLayout::older, file, where);
}

}  // namespace cbr
