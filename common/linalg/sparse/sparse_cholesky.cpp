// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/sparse_cholesky.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <new>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/process.hpp"
#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/kernels/narrow_product.hpp"
#include "common/linalg/sparse/fronts.hpp"
#include "common/linalg/sparse/shared_solve.hpp"
#include "common/linalg/sparse/symbolic_factor.hpp"

namespace cbr {
namespace {

// Enough columns for BLAS to run near its own speed, few enough that a panel (block x n) stays
// small beside the factor.
constexpr Index solve_block = 128;
// Fewer columns than this are not worth a thread.
constexpr Index least_block = 8;
constexpr double vanishing_pivot = 1e-13;
// Non-zeros of a factor from which on threads share the solution of a few right-hand sides.
constexpr double worth_sharing = 1e6;
// A flop of a solve of many right-hand sides costs as much as this many of a front's products;
// share of L that it visits.
constexpr double solve_penalty = 1.5, visited = 0.8;
// Flops of a factorisation from which on it condenses, too.
constexpr double worth_condensing = 1e8;

bool has_both_triangles(const SparseMatrix& A) {
  Index balance = 0;
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      balance += it.row() > j ? 1 : it.row() < j ? -1 : 0;
  return balance == 0;
}

// True when elimination of K and M with `last` in its rows is faster than the factor of K_II alone
// and the constraint modes. Those cost two solves each, or one and the product of all.
bool is_cheaper(const SupernodalFactor& f, Index n_I, double& more_flops) {
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

// Numbers of L, which leading factors share.
struct Numbers {
  SymbolicFactor symbolic;
  Matrix x;          // a column
  Index n_done = 0;  // columns before the first pivot that is not positive

  SupernodalFactor view() const { return symbolic.view(x.data()); }
  void make_room() { x = on_huge_pages(symbolic.pattern.px.back(), 1); }
};

// B <- A^-1 B by one thread; X_t is its workspace.
void solve_panel(PanelSolver& solver, const SupernodeTree& tree, Matrix& X_t,
                 Eigen::Ref<Matrix> B) {
  const Index rows = std::max(B.cols(), narrow::width);
  if (rows != X_t.rows()) X_t.setZero(rows, B.rows());
  load_panel(tree.factor(), B, X_t.topRows(B.cols()));
  solver.forward(X_t, tree.all());
  solver.backward(X_t, tree.all());
  store_panel(tree.factor(), X_t.topRows(B.cols()), B);
}

}  // namespace

struct SparseCholesky::Impl {
  std::shared_ptr<Numbers> numbers = std::make_shared<Numbers>();
  // for a few at a time, on several threads or one; made when first wanted
  std::unique_ptr<SharedSolve> shared;
  std::unique_ptr<PanelSolver> one;
  Matrix panel;
  SupernodeTree tree;
  SupernodalFactor factor;
  SupernodePattern leading;  // of a leading factor, to which `factor` points
  std::vector<Index> order, last;
  Vector diagonal;  // of A
  Index n = 0, weakest = -1;
  double smallest_pivot = 1, n_nonzeros = 0, flops = 0;
  bool is_definite = true;

  // The diagonal of L in the order of elimination stands at the head of each supernode's columns.
  void examine_pivots() {
    for (Index s = 0; s < factor.n_super; ++s) {
      for (Index j = 0; j < factor.columns(s); ++j) {
        const Index column = factor.order[factor.first(s) + j];
        const double pivot = factor.x[factor.px[s] + j * (factor.stride(s) + 1)];
        const double ratio = pivot * pivot / diagonal(column);
        if (weakest >= 0 && ratio >= smallest_pivot) continue;
        smallest_pivot = ratio;
        weakest = column;
      }
    }
  }

  void fail_at(Index column) {
    is_definite = false;
    weakest = column;
    smallest_pivot = 0;
  }

  void finish() {
    examine_pivots();
    tree = SupernodeTree(factor);
  }

