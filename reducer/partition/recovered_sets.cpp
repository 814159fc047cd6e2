// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/recovered_sets.hpp"

#include <algorithm>
#include <unordered_map>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// A name becomes that of a dataset.
bool is_plain(const std::string& name) {
  return !name.empty() &&
         std::none_of(name.begin(), name.end(), [](unsigned char c) { return c == '/' || c < 32; });
}

std::vector<char> marked_nodes(const Mesh& mesh, const std::vector<std::string>& names) {
  std::vector<char> marked(mesh.node_ids.size(), 0);
  for (const std::string& name : names) {
    if (find_block(mesh, name) >= 0) continue;
    for (const Index node : set_nodes(mesh, name)) marked[static_cast<std::size_t>(node)] = 1;
  }
  return marked;
}

bool is_named(const std::vector<std::string>& names, const Block& block) {
  return std::find(names.begin(), names.end(), block.name) != names.end();
}

}  // namespace

void check_recovery_sets(const Mesh& mesh, const ReductionOptions& reduction) {
  for (const std::string& name : reduction.recovery_sets) {
    if (find_block(mesh, name) >= 0) continue;
    try {
      set_nodes(mesh, name);
    } catch (const InputError& error) {
      throw InputError(reduction.source.text() +
                       ": reduction.recovery: no element block is named '" + name + "', and " +
                       error.what());
    }
  }
}

void keep_elements_at(const Mesh& mesh, const std::vector<std::string>& names,
                      const std::vector<Index>& place, Superelement::Recovery& recovery) {
  const std::vector<char> marked = marked_nodes(mesh, names);
  const auto n = static_cast<Index>(recovery.node_ids.size());
  const Index n_interface = *std::max_element(place.begin(), place.end()) + 1 - n;
  std::vector<char> is_at(static_cast<std::size_t>(n_interface + n), 0), is_needed = is_at;
  for (std::size_t node = 0; node < place.size(); ++node)
    if (place[node] >= 0) is_at[static_cast<std::size_t>(place[node])] = marked[node];
  for (Block& block : recovery.blocks) {
    const bool whole = is_named(names, block);
    std::vector<Index> rows, ids;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const auto nodes = block.connectivity.row(e);
      if (!whole && std::none_of(nodes.begin(), nodes.end(),
                                 [&](Index i) { return is_at[static_cast<std::size_t>(i)] != 0; }))
        continue;
      rows.push_back(e);
      ids.push_back(block.element_ids[static_cast<std::size_t>(e)]);
      for (const Index i : nodes) is_needed[static_cast<std::size_t>(i)] = 1;
    }
    block.connectivity = IndexTable(block.connectivity(rows, Eigen::all));
    block.element_ids = ids;
  }
  std::vector<Index> new_place(is_needed.size()), nodes, dofs, ids;
  for (Index i = 0; i < n_interface; ++i) new_place[static_cast<std::size_t>(i)] = i;
  for (Index i = 0; i < n; ++i) {
    if (is_needed[static_cast<std::size_t>(n_interface + i)] == 0) continue;
    new_place[static_cast<std::size_t>(n_interface + i)] =
        n_interface + static_cast<Index>(nodes.size());
    nodes.push_back(i);
    dofs.insert(dofs.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    ids.push_back(recovery.node_ids[static_cast<std::size_t>(i)]);
  }
  for (Block& block : recovery.blocks)
    for (Index& i : block.connectivity.reshaped()) i = new_place[static_cast<std::size_t>(i)];
  recovery.node_ids = ids;
  recovery.coordinates = Points(recovery.coordinates(nodes, Eigen::all));
  recovery.Psi = Matrix(recovery.Psi(dofs, Eigen::all));
  recovery.Phi = Matrix(recovery.Phi(dofs, Eigen::all));
}

void add_recovered_sets(const Mesh& mesh, bool is_domain, Superelement& s) {
  if (s.recovery.empty()) return;
  std::unordered_map<Index, Index> place;
  for (const Index id : s.node_ids) place.emplace(id, static_cast<Index>(place.size()));
  for (const Index id : s.recovery.front().node_ids)
    place.emplace(id, static_cast<Index>(place.size()));
  const auto add = [&](const std::string& name) {
    if (!is_plain(name)) return;
    std::vector<Index> nodes;
    const std::vector<Index> all = set_nodes(mesh, name);
    for (const Index node : all)
      if (const auto found = place.find(mesh.node_ids[static_cast<std::size_t>(node)]);
          found != place.end())
        nodes.push_back(found->second);
    if (!nodes.empty() && (is_domain || nodes.size() == all.size()))
      s.recovered_sets[name] = std::move(nodes);
  };
  for (const Sideset& sideset : mesh.sidesets) add(sideset.name);
  for (const Nodeset& nodeset : mesh.nodesets) add(nodeset.name);
}

}  // namespace cbr
