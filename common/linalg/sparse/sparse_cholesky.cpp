// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/sparse_cholesky.hpp"

#include <cholmod.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <new>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/base/parallel.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense_factor.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/narrow_product.hpp"
#include "common/linalg/sparse/cut_supernodes.hpp"
#include "common/linalg/sparse/elimination_order.hpp"
#include "common/linalg/sparse/shared_solve.hpp"
#include "common/linalg/sparse/supernodal_cholesky.hpp"
#include "common/linalg/sparse/supernodal_inertia.hpp"

namespace cbr {
namespace {

static_assert(sizeof(SuiteSparse_long) == sizeof(Index));

// Enough columns for BLAS to run near its own speed, few enough that a panel (block x n) stays
// small beside the factor.
constexpr Index solve_block = 128;
// Fewer columns than this are not worth a thread.
constexpr Index least_block = 8;
// Columns of a supernode: narrower ones waste less memory (half of their square), wider ones have
// longer products.
constexpr Index widest_supernode = 512;
constexpr double vanishing_pivot = 1e-13;
// Non-zeros of a factor from which on threads share the solution of a few right-hand sides.
constexpr double worth_sharing = 1e6;

// A flop of a solve of many right-hand sides costs as much as this many of a front's products;
// share of L that it visits.
constexpr double solve_penalty = 1.5, visited = 0.8;

// Flops of a factorisation from which on it is done front by front on all threads.
constexpr double worth_fronts = 1e8;

bool has_both_triangles(const SparseMatrix& A) {
  Index balance = 0;
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      balance += it.row() > j ? 1 : it.row() < j ? -1 : 0;
  return balance == 0;
}

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

[[noreturn]] void fail_to_solve(Index rows, Index columns) {
  throw RunError("not enough memory to solve for " + std::to_string(columns) +
                 " right-hand sides of " + std::to_string(rows) + " dofs (" +
                 gigabytes(16.0 * static_cast<double>(rows * columns)) + " of workspace)");
}

// The factor and its common block, freed together.
struct Cholmod {
  cholmod_common common{};
  cholmod_factor* L = nullptr;

