// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/set_matrix.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "common/linalg/sparse_cholesky.hpp"

namespace cbr {
namespace {

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

// Pivots below this share of the diagonal are round-off; the shift that then stands in for them.
constexpr double weakest_pivot = 1e-11, shift = 1e-8;

PointState state_of(const PointLaw& law, double w, const double* p, const double* gap, double* slide) {
  if (law.law == ContactLaw::tied) return PointState::stick;
  const double tau_n = w * p[0] - gap[0];
  if (!(w > 0) || !(tau_n > 0)) return PointState::open;
  if (law.law == ContactLaw::frictionless) return PointState::normal;
  const double t1 = w * p[1] - gap[1], t2 = w * p[2] - gap[2], length = std::hypot(t1, t2), limit = law.friction * tau_n;
  if (length <= limit) return PointState::stick;
  slide[0] = t1 / length, slide[1] = t2 / length;
  // Beyond 1e12 w the tangential impulse across the slip is 0 to round-off.
  slide[2] = w * std::min(1e12, limit > 0 ? (length - limit) / limit : 1e12);
  return PointState::slide;
}

}  // namespace

bool ContactSet::slides_anywhere() const { return std::find(states.begin(), states.end(), PointState::slide) != states.end(); }

ContactSet contact_set(const ContactProblem& problem, const Vector& p, const Vector& gap) {
  ContactSet set;
  set.states.resize(problem.n_points());
  set.slides.setZero(problem.n_points(), 3);
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index row = problem.first[i];
    set.states[i] = state_of(problem.laws[i], problem.w[i], p.data() + row, gap.data() + row, set.slides.row(i).data());
  }
  return set;
}

struct SetMatrix::Impl {
  SparseMatrix R, C;  // m x n
  Vector alpha;       // n
  Vector scale;       // n: K is factored as scale K scale, of unit diagonal
  bool symmetric = true, shifted = false;
  // Scaled K, kept where it is needed for refinement, and one of its factors.
  Matrix dense;
  SparseMatrix sparse;
  bool is_sparse = false;
  std::optional<Eigen::LLT<Matrix>> llt;
  std::optional<Eigen::PartialPivLU<Matrix>> lu;
  std::optional<SparseCholesky> cholesky;
  std::unique_ptr<Eigen::SparseLU<SparseMatrix>> sparse_lu;

  Index size() const { return R.cols(); }
  void bases(const ContactProblem& problem, const ContactSet& set);
  void assemble(const ContactProblem& problem);
  bool factor(double epsilon);
  Vector back_solve(const Vector& b) const;
};

// Columns: the directions of the equations (R) and of the unknowns (C).
void SetMatrix::Impl::bases(const ContactProblem& problem, const ContactSet& set) {
  Triplets rows, columns;
  std::vector<double> diagonal;
  Index n = 0;
  const auto unit = [&](Index row) {
    rows.emplace_back(row, n, 1.0), columns.emplace_back(row, n, 1.0);
    diagonal.push_back(0), ++n;
  };
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index row = problem.first[i];
    if (set.states[i] == PointState::open) continue;
    if (set.states[i] != PointState::slide) {
      for (Index d = 0; d < (set.states[i] == PointState::stick ? 3 : 1); ++d)
        if (problem.diagonal[row + d] > 0) unit(row + d);
      continue;
    }
    symmetric = false;
    const double mu = problem.laws[i].friction, d1 = set.slides(i, 0), d2 = set.slides(i, 1);
    columns.emplace_back(row + 1, n, mu * d1), columns.emplace_back(row + 2, n, mu * d2);
    unit(row);
    for (Triplets* list : {&rows, &columns}) list->emplace_back(row + 1, n, -d2), list->emplace_back(row + 2, n, d1);
    diagonal.push_back(set.slides(i, 2)), ++n;
  }
  R.resize(problem.n_rows(), n), C.resize(problem.n_rows(), n);
  R.setFromTriplets(rows.begin(), rows.end()), C.setFromTriplets(columns.begin(), columns.end());
  alpha = Eigen::Map<const Vector>(diagonal.data(), n);
}

