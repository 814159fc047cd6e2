// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/sparse_cholesky.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <new>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/narrow_product.hpp"
#include "common/linalg/sparse/cholmod_factor.hpp"
#include "common/linalg/sparse/cut_supernodes.hpp"
#include "common/linalg/sparse/shared_solve.hpp"
#include "common/linalg/sparse/supernodal_ldl.hpp"

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

}  // namespace

struct SparseCholesky::Impl {
  // a leading factor shares it
  std::shared_ptr<CholmodFactor> cholmod =
      std::make_shared<CholmodFactor>(CholmodFactor::Kind::supernodal);
  // for a few at a time; made when first wanted
  std::unique_ptr<SharedSolve> shared;
  SupernodeTree tree;
  SupernodalFactor factor;
  SupernodePattern leading;  // of a leading factor, to which `factor` points
  std::vector<Index> order, last;
  Vector diagonal;  // of A
  Index n = 0, weakest = -1;
  double smallest_pivot = 1, n_nonzeros = 0, flops = 0;
  bool is_whole = true, is_definite = true;

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
  CholmodFactor& cholmod = *impl_->cholmod;
  cholmod.factorize(A, last, progress, nodes);
  impl_->diagonal = A.diagonal();
  impl_->last = last;
  impl_->factor = cholmod.view();
  impl_->n_nonzeros = cholmod.n_nonzeros();
  impl_->flops = cholmod.flops();
  if (cholmod.n_done() < cholmod.n()) {
    impl_->fail_at(cholmod.permutation()[cholmod.n_done()]);
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
  const Index n_done = impl_->cholmod->n_done();
  if (n_done < own.n) {
    own.fail_at(own.order[static_cast<std::size_t>(n_done)]);
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

bool SparseCholesky::ok() const { return impl_->is_definite; }
double SparseCholesky::smallest_pivot() const { return impl_->smallest_pivot; }
Index SparseCholesky::weakest_column() const { return impl_->weakest; }
Index SparseCholesky::n_rows() const { return impl_->n; }
double SparseCholesky::bytes() const { return impl_->n == 0 ? 0 : impl_->cholmod->bytes(); }
double SparseCholesky::n_nonzeros() const { return impl_->n_nonzeros; }
double SparseCholesky::flops() const { return impl_->flops; }

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
  impl_->cholmod->solve(b, x);
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
  CholmodFactor cholmod(CholmodFactor::Kind::simplicial);
  cholmod.analyze(nodes);
  const auto* count = cholmod.column_counts();
  cost.order.assign(cholmod.permutation(), cholmod.permutation() + cholmod.n());
  for (Index j = 0; j < cholmod.n(); ++j) {
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
  CholmodFactor cholmod(CholmodFactor::Kind::supernodal);
  cholmod.analyze(A);
  const auto count = count_negative_pivots(SupernodeTree(cholmod.view()), {A}, vanishing_pivot);
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
