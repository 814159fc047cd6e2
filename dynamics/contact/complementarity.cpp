// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/complementarity.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

using Active = std::vector<char>;

std::vector<Index> indices(const Active& active) {
  std::vector<Index> list;
  for (std::size_t i = 0; i < active.size(); ++i)
    if (active[i]) list.push_back(static_cast<Index>(i));
  return list;
}

double residual(const Vector& p, const Vector& gap, double scale) {
  double worst = 0;
  for (Index i = 0; i < p.size(); ++i) worst = std::max(worst, p[i] > 0 ? std::abs(gap[i]) : -gap[i]);
  return scale > 0 ? worst / scale : worst;
}

}  // namespace

struct ComplementaritySolver::Impl {
  GapResponse W;
  // Factor of W_AA for the set `factored`.
  Active factored;
  std::vector<Index> A;
  Eigen::LLT<Matrix> cholesky;
  Eigen::CompleteOrthogonalDecomposition<Matrix> orthogonal;
  std::unique_ptr<Eigen::SimplicialLDLT<SparseMatrix>> sparse;
  enum class Factor { none, cholesky, orthogonal, sparse } kind = Factor::none;

  Matrix active_part() const {
    if (!W.is_sparse) return W.dense(A, A);
    return Matrix(sparse_active_part());
  }

  SparseMatrix sparse_active_part() const {
    std::vector<Index> position(W.size(), -1);
    for (std::size_t i = 0; i < A.size(); ++i) position[A[i]] = static_cast<Index>(i);
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (const Index j : A)
      for (SparseMatrix::InnerIterator it(W.sparse, j); it; ++it)
        if (position[it.row()] >= 0) entries.emplace_back(position[it.row()], position[j], it.value());
    SparseMatrix part(static_cast<Index>(A.size()), static_cast<Index>(A.size()));
    part.setFromTriplets(entries.begin(), entries.end());
    return part;
  }

  void factor(const Active& active) {
    if (kind != Factor::none && active == factored) return;
    factored = active;
    A = indices(active);
    if (W.is_sparse) {
      sparse = std::make_unique<Eigen::SimplicialLDLT<SparseMatrix>>(sparse_active_part());
      kind = Factor::sparse;
      if (sparse->info() == Eigen::Success && sparse->vectorD().minCoeff() > 1e-12 * sparse->vectorD().maxCoeff()) return;
    } else {
      cholesky.compute(W.dense(A, A));
      kind = Factor::cholesky;
      if (cholesky.info() == Eigen::Success) {
        const auto diagonal = cholesky.matrixLLT().diagonal().cwiseAbs2();
        if (diagonal.minCoeff() > 1e-12 * diagonal.maxCoeff()) return;
      }
    }
    // Redundant constraints: the least-norm solution shares the impulse among them.
    orthogonal.setThreshold(1e-11);
    orthogonal.compute(active_part());
    kind = Factor::orthogonal;
  }

  // p_A = -W_AA^-1 g_A, 0 elsewhere.
  Vector solve_on(const Active& active, const Vector& g) {
    Vector p = Vector::Zero(g.size());
    if (std::none_of(active.begin(), active.end(), [](char a) { return a; })) return p;
    factor(active);
    const Vector rhs = -g(A);
    Vector x;
    if (kind == Factor::cholesky) x = cholesky.solve(rhs);
    if (kind == Factor::sparse) x = sparse->solve(rhs);
    if (kind == Factor::orthogonal) x = orthogonal.solve(rhs);
    for (std::size_t i = 0; i < A.size(); ++i) p[A[i]] = x[static_cast<Index>(i)];
    return p;
  }

  double diagonal(Index i) const { return W.is_sparse ? W.sparse.coeff(i, i) : W.dense(i, i); }
  void add_column(Index i, double factor_, Vector& y) const {
    if (W.is_sparse) {
      y += factor_ * W.sparse.col(i);
    } else {
      y += factor_ * W.dense.col(i);
    }
  }

  Vector gauss_seidel(const Vector& g, double tolerance) const {
    Vector p = Vector::Zero(g.size()), gap = g;
    for (int sweep = 0; sweep < 500; ++sweep) {
      double change = 0;
      for (Index i = 0; i < g.size(); ++i) {
        const double w = diagonal(i);
        if (!(w > 0)) continue;
        const double step = std::max(-p[i], -gap[i] / w);
        if (step == 0) continue;
        p[i] += step;
        add_column(i, step, gap);
        change = std::max(change, std::abs(step) * w);
      }
      if (change <= tolerance) break;
    }
    return p;
  }

