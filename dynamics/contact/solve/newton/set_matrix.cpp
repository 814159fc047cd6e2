// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/set_matrix.hpp"

#include <Eigen/SparseLU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"
#include "dynamics/contact/solve/newton/krylov.hpp"

namespace cbr {
namespace {

// Relative to the diagonal: pivots of round-off; and the shift that replaces them.
constexpr double round_off_pivot = 1e-11, shift = 1e-8;
// Limits of products of Krylov methods.
constexpr int most_products_symmetric = 1000, most_products_gmres = 100;

// r^T W c over the closed rows: one entry of W, or of a small block.
double between(const ContactProblem& problem, const SetBases& bases, Index j) {
  double sum = 0;
  for (SparseMatrix::InnerIterator r(bases.R, j); r; ++r)
    for (SparseMatrix::InnerIterator c(bases.C, j); c; ++c) {
      const Index row = bases.rows[r.row()], column = bases.rows[c.row()];
      sum += r.value() * c.value() *
             (problem.W.is_sparse ? problem.W.sparse.coeff(row, column)
                                  : problem.W.dense(row, column));
    }
  return sum;
}

// Scale of each unknown for a unit diagonal of K. Friction may reduce the diagonal; W's own is the
// lower bound.
Vector unit_scale(const ContactProblem& problem, const SetBases& bases) {
  Vector scale(bases.size());
  for (Index j = 0; j < bases.size(); ++j) {
    double own = bases.alpha[j];
    for (SparseMatrix::InnerIterator r(bases.R, j); r; ++r)
      own += r.value() * r.value() * problem.diagonal[bases.rows[r.row()]];
    const double entry =
        bases.symmetric ? own : std::abs(between(problem, bases, j) + bases.alpha[j]);
    scale[j] = 1 / std::sqrt(std::max(entry, 1e-3 * own));
  }
  return scale;
}

// W over the closed rows: sparse   (k x k)
SparseMatrix sparse_part(const SparseMatrix& W, const std::vector<Index>& rows) {
  std::vector<Index> position(W.rows(), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) position[rows[i]] = static_cast<Index>(i);
  const Index k = static_cast<Index>(rows.size());
  SparseMatrix part(k, k);
  for (Index j = 0; j < k; ++j) {
    part.startVec(j);
    for (SparseMatrix::InnerIterator it(W, rows[j]); it; ++it)
      if (position[it.row()] >= 0) part.insertBack(position[it.row()], j) = it.value();
  }
  part.finalize();
  return part;
}

}  // namespace

struct SetMatrix::Impl {
  const ContactProblem* problem = nullptr;
  SetBases bases;
  Vector scale;  // n: solves scale K scale, of unit diagonal
  LinearSolver solver = LinearSolver::factor;
  bool shifted = false;
  // W over the closed rows (k x k). Dense and krylov: only if much smaller than W, otherwise W is
  // used.
  Matrix dense;
  SparseMatrix sparse;
  // One of the factors of scale K scale
  std::optional<Cholesky> cholesky;
  std::optional<Lu> lu;
  std::optional<SparseCholesky> sparse_cholesky;
  std::unique_ptr<Eigen::SparseLU<SparseMatrix>> sparse_lu;

