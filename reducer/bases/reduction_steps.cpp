// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduction_steps.hpp"

#include <algorithm>
#include <utility>

#include "reducer/modes/interior_loads.hpp"
#include "reducer/partition/interface_sets.hpp"

namespace cbr {
namespace {

std::vector<Index> ids_of(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> ids;
  for (const Index i : nodes) ids.push_back(r.mesh.node_ids[r.model.nodes[i]]);
  return ids;
}

// Interface nodes that are nodes of the mesh, which come before those of points.
std::vector<Index> mesh_nodes_on_interface(const Reduction& r) {
  const auto& all = r.p.interface_nodes;
  return {all.begin(), all.end() - 2 * r.p.n_points - r.p.interface_rotations};
}

// The same of the interior.
std::vector<Index> mesh_nodes_inside(const Reduction& r) {
  const auto& all = r.p.interior_nodes;
  return {all.begin(), all.end() - r.p.interior_rotations};
}

// Mesh node -> its place in [interface nodes; points; interior nodes; nodes of points], or -1.
std::vector<Index> places(const Reduction& r) {
  std::vector<Index> place(r.mesh.node_ids.size(), -1);
  Index next = 0;
  const auto add = [&](const std::vector<Index>& nodes) {
    for (const Index i : nodes) place[r.model.nodes[i]] = next++;
  };
  add(mesh_nodes_on_interface(r));
  next += r.p.n_points;
  add(mesh_nodes_inside(r));
  for (const RigidPoint& point : r.settings.points)
    for (const Index node : point.nodes) place[node] = next++;
  return place;
}

// The nodes of points follow those inside: u = U + theta x r, whatever the modes do.
void add_nodes_of_points(const Reduction& r, Superelement::Recovery& recovery) {
  Index n = static_cast<Index>(recovery.node_ids.size()), more = 0;
  for (const RigidPoint& point : r.settings.points) more += static_cast<Index>(point.nodes.size());
  if (more == 0) return;
  recovery.coordinates.conservativeResize(n + more, Eigen::NoChange);
  recovery.Psi.conservativeResize(3 * (n + more), Eigen::NoChange);
  recovery.Phi.conservativeResize(3 * (n + more), Eigen::NoChange);
  recovery.Psi.bottomRows(3 * more).setZero();
  recovery.Phi.bottomRows(3 * more).setZero();
  Index column = r.p.n_interface() - 6 * r.p.n_points;
  for (const RigidPoint& point : r.settings.points) {
    for (const Index node : point.nodes) {
      recovery.node_ids.push_back(r.mesh.node_ids[node]);
      recovery.coordinates.row(n) = r.mesh.coordinates.row(node);
      recovery.Psi.block<3, 6>(3 * n, column) =
          motion_at(Vector3(r.mesh.coordinates.row(node)) - point.at);
      ++n;
    }
    column += 6;
  }
}

}  // namespace

Index mesh_node(const Reduction& r, Index model_node) { return r.model.nodes[model_node]; }

std::string node_of_interior_dof(const Reduction& r, Index row) {
  const Index dof = r.p.interior_dof(row);
  const Index node = r.p.interior_nodes[dof / 3];
  return name_of_node(r.mesh, r.model.nodes[node]) +
         (r.p.is_interior_rotation(dof / 3) ? " turning about " : " in ") + "xyz"[dof % 3];
}

std::vector<Index> parts_of_nodes(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> part;
  for (const Index node : nodes) part.push_back(r.part[node]);
  return part;
}

std::vector<Index> parts_of_interface(const Reduction& r) {
  std::vector<Index> part = parts_of_nodes(r, r.p.interface_nodes);
  // A point is one node, and so is a node with its rotation
  part.resize(part.size() - static_cast<std::size_t>(r.p.n_points + r.p.interface_rotations));
  return part;
}

bool has_parts(const Reduction& r) {
  return !r.part.empty() && *std::max_element(r.part.begin(), r.part.end()) > 0;
}

std::vector<ComponentPart> parts(const Reduction& r) {
  if (!has_parts(r)) return {};
  return split(r.p, parts_of_nodes(r, r.p.interior_nodes), parts_of_nodes(r, r.p.interface_nodes));
}

std::string node_of_interface_dof(const Reduction& r, Index row) {
  const Index dof = r.p.interface_dof(row);
  return name_of_node(r.mesh, mesh_node(r, r.p.interface_nodes[dof / 3]));
}

Points coordinates_of(const Reduction& r, const std::vector<Index>& nodes) {
  return r.x(nodes, Eigen::all);
}

void add_momentum(const Reduction& r, const Matrix& Phi, Superelement& s) {
  if (!s.fixed.any()) return;
  s.fixed.momentum = generalised_forces(*r.inside, r.momentum(r.p.interior_rows, Eigen::all),
                                        r.momentum(r.p.interface_rows, Eigen::all), Phi);
}

std::vector<Index> own_nodes(const Reduction& r) {
  const std::vector<Index>* numbers = r.inside->own_nodes();
  if (numbers == nullptr) return r.p.interior_nodes;
  std::vector<Index> own;
  for (const Index i : *numbers) own.push_back(r.p.interior_nodes[i]);
  return own;
}

namespace {

// Rows of all dofs of the interior's nodes: fixed ones do not move.
void add_fixed_rows(const Partition& p, Matrix& A) {
  if (!p.has_fixed()) return;
  Matrix all = Matrix::Zero(3 * static_cast<Index>(p.interior_nodes.size()), A.cols());
  all(p.interior_dofs, Eigen::all) = A;
  A = std::move(all);
}

void recover_in_one(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s) {
  Superelement::Recovery recovery;
  const std::vector<Index> inside = mesh_nodes_inside(r);
  recovery.node_ids = ids_of(r, inside);
  recovery.coordinates = coordinates_of(r, inside);
  recovery.Psi = std::move(Psi);
  recovery.Phi = std::move(Phi);
  if (r.p.n_interior() == 0) {
    recovery.Psi.resize(0, r.p.n_interface());
    recovery.Phi.resize(0, s.k());
  }
  add_fixed_rows(r.p, recovery.Psi);
  add_fixed_rows(r.p, recovery.Phi);
  add_nodes_of_points(r, recovery);
  const std::vector<Index> place = places(r);
  for (std::size_t i = inside.size(); i < r.p.interior_nodes.size(); ++i)
    recovery.rotations.push_back(place[mesh_node(r, r.p.interior_nodes[i])]);
  for (const auto& block : r.mesh.blocks) {
    if (!is_structure(block)) continue;
    recovery.blocks.push_back(block);
    for (Index& node : recovery.blocks.back().connectivity.reshaped()) node = place[node];
  }
  if (!r.options.recovery_sets.empty())
    keep_elements_at(r.mesh, r.options.recovery_sets, place, recovery);
  s.recovery.push_back(std::move(recovery));
}

}  // namespace

void add_recovery(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s) {
  Matrix all = r.inside->gather(std::move(Phi));
  r.inside->in_first([&] { recover_in_one(r, std::move(Psi), std::move(all), s); });
}

void describe_interface(const Reduction& r, Superelement& s) {
  const std::vector<Index> nodes = mesh_nodes_on_interface(r);
  s.node_ids = ids_of(r, nodes);
  Points x = coordinates_of(r, nodes);
  for (Index i = 0; i < 3 * x.rows(); ++i) {
    if (r.model.is_fixed(3 * nodes[i / 3] + i % 3)) continue;
    s.dof_node.push_back(i / 3);
    s.dof_component.push_back(static_cast<int>(i % 3));
  }
  std::vector<Index> place = places(r);
  for (Index& i : place) i = i < x.rows() ? i : -1;
  // Rotations behind all displacements
  const auto first = static_cast<std::ptrdiff_t>(nodes.size());
  for (Index i = 0; i < r.p.interface_rotations; ++i)
    for (int c = 3; c < 6; ++c) {
      const Index node = r.p.interface_nodes[first + i];
      s.dof_node.push_back(place[mesh_node(r, node)]);
      s.dof_component.push_back(c);
    }
  add_interface_sets(r.mesh, place, r.options.interface_sets, s);
  // Nodes that the mesh does not have, numbered above all of its own
  Index id = *std::max_element(r.mesh.node_ids.begin(), r.mesh.node_ids.end());
  for (const RigidPoint& point : r.settings.points) {
    const auto node = static_cast<Index>(s.node_ids.size());
    s.node_ids.push_back(++id);
    x.conservativeResize(node + 1, Eigen::NoChange);
    x.row(node) = point.at.transpose();
    for (int component = 0; component < 6; ++component) {
      s.dof_node.push_back(node);
      s.dof_component.push_back(component);
    }
    s.nodesets[point.name] = {node};
  }
  s.coordinates = std::move(x);
}

}  // namespace cbr
