// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/coupled/coupled_system.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {
namespace {

// A dense symmetric block on some of the free dofs.
struct FreeBlock {
  Matrix S;
  std::vector<Index> dof;
};

// Rows `dof` of Z without its empty columns, which are listed in `columns`.
SparseMatrix rows_of(const SparseMatrix& Z, const std::vector<Index>& dof,
                     std::vector<Index>& columns) {
  const SparseMatrix Zt = Z.transpose();
  std::vector<Eigen::Triplet<double, Index>> entries;
  columns.clear();
  for (const Index row : dof)
    for (SparseMatrix::InnerIterator it(Zt, row); it; ++it) columns.push_back(it.row());
  sort_uniquely(columns);
  for (std::size_t i = 0; i < dof.size(); ++i) {
    for (SparseMatrix::InnerIterator it(Zt, dof[i]); it; ++it) {
      const auto column =
          std::lower_bound(columns.begin(), columns.end(), it.row()) - columns.begin();
      entries.emplace_back(static_cast<Index>(i), column, it.value());
    }
  }
  SparseMatrix rows(static_cast<Index>(dof.size()), static_cast<Index>(columns.size()));
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

// Right-hand sides at once.
constexpr Index solve_columns = 256;

// S = Z^T (M_cc + theta K_cc - M_kc^T D^-1 M_kc) Z of one part; lower triangle at least. Of K
// alone the modes have no part in it.
FreeBlock condensed(const CoupledPart& part, const FreeDofs& free, double theta) {
  const Superelement& s = *part.superelement;
  const bool with_mass = std::isfinite(theta);
  FreeBlock block{with_mass ? s.M_cc : s.K_cc, part.dof};
  if (with_mass && theta != 0) block.S += theta * s.K_cc;
  if (with_mass && s.k() > 0) {
    const Vector weight = (1 + theta * s.eigenvalues.array()).rsqrt();
    const Matrix scaled = weight.asDiagonal() * s.M_kc;
    block.S.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose(), -1);
  }
  if (free.is_all) return block;
  const SparseMatrix Z = rows_of(free.Z, part.dof, block.dof);
  block.S.triangularView<Eigen::StrictlyUpper>() = block.S.transpose();
  const Matrix S_Z = block.S * Z;
  block.S = Z.transpose() * S_Z;
  return block;
}

// The lower triangle of a sum of dense blocks and one sparse matrix. The pattern is laid out first
// and then filled in place: triplets would take three times the memory of the blocks.
class LowerSum {
 public:
  explicit LowerSum(Index n) : A_(n, n), blocks_of_(n), position_(n, -1) {}

  void announce(const std::vector<std::vector<Index>>& blocks, const SparseMatrix& sparse) {
    const Index n = A_.cols();
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (const Index dof : blocks[b]) blocks_of_[dof].push_back(b);
    std::vector<Index> rows, start(n + 1, 0);
    std::vector<std::vector<Index>> columns(n);
    for (Index j = 0; j < n; ++j) {
      rows.clear();
      const auto add = [&](Index i) {
        if (i < j || position_[i] == j) return;
        position_[i] = j;
        rows.push_back(i);
      };
      for (const std::size_t b : blocks_of_[j])
        for (const Index i : blocks[b]) add(i);
      if (sparse.cols() > 0)
        for (SparseMatrix::InnerIterator it(sparse, j); it; ++it) add(it.row());
      std::sort(rows.begin(), rows.end());
      columns[j] = rows;
      start[j + 1] = start[j] + static_cast<Index>(rows.size());
    }
    A_.resizeNonZeros(start[n]);
    std::copy(start.begin(), start.end(), A_.outerIndexPtr());
    for (Index j = 0; j < n; ++j)
      std::copy(columns[j].begin(), columns[j].end(), A_.innerIndexPtr() + start[j]);
    std::fill_n(A_.valuePtr(), start[n], 0.0);
  }

  void add(const FreeBlock& block) {
    for (std::size_t b = 0; b < block.dof.size(); ++b) {
      const Index j = block.dof[b];
      locate(j);
      for (std::size_t a = 0; a < block.dof.size(); ++a) {
        const Index i = block.dof[a];
        // The lower triangle of the block, whichever way its dofs are numbered
        if (i >= j)
          A_.valuePtr()[position_[i]] +=
              block.S(static_cast<Index>(std::max(a, b)), static_cast<Index>(std::min(a, b)));
      }
    }
  }

  void add(const SparseMatrix& sparse) {
    for (Index j = 0; j < sparse.cols(); ++j) {
      locate(j);
      for (SparseMatrix::InnerIterator it(sparse, j); it; ++it)
        if (it.row() >= j) A_.valuePtr()[position_[it.row()]] += it.value();
    }
  }

