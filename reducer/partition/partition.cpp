// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/partition.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "common/base/error.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/fem/shell_model.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Relative to the part's size. Far above round-off, far below any interface that could hold a part
// in practice.
constexpr double collinear = 1e-10;

// The block of A with these rows (`local`: their number in the block, -1 outside, ascending) and
// columns. Into an argument, because Eigen 3.4 copies a sparse matrix that is returned and
// assigned.
void take_block(const SparseMatrix& A, const std::vector<Index>& local, Index rows,
                const std::vector<Index>& columns, SparseMatrix& B) {
  B.resize(rows, static_cast<Index>(columns.size()));
  Index* outer = B.outerIndexPtr();
  outer[0] = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    outer[j + 1] = outer[j];
    for (SparseMatrix::InnerIterator it(A, columns[j]); it; ++it)
      outer[j + 1] += local[it.row()] >= 0;
  }
  B.resizeNonZeros(outer[columns.size()]);
  Index* inner = B.innerIndexPtr();
  double* value = B.valuePtr();
  for (const Index j : columns) {
    for (SparseMatrix::InnerIterator it(A, j); it; ++it) {
      const Index row = local[it.row()];
      if (row < 0) continue;
      *inner++ = row;
      *value++ = it.value();
    }
  }
}

std::vector<Index> numbering(const std::vector<Index>& dofs, Index n) {
  std::vector<Index> local(n, -1);
  for (std::size_t i = 0; i < dofs.size(); ++i) local[dofs[i]] = static_cast<Index>(i);
  return local;
}

// Rows of K of the nodes' dofs; where some are fixed, also the numbers of the others.
void take_rows(const FiniteElementModel& model, const std::vector<Index>& nodes,
               std::vector<Index>& rows, std::vector<Index>& numbers) {
  rows = dofs_of(nodes);
  numbers.clear();
  if (model.row_of_dof.empty()) return;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!model.is_fixed(rows[i])) numbers.push_back(static_cast<Index>(i));
  std::erase_if(rows, [&](Index dof) { return model.is_fixed(dof); });
  for (Index& row : rows) row = model.row_of_dof[row];
}

bool is_diagonal(const SparseMatrix& M) {
  for (Index j = 0; j < M.cols(); ++j) {
    for (SparseMatrix::InnerIterator it(M, j); it; ++it) {
      if (it.row() != j && it.value() != 0) return false;
    }
  }
  return true;
}

struct Part {
  std::vector<Index> interior, interface;  // model nodes
};

// Rank of the six rigid motions of the part on its interface nodes and on dofs that are fixed.
Index rank_on_interface(const Mesh& mesh, const FiniteElementModel& model, const Part& part) {
  const auto position = [&](Index i) { return Vector3(mesh.coordinates.row(model.nodes[i])); };
  const Vector3 center = position(part.interface.front());
  double size = 0;
  for (const auto* nodes : {&part.interior, &part.interface}) {
    for (const Index i : *nodes) size = std::max(size, (position(i) - center).norm());
  }
  // Of the interior's nodes those with a fixed dof
  std::vector<Index> nodes = part.interface, rows(3 * nodes.size());
  std::iota(rows.begin(), rows.end(), Index{0});
  for (const Index i : model.row_of_dof.empty() ? std::vector<Index>() : part.interior) {
    const auto first = 3 * static_cast<Index>(nodes.size());
    for (Index c = 0; c < 3; ++c)
      if (model.is_fixed(3 * i + c)) rows.push_back(first + c);
    if (rows.back() >= first) nodes.push_back(i);
  }
  Points x(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = (position(nodes[i]) - center) / size;
  const auto n_rotations = std::count_if(nodes.begin(), nodes.end(),
                                         [&](Index i) { return i >= model.n_translations(); });
  const Matrix R = rigid_modes(x, Vector3::Zero(), n_rotations)(rows, Eigen::all);
  return PivotedQr(R, collinear).rank();
}

// "; node id 28 of block 'a' and node id 3 of block 'b' are at the same place: ...", or "": a node
// of the part and one of another that the mesh generator should have made one.
std::string coincidence(const Mesh& mesh, const FiniteElementModel& model,
                        const std::vector<Index>& parts, Index part) {
  for (const NearNodes& pair : near_nodes(mesh, model, parts)) {
    const auto number = [&](Index node) { return parts[node]; };
    if (number(pair.first) != part && number(pair.second) != part) continue;
    const bool own = number(pair.first) == part;
    return "; " + name_of_node(mesh, model.nodes[own ? pair.first : pair.second]) + " and " +
           name_of_node(mesh, model.nodes[own ? pair.second : pair.first]) + " are " +
           how_near(pair.apart) + ": were nodes to be merged?";
  }
  return "";
}

}  // namespace

