// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/symbolic_factor.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cassert>
#include <mutex>
#include <string>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"

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

static_assert(sizeof(SuiteSparse_long) == sizeof(Index));

// Columns of a supernode: narrower ones waste less memory (half of their square), wider ones have
// longer products.
constexpr Index widest_supernode = 512;

// CHOLMOD's view of the lower triangle of A; nothing is copied and nothing is written through it.
cholmod_sparse lower_view(const SparseMatrix& A) {
  assert(A.isCompressed() && A.rows() == A.cols());
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(A.rows());
  view.ncol = static_cast<std::size_t>(A.cols());
  view.nzmax = static_cast<std::size_t>(A.nonZeros());
  view.p = const_cast<Index*>(A.outerIndexPtr());
  view.i = const_cast<Index*>(A.innerIndexPtr());
  view.x = const_cast<double*>(A.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_LONG;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 0;
  view.packed = 1;
  return view;
}

// CHOLMOD's analysis of A, and the memory of it.
class Analysis {
 public:
  explicit Analysis(bool supernodal) {
    cholmod_l_start(&common_);
    common_.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
    common_.print = 0;
    common_.error_handler = nullptr;
    // Nested dissection wins on solids, minimum degree on thin parts: both are tried, the sparser
    // factor is taken.
    common_.nmethods = 2;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.method[1].ordering = CHOLMOD_AMD;
    common_.postorder = true;
  }
  ~Analysis() {
    cholmod_l_free_factor(&L_, &common_);
    cholmod_l_finish(&common_);
  }
  Analysis(const Analysis&) = delete;
  Analysis& operator=(const Analysis&) = delete;

  void find_order(const SparseMatrix& A) {
    cholmod_sparse view = lower_view(A);
    // METIS seeds and draws the C library's random numbers. One ordering at a time keeps the factor
    // of a matrix independent of other threads.
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    L_ = cholmod_l_analyze(&view, &common_);
    check(A.rows());
  }

  void take_order(const SparseMatrix& A, std::vector<Index> order) {
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    common_.postorder = false;  // the nodes are, and `last` stays where it is
    cholmod_sparse view = lower_view(A);
    L_ = cholmod_l_analyze_p(&view, order.data(), nullptr, 0, &common_);
    check(A.rows());
  }

  std::vector<Index> order() const { return copy_of(L_->Perm, L_->n); }
  std::vector<Index> counts() const { return copy_of(L_->ColCount, L_->n); }

  SymbolicFactor factor(Index boundary) const {
    SymbolicFactor made;
    made.order = order();
    made.n_nonzeros = common_.lnz;
    made.flops = common_.fl;
    SupernodalFactor theirs;
    theirs.n = static_cast<Index>(L_->n);
    theirs.n_super = static_cast<Index>(L_->nsuper);
    theirs.super = static_cast<const Index*>(L_->super);
    theirs.pi = static_cast<const Index*>(L_->pi);
    theirs.rows = static_cast<const Index*>(L_->s);
    made.pattern = cut_supernodes(theirs, widest_supernode, boundary);
    return made;
  }

 private:
  static std::vector<Index> copy_of(const void* first, std::size_t n) {
    const auto* begin = static_cast<const Index*>(first);
    return {begin, begin + n};
  }

  void check(Index n) const {
    if (common_.status >= CHOLMOD_OK) return;
    if (common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE)
      fail_for_memory("ordering", n, 8 * common_.lnz);
    throw RunError("sparse ordering of " + std::to_string(n) + " dofs failed (CHOLMOD status " +
                   std::to_string(common_.status) + ")");
  }

  cholmod_common common_{};
  cholmod_factor* L_ = nullptr;
};

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

void fail_for_memory(const char* phase, Index n, double bytes) {
  throw RunError(
      format_text("not enough memory for the sparse %s of %lld dofs", phase,
                  static_cast<long long>(n)) +
      (bytes > 0 ? format_text(", whose factor takes %.2f GB", 1e-9 * bytes) : std::string()) +
      ": use a coarser mesh or a machine with more memory");
}

SupernodalFactor SymbolicFactor::view(const double* x) const {
  SupernodalFactor f;
  f.n = static_cast<Index>(order.size());
  f.n_super = static_cast<Index>(pattern.super.size()) - 1;
  f.super = pattern.super.data();
  f.pi = pattern.pi.data();
  f.px = pattern.px.data();
  f.rows = pattern.rows.data();
  f.order = order.data();
  f.x = x;
  return f;
}

SymbolicFactor symbolic_factor(const SparseMatrix& A, const std::vector<Index>& last,
                               std::vector<Index> nodes) {
  const Index dofs = dofs_per_node(A), n_leading = A.rows() - static_cast<Index>(last.size());
  Analysis analysis(true);
  if (dofs == 1 && last.empty()) {
    analysis.find_order(A);
    return analysis.factor(0);
  }
  if (n_leading > 0 && static_cast<Index>(nodes.size()) * dofs != n_leading)
    nodes = order_of_graph(node_graph(A, dofs, last)).order;
  analysis.take_order(A, order_of_rows(nodes, dofs, A.rows(), last));
  return analysis.factor(n_leading);
}

GraphOrder order_of_graph(const SparseMatrix& graph) {
  Analysis analysis(false);
  analysis.find_order(graph);
  return {analysis.order(), analysis.counts()};
}

SupernodePattern cut_supernodes(const SupernodalFactor& factor, Index widest, Index boundary) {
  SupernodePattern made{{0}, {0}, {0}, {}};
  for (Index s = 0; s < factor.n_super; ++s) {
    const Index columns = factor.columns(s), height = factor.height(s);
    const Index *rows = factor.rows + factor.pi[s], *end = rows + height;
    const auto cut = [&](Index begin, Index count) {
      const Index pieces = (count + widest - 1) / widest;
      for (Index piece = 0; piece < pieces; ++piece) {
        const Index first = begin + count * piece / pieces,
                    last = begin + count * (piece + 1) / pieces;
        made.rows.insert(made.rows.end(), rows + first, end);
        made.super.push_back(factor.first(s) + last);
        made.pi.push_back(static_cast<Index>(made.rows.size()));
        made.px.push_back(made.px.back() + (last - first) * (height - first));
      }
    };
    const Index before = std::clamp<Index>(boundary - factor.first(s), 0, columns);
    cut(0, before);
    cut(before, columns - before);
  }
  return made;
}

SupernodePattern leading_pattern(const SupernodalFactor& factor, Index n) {
  SupernodePattern made{{0}, {0}, {}, {}};
  for (Index s = 0; s < factor.n_super && factor.first(s) < n; ++s) {
    const Index *rows = factor.rows + factor.pi[s], *end = rows + factor.height(s);
    made.rows.insert(made.rows.end(), rows, std::lower_bound(rows, end, n));
    made.super.push_back(factor.super[s + 1]);
    made.pi.push_back(static_cast<Index>(made.rows.size()));
  }
  return made;
}

}  // namespace cbr