  const SparseMatrix& matrix() const { return A_; }

 private:
  void locate(Index j) {
    for (Index p = A_.outerIndexPtr()[j]; p < A_.outerIndexPtr()[j + 1]; ++p)
      position_[A_.innerIndexPtr()[p]] = p;
  }

  SparseMatrix A_;
  std::vector<std::vector<std::size_t>> blocks_of_;
  std::vector<Index> position_;
};

// M + theta K of meshes and shells on the free dofs; 0 x 0: none.
SparseMatrix sparse_part(const CoupledModel& model, const FreeDofs& free, double theta) {
  SparseMatrix A;
  if (!std::isfinite(theta)) {
    A = model.K;
    theta = 0;
  } else if (model.M.size() > 0) {
    A = model.M;
  }
  if (theta != 0 && model.K.size() > 0) {
    if (A.size() > 0) {
      A = (A + theta * model.K).eval();
    } else {
      A = theta * model.K;
    }
  }
  if (A.size() == 0 || free.is_all) return A;
  return free.Z.transpose() * A * free.Z;
}

// To round-off: turned axes of a held node leave some beside equal masses.
bool is_diagonal(const SparseMatrix& A) {
  const Vector diagonal = A.diagonal().cwiseAbs();
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      if (it.row() != j &&
          !(std::abs(it.value()) <= 1e-15 * std::min(diagonal[j], diagonal[it.row()])))
        return false;
  return true;
}

}  // namespace

struct CoupledFactor::Impl {
  const CoupledModel& model;
  const FreeDofs& free;
  double theta;
  std::vector<Vector> weights;  // D^-1 of each part
  Vector diagonal;
  std::optional<Cholesky> dense;
  double dense_pivot = 1;
  std::optional<SparseCholesky> sparse;
  // Workspaces of solve(Vector)
  std::vector<Vector> part_c, part_k;
  Vector y;

  bool factor() {
    SparseMatrix A = sparse_part(model, free, theta);
    if (model.parts.size() == 1 && A.size() == 0) return factor_dense();
    if (model.parts.empty() && is_diagonal(A)) {
      diagonal = A.diagonal();
      return diagonal.size() == 0 || diagonal.minCoeff() > 0;
    }
    return factor_sparse(A);
  }

  bool factor_dense() {
    FreeBlock block = condensed(model.parts[0], free, theta);
    const Index n = free.Z.cols();
    bool ordered = static_cast<Index>(block.dof.size()) == n;
    for (Index i = 0; ordered && i < n; ++i) ordered = block.dof[i] == i;
    if (!ordered) {
      Matrix S = Matrix::Zero(n, n);
      for (std::size_t b = 0; b < block.dof.size(); ++b)
        for (std::size_t a = b; a < block.dof.size(); ++a)
          S(std::max(block.dof[a], block.dof[b]), std::min(block.dof[a], block.dof[b])) =
              block.S(static_cast<Index>(a), static_cast<Index>(b));
      block.S = std::move(S);
    }
    const Vector diagonal_of_S = block.S.diagonal();
    dense.emplace(std::move(block.S));
    if (n > 0 && dense->ok())
      dense_pivot = (dense->diagonal().array().square() / diagonal_of_S.array()).minCoeff();
    return dense->ok();
  }

  bool factor_sparse(const SparseMatrix& A) {
    LowerSum sum(free.Z.cols());
    std::vector<std::vector<Index>> dofs;
    for (const CoupledPart& part : model.parts) {
      dofs.push_back(part.dof);
      if (!free.is_all) rows_of(free.Z, part.dof, dofs.back());
    }
    sum.announce(dofs, A);
    for (const CoupledPart& part : model.parts) sum.add(condensed(part, free, theta));
    sum.add(A);
    sparse.emplace(sum.matrix());
    return sparse->ok();
  }
};

CoupledFactor::CoupledFactor(const CoupledModel& model, const FreeDofs& free, double theta,
                             const std::string& where)
    : impl_(std::make_unique<Impl>(Impl{model, free, theta, {}, {}, {}, 1, {}, {}, {}, {}})) {
  for (const CoupledPart& part : model.parts) {
    const auto lambda = part.superelement->eigenvalues.array();
    impl_->weights.emplace_back(lambda.inverse());
    if (std::isfinite(theta)) impl_->weights.back() = (1 + theta * lambda).inverse();
    impl_->part_c.push_back(Vector::Zero(part.superelement->c()));
    impl_->part_k.push_back(Vector::Zero(part.superelement->k()));
  }
  impl_->y.setZero(free.Z.cols());
  if (!impl_->factor()) {
    throw RunError(where +
                   (theta == 0 ? ": the mass is not positive definite"
                    : std::isfinite(theta)
                        ? ": mass and stiffness of an implicit step are not positive definite"
                        : ": the stiffness is not positive definite"));
  }
}
CoupledFactor::~CoupledFactor() = default;
CoupledFactor::CoupledFactor(CoupledFactor&&) noexcept = default;
CoupledFactor& CoupledFactor::operator=(CoupledFactor&&) noexcept = default;