std::string name_of_node(const Mesh& mesh, Index node) {
  const std::string id = "node id " + std::to_string(mesh.node_ids[node]);
  for (const auto& block : mesh.blocks) {
    if (is_structure(block) && (block.connectivity.array() == node).any())
      return id + " of block '" + block.name + "'";
  }
  return id;
}

std::string name_of_node_id(const Mesh& mesh, Index id) {
  const auto found = std::find(mesh.node_ids.begin(), mesh.node_ids.end(), id);
  return found == mesh.node_ids.end() ? "node id " + std::to_string(id)
                                      : name_of_node(mesh, found - mesh.node_ids.begin());
}

FiniteElementModel number_nodes(const Mesh& mesh) {
  FiniteElementModel model;
  number_nodes(mesh, model);
  if (model.nodes.empty()) throw InputError(no_volume_elements);
  return model;
}

std::vector<Index> dofs_of(const std::vector<Index>& nodes) {
  std::vector<Index> dofs;
  dofs.reserve(3 * nodes.size());
  for (const Index node : nodes) dofs.insert(dofs.end(), {3 * node, 3 * node + 1, 3 * node + 2});
  return dofs;
}

std::vector<Index> interface_nodes(const Mesh& mesh, const FiniteElementModel& model,
                                   const std::vector<std::string>& sets) {
  if (sets.empty()) {
    throw InputError(
        "no interface: name at least one sideset or nodeset whose nodes are kept; the mesh has " +
        set_names(mesh));
  }
  std::vector<bool> kept(model.nodes.size(), false);
  for (const auto& name : sets) {
    const std::vector<Index> nodes = set_nodes(mesh, name);
    if (nodes.empty())
      throw InputError("interface '" + name + "' has no nodes: choose another set of " +
                       set_names(mesh));
    for (const Index node : nodes) {
      const Index i = model.row[node];
      if (i < 0) {
        throw InputError(
            "interface '" + name + "': node id " + std::to_string(mesh.node_ids[node]) +
            " belongs to no volume element and no shell with a thickness: take it out of the set");
      }
      kept[i] = true;
    }
  }
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]) nodes.push_back(static_cast<Index>(i));
  }
  return nodes;
}

std::vector<Index> nodes_of_sets(const Mesh& mesh, const FiniteElementModel& model,
                                 const ReductionOptions& reduction) {
  if (reduction.interface_sets.empty() && !reduction.interface_points.empty()) return {};
  return interface_nodes(mesh, model, reduction.interface_sets);
}

std::vector<Index> other_nodes(const FiniteElementModel& model, const std::vector<Index>& nodes) {
  const std::vector<Index> all = first_numbers(model.nodes.size());
  std::vector<Index> others;
  std::set_difference(all.begin(), all.end(), nodes.begin(), nodes.end(),
                      std::back_inserter(others));
  return others;
}

void partition(const FiniteElementModel& model, const std::vector<Index>& interface_nodes,
               Partition& p) {
  p.interface_nodes = interface_nodes;
  p.interior_nodes = other_nodes(model, interface_nodes);
  const auto rotations_of = [&](const std::vector<Index>& nodes) {
    return nodes.end() - std::lower_bound(nodes.begin(), nodes.end(), model.n_translations());
  };
  p.interior_rotations = rotations_of(p.interior_nodes);
  p.interface_rotations = rotations_of(p.interface_nodes);
  take_rows(model, p.interior_nodes, p.interior_rows, p.interior_dofs);
  take_rows(model, p.interface_nodes, p.interface_rows, p.interface_dofs);
  const std::vector<Index>&I = p.interior_rows, &C = p.interface_rows;
  const std::vector<Index> local_I = numbering(I, model.K.rows()),
                           local_C = numbering(C, model.K.rows());
  const auto n_I = static_cast<Index>(I.size()), c = static_cast<Index>(C.size());
  take_block(model.K, local_I, n_I, I, p.K_II);
  take_block(model.K, local_I, n_I, C, p.K_IC);
  take_block(model.K, local_C, c, C, p.K_CC);
  take_block(model.M, local_I, n_I, I, p.M_II);
  take_block(model.M, local_I, n_I, C, p.M_IC);
  take_block(model.M, local_C, c, C, p.M_CC);
  // With points the mass of the interface alone is not diagonal
  p.lumped =
      p.n_points > 0 ? is_diagonal(p.M_II) && p.M_IC.coeffs().isZero(0) : is_diagonal(model.M);
}

