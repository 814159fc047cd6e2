// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/cholmod_factor.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <mutex>
#include <string>

#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense_factor.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/sparse/cut_supernodes.hpp"
#include "common/linalg/sparse/elimination_order.hpp"
#include "common/linalg/sparse/supernodal_cholesky.hpp"

namespace cbr {
namespace {

static_assert(sizeof(SuiteSparse_long) == sizeof(Index));

// Columns of a supernode: narrower ones waste less memory (half of their square), wider ones have
// longer products.
constexpr Index widest_supernode = 512;
// A flop of a solve of many right-hand sides costs as much as this many of a front's products;
// share of L that it visits.
constexpr double solve_penalty = 1.5, visited = 0.8;

// Flops of a factorisation from which on it is done front by front on all threads.
constexpr double worth_fronts = 1e8;

std::string gigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f GB", 1e-9 * bytes);
  return text;
}

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

cholmod_dense dense_view(double* x, Index rows, Index columns, Index stride) {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(rows);
  view.ncol = static_cast<std::size_t>(columns);
  view.d = static_cast<std::size_t>(stride);
  view.nzmax = view.d * view.ncol;
  view.x = x;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

// For single right-hand sides: a common block and workspaces that are kept.
struct Solver {
  cholmod_common common{};
  cholmod_dense *Y = nullptr, *E = nullptr;

  Solver() {
    cholmod_l_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
  }
  ~Solver() {
    cholmod_l_free_dense(&Y, &common);
    cholmod_l_free_dense(&E, &common);
    cholmod_l_finish(&common);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  // X and B may share their memory: CHOLMOD permutes B to its own workspace first. False when
  // memory ran out.
  bool solve(cholmod_factor* L, double* b, Index stride, double* x, Index rows, Index columns) {
    cholmod_dense B = dense_view(b, rows, columns, stride), X = dense_view(x, rows, columns, rows);
    cholmod_dense* X_handle = &X;
    return cholmod_l_solve2(CHOLMOD_A, L, &B, nullptr, &X_handle, nullptr, &Y, &E, &common) != 0;
  }
};

}  // namespace

// The factor and its common block, freed together.
struct CholmodFactor::Handles {
  cholmod_common common{};
  cholmod_factor* L = nullptr;
  Solver single;
};

bool has_both_triangles(const SparseMatrix& A) {
  Index balance = 0;
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      balance += it.row() > j ? 1 : it.row() < j ? -1 : 0;
  return balance == 0;
}

void fail_to_solve(Index rows, Index columns) {
  throw RunError("not enough memory to solve for " + std::to_string(columns) +
                 " right-hand sides of " + std::to_string(rows) + " dofs (" +
                 gigabytes(16.0 * static_cast<double>(rows * columns)) + " of workspace)");
}

CholmodFactor::CholmodFactor(Kind kind) : h_(std::make_unique<Handles>()) {
  cholmod_common& common = h_->common;
  const bool is_supernodal = kind == Kind::supernodal;
  cholmod_l_start(&common);
  common.supernodal = is_supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  common.final_ll = is_supernodal;
  common.quick_return_if_not_posdef = true;
  common.print = 0;
  common.error_handler = nullptr;
  // Nested dissection wins on solids, minimum degree on thin parts: both are tried, the sparser
  // factor is taken.
  common.nmethods = 2;
  common.method[0].ordering = CHOLMOD_METIS;
  common.method[1].ordering = CHOLMOD_AMD;
  common.postorder = true;
}

CholmodFactor::~CholmodFactor() {
  cholmod_l_free_factor(&h_->L, &h_->common);
  cholmod_l_finish(&h_->common);
}

Index CholmodFactor::n() const { return static_cast<Index>(h_->L->n); }
Index CholmodFactor::n_done() const { return static_cast<Index>(h_->L->minor); }
double CholmodFactor::n_nonzeros() const { return h_->common.lnz; }
double CholmodFactor::flops() const { return h_->common.fl; }
double CholmodFactor::bytes() const { return 8 * static_cast<double>(h_->L->xsize); }

const Index* CholmodFactor::column_counts() const {
  return static_cast<const Index*>(h_->L->ColCount);
}

void CholmodFactor::solve(const double* b, double* x) {
  if (!h_->single.solve(h_->L, const_cast<double*>(b), n(), x, n(), 1)) fail_to_solve(n(), 1);
}

void CholmodFactor::analyze(const SparseMatrix& A, const std::vector<Index>& last,
                            std::vector<Index> nodes) {
  const Index dofs = dofs_per_node(A), n_leading = A.rows() - static_cast<Index>(last.size());
  if (h_->common.supernodal == CHOLMOD_SIMPLICIAL || (dofs == 1 && last.empty()))
    return analyze_rows(A);
  if (n_leading > 0 && static_cast<Index>(nodes.size()) * dofs != n_leading) {
    CholmodFactor graph(Kind::simplicial);
    graph.analyze_rows(node_graph(A, dofs, last));
    nodes.assign(graph.permutation(), graph.permutation() + graph.h_->L->n);
  }
  std::vector<Index> order = order_of_rows(nodes, dofs, A.rows(), last);
  h_->common.nmethods = 1;
  h_->common.method[0].ordering = CHOLMOD_GIVEN;
  h_->common.postorder = false;  // the nodes are, and `last` stays where it is
  cholmod_sparse view = lower_view(A);
  h_->L = cholmod_l_analyze_p(&view, order.data(), nullptr, 0, &h_->common);
  check("ordering", A);
  if (h_->L->is_super != 0 && !cut(widest_supernode, n_leading)) check("ordering", A);
}

void CholmodFactor::analyze_rows(const SparseMatrix& A) {
  cholmod_sparse view = lower_view(A);
  // METIS seeds and draws the C library's random numbers. One ordering at a time keeps the factor
  // of a matrix independent of other threads.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  h_->L = cholmod_l_analyze(&view, &h_->common);
  check("ordering", A);
  if (h_->L->is_super != 0 && !cut(widest_supernode, 0)) check("ordering", A);
}

// Replaces CHOLMOD's supernodes by narrower ones. False when memory ran out.
bool CholmodFactor::cut(Index widest, Index boundary) {
  cholmod_factor& L = *h_->L;
  const SupernodePattern made = cut_supernodes(view(), widest, boundary);
  const auto replace = [&](void*& old, std::size_t old_size, const std::vector<Index>& with) {
    void* copy = cholmod_l_malloc(with.size(), sizeof(Index), &h_->common);
    if (copy == nullptr) return false;
    std::copy(with.begin(), with.end(), static_cast<Index*>(copy));
    cholmod_l_free(old_size, sizeof(Index), old, &h_->common);
    old = copy;
    return true;
  };
  const std::size_t old = L.nsuper + 1;
  if (!replace(L.s, L.ssize, made.rows) || !replace(L.super, old, made.super)) return false;
  if (!replace(L.pi, old, made.pi) || !replace(L.px, old, made.px)) return false;
  L.nsuper = made.super.size() - 1;
  L.ssize = made.rows.size();
  L.xsize = static_cast<std::size_t>(made.px.back());
  const SupernodeWorkspace workspace = find_workspace(view());
  L.maxcsize = static_cast<std::size_t>(workspace.largest_update);
  L.maxesize = static_cast<std::size_t>(workspace.most_rows_below);
  return true;
}

void CholmodFactor::factorize(const SparseMatrix& A, const std::vector<Index>& last,
                              const Progress& progress, const std::vector<Index>& nodes) {
  analyze(A, last, nodes);
  if (h_->L->is_super != 0 && h_->common.fl > worth_fronts && factorize_by_fronts(A, progress))
    return;
  // Also where it is not positive definite: CHOLMOD reports the first column that fails
  cholmod_sparse view = lower_view(A);
  const BlasForWork blas(h_->common.fl);
  cholmod_l_factorize(&view, h_->L, &h_->common);
  check("factorisation", A);
}

// For the numbers of L, which nothing has written yet.
void CholmodFactor::make_room(const SparseMatrix& A) {
  if (cholmod_l_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, h_->L, &h_->common) == 0)
    check("factorisation", A);
  prefer_huge_pages(h_->L->x, 8 * static_cast<double>(h_->L->xsize));
}

// On all threads, subtree by subtree, where its fronts fit the machine beside the factor. False:
// not done.
bool CholmodFactor::factorize_by_fronts(const SparseMatrix& A, const Progress& progress) {
  const SupernodeTree tree(view());
  const double entries = static_cast<double>(h_->L->xsize) + 2 * static_cast<double>(A.nonZeros());
  if (!has_both_triangles(A) || 8 * entries + front_bytes(tree) > 0.9 * machine_memory_bytes())
    return false;
  make_room(A);
  return factor_supernodes(tree, {A}, static_cast<double*>(h_->L->x), progress) == Factored::done;
}

bool CholmodFactor::condense(const SparseMatrix& K, const SparseMatrix& M,
                             const std::vector<Index>& last, Condensed& condensed, bool always,
                             const Progress& progress) {
  analyze(K, last);
  if (h_->L->is_super == 0 || (h_->common.fl < worth_fronts && !always)) return false;
  const SupernodeTree tree(view());
  const Index c = static_cast<Index>(last.size()), n_I = K.rows() - c;
  if (!is_cheaper(n_I, condensed.flops) && !always) return false;
  const double square = 8 * static_cast<double>(c) * static_cast<double>(c);
  const double entries = static_cast<double>(h_->L->xsize) + 4 * static_cast<double>(K.nonZeros());
  if (8 * entries + 2 * (front_bytes(tree) + square) > 0.9 * machine_memory_bytes()) return false;
  make_room(K);
  if (factor_and_condense(tree, n_I, K, M, static_cast<double*>(h_->L->x), condensed.K, condensed.M,
                          progress) != Factored::done)
    return false;
  mirror_lower(condensed.K);
  mirror_lower(condensed.M);
  return true;
}

// True when elimination of K and M with `last` in its rows is faster than the factor of K_II alone
// and the constraint modes. Those cost two solves each, or one and the product of all.
bool CholmodFactor::is_cheaper(Index n_I, double& more_flops) const {
  const SupernodalFactor f = view();
  const auto c = static_cast<double>(f.n - n_I);
  double own = 0, with_last = 0, n_nonzeros = 0;
  for (Index s = 0; s < f.n_super && f.first(s) < n_I; ++s) {
    const Index *rows = f.rows + f.pi[s], *end = rows + f.height(s);
    const auto columns = static_cast<double>(f.columns(s)),
               below = static_cast<double>(f.height(s)) - columns,
               inside = static_cast<double>(std::lower_bound(rows, end, n_I) - rows) - columns;
    own += columns * (columns * columns / 3 + columns * inside + inside * inside);
    with_last += columns * (columns * columns / 3 + columns * below + below * below) +
                 condensing_flops(columns, below);
    n_nonzeros += columns * (columns / 2 + inside);
  }
  more_flops = with_last - own;
  const double solves = solve_penalty * visited * 4 * n_nonzeros * c;
  return more_flops < solves + std::min(solves, static_cast<double>(n_I) * c * c);
}

void CholmodFactor::check(const char* phase, const SparseMatrix& A) const {
  // not positive definite is a warning to CHOLMOD, and a result to us
  if (h_->common.status >= CHOLMOD_OK) return;
  const std::string size = std::to_string(A.rows()) + " dofs";
  if (h_->common.status == CHOLMOD_OUT_OF_MEMORY || h_->common.status == CHOLMOD_TOO_LARGE) {
    throw RunError(
        "not enough memory for the sparse " + std::string(phase) + " of " + size +
        (h_->common.lnz > 0 ? ", whose factor takes " + gigabytes(8 * h_->common.lnz) : "") +
        ": use a coarser mesh or a machine with more memory");
  }
  throw RunError("sparse " + std::string(phase) + " of " + size + " failed (CHOLMOD status " +
                 std::to_string(h_->common.status) + ")");
}

SupernodalFactor CholmodFactor::view() const {
  const cholmod_factor& L = *h_->L;
  SupernodalFactor f;
  f.n = static_cast<Index>(L.n);
  f.n_super = static_cast<Index>(L.nsuper);
  f.super = static_cast<const Index*>(L.super);
  f.pi = static_cast<const Index*>(L.pi);
  f.px = static_cast<const Index*>(L.px);
  f.rows = static_cast<const Index*>(L.s);
  f.order = permutation();
  f.x = static_cast<const double*>(L.x);
  return f;
}

const Index* CholmodFactor::permutation() const { return static_cast<const Index*>(h_->L->Perm); }

}  // namespace cbr