  void solve_few(Eigen::Ref<Matrix> B) {
    if (n_threads() > 1 && n_nonzeros > worth_sharing) {
      if (!shared) shared = std::make_unique<SharedSolve>(tree, n_threads());
      return (*shared)(B);
    }
    const SingleThreadedBlas blas;
    if (!one) one = std::make_unique<PanelSolver>(tree, narrow::width);
    solve_panel(*one, tree, panel, B);
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
  if (!has_both_triangles(A)) {
    *this = SparseCholesky(SparseMatrix(A.selfadjointView<Eigen::Lower>()), last, progress, nodes);
    return;
  }
  Numbers& numbers = *impl_->numbers;
  numbers.symbolic = symbolic_factor(A, last, nodes);
  impl_->n_nonzeros = numbers.symbolic.n_nonzeros;
  impl_->flops = numbers.symbolic.flops;
  const SupernodeTree pattern(numbers.symbolic.view());
  const double bytes = numbers.symbolic.bytes();
  if (bytes + front_bytes(pattern) > machine_memory_bytes())
    fail_for_memory("factorisation", impl_->n, bytes);
  try {
    numbers.make_room();
    numbers.n_done = factor_supernodes(pattern, A, impl_->n - static_cast<Index>(last.size()),
                                       numbers.x.data(), progress);
  } catch (const std::bad_alloc&) {
    fail_for_memory("factorisation", impl_->n, bytes);
  }
  impl_->diagonal = A.diagonal();
  impl_->last = last;
  impl_->factor = numbers.view();
  if (numbers.n_done < impl_->n) {
    impl_->fail_at(numbers.symbolic.order[numbers.n_done]);
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
  own.numbers = impl_->numbers;
  own.leading = leading_pattern(impl_->factor, own.n);
  // of A's rows in the leading matrix
  std::vector<Index> number(impl_->n, 0);
  for (const Index row : last) number[row] = -1;
  own.diagonal.resize(own.n);
  Index count = 0;
  for (Index row = 0; row < impl_->n; ++row) {
    if (number[row] < 0) continue;
    own.diagonal(count) = impl_->diagonal(row);
    number[row] = count++;
  }
  const Index* order = impl_->factor.order;
  for (Index i = 0; i < own.n; ++i) own.order.push_back(number[order[i]]);
  own.factor = impl_->factor;
  own.factor.n = own.n;
  own.factor.n_super = static_cast<Index>(own.leading.super.size()) - 1;
  own.factor.super = own.leading.super.data();
  own.factor.pi = own.leading.pi.data();
  own.factor.rows = own.leading.rows.data();
  own.factor.order = own.order.data();
  own.count();
  const Index n_done = impl_->numbers->n_done;
  if (n_done < own.n) {
    own.fail_at(own.order[n_done]);
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
  Numbers& numbers = *impl.numbers;
  numbers.symbolic = symbolic_factor(K, last);
  if (numbers.symbolic.flops < worth_condensing && !always) return {};
  const SupernodeTree pattern(numbers.symbolic.view());
  const Index c = static_cast<Index>(last.size()), n_I = K.rows() - c;
  if (!is_cheaper(pattern.factor(), n_I, condensed.flops) && !always) return {};
  const double square = 8 * static_cast<double>(c) * static_cast<double>(c),
               matrices = 32 * static_cast<double>(K.nonZeros());
  if (numbers.symbolic.bytes() + matrices + 2 * (front_bytes(pattern) + square) >
      0.9 * machine_memory_bytes())
    return {};
  numbers.make_room();
  if (!factor_and_condense(pattern, n_I, K, M, numbers.x.data(), condensed.K, condensed.M,
                           progress))
    return {};
  mirror_lower(condensed.K);
  mirror_lower(condensed.M);
  numbers.n_done = n_I;
  impl.n = K.rows();
  impl.diagonal = K.diagonal();
  impl.last = last;
  impl.factor = numbers.view();
  return whole.leading();
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

bool SparseCholesky::ok() const { return impl_->is_definite; }
double SparseCholesky::smallest_pivot() const { return impl_->smallest_pivot; }
Index SparseCholesky::weakest_column() const { return impl_->weakest; }
Index SparseCholesky::n_rows() const { return impl_->n; }
double SparseCholesky::bytes() const { return 8 * static_cast<double>(impl_->numbers->x.size()); }
double SparseCholesky::n_nonzeros() const { return impl_->n_nonzeros; }
double SparseCholesky::flops() const { return impl_->flops; }

void SparseCholesky::solve_in_place(Eigen::Ref<Matrix> B) const {
  assert(ok() && B.rows() == n_rows());
  if (n_rows() == 0 || B.cols() == 0) return;
  if (B.cols() <= narrow::width) return impl_->solve_few(B);
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
      solve_panel(solver, tree(), X_t, B.middleCols(first, columns));
    }
  };
  try {
    const SingleThreadedBlas blas;
    run_threads(static_cast<int>(wanted), work);
  } catch (const std::bad_alloc&) {
    throw RunError(format_text("not enough memory to solve for %lld right-hand sides of %lld dofs",
                               static_cast<long long>(block), static_cast<long long>(n_rows())));
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
  if (x != b) std::copy_n(b, n_rows(), x);
  solve_in_place(Eigen::Map<Matrix>(x, n_rows(), 1));
}

FactorCost factor_cost(const SparseMatrix& nodes, Index dofs) {
  FactorCost cost;
  if (nodes.rows() == 0) return cost;
  assert(nodes.isCompressed());
  GraphOrder found = order_of_graph(nodes);
  cost.order = std::move(found.order);
  for (const Index count : found.counts) {
    for (Index i = 0; i < dofs; ++i) {
      const auto rows = static_cast<double>(dofs * count - i);
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
  const SymbolicFactor symbolic = symbolic_factor(A);
  const auto count = count_negative_pivots(SupernodeTree(symbolic.view()), {A}, vanishing_pivot);
  assert(count);
  return *count;
}

Index negative_inertia(const SparseMatrix& K, double sigma, const SparseMatrix& M,
                       const SparseCholesky& like, const Progress& progress) {
  if (K.rows() == 0) return 0;
  if (like.ok()) {
    const auto count =
        count_negative_pivots(like.tree(), {K, sigma, &M}, vanishing_pivot, progress);
    if (count) return *count;
  }
  return negative_inertia(SparseMatrix(K - sigma * M));
}

}  // namespace cbr
