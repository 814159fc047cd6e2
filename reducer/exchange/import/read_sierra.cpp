// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>

#include "common/base/error.hpp"
#include "common/superelement/sierra_superelement.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {

ReducedMatrices read_sierra(const std::filesystem::path& file) {
  SierraSuperelement s = read_sierra_superelement(file);
  std::map<Index, Index> place;
  for (std::size_t i = 0; i < s.node_ids.size(); ++i)
    place.emplace(s.node_ids[i], static_cast<Index>(i));
  const Index last =
      s.dof_node.empty() ? 0 : *std::max_element(s.dof_node.begin(), s.dof_node.end());
  ReducedMatrices reduced;
  for (Index j = 0; j < s.n_modes; ++j)
    reduced.rows.push_back({last + 1 + j, 0, Vector3::Zero(), 0});
  for (std::size_t i = 0; i < s.dof_node.size(); ++i) {
    const std::string node = "node " + std::to_string(s.dof_node[i]);
    if (s.dof_component[i] > 2)
      throw InputError(file.string() + ": cbmap: rotational dof " +
                       std::to_string(s.dof_component[i] + 1) + " of " + node +
                       " found, only x, y, z (1, 2, 3) are known: make the superelement with an "
                       "interface of solid elements");
    const auto found = place.find(s.dof_node[i]);
    if (found == place.end())
      throw InputError(file.string() + ": cbmap: " + node + " is not in node_num_map");
    reduced.rows.push_back(
        {s.dof_node[i], s.dof_component[i] + 1, s.coordinates.row(found->second).transpose(), 0});
  }
  reduced.has_damping = s.has_damping;
  reduced.has_recovery = s.output_map.size() > 0;
  reduced.K = std::move(s.Kr);
  reduced.M = std::move(s.Mr);
  return reduced;
}

}  // namespace cbr
