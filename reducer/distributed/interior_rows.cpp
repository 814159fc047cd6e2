// SPDX-License-Identifier: GPL-3.0-or-later

#include <petscmat.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "common/base/error.hpp"
#include "reducer/distributed/distributed_interior.hpp"
#include "reducer/distributed/petsc.hpp"
#include "reducer/partition/rigid_motions.hpp"

namespace cbr {
namespace {

// Fewer nodes than this a process are divided by their numbers alone.
constexpr Index worth_a_partition = 200;

// Rows [begin, end) of the graph: other nodes that share an element with the row's, ascending.
struct GraphRows {
  std::vector<std::vector<PetscInt>> rows;

  GraphRows(const Mesh& mesh, const std::vector<Index>& node, Index begin, Index end)
      : rows(end - begin) {
    for (const Block& block : mesh.blocks) {
      if (dimension(block.type) != 3) continue;
      for (Index e = 0; e < block.connectivity.rows(); ++e) add_element(block, e, node, begin, end);
    }
    for (auto& row : rows) sort_uniquely(row);
  }

 private:
  void add_element(const Block& block, Index e, const std::vector<Index>& node, Index begin,
                   Index end) {
    for (const Index a : block.connectivity.row(e)) {
      const Index i = node[a];
      if (i < begin || i >= end) continue;
      for (const Index b : block.connectivity.row(e))
        if (node[b] >= 0 && b != a) rows[i - begin].push_back(static_cast<PetscInt>(node[b]));
      if (rows[i - begin].size() > 512) sort_uniquely(rows[i - begin]);
    }
  }
};

// PETSc frees these arrays
Mat graph_of(const GraphRows& graph, Index n) {
  std::size_t entries = 0;
  for (const auto& row : graph.rows) entries += row.size();
  PetscInt *start = nullptr, *list = nullptr;
  petsc(PetscMalloc1(graph.rows.size() + 1, &start));
  petsc(PetscMalloc1(entries, &list));
  start[0] = 0;
  for (std::size_t i = 0; i < graph.rows.size(); ++i) {
    std::copy(graph.rows[i].begin(), graph.rows[i].end(), list + start[i]);
    start[i + 1] = start[i] + static_cast<PetscInt>(graph.rows[i].size());
  }
  Mat A = nullptr;
  petsc(MatCreateMPIAdj(PETSC_COMM_WORLD, static_cast<PetscInt>(graph.rows.size()),
                        static_cast<PetscInt>(n), start, list, nullptr, &A));
  return A;
}

// Per node its process.
std::vector<int> partition_of(const Mesh& mesh, const std::vector<Index>& node, Index n, int rank,
                              int count) {
  Mat graph = graph_of(GraphRows(mesh, node, n * rank / count, n * (rank + 1) / count), n);
  MatPartitioning partitioning = nullptr;
  IS own = nullptr, all = nullptr;
  petsc(MatPartitioningCreate(PETSC_COMM_WORLD, &partitioning));
  petsc(MatPartitioningSetAdjacency(partitioning, graph));
  petsc(MatPartitioningSetType(partitioning, MATPARTITIONINGPTSCOTCH));
  petsc(MatPartitioningApply(partitioning, &own));
  petsc(ISAllGather(own, &all));
  const PetscInt* of = nullptr;
  petsc(ISGetIndices(all, &of));
  std::vector<int> owner(of, of + n);
  petsc(ISRestoreIndices(all, &of));
  petsc(ISDestroy(&all));
  petsc(ISDestroy(&own));
  petsc(MatPartitioningDestroy(&partitioning));
  petsc(MatDestroy(&graph));
  return owner;
}

}  // namespace

NodeShares share_nodes(const Mesh& mesh, const std::vector<Index>& node, Index n) {
  int rank = 0, count = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &count);
  NodeShares shares;
  if (count > 1 && n >= worth_a_partition * count) {
    shares.owner = partition_of(mesh, node, n, rank, count);
  } else {
    for (Index i = 0; i < n; ++i) shares.owner.push_back(static_cast<int>(i * count / n));
  }
  shares.first.assign(count + 1, 0);
  for (const int owner : shares.owner) ++shares.first[owner + 1];
  for (int q = 0; q < count; ++q) shares.first[q + 1] += shares.first[q];
  std::vector<Index> next(shares.first.begin(), shares.first.end() - 1);
  for (const int owner : shares.owner) shares.number.push_back(next[owner]++);
  return shares;
}

namespace {

using Wanted = std::function<bool(Index mesh_node)>;

// The elements that have a wanted node, with their nodes alone. `origin`: mesh nodes of these.
Mesh elements_around(const Mesh& mesh, const Wanted& is_wanted, std::vector<Index>& origin) {
  Mesh part;
  std::vector<Index> local(mesh.node_ids.size(), -1);
  for (const Block& block : mesh.blocks) {
    part.blocks.push_back({block.name, block.id, block.type, {}, {}, {}});
    Block& own = part.blocks.back();
    own.connectivity.resize(0, block.connectivity.cols());
    if (dimension(block.type) != 3) continue;
    std::vector<Index> elements;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const auto nodes = block.connectivity.row(e);
      if (std::any_of(nodes.begin(), nodes.end(), is_wanted)) elements.push_back(e);
    }
    own.connectivity = block.connectivity(elements, Eigen::all);
    for (const Index e : elements) own.element_ids.push_back(block.element_ids[e]);
    for (const Index a : own.connectivity.reshaped()) local[a] = 0;
  }
  for (std::size_t a = 0; a < local.size(); ++a)
    if (local[a] == 0) {
      local[a] = static_cast<Index>(origin.size());
      origin.push_back(static_cast<Index>(a));
    }
  for (Block& block : part.blocks)
    for (Index& a : block.connectivity.reshaped()) a = local[a];
  part.coordinates = mesh.coordinates(origin, Eigen::all);
  for (const Index a : origin) part.node_ids.push_back(mesh.node_ids[a]);
  return part;
}

