// SPDX-License-Identifier: GPL-3.0-or-later
// Superelements that share nodes put together. The file of a group: superelement_group_file.cpp.
#include "common/superelement/superelement_group.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// A triangle in a set of quad4 repeats its last node, as extract_surface() has it.
void widen_to_quads(Surface& surface) {
  if (surface.kind == FaceKind::quad4) return;
  IndexTable faces(surface.n_faces(), 4);
  faces << surface.faces, surface.faces.col(2);
  surface.faces = std::move(faces);
  surface.kind = FaceKind::quad4;
}

bool is_linear(FaceKind kind) { return kind == FaceKind::tri3 || kind == FaceKind::quad4; }

// Faces of one name; `more` indexes the joined nodes already.
void append(Surface& surface, Surface more) {
  if (surface.kind != more.kind) {
    if (!is_linear(surface.kind) || !is_linear(more.kind)) {
      throw InputError("/interface/" + surface.name + ": faces of kind " +
                       std::string(name(more.kind)) + " in one domain, " +
                       std::string(name(surface.kind)) +
                       " in another: only tri3 and quad4 go together");
    }
    widen_to_quads(surface);
    widen_to_quads(more);
  }
  const Index n = surface.n_faces();
  surface.faces.conservativeResize(n + more.n_faces(), Eigen::NoChange);
  surface.faces.bottomRows(more.n_faces()) = more.faces;
  surface.element.insert(surface.element.end(), more.element.begin(), more.element.end());
  surface.side.insert(surface.side.end(), more.side.begin(), more.side.end());
}

void join_surfaces(const SuperelementGroup& group, JoinedNodes& joined) {
  std::map<std::string, Surface> by_name;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    for (Surface surface : group.domains[d].surfaces) {
      for (Index& node : surface.faces.reshaped())
        node = joined.place[d][static_cast<std::size_t>(node)];
      const auto [place, is_new] = by_name.try_emplace(surface.name, surface);
      if (!is_new) append(place->second, std::move(surface));
    }
  }
  for (auto& [name, surface] : by_name) joined.surfaces.push_back(std::move(surface));
}

void join_nodesets(const SuperelementGroup& group, JoinedNodes& joined) {
  std::map<std::string, std::set<Index>> by_name;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    for (const auto& [name, nodes] : group.domains[d].nodesets) {
      auto& all = by_name[name];
      for (const Index node : nodes) all.insert(joined.place[d][static_cast<std::size_t>(node)]);
    }
  }
  for (const auto& [name, nodes] : by_name)
    joined.nodesets[name].assign(nodes.begin(), nodes.end());
}

// Per dof of the domain its number among the joined ones, 3 node + component.
std::vector<Index> joined_dofs(const Superelement& domain, const std::vector<Index>& place) {
  std::vector<Index> dofs;
  for (std::size_t i = 0; i < domain.dof_node.size(); ++i) {
    dofs.push_back(3 * place[static_cast<std::size_t>(domain.dof_node[i])] +
                   domain.dof_component[i]);
  }
  return dofs;
}

// Domains that were read without their matrices give a whole without them.
bool has_matrices(const SuperelementGroup& group) {
  return std::all_of(group.domains.begin(), group.domains.end(), [](const Superelement& s) {
    return s.K_cc.rows() == s.c() && s.M_kc.cols() == s.c();
  });
}

void join_matrices(const SuperelementGroup& group, const JoinedNodes& joined, Superelement& whole) {
  const Index c = whole.c();
  whole.K_cc = Matrix::Zero(c, c);
  whole.M_cc = Matrix::Zero(c, c);
  whole.M_kc = Matrix::Zero(whole.k(), c);
  Index first = 0;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const std::vector<Index> dofs = joined_dofs(s, joined.place[d]);
    for (Index j = 0; j < s.c(); ++j) {
      const Index column = dofs[static_cast<std::size_t>(j)];
      for (Index i = 0; i < s.c(); ++i) {
        const Index row = dofs[static_cast<std::size_t>(i)];
        whole.K_cc(row, column) += s.K_cc(i, j);
        whole.M_cc(row, column) += s.M_cc(i, j);
      }
      whole.M_kc.col(column).segment(first, s.k()) = s.M_kc.col(j);
    }
    first += s.k();
  }
}

}  // namespace

JoinedNodes join_nodes(const SuperelementGroup& group) {
  std::map<Index, Index> row;  // id -> row
  for (const auto& domain : group.domains) {
    for (const Index id : domain.node_ids) row.try_emplace(id, 0);
  }
  JoinedNodes joined;
  for (auto& [id, i] : row) {
    i = static_cast<Index>(joined.node_ids.size());
    joined.node_ids.push_back(id);
  }
  joined.coordinates.resize(static_cast<Index>(row.size()), 3);
  for (const auto& domain : group.domains) {
    auto& place = joined.place.emplace_back();
    for (std::size_t i = 0; i < domain.node_ids.size(); ++i) {
      place.push_back(row.at(domain.node_ids[i]));
      joined.coordinates.row(place.back()) = domain.coordinates.row(static_cast<Index>(i));
    }
  }
  join_surfaces(group, joined);
  join_nodesets(group, joined);
  return joined;
}

Superelement join(const SuperelementGroup& group) {
  JoinedNodes joined = join_nodes(group);
  Superelement whole;
  if (!group.domains.empty()) whole.basis = group.domains.front().basis;
  whole.content_hash = group.content_hash;
  whole.provenance = group.provenance;
  whole.rigid_body = group.rigid_body;
  Index k = 0;
  for (const auto& domain : group.domains) k += domain.k();
  whole.eigenvalues.resize(k);
  k = 0;
  for (const auto& domain : group.domains) {
    whole.eigenvalues.segment(k, domain.k()) = domain.eigenvalues;
    k += domain.k();
  }
  for (Index i = 0; i < 3 * static_cast<Index>(joined.node_ids.size()); ++i) {
    whole.dof_node.push_back(i / 3);
    whole.dof_component.push_back(static_cast<int>(i % 3));
  }
  if (has_matrices(group)) join_matrices(group, joined, whole);
  whole.node_ids = std::move(joined.node_ids);
  whole.coordinates = std::move(joined.coordinates);
  whole.surfaces = std::move(joined.surfaces);
  whole.nodesets = std::move(joined.nodesets);
  whole.omega = group.omega;
  whole.V = group.V;
  return whole;
}

}  // namespace cbr
