// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduction_steps.hpp"

#include <algorithm>
#include <utility>

#include "reducer/partition/interface_sets.hpp"
#include "reducer/partition/recovered_sets.hpp"

namespace cbr {
namespace {

std::vector<Index> ids_of(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> ids;
  for (const Index i : nodes)
    ids.push_back(
        r.mesh.node_ids[static_cast<std::size_t>(r.model.nodes[static_cast<std::size_t>(i)])]);
  return ids;
}

// Mesh node -> its place in [interface nodes; interior nodes], or -1.
std::vector<Index> places(const Reduction& r) {
  std::vector<Index> place(r.mesh.node_ids.size(), -1);
  Index next = 0;
  for (const auto* nodes : {&r.p.interface_nodes, &r.p.interior_nodes}) {
    for (const Index i : *nodes)
      place[static_cast<std::size_t>(r.model.nodes[static_cast<std::size_t>(i)])] = next++;
  }
  return place;
}

}  // namespace

Index mesh_node(const Reduction& r, Index model_node) {
  return r.model.nodes[static_cast<std::size_t>(model_node)];
}

std::string node_of_interior_dof(const Reduction& r, Index dof) {
  const Index node = r.p.interior_nodes[static_cast<std::size_t>(dof / 3)];
  return name_of_node(r.mesh, r.model.nodes[static_cast<std::size_t>(node)]) + " in " +
         "xyz"[dof % 3];
}

std::vector<Index> parts_of_nodes(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> part;
  for (const Index node : nodes) part.push_back(r.part[static_cast<std::size_t>(node)]);
  return part;
}

std::vector<Index> parts_of_interface(const Reduction& r) {
  return parts_of_nodes(r, r.p.interface_nodes);
}

bool has_parts(const Reduction& r) {
  return !r.part.empty() && *std::max_element(r.part.begin(), r.part.end()) > 0;
}

std::vector<ComponentPart> parts(const Reduction& r) {
  if (!has_parts(r)) return {};
  return split(r.p, parts_of_nodes(r, r.p.interior_nodes), parts_of_interface(r));
}

std::string node_of_interface_dof(const Reduction& r, Index dof) {
  return name_of_node(r.mesh, mesh_node(r, r.p.interface_nodes[static_cast<std::size_t>(dof / 3)]));
}

Points coordinates_of(const Reduction& r, const std::vector<Index>& nodes) {
  Points x(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) {
    x.row(i) = r.mesh.coordinates.row(
        r.model.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(i)])]);
  }
  return x;
}

void add_recovery(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s) {
  Superelement::Recovery recovery;
  recovery.node_ids = ids_of(r, r.p.interior_nodes);
  recovery.coordinates = coordinates_of(r, r.p.interior_nodes);
  recovery.Psi = std::move(Psi);
  recovery.Phi = std::move(Phi);
  if (r.p.n_interior() == 0)
    recovery.Psi.resize(0, r.p.n_interface()), recovery.Phi.resize(0, s.k());
  const std::vector<Index> place = places(r);
  for (const auto& block : r.mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    recovery.blocks.push_back(block);
    for (Index& node : recovery.blocks.back().connectivity.reshaped())
      node = place[static_cast<std::size_t>(node)];
  }
  if (!r.options.recovery_sets.empty())
    keep_elements_at(r.mesh, r.options.recovery_sets, place, recovery);
  s.recovery.push_back(std::move(recovery));
}

void describe_interface(const Reduction& r, Superelement& s) {
  s.node_ids = ids_of(r, r.p.interface_nodes);
  s.coordinates = coordinates_of(r, r.p.interface_nodes);
  for (Index i = 0; i < r.p.n_interface(); ++i) {
    s.dof_node.push_back(i / 3);
    s.dof_component.push_back(static_cast<int>(i % 3));
  }
  std::vector<Index> place = places(r);
  for (Index& i : place) i = i < static_cast<Index>(r.p.interface_nodes.size()) ? i : -1;
  add_interface_sets(r.mesh, place, r.options.interface_sets, s);
}

}  // namespace cbr