// Where a dof of a part of the mesh belongs.
struct Dofs {
  // number over all processes, number among the interface's dofs; or -1
  std::vector<Index> interior, interface;
};

Dofs dofs_of_part(const std::vector<Index>& origin, const std::vector<Index>& node,
                  const std::vector<Index>& place, const NodeShares& shares) {
  Dofs dofs;
  for (const Index a : origin)
    for (Index d = 0; d < 3; ++d) {
      dofs.interior.push_back(node[a] < 0 ? -1 : 3 * shares.number[node[a]] + d);
      dofs.interface.push_back(place[a] < 0 ? -1 : 3 * place[a] + d);
    }
  return dofs;
}

void require_small_indices(Index n) {
  if (n > std::numeric_limits<int>::max())
    throw RunError(
        "a process has more than 2^31 entries of the matrices, which Debian's PETSc cannot count: "
        "use more processes");
}

// Rows `own` of A (symmetric: its columns) in the interior's columns and, by triplets, in the
// interface's.
void take_rows(const SparseMatrix& A, const std::vector<Index>& own, const Dofs& dofs, Index c,
               DistributedRows& II, SparseMatrix& IC) {
  Index entries = 0;
  for (const Index j : own) entries += A.col(j).nonZeros();
  require_small_indices(entries);
  std::vector<Eigen::Triplet<double, Index>> coupling;
  std::vector<std::pair<int, double>> row;
  II.start.push_back(0);
  for (std::size_t i = 0; i < own.size(); ++i) {
    row.clear();
    for (SparseMatrix::InnerIterator it(A, own[i]); it; ++it) {
      const Index in = dofs.interior[it.row()];
      if (in >= 0) row.emplace_back(static_cast<int>(in), it.value());
      if (in < 0)
        coupling.emplace_back(static_cast<Index>(i), dofs.interface[it.row()], it.value());
    }
    std::sort(row.begin(), row.end());
    for (const auto& [column, value] : row) {
      II.column.push_back(column);
      II.value.push_back(value);
    }
    II.start.push_back(static_cast<int>(II.column.size()));
  }
  IC.resize(static_cast<Index>(own.size()), c);
  IC.setFromTriplets(coupling.begin(), coupling.end());
}

SparseMatrix on_interface(const SparseMatrix& A, const Dofs& dofs, Index c) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      if (dofs.interface[j] >= 0 && dofs.interface[it.row()] >= 0)
        entries.emplace_back(dofs.interface[it.row()], dofs.interface[j], it.value());
  SparseMatrix B(c, c);
  B.setFromTriplets(entries.begin(), entries.end());
  return B;
}

// A model's dof is that of the part's node, as all of its nodes are used.
FiniteElementModel model_around(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                MassKind mass, const Wanted& is_wanted,
                                std::vector<Index>& origin) {
  return assemble(elements_around(mesh, is_wanted, origin), properties, mass);
}

double residual_of(const FiniteElementModel& model, const Points& x) {
  return rigid_residual(model.K, rigid_modes(x, x.colwise().mean().transpose())).value;
}

}  // namespace

InteriorRows assemble_rows(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                           MassKind mass, const std::vector<Index>& node,
                           const std::vector<Index>& place, Index n_interface_nodes,
                           const NodeShares& shares, int rank) {
  InteriorRows rows;
  const Index c = 3 * n_interface_nodes;
  rows.n = 3 * shares.first.back();
  rows.first = 3 * shares.first[rank];
  for (std::size_t i = 0; i < shares.owner.size(); ++i)
    if (shares.owner[i] == rank) rows.nodes.push_back(static_cast<Index>(i));
  rows.n_own = 3 * static_cast<Index>(rows.nodes.size());
  require_small_indices(rows.n);
  rows.K_IC.resize(rows.n_own, c);
  rows.M_IC.resize(rows.n_own, c);
  rows.K_CC.resize(c, c);
  rows.M_CC.resize(c, c);
  const auto is_own = [&](Index a) { return node[a] >= 0 && shares.owner[node[a]] == rank; };
  if (rows.n_own > 0) {
    std::vector<Index> origin, own(rows.n_own);
    const FiniteElementModel model = model_around(mesh, properties, mass, is_own, origin);
    const Dofs dofs = dofs_of_part(origin, node, place, shares);
    for (std::size_t j = 0; j < dofs.interior.size(); ++j)
      if (is_own(origin[j / 3])) own[dofs.interior[j] - rows.first] = static_cast<Index>(j);
    rows.rigid_residual = residual_of(model, mesh.coordinates(origin, Eigen::all));
    take_rows(model.K, own, dofs, c, rows.K_II, rows.K_IC);
    take_rows(model.M, own, dofs, c, rows.M_II, rows.M_IC);
  } else {
    rows.K_II.start = rows.M_II.start = {0};
  }
  if (rank == 0 && c > 0) {
    std::vector<Index> origin;
    const FiniteElementModel model = model_around(
        mesh, properties, mass, [&](Index a) { return place[a] >= 0; }, origin);
    const Dofs dofs = dofs_of_part(origin, node, place, shares);
    rows.K_CC = on_interface(model.K, dofs, c);
    rows.M_CC = on_interface(model.M, dofs, c);
  }
  return rows;
}

}  // namespace cbr