  explicit Cholmod(int supernodal) {
    cholmod_l_start(&common);
    common.supernodal = supernodal;
    common.final_ll = supernodal == CHOLMOD_SUPERNODAL;
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
  ~Cholmod() {
    cholmod_l_free_factor(&L, &common);
    cholmod_l_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  // The order of elimination that costs least on the graph of nodes (or of rows), and what follows
  // from it for A.
  void analyze(const SparseMatrix& A, const std::vector<Index>& last = {},
               std::vector<Index> nodes = {}) {
    const Index dofs = dofs_per_node(A), n_leading = A.rows() - static_cast<Index>(last.size());
    if (common.supernodal == CHOLMOD_SIMPLICIAL || (dofs == 1 && last.empty()))
      return analyze_rows(A);
    if (n_leading > 0 && static_cast<Index>(nodes.size()) * dofs != n_leading) {
      Cholmod graph(CHOLMOD_SIMPLICIAL);
      graph.analyze_rows(node_graph(A, dofs, last));
      nodes.assign(graph.permutation(), graph.permutation() + graph.L->n);
    }
    std::vector<Index> order = order_of_rows(nodes, dofs, A.rows(), last);
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = false;  // the nodes are, and `last` stays where it is
    cholmod_sparse view = lower_view(A);
    L = cholmod_l_analyze_p(&view, order.data(), nullptr, 0, &common);
    check("ordering", A);
    if (L->is_super != 0 && !cut(widest_supernode, n_leading)) check("ordering", A);
  }

  void analyze_rows(const SparseMatrix& A) {
    cholmod_sparse view = lower_view(A);
    // METIS draws from the C library's random numbers, which it seeds itself: one ordering at a
    // time, so that the same matrix gives the same factor whatever other threads do.
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    L = cholmod_l_analyze(&view, &common);
    check("ordering", A);
    if (L->is_super != 0 && !cut(widest_supernode, 0)) check("ordering", A);
  }

  // Replaces CHOLMOD's supernodes by narrower ones. False when memory ran out.
  bool cut(Index widest, Index boundary) {
    const SupernodePattern made = cut_supernodes(view(), widest, boundary);
    const auto replace = [&](void*& old, std::size_t old_size, const std::vector<Index>& with) {
      void* copy = cholmod_l_malloc(with.size(), sizeof(Index), &common);
      if (copy == nullptr) return false;
      std::copy(with.begin(), with.end(), static_cast<Index*>(copy));
      cholmod_l_free(old_size, sizeof(Index), old, &common);
      old = copy;
      return true;
    };
    const std::size_t old = L->nsuper + 1;
    if (!replace(L->s, L->ssize, made.rows) || !replace(L->super, old, made.super)) return false;
    if (!replace(L->pi, old, made.pi) || !replace(L->px, old, made.px)) return false;
    L->nsuper = made.super.size() - 1;
    L->ssize = made.rows.size();
    L->xsize = static_cast<std::size_t>(made.px.back());
    const SupernodeWorkspace workspace = find_workspace(view());
    L->maxcsize = static_cast<std::size_t>(workspace.largest_update);
    L->maxesize = static_cast<std::size_t>(workspace.most_rows_below);
    return true;
  }

  void factorize(const SparseMatrix& A, const std::vector<Index>& last, const Progress& progress,
                 const std::vector<Index>& nodes) {
    analyze(A, last, nodes);
    if (L->is_super != 0 && common.fl > worth_fronts && factorize_by_fronts(A, progress)) return;
    // Also where it is not positive definite: CHOLMOD tells the first column that fails
    cholmod_sparse view = lower_view(A);
    const BlasForWork blas(common.fl);
    cholmod_l_factorize(&view, L, &common);
    check("factorisation", A);
  }

  // For the numbers of L, which nothing has written yet.
  void make_room(const SparseMatrix& A) {
    if (cholmod_l_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, L, &common) == 0)
      check("factorisation", A);
    prefer_huge_pages(L->x, 8 * static_cast<double>(L->xsize));
  }

  // On all threads, subtree by subtree, where its fronts fit the machine beside the factor. False:
  // not done.
  bool factorize_by_fronts(const SparseMatrix& A, const Progress& progress) {
    const SupernodeTree tree(view());
    const double entries = static_cast<double>(L->xsize) + 2 * static_cast<double>(A.nonZeros());
    if (!has_both_triangles(A) || 8 * entries + front_bytes(tree) > 0.9 * machine_memory_bytes())
      return false;
    make_room(A);
    return factor_supernodes(tree, {A}, static_cast<double*>(L->x), progress) == Factored::done;
  }

  // The columns before `last`, and K and M condensed to `last`. False: not done, for one of the
  // reasons of condensing().
  bool condense(const SparseMatrix& K, const SparseMatrix& M, const std::vector<Index>& last,
                Condensed& condensed, bool always, const Progress& progress) {
    analyze(K, last);
    if (L->is_super == 0 || (common.fl < worth_fronts && !always)) return false;
    const SupernodeTree tree(view());
    const Index c = static_cast<Index>(last.size()), n_I = K.rows() - c;
    if (!is_cheaper(n_I, condensed.flops) && !always) return false;
    const double square = 8 * static_cast<double>(c) * static_cast<double>(c);
    const double entries = static_cast<double>(L->xsize) + 4 * static_cast<double>(K.nonZeros());
    if (8 * entries + 2 * (front_bytes(tree) + square) > 0.9 * machine_memory_bytes()) return false;
    make_room(K);
    if (factor_and_condense(tree, n_I, K, M, static_cast<double*>(L->x), condensed.K, condensed.M,
                            progress) != Factored::done)
      return false;
    mirror_lower(condensed.K);
    mirror_lower(condensed.M);
    return true;
  }

  // Whether elimination with `last` in its rows, of K and M, takes less time than the factor of
  // K_II alone and two solves of each constraint mode, or one and the product of all.
  bool is_cheaper(Index n_I, double& more_flops) const {
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

  void check(const char* phase, const SparseMatrix& A) const {
    // not positive definite is a warning to CHOLMOD, and a result to us
    if (common.status >= CHOLMOD_OK) return;
    const std::string size = std::to_string(A.rows()) + " dofs";
    if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE) {
      throw RunError("not enough memory for the sparse " + std::string(phase) + " of " + size +
                     (common.lnz > 0 ? ", whose factor takes " + gigabytes(8 * common.lnz) : "") +
                     ": use a coarser mesh or a machine with more memory");
    }
    throw RunError("sparse " + std::string(phase) + " of " + size + " failed (CHOLMOD status " +
                   std::to_string(common.status) + ")");
  }

  SupernodalFactor view() const {
    SupernodalFactor f;
    f.n = static_cast<Index>(L->n);
    f.n_super = static_cast<Index>(L->nsuper);
    f.super = static_cast<const Index*>(L->super);
    f.pi = static_cast<const Index*>(L->pi);
    f.px = static_cast<const Index*>(L->px);
    f.rows = static_cast<const Index*>(L->s);
    f.order = permutation();
    f.x = static_cast<const double*>(L->x);
    return f;
  }

  const Index* permutation() const { return static_cast<const Index*>(L->Perm); }
};

}  // namespace

struct SparseCholesky::Impl {
  // a leading factor shares it
  std::shared_ptr<Cholmod> cholmod = std::make_shared<Cholmod>(CHOLMOD_SUPERNODAL);
  // for one right-hand side after another
  Solver single;
  // for a few at a time; made when first wanted
  std::unique_ptr<SharedSolve> shared;
  SupernodeTree tree;
  SupernodalFactor factor;
  SupernodePattern leading;  // of a leading factor, to which `factor` points
  std::vector<Index> order, last;
  Vector diagonal;  // of A
  Index n = 0, failed = -1, weakest = -1;
  double smallest_pivot = 1, least = 1, largest = 1, n_nonzeros = 0, flops = 0;
  bool is_whole = true;