  void gather();
  bool factor(double epsilon);
  bool factor_sparse(double epsilon);
  Matrix dense_matrix() const;
  Vector back_solve(const Vector& b) const;
  Vector closed_response(const Vector& p) const;
  Vector product(const Vector& x) const;
  Vector refined(const Vector& b) const;
  Vector iterated(const Vector& b, Vector x, double reduction, Index* products) const;
};

void SetMatrix::Impl::gather() {
  if (problem->W.is_sparse) {
    sparse = sparse_part(problem->W.sparse, bases.rows);
  } else if (solver == LinearSolver::factor ||
             10 * static_cast<Index>(bases.rows.size()) < 7 * problem->n_rows()) {
    dense = problem->W.dense(bases.rows, bases.rows);
  }
}

// scale (R^T W C + diag(alpha)) scale   (n x n)
Matrix SetMatrix::Impl::dense_matrix() const {
  if (bases.symmetric) return scale.asDiagonal() * dense * scale.asDiagonal();
  Matrix K(bases.size(), bases.size());
  Vector y(dense.rows());
  for (Index j = 0; j < K.cols(); ++j) {
    y.setZero();
    for (SparseMatrix::InnerIterator c(bases.C, j); c; ++c)
      y += c.value() * scale[j] * dense.col(c.row());
    for (Index i = 0; i < K.rows(); ++i) {
      double sum = 0;
      for (SparseMatrix::InnerIterator r(bases.R, i); r; ++r) sum += r.value() * y[r.row()];
      K(i, j) = scale[i] * sum;
    }
    K(j, j) += bases.alpha[j] * scale[j] * scale[j];
  }
  return K;
}

bool SetMatrix::Impl::factor_sparse(double epsilon) {
  SparseMatrix D(bases.size(), bases.size());
  D.setIdentity();
  D.diagonal() = Vector(bases.alpha.cwiseProduct(scale).cwiseProduct(scale).array() + epsilon);
  SparseMatrix K = bases.R.transpose() * SparseMatrix(sparse * bases.C);
  K = SparseMatrix(scale.asDiagonal() * K * scale.asDiagonal()) + D;
  if (!bases.symmetric) {
    sparse_lu = std::make_unique<Eigen::SparseLU<SparseMatrix>>(K);
    return sparse_lu->info() == Eigen::Success;
  }
  sparse_cholesky.emplace(K);
  if (sparse_cholesky->ok() && (epsilon > 0 || sparse_cholesky->smallest_pivot() > round_off_pivot))
    return true;
  sparse_cholesky.reset();
  return false;
}

// Factors scaled K + epsilon I; false if a pivot is round-off.
bool SetMatrix::Impl::factor(double epsilon) {
  if (problem->W.is_sparse) return factor_sparse(epsilon);
  Matrix K = dense_matrix();
  K.diagonal().array() += epsilon;
  if (bases.symmetric) {
    cholesky.emplace(std::move(K));
    return cholesky->ok() &&
           (epsilon > 0 || cholesky->diagonal().cwiseAbs2().minCoeff() > round_off_pivot);
  }
  lu.emplace(std::move(K));
  return epsilon > 0 || lu->smallest_pivot() > round_off_pivot;
}

Vector SetMatrix::Impl::back_solve(const Vector& b) const {
  if (cholesky) return cholesky->solve(b);
  if (lu) return lu->solve(b);
  if (sparse_cholesky) return sparse_cholesky->solve(Matrix(b));
  if (sparse_lu && sparse_lu->info() == Eigen::Success) return sparse_lu->solve(b);
  return Vector::Constant(b.size(), std::numeric_limits<double>::quiet_NaN());
}

Vector SetMatrix::Impl::closed_response(const Vector& p) const {
  if (problem->W.is_sparse) return sparse * p;
  if (dense.size() > 0) return symmetric_product(dense, p);
  Vector all = Vector::Zero(problem->n_rows());
  all(bases.rows) = p;
  return respond(*problem, all)(bases.rows);
}

Vector SetMatrix::Impl::product(const Vector& x) const {
  const Vector y = scale.cwiseProduct(x);
  return scale.cwiseProduct(bases.R.transpose() * closed_response(bases.C * y) +
                            bases.alpha.cwiseProduct(y));
}

// Iterative refinement removes the shift; components in the null space of W stay minimal.
Vector SetMatrix::Impl::refined(const Vector& b) const {
  Vector x = back_solve(b);
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; shifted && i < 20; ++i) {
    const Vector r = b - product(x);
    const double size = r.norm();
    if (!(size > 1e-15 * b.norm()) || !(size < 0.7 * last)) break;
    last = size;
    x += back_solve(r);
  }
  return x;
}

Vector SetMatrix::Impl::iterated(const Vector& b, Vector x, double reduction,
                                 Index* products) const {
  const auto A = [this](const Vector& y) { return product(y); };
  const double tolerance = std::max(1e-15 * b.norm(), reduction * (b - product(x)).norm());
  const int n = bases.symmetric ? conjugate_gradients(A, b, tolerance, most_products_symmetric, x)
                                : gmres(A, b, tolerance, most_products_gmres, x);
  if (products != nullptr) *products += n;
  return x;
}

SetMatrix::SetMatrix(const ContactProblem& problem, const ContactSet& set, LinearSolver solver)
    : impl_(std::make_unique<Impl>()) {
  impl_->problem = &problem;
  impl_->solver = solver;
  impl_->bases = set_bases(problem, set);
  if (impl_->bases.size() == 0) return;
  impl_->scale = unit_scale(problem, impl_->bases);
  impl_->gather();
  if (solver == LinearSolver::krylov) return;
  impl_->shifted = !impl_->factor(0);
  if (impl_->shifted) {
    impl_->factor(shift);
  } else {
    impl_->dense.resize(0, 0);  // refinement alone needs it
  }
}
SetMatrix::~SetMatrix() = default;
SetMatrix::SetMatrix(SetMatrix&&) noexcept = default;
SetMatrix& SetMatrix::operator=(SetMatrix&&) noexcept = default;