// K = R^T W C + diag(alpha), scaled to a unit diagonal   (n x n)
void SetMatrix::Impl::assemble(const ContactProblem& problem) {
  is_sparse = problem.W.is_sparse;
  Vector diagonal;
  if (is_sparse) {
    sparse = R.transpose() * SparseMatrix(problem.W.sparse * C);
    SparseMatrix D(size(), size());
    D.setIdentity();
    D.diagonal() = alpha;
    sparse += D;
    diagonal = sparse.diagonal();
  } else if (symmetric) {
    std::vector<Index> A(R.innerIndexPtr(), R.innerIndexPtr() + size());
    dense = problem.W.dense(A, A);
    diagonal = dense.diagonal();
  } else {
    dense = R.transpose() * Matrix(problem.W.dense * C);
    dense.diagonal() += alpha;
    diagonal = dense.diagonal();
  }
  // What W has in the unknown's place: friction alone can make a diagonal entry small or negative
  Vector own(size());
  for (Index j = 0; j < size(); ++j) {
    own[j] = alpha[j];
    for (SparseMatrix::InnerIterator it(R, j); it; ++it) own[j] += it.value() * it.value() * problem.diagonal[it.row()];
  }
  scale = diagonal.cwiseAbs().cwiseMax(1e-3 * own).cwiseSqrt().cwiseInverse();
  if (is_sparse) {
    sparse = scale.asDiagonal() * sparse * scale.asDiagonal();
  } else {
    dense.array().colwise() *= scale.array();
    dense.array().rowwise() *= scale.transpose().array();
  }
}

// Factors scaled K + epsilon I; false when a pivot is round-off.
bool SetMatrix::Impl::factor(double epsilon) {
  if (is_sparse) {
    SparseMatrix K = sparse;
    if (epsilon > 0) K.diagonal().array() += epsilon;
    if (symmetric) {
      cholesky.emplace(K);
      if (cholesky->ok() && (epsilon > 0 || cholesky->smallest_pivot() > weakest_pivot)) return true;
      cholesky.reset();
      return false;
    }
    sparse_lu = std::make_unique<Eigen::SparseLU<SparseMatrix>>(K);
    return sparse_lu->info() == Eigen::Success;
  }
  Matrix K = dense;
  K.diagonal().array() += epsilon;
  if (symmetric) {
    llt.emplace(std::move(K));
    return llt->info() == Eigen::Success && (epsilon > 0 || llt->matrixLLT().diagonal().cwiseAbs2().minCoeff() > weakest_pivot);
  }
  lu.emplace(std::move(K));
  return epsilon > 0 || lu->matrixLU().diagonal().cwiseAbs().minCoeff() > weakest_pivot;
}

Vector SetMatrix::Impl::back_solve(const Vector& b) const {
  if (llt) return llt->solve(b);
  if (lu) return lu->solve(b);
  if (cholesky) return cholesky->solve(Matrix(b));
  return sparse_lu->solve(b);
}

SetMatrix::SetMatrix(const ContactProblem& problem, const ContactSet& set) : impl_(std::make_unique<Impl>()) {
  impl_->bases(problem, set);
  if (impl_->size() == 0) return;
  impl_->assemble(problem);
  impl_->shifted = !impl_->factor(0);
  if (impl_->shifted) impl_->factor(shift);
}
SetMatrix::~SetMatrix() = default;
SetMatrix::SetMatrix(SetMatrix&&) noexcept = default;
SetMatrix& SetMatrix::operator=(SetMatrix&&) noexcept = default;

Vector SetMatrix::solve(const Vector& g) const {
  const Impl& of = *impl_;
  if (of.size() == 0) return Vector::Zero(g.size());
  const Vector b = -of.scale.cwiseProduct(of.R.transpose() * g);
  Vector x = of.back_solve(b);
  // The shift is taken back by refinement; what the shift alone holds (the null space of W) stays least.
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; of.shifted && i < 20; ++i) {
    Vector r = b;
    if (of.is_sparse) {
      r -= of.sparse * x;
    } else {
      r.noalias() -= of.dense * x;
    }
    const double size = r.norm();
    if (!(size > 1e-15 * b.norm()) || !(size < 0.7 * last)) break;
    last = size;
    x += of.back_solve(r);
  }
  return of.C * of.scale.cwiseProduct(x);
}

}  // namespace cbr