  // -(W_AA + epsilon I)^-1 g_A, 0 elsewhere.
  Vector solve_shifted(const Active& active, const Vector& g, double epsilon) {
    A = indices(active);
    kind = Factor::none;
    Vector p = Vector::Zero(g.size());
    if (A.empty()) return p;
    Matrix part = active_part();
    part.diagonal().array() += epsilon;
    const Vector x = part.ldlt().solve(Vector(-g(A)));
    for (std::size_t i = 0; i < A.size(); ++i) p[A[i]] = x[static_cast<Index>(i)];
    return p;
  }

  // Minimises p (W + epsilon I) p / 2 + g p over p >= 0 from a feasible p, one constraint in or out at a time: descends, so it
  // cannot cycle (the scheme of Lawson and Hanson 1974, chapter 23).
  Vector descend(const Vector& g, double epsilon, Vector p, double tolerance) {
    Active active(g.size());
    for (Index i = 0; i < g.size(); ++i) active[i] = p[i] > 0;
    for (Index change = 0; change < 20 * g.size() + 100; ++change) {
      const Vector target = solve_shifted(active, g, epsilon);
      double step = 1;
      Index leaving = -1;
      for (Index i = 0; i < g.size(); ++i) {
        if (!active[i] || target[i] > 0) continue;
        const double until_zero = p[i] > 0 ? p[i] / (p[i] - target[i]) : 0.0;
        if (leaving < 0 || until_zero < step) step = until_zero, leaving = i;
      }
      p += step * (target - p);
      if (leaving >= 0) {
        p[leaving] = 0, active[leaving] = 0;
        continue;
      }
      Index entering = -1;
      const Vector gap = g + apply(W, p) + epsilon * p;
      for (Index i = 0; i < g.size(); ++i)
        if (!active[i] && gap[i] < -tolerance && (entering < 0 || gap[i] < gap[entering])) entering = i;
      if (entering < 0) break;
      active[entering] = 1;
    }
    return p.cwiseMax(0);
  }

  // Proximal point iteration (Rockafellar 1976): a definite problem each time, and the solution of a semi-definite one in the
  // limit.
  Vector proximal(const Vector& g, Vector p, double tolerance) {
    double trace = 0;
    for (Index i = 0; i < g.size(); ++i) trace += diagonal(i);
    const double epsilon = 1e-7 * trace / static_cast<double>(g.size());
    for (int outer = 0; outer < 12; ++outer) {
      p = descend(g - epsilon * p, epsilon, p, tolerance);
      if (residual(p, g + apply(W, p), 1) <= 10 * tolerance) break;
    }
    return p;
  }
};

ComplementaritySolver::ComplementaritySolver(GapResponse W) : impl_(std::make_unique<Impl>()) { impl_->W = std::move(W); }
ComplementaritySolver::~ComplementaritySolver() = default;
ComplementaritySolver::ComplementaritySolver(ComplementaritySolver&&) noexcept = default;
ComplementaritySolver& ComplementaritySolver::operator=(ComplementaritySolver&&) noexcept = default;

const GapResponse& ComplementaritySolver::W() const { return impl_->W; }

ComplementarityResult ComplementaritySolver::solve(const Vector& g, const std::vector<char>& guess) {
  ComplementarityResult result;
  const Index m = g.size();
  const double scale = m > 0 ? g.cwiseAbs().maxCoeff() : 0, tolerance = 1e-12 * scale;
  Active active(m);
  for (Index i = 0; i < m; ++i) active[i] = guess[i] || g[i] < 0;
  std::vector<Active> seen;
  bool settled = false;
  for (result.iterations = 1; result.iterations <= 40 && !settled; ++result.iterations) {
    result.p = impl_->solve_on(active, g);
    result.gap = g + apply(impl_->W, result.p);
    Active next(m);
    for (Index i = 0; i < m; ++i) next[i] = active[i] ? result.p[i] > 0 : result.gap[i] < -tolerance;
    settled = next == active;
    if (std::find(seen.begin(), seen.end(), next) != seen.end()) break;
    seen.push_back(active);
    active = std::move(next);
  }
  result.residual = residual(result.p.cwiseMax(0), result.gap, scale);
  // A settled set can still be wrong when W is singular: the least-squares impulse of gaps that no impulse of theirs closes.
  if (!settled || result.residual > 1e-9) {
    result.fallback = true;
    const Vector p = impl_->proximal(g, impl_->gauss_seidel(g, tolerance), tolerance), gap = g + apply(impl_->W, p);
    const Vector clamped = result.p.cwiseMax(0), clamped_gap = g + apply(impl_->W, clamped);
    const bool solved = residual(p, gap, scale) < 1e-6;
    result.p = solved ? p : clamped;
    result.gap = solved ? gap : clamped_gap;
    result.residual = residual(result.p, result.gap, scale);
  }
  return result;
}

}  // namespace cbr