  // The diagonal of L in the order of elimination stands at the head of each supernode's columns.
  void examine_pivots() {
    least = HUGE_VAL, largest = 0;
    for (Index s = 0; s < factor.n_super; ++s) {
      for (Index j = 0; j < factor.columns(s); ++j) {
        const Index column = factor.order[factor.first(s) + j];
        const double pivot = factor.x[factor.px[s] + j * (factor.stride(s) + 1)];
        least = std::min(least, pivot), largest = std::max(largest, pivot);
        const double ratio = pivot * pivot / diagonal(column);
        if (weakest >= 0 && ratio >= smallest_pivot) continue;
        smallest_pivot = ratio;
        weakest = column;
      }
    }
  }

  void fail_at(Index column) {
    failed = weakest = column;
    smallest_pivot = 0;
  }

  void finish() {
    examine_pivots();
    tree = SupernodeTree(factor);
  }

  // Of the rectangles of the leading factor's supernodes.
  void count() {
    for (Index s = 0; s < factor.n_super; ++s) {
      for (Index j = 0; j < factor.columns(s); ++j) {
        const auto rows = static_cast<double>(factor.height(s) - j);
        n_nonzeros += rows;
        flops += rows * rows;
      }
    }
  }
};

SparseCholesky::SparseCholesky(const SparseMatrix& A, const std::vector<Index>& last,
                               const Progress& progress, const std::vector<Index>& nodes)
    : impl_(std::make_unique<Impl>()) {
  impl_->n = A.rows();
  if (A.rows() == 0) return;
  if (!A.isCompressed()) {
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    *this = SparseCholesky(compressed, last, progress, nodes);
    return;
  }
  Cholmod& cholmod = *impl_->cholmod;
  cholmod.factorize(A, last, progress, nodes);
  impl_->diagonal = A.diagonal();
  impl_->last = last;
  impl_->factor = cholmod.view();
  impl_->n_nonzeros = cholmod.common.lnz;
  impl_->flops = cholmod.common.fl;
  const auto* L = cholmod.L;
  if (L->minor < L->n) {
    impl_->fail_at(cholmod.permutation()[L->minor]);
  } else {
    impl_->finish();
  }
}

SparseCholesky SparseCholesky::leading() const {
  SparseCholesky made(SparseMatrix(0, 0));
  Impl& own = *made.impl_;
  const auto& last = impl_->last;
  own.n = impl_->n - static_cast<Index>(last.size());
  if (own.n == 0) return made;
  own.cholmod = impl_->cholmod;
  own.is_whole = false;
  own.leading = leading_pattern(impl_->factor, own.n);
  // of A's rows in the leading matrix
  std::vector<Index> number(static_cast<std::size_t>(impl_->n), 0);
  for (const Index row : last) number[static_cast<std::size_t>(row)] = -1;
  own.diagonal.resize(own.n);
  Index count = 0;
  for (Index row = 0; row < impl_->n; ++row) {
    if (number[static_cast<std::size_t>(row)] < 0) continue;
    own.diagonal(count) = impl_->diagonal(row);
    number[static_cast<std::size_t>(row)] = count++;
  }
  const Index* order = impl_->factor.order;
  for (Index i = 0; i < own.n; ++i) own.order.push_back(number[static_cast<std::size_t>(order[i])]);
  own.factor = impl_->factor;
  own.factor.n = own.n;
  own.factor.n_super = static_cast<Index>(own.leading.super.size()) - 1;
  own.factor.super = own.leading.super.data();
  own.factor.pi = own.leading.pi.data();
  own.factor.rows = own.leading.rows.data();
  own.factor.order = own.order.data();
  own.count();
  const auto minor = static_cast<Index>(impl_->cholmod->L->minor);
  if (minor < own.n) {
    own.fail_at(own.order[static_cast<std::size_t>(minor)]);
  } else {
    own.finish();
  }
  return made;
}

std::optional<SparseCholesky> SparseCholesky::condensing(const SparseMatrix& K,
                                                         const SparseMatrix& M,
                                                         const std::vector<Index>& last,
                                                         Condensed& condensed, bool always,
                                                         const Progress& progress) {
  assert(K.isCompressed() && M.isCompressed());
  if (last.empty() || static_cast<Index>(last.size()) == K.rows() || !has_both_triangles(K))
    return {};
  SparseCholesky whole{SparseMatrix(0, 0)};
  Impl& impl = *whole.impl_;
  if (!impl.cholmod->condense(K, M, last, condensed, always, progress)) return {};
  impl.n = K.rows();
  impl.diagonal = K.diagonal();
  impl.last = last;
  impl.factor = impl.cholmod->view();
  return whole.leading();
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

bool SparseCholesky::ok() const { return impl_->failed < 0; }
Index SparseCholesky::failed_column() const { return impl_->failed; }
double SparseCholesky::smallest_pivot() const { return impl_->smallest_pivot; }
Index SparseCholesky::weakest_column() const { return impl_->weakest; }
Index SparseCholesky::n_rows() const { return impl_->n; }
double SparseCholesky::bytes() const {
  return impl_->n == 0 ? 0 : 8 * static_cast<double>(impl_->cholmod->L->xsize);
}
double SparseCholesky::n_nonzeros() const { return impl_->n_nonzeros; }
double SparseCholesky::flops() const { return impl_->flops; }

double SparseCholesky::reciprocal_condition() const {
  if (impl_->n == 0) return 1;
  const double ratio = impl_->least / impl_->largest;
  return ok() ? ratio * ratio : 0;
}

void SparseCholesky::solve_in_place(Eigen::Ref<Matrix> B) const {
  assert(ok() && B.rows() == n_rows());
  if (n_rows() == 0 || B.cols() == 0) return;
  if (B.cols() == 1 && impl_->is_whole) return solve(B.data(), B.data());
  if (B.cols() <= narrow::width && n_threads() > 1 && n_nonzeros() > worth_sharing) {
    if (!impl_->shared) impl_->shared = std::make_unique<SharedSolve>(tree(), n_threads());
    return (*impl_->shared)(B);
  }
  // The supernodes are too small for BLAS's own threads: each of ours takes panels of right-hand
  // sides instead.
  const Index wanted = std::max<Index>(1, std::min<Index>(n_threads(), B.cols() / least_block));
  const Index rounds = (B.cols() + wanted * solve_block - 1) / (wanted * solve_block);
  const Index block = (B.cols() + rounds * wanted - 1) / (rounds * wanted);
  const Index n_blocks = (B.cols() + block - 1) / block;
  std::atomic<Index> next{0};
  const auto work = [&](int) {
    // A few columns are filled up to the panels that go without BLAS
    const Index width = std::max(block, narrow::width);
    PanelSolver solver(tree(), width);
    Matrix X_t;
    for (Index i = next++; i < n_blocks; i = next++) {
      const Index first = i * block, columns = std::min(block, B.cols() - first);
      const Index rows = std::max(columns, narrow::width);
      if (rows != X_t.rows()) X_t.setZero(rows, n_rows());
      load_panel(tree().factor(), B.middleCols(first, columns), X_t.topRows(columns));
      solver.forward(X_t, tree().all());
      solver.backward(X_t, tree().all());
      store_panel(tree().factor(), X_t.topRows(columns), B.middleCols(first, columns));
    }
  };
  try {
    const SingleThreadedBlas blas;
    run_threads(static_cast<int>(wanted), work);
  } catch (const std::bad_alloc&) {
    fail_to_solve(n_rows(), block);
  }
}

const SupernodeTree& SparseCholesky::tree() const { return impl_->tree; }

Matrix SparseCholesky::solve(const Matrix& B) const {
  Matrix X = B;
  solve_in_place(X);
  return X;
}

void SparseCholesky::solve(const double* b, double* x) const {
  assert(ok());
  if (n_rows() == 0) return;
  if (!impl_->is_whole) {
    if (x != b) std::copy_n(b, n_rows(), x);
    return solve_in_place(Eigen::Map<Matrix>(x, n_rows(), 1));
  }
  if (!impl_->single.solve(impl_->cholmod->L, const_cast<double*>(b), n_rows(), x, n_rows(), 1))
    fail_to_solve(n_rows(), 1);
}

SparseMatrix SparseCholesky::solve(const SparseMatrix& B) const {
  assert(ok() && B.rows() == n_rows());
  std::vector<Index> used;
  for (Index j = 0; j < B.cols(); ++j) {
    if (SparseMatrix::InnerIterator(B, j)) used.push_back(j);
  }
  SparseMatrix X(B.rows(), B.cols());
  std::vector<Eigen::Triplet<double, Index>> entries;
  Matrix block;
  for (std::size_t first = 0; first < used.size(); first += solve_block) {
    const Index columns = std::min<Index>(solve_block, static_cast<Index>(used.size() - first));
    block.setZero(B.rows(), columns);
    for (Index j = 0; j < columns; ++j) {
      for (SparseMatrix::InnerIterator it(B, used[first + j]); it; ++it)
        block(it.row(), j) = it.value();
    }
    solve_in_place(block);
    for (Index j = 0; j < columns; ++j) {
      for (Index i = 0; i < block.rows(); ++i) {
        if (block(i, j) != 0) entries.emplace_back(i, used[first + j], block(i, j));
      }
    }
  }
  X.setFromTriplets(entries.begin(), entries.end());
  return X;
}

FactorCost factor_cost(const SparseMatrix& nodes, Index dofs) {
  FactorCost cost;
  if (nodes.rows() == 0) return cost;
  assert(nodes.isCompressed());
  Cholmod cholmod(CHOLMOD_SIMPLICIAL);
  cholmod.analyze(nodes);
  const auto* count = static_cast<const Index*>(cholmod.L->ColCount);
  cost.order.assign(cholmod.permutation(), cholmod.permutation() + cholmod.L->n);
  for (std::size_t j = 0; j < cholmod.L->n; ++j) {
    for (Index i = 0; i < dofs; ++i) {
      const auto rows = static_cast<double>(dofs * count[j] - i);
      cost.n_nonzeros += rows;
      cost.flops += rows * rows;
    }
  }
  return cost;
}

Index negative_inertia(const SparseMatrix& A, const SparseCholesky* like) {
  if (A.rows() == 0) return 0;
  if (!A.isCompressed()) {
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    return negative_inertia(compressed, like);
  }
  if (like != nullptr && like->ok()) {
    const auto count = count_negative_pivots(like->tree(), {A}, vanishing_pivot);
    if (count) return *count;
  }
  Cholmod cholmod(CHOLMOD_SUPERNODAL);
  cholmod.analyze(A);
  const auto count = count_negative_pivots(SupernodeTree(cholmod.view()), {A}, vanishing_pivot);
  assert(count);
  return *count;
}

Index negative_inertia(const SparseMatrix& K, double sigma, const SparseMatrix& M,
                       const SparseCholesky& like) {
  if (K.rows() == 0) return 0;
  if (like.ok()) {
    const auto count = count_negative_pivots(like.tree(), {K, sigma, &M}, vanishing_pivot);
    if (count) return *count;
  }
  return negative_inertia(SparseMatrix(K - sigma * M));
}

}  // namespace cbr
