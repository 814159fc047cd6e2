// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/node_shares.hpp"

#include <petscmat.h>

#include <algorithm>

#include "reducer/distributed/petsc.hpp"

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
    for (auto& row : rows) settle(row);
  }

 private:
  void add_element(const Block& block, Index e, const std::vector<Index>& node, Index begin,
                   Index end) {
    for (const Index a : block.connectivity.row(e)) {
      const Index i = node[a];
      if (i < begin || i >= end) continue;
      for (const Index b : block.connectivity.row(e))
        if (node[b] >= 0 && b != a) rows[i - begin].push_back(static_cast<PetscInt>(node[b]));
      if (rows[i - begin].size() > 512) settle(rows[i - begin]);
    }
  }

  static void settle(std::vector<PetscInt>& row) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
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

}  // namespace cbr
