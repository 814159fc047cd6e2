// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation.hpp"

#include <algorithm>

#include "common/error.hpp"

namespace cbr {
namespace {

// Panels of this many columns run at BLAS's own speed.
constexpr Index good_panel = 512;
// A solve with the sparse factor runs at about a fifth of dgemm's rate (docs/decisions/reduction.md).
constexpr double solve_penalty = 5;

// A sparse matrix with more than this share of non-zeros is faster as a dense one: joined domains, sums of dense blocks.
constexpr double dense_share = 0.03;

Matrix product(const SparseMatrix& A, const Eigen::Ref<const Matrix>& X) {
  const double share =
      static_cast<double>(A.nonZeros()) / std::max(1.0, static_cast<double>(A.rows()) * static_cast<double>(A.cols()));
  if (share > dense_share && X.cols() > 1) return Matrix(A) * X;
  return A * X;
}

void symmetrise(Matrix& A) {
  constexpr Index tile = 64;
  for (Index j = 0; j < A.cols(); j += tile) {
    const Index columns = std::min(tile, A.cols() - j);
    for (Index i = j; i < A.rows(); i += tile) {
      const Index rows = std::min(tile, A.rows() - i);
      const Matrix mean = 0.5 * (A.block(i, j, rows, columns) + A.block(j, i, columns, rows).transpose());
      A.block(i, j, rows, columns) = mean;
      A.block(j, i, columns, rows) = mean.transpose();
      if (i == j) A.block(i, j, rows, columns) = 0.5 * (mean + mean.transpose());
    }
  }
}

class Condenser {
 public:
  Condenser(const Partition& p, const SparseCholesky& factor, const Matrix& Phi, const CondensationOptions& options, Report& report)
      : p_(p),
        factor_(factor),
        options_(options),
        report_(report),
        K_CI_(p.K_IC.transpose()),
        M_CI_(p.M_IC.transpose()),
        M_Phi_(product(p.M_II, Phi)) {
    choose();
    result_.K_cc = Matrix(p.K_CC);
    result_.M_cc = Matrix(p.M_CC);
    // Phi^T M_IC   (k x c); the rest is added panel by panel
    result_.M_kc = product(M_CI_, Phi).transpose();
  }

  Condensation run() {
    if (p_.n_interior() == 0) {
      result_.M_kc.resize(0, p_.n_interface());
    } else if (result_.way == CondensationWay::product) {
      whole();
    } else {
      panels();
    }
    symmetrise(result_.K_cc);
    symmetrise(result_.M_cc);
    return std::move(result_);
  }

 private:
  void choose() {
    const auto n_I = static_cast<double>(p_.n_interior()), c = static_cast<double>(p_.n_interface());
    const double whole_bytes = 8 * n_I * c * (p_.lumped && !options_.keep_Psi ? 1 : 2);
    result_.way = options_.way;
    if (result_.way == CondensationWay::automatic) {
      const bool solve_is_cheaper = solve_penalty * 4 * factor_.n_nonzeros() < n_I * c;
      const bool fits = whole_bytes <= options_.memory;
      result_.way = fits && !solve_is_cheaper ? CondensationWay::product : CondensationWay::second_solve;
    }
    const auto fitting = static_cast<Index>(std::min(options_.memory / (32 * std::max(n_I, 1.0)), 1e9));
    result_.panel = std::clamp(options_.panel > 0 ? options_.panel : std::min(good_panel, fitting), Index{1},
                               std::max<Index>(p_.n_interface(), 1));
    if (options_.keep_Psi || result_.way == CondensationWay::product) result_.Psi.resize(p_.n_interior(), p_.n_interface());
  }

  // Columns [first, first + P.cols()) of Psi = -K_II^-1 K_IC   (n_I x panel)
  void constraint_modes(Index first, Eigen::Ref<Matrix> P) {
    P.setZero();
    for (Index j = 0; j < P.cols(); ++j) {
      for (SparseMatrix::InnerIterator it(p_.K_IC, first + j); it; ++it) P(it.row(), j) = -it.value();
    }
    factor_.solve_in_place(P);
    result_.solve_flops += 4 * factor_.n_nonzeros() * static_cast<double>(P.cols());
    report_.progress("constraint modes", static_cast<double>(first + P.cols()) / static_cast<double>(p_.n_interface()));
  }