Partition partition(const FiniteElementModel& model, const std::vector<Index>& interface_nodes) {
  Partition p;
  partition(model, interface_nodes, p);
  return p;
}

void check_interface_holds(const Mesh& mesh, const FiniteElementModel& model,
                           const Partition& partition, const std::vector<Index>& parts) {
  if (partition.n_points > 0) return;  // of a component of one part, which a point holds
  const Index n_parts = parts.empty() ? 0 : *std::max_element(parts.begin(), parts.end()) + 1;
  std::vector<Part> found(n_parts);
  for (const Index i : partition.interior_nodes) found[parts[i]].interior.push_back(i);
  for (const Index i : partition.interface_nodes) found[parts[i]].interface.push_back(i);
  for (std::size_t number = 0; number < found.size(); ++number) {
    const Part& part = found[number];
    if (part.interior.empty()) continue;
    // Looked for only when there is something to say of it: the name takes a walk through the mesh
    const auto name = [&] {
      return "the part of " + std::to_string(part.interior.size() + part.interface.size()) +
             " nodes with " + name_of_node(mesh, model.nodes[part.interior.front()]) +
             (n_parts > 1 ? " (one of " + std::to_string(n_parts) + " parts of the mesh)" : "");
    };
    if (part.interface.empty()) {
      throw InputError(name() +
                       " is not connected to the interface: its interior would float; join it to "
                       "the rest, leave it out "
                       "of the mesh, or put some of its nodes into the interface" +
                       coincidence(mesh, model, parts, static_cast<Index>(number)));
    }
    const Index rank = rank_on_interface(mesh, model, part);
    if (rank == 6) continue;
    throw InputError("the interface has " + std::to_string(part.interface.size()) + " node" +
                     (part.interface.size() > 1 ? "s" : "") + " on " + name() +
                     ", not three that are off one line: the interior could turn freely about "
                     "them; add nodes to " +
                     "the interface" +
                     (partition.interior_rotations > 0
                          ? ", or keep rotations of shells there (condense_rotations: false)"
                          : ""));
  }
}

void fix_dofs(const Mesh& mesh, const std::vector<FixedSet>& fixed, FiniteElementModel& model) {
  if (fixed.empty()) return;
  std::vector<Index>& row = model.row_of_dof;
  row.assign(3 * model.nodes.size(), 0);
  for (const FixedSet& set : fixed) {
    const auto fail = [&](const std::string& what) {
      throw InputError(set.source.text() + ": reduction.fixed: " + what);
    };
    std::vector<Index> nodes;
    try {
      nodes = interface_nodes(mesh, model, {set.nodes});
    } catch (const InputError& error) {
      fail(error.what());
    }
    for (const Index node : nodes)
      for (std::size_t c = 0; c < 3; ++c)
        if (set.fix[c]) row[3 * static_cast<std::size_t>(node) + c] = -1;
  }
  std::vector<Index> kept;
  for (std::size_t dof = 0; dof < row.size(); ++dof) {
    if (row[dof] < 0) continue;
    row[dof] = static_cast<Index>(kept.size());
    kept.push_back(static_cast<Index>(dof));
  }
  for (SparseMatrix* A : {&model.K, &model.M}) {
    SparseMatrix whole;
    whole.swap(*A);
    take_block(whole, row, static_cast<Index>(kept.size()), kept, *A);
  }
}

void tell_of_parts(const Mesh& mesh, const FiniteElementModel& model,
                   const std::vector<Index>& parts, Report& report) {
  if (const std::string text = several_parts(mesh, model, parts); !text.empty())
    report.line(report.about() + text);
  if (const std::string text = unjoined_parts(mesh, model, parts); !text.empty())
    report.warning(text);
  if (const std::string text = hinged_shells(mesh, model); !text.empty()) report.warning(text);
}

}  // namespace cbr
