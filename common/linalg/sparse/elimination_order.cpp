// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/elimination_order.hpp"

#include <algorithm>

namespace cbr {
namespace {

constexpr Index dofs_of_a_node = 3;
// Of the entries that whole blocks would have. One triangle of the blocks on the diagonal may be
// missing.
constexpr double full_enough = 0.8;

// Numbers of the nodes that are not in `last`, in their order; -1: of `last`.
std::vector<Index> numbers(Index n_nodes, Index dofs, const std::vector<Index>& last,
                           Index& count) {
  std::vector<Index> number(n_nodes, 0);
  for (const Index row : last) number[row / dofs] = -1;
  count = 0;
  for (Index& of : number)
    if (of >= 0) of = count++;
  return number;
}

// work(node, other) once for every pair of nodes that share an entry of A.
template <typename Work>
void for_pairs(const SparseMatrix& A, Index dofs, Work work) {
  std::vector<Index> seen(A.cols() / dofs, -1);
  for (Index node = 0; node < A.cols() / dofs; ++node) {
    for (Index column = dofs * node; column < dofs * (node + 1); ++column) {
      for (SparseMatrix::InnerIterator it(A, column); it; ++it) {
        const Index other = it.row() / dofs;
        if (seen[other] == node) continue;
        seen[other] = node;
        work(node, other);
      }
    }
  }
}

}  // namespace

Index dofs_per_node(const SparseMatrix& A) {
  if (A.rows() % dofs_of_a_node != 0) return 1;
  Index blocks = 0;
  for_pairs(A, dofs_of_a_node, [&](Index, Index) { ++blocks; });
  const auto whole = static_cast<double>(dofs_of_a_node * dofs_of_a_node * blocks);
  return static_cast<double>(A.nonZeros()) >= full_enough * whole ? dofs_of_a_node : 1;
}

SparseMatrix node_graph(const SparseMatrix& A, Index dofs, const std::vector<Index>& last) {
  Index count = 0;
  const std::vector<Index> number = numbers(A.cols() / dofs, dofs, last, count);
  std::vector<std::vector<Index>> below(count);
  for_pairs(A, dofs, [&](Index node, Index other) {
    const Index i = number[node], j = number[other];
    // Either triangle may be stored; the lower one of a node's pairs is enough where both are
    if (i >= 0 && j >= i) below[i].push_back(j);
  });
  SparseMatrix graph(count, count);
  Index entries = 0;
  for (const auto& rows : below) entries += static_cast<Index>(rows.size());
  graph.reserve(entries);
  for (Index i = 0; i < count; ++i) {
    auto& rows = below[i];
    std::sort(rows.begin(), rows.end());
    graph.startVec(i);
    for (const Index j : rows) graph.insertBack(j, i) = 1;
  }
  graph.finalize();
  return graph;
}

std::vector<Index> order_of_rows(const std::vector<Index>& nodes, Index dofs, Index n,
                                 const std::vector<Index>& last) {
  Index count = 0;
  const std::vector<Index> number = numbers(n / dofs, dofs, last, count);
  std::vector<Index> node_of(count);
  for (std::size_t node = 0; node < number.size(); ++node)
    if (number[node] >= 0) node_of[number[node]] = static_cast<Index>(node);
  std::vector<Index> order;
  order.reserve(n);
  for (const Index i : nodes)
    for (Index d = 0; d < dofs; ++d) order.push_back(dofs * node_of[i] + d);
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

}  // namespace cbr