bool SetMatrix::has_factor() const {
  return impl_->solver == LinearSolver::factor && !impl_->shifted;
}

Vector SetMatrix::solve(const Vector& g, const Vector& start, double reduction,
                        Index* products) const {
  const Impl& of = *impl_;
  Vector p = Vector::Zero(g.size());
  if (of.bases.size() == 0) return p;
  const Vector b = -of.scale.cwiseProduct(of.bases.R.transpose() * Vector(g(of.bases.rows)));
  const Vector x = of.solver == LinearSolver::factor
                       ? of.refined(b)
                       : of.iterated(b,
                                     Vector((of.bases.R.transpose() * Vector(start(of.bases.rows)))
                                                .cwiseQuotient(of.scale)),
                                     reduction, products);
  p(of.bases.rows) = of.bases.C * of.scale.cwiseProduct(x);
  return p;
}

namespace {

// A released direction: gap = e y in the n rows from `first`, and q^T p + d y = 0.
struct Released {
  Index first = 0, n = 3;
  std::array<double, 3> e{}, q{};
  double d = 0;
};

std::vector<Released> released_by(const ContactProblem& problem, const ContactSet& set) {
  std::vector<Released> list;
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index first = problem.first[i], n = problem.first[i + 1] - first;
    for (Index row = 0; set.states[i] == PointState::open && row < n; ++row) {
      list.push_back({first, n, {}, {}, 0});
      list.back().e[row] = list.back().q[row] = 1;
    }
    if (set.states[i] != PointState::slide) continue;
    const double d1 = set.slides(i, 0), d2 = set.slides(i, 1), alpha = set.slides(i, 2),
                 scale = 1 / (problem.w[i] + alpha);
    list.push_back({first, n, {0, d1, d2}, {-problem.laws[i].friction, d1, d2}, 0});
    list.push_back({first, n, {0, -d2, d1}, {0, -alpha * scale * d2, alpha * scale * d1}, scale});
  }
  return list;
}

}  // namespace

FullInverse::FullInverse(const ContactProblem& problem) {
  if (!(problem.diagonal.minCoeff() > 0)) return;
  const Vector scale = problem.diagonal.cwiseSqrt().cwiseInverse();
  const Cholesky factor(scale.asDiagonal() * problem.W.dense * scale.asDiagonal());
  if (!factor.ok() || !(factor.diagonal().cwiseAbs2().minCoeff() > round_off_pivot)) return;
  Z_ = Matrix::Identity(scale.size(), scale.size());
  factor.solve_in_place(Eigen::Ref<Matrix>(Z_));
  Z_ = scale.asDiagonal() * Z_ * scale.asDiagonal();
}

bool FullInverse::serves(const ContactProblem& problem, const ContactSet& set) {
  Index released = 0;
  for (Index i = 0; i < problem.n_points(); ++i) {
    if (set.states[i] == PointState::open) released += n_rows(problem.laws[i].law);
    if (set.states[i] == PointState::slide) released += 2;
  }
  return 2 * released <= problem.n_rows();
}

Vector FullInverse::solve(const ContactProblem& problem, const ContactSet& set, const Vector& p,
                          const Vector& gap) const {
  const std::vector<Released> released = released_by(problem, set);
  const auto r = static_cast<Index>(released.size());
  Vector all = p - symmetric_product(Z_, gap);
  if (r == 0) return all;
  Matrix S(r, r);
  Vector right = Vector::Zero(r);
  for (Index j = 0; j < r; ++j) {
    const Released& column = released[j];
    for (Index a = 0; a < column.n; ++a) right[j] -= column.q[a] * all[column.first + a];
    for (Index i = 0; i < r; ++i) {
      const Released& row = released[i];
      double sum = 0;
      for (Index b = 0; b < column.n; ++b)
        for (Index a = 0; column.e[b] != 0 && a < row.n; ++a)
          sum += row.q[a] * column.e[b] * Z_(row.first + a, column.first + b);
      S(i, j) = sum;
    }
    S(j, j) += column.d;
  }
  const Vector y = Lu(std::move(S)).solve(right);
  Vector opening = Vector::Zero(gap.size());
  for (Index j = 0; j < r; ++j)
    for (Index b = 0; b < released[j].n; ++b)
      opening[released[j].first + b] += y[j] * released[j].e[b];
  all += symmetric_product(Z_, opening);
  for (Index i = 0; i < problem.n_points(); ++i)  // without round-off
    if (set.states[i] == PointState::open)
      all.segment(problem.first[i], problem.first[i + 1] - problem.first[i]).setZero();
  return all;
}

}  // namespace cbr