double CoupledFactor::theta() const { return impl_->theta; }
double CoupledFactor::smallest_pivot() const {
  return impl_->sparse ? impl_->sparse->smallest_pivot() : impl_->dense_pivot;
}
const Vector& CoupledFactor::diagonal() const { return impl_->diagonal; }

void CoupledFactor::solve(Vector& f) const {
  const bool couples = std::isfinite(theta());  // modes and nodes, by the mass
  const Index n_modal = f.size() - impl_->free.Z.rows();
  auto f_c = f.tail(impl_->free.Z.rows());
  Index first = 0;
  for (std::size_t p = 0; p < impl_->weights.size(); ++p) {
    const CoupledPart& part = impl_->model.parts[p];
    const Index k = part.superelement->k();
    if (k == 0) continue;
    // f_k <- D^-1 f_k,  f_c <- f_c - M_kc^T D^-1 f_k
    auto f_k = f.segment(first, k);
    f_k.array() *= impl_->weights[p].array();
    first += k;
    if (!couples) continue;
    Vector& c = impl_->part_c[p];
    c.noalias() = part.superelement->M_kc.transpose() * f_k;
    for (Index i = 0; i < c.size(); ++i) f_c[part.dof[i]] -= c[i];
  }
  Vector& y = impl_->y;
  if (impl_->free.is_all) {
    y = f_c;
  } else {
    y.noalias() = impl_->free.Z.transpose() * f_c;
  }
  if (impl_->diagonal.size() > 0) {
    y.array() /= impl_->diagonal.array();
  } else if (impl_->dense) {
    if (y.size() > 0) impl_->dense->solve_in_place(y);
  } else if (impl_->sparse) {
    impl_->sparse->solve(y.data(), y.data());
  }
  if (impl_->free.is_all) {
    f_c = y;
  } else {
    f_c.noalias() = impl_->free.Z * y;
  }
  first = 0;
  for (std::size_t p = 0; couples && p < impl_->weights.size(); ++p) {
    const CoupledPart& part = impl_->model.parts[p];
    const Index k = part.superelement->k();
    if (k == 0) continue;
    // q_k = D^-1 f_k - D^-1 M_kc u_c
    Vector& c = impl_->part_c[p];
    for (Index i = 0; i < c.size(); ++i) c[i] = f[n_modal + part.dof[i]];
    impl_->part_k[p].noalias() = part.superelement->M_kc * c;
    f.segment(first, k).array() -= impl_->weights[p].array() * impl_->part_k[p].array();
    first += k;
  }
}

void CoupledFactor::solve_free(Eigen::Ref<Matrix> Y) const {
  assert(Y.rows() == impl_->free.Z.cols());
  if (Y.size() == 0) return;
  if (impl_->diagonal.size() > 0) {
    Y.array().colwise() /= impl_->diagonal.array();
  } else if (impl_->dense) {
    impl_->dense->solve_in_place(Y);
  } else if (impl_->sparse) {
    impl_->sparse->solve_in_place(Y);
  }
}

Matrix CoupledFactor::nodal_inverse(const std::vector<Index>& nodes, const Matrix3& T) const {
  const SparseMatrix rows = impl_->free.Z.transpose();
  const Index m = static_cast<Index>(nodes.size());
  Matrix answer(3 * m, 3 * m), Y;
  for (Index first = 0; first < 3 * m; first += solve_columns) {
    const Index columns = std::min(solve_columns, 3 * m - first);
    // Y = S^-1 Z^T [T^T e]   (free x columns)
    Y.setZero(rows.rows(), columns);
    for (Index j = 0; j < columns; ++j) {
      const Index node = nodes[(first + j) / 3];
      for (int d = 0; d < 3; ++d)
        for (SparseMatrix::InnerIterator it(rows, 3 * node + d); it; ++it)
          Y(it.row(), j) += T((first + j) % 3, d) * it.value();
    }
    solve_free(Y);
    for (Index i = 0; i < m; ++i) {
      Matrix local = Matrix::Zero(3, columns);
      for (int d = 0; d < 3; ++d)
        for (SparseMatrix::InnerIterator it(rows, 3 * nodes[i] + d); it; ++it)
          local.row(d) += it.value() * Y.row(it.row());
      answer.block(3 * i, first, 3, columns).noalias() = T * local;
    }
  }
  return 0.5 * (answer + answer.transpose());
}

}  // namespace cbr