  // What a panel of Psi adds to K_cc and M_kc.
  void add_linear_terms(Index first, const Eigen::Ref<const Matrix>& P) {
    // K_cc += K_CI Psi   (c x panel)
    result_.K_cc.middleCols(first, P.cols()) += product(K_CI_, P);
    // M_kc += (M_II Phi)^T Psi   (k x panel)
    if (M_Phi_.cols() > 0) result_.M_kc.middleCols(first, P.cols()).noalias() += M_Phi_.transpose() * P;
    result_.product_flops += 2.0 * static_cast<double>(p_.n_interior()) * static_cast<double>(M_Phi_.cols() * P.cols());
  }

  void whole() {
    const Index c = p_.n_interface();
    for (Index j = 0; j < c; j += good_panel) constraint_modes(j, result_.Psi.middleCols(j, std::min(good_panel, c - j)));
    report_.end_progress();
    add_linear_terms(0, result_.Psi);
    if (p_.lumped) {
      lumped_product();
    } else {
      consistent_product();
    }
    result_.product_flops += static_cast<double>(p_.n_interior()) * static_cast<double>(c) * static_cast<double>(c);
    if (!options_.keep_Psi) result_.Psi.resize(0, 0);
  }

  // M_cc = M_CC + S^T S, S = M_II^1/2 Psi   (n_I x c)
  void lumped_product() {
    const Vector root = Vector(p_.M_II.diagonal()).cwiseSqrt();
    Matrix copy;
    if (options_.keep_Psi) copy = result_.Psi;
    Matrix& S = options_.keep_Psi ? copy : result_.Psi;
    S.array().colwise() *= root.array();
    result_.M_cc.selfadjointView<Eigen::Lower>().rankUpdate(S.transpose());
    mirror_lower();
  }

  // M_cc = M_CC + H + H^T + Psi^T (M_II Psi), H = M_CI Psi   (c x c), the product on the lower half only
  void consistent_product() {
    const Index c = p_.n_interface();
    const Matrix H = product(M_CI_, result_.Psi);
    result_.M_cc += H + H.transpose();
    const Matrix Y = product(p_.M_II, result_.Psi);
    for (Index j = 0; j < c; j += good_panel) {
      const Index columns = std::min(good_panel, c - j);
      result_.M_cc.block(j, j, c - j, columns).noalias() += result_.Psi.rightCols(c - j).transpose() * Y.middleCols(j, columns);
    }
    mirror_lower();
  }

  void mirror_lower() { result_.M_cc.triangularView<Eigen::StrictlyUpper>() = result_.M_cc.transpose(); }

  // M_cc = M_CC + M_CI Psi + Psi^T Y, Y = M_IC + M_II Psi, and Psi^T Y = -K_CI K_II^-1 Y: no panel meets another one.
  void panels() {
    const Index c = p_.n_interface();
    Matrix P, Y;
    for (Index j = 0; j < c; j += result_.panel) {
      const Index columns = std::min(result_.panel, c - j);
      P.resize(p_.n_interior(), columns);
      constraint_modes(j, P);
      if (options_.keep_Psi) result_.Psi.middleCols(j, columns) = P;
      add_linear_terms(j, P);
      if (!p_.lumped) result_.M_cc.middleCols(j, columns) += product(M_CI_, P);
      Y = product(p_.M_II, P);
      for (Index i = 0; i < columns; ++i) {
        for (SparseMatrix::InnerIterator it(p_.M_IC, j + i); it; ++it) Y(it.row(), i) += it.value();
      }
      factor_.solve_in_place(Y);
      result_.solve_flops += 4 * factor_.n_nonzeros() * static_cast<double>(columns);
      result_.M_cc.middleCols(j, columns) -= product(K_CI_, Y);
    }
    report_.end_progress();
  }

  const Partition& p_;
  const SparseCholesky& factor_;
  const CondensationOptions& options_;
  Report& report_;
  SparseMatrix K_CI_, M_CI_;  // c x n_I
  Matrix M_Phi_;              // n_I x k
  Condensation result_;
};

}  // namespace

Condensation condense(const Partition& partition, const SparseCholesky& factor, const Matrix& Phi,
                      const CondensationOptions& options, Report& report) {
  return Condenser(partition, factor, Phi, options, report).run();
}

}  // namespace cbr
