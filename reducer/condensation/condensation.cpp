// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/condensation.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "reducer/condensation/panel_product.hpp"

namespace cbr {
namespace {

class Condenser {
 public:
  Condenser(const Partition& p, const SparseCholesky& factor, const Matrix& Phi,
            const CondensationOptions& options, Report& report)
      : p_(p),
        factor_(factor),
        tree_(factor.tree()),
        options_(options),
        report_(report),
        place_(inverse(order())),
        columns_(by_first_row(p.K_IC, place_)),
        K_IC_(reordered(p.K_IC, place_, columns_)),
        M_IC_(reordered(p.M_IC, place_, columns_)),
        M_II_(reordered(p.M_II, place_, order())),
        P_I_(reordered(p.rigid.P_I, place_, first_numbers(p.rigid.count()))),
        Phi_(Phi),
        wanted_(tree_.reach(rows_of(K_IC_.sparse(), 0, p.n_interface()))) {
    if (p.lumped) mass_ = M_II_.sparse().diagonal();
    choose();
    couple(Phi);
  }

  Matrix coupling() {
    if (M_Phi_.cols() > 0) {
      for_panels([&](Index first, Index width, Workspace& work) {
        constraint_modes(first, width, work);
        couple_panel(first, work.X);
      });
    }
    follow_rigid_motions(p_.rigid, p_.rigid.G, p_.rigid.momentum(Phi_), result_.M_kc);
    return std::move(result_.M_kc);
  }

  Condensation run() {
    if (p_.n_interior() > 0 && p_.n_interface() > 0) {
      panels();
      follow();
    } else {
      result_.K_cc = Matrix(p_.K_CC);
      result_.M_cc = Matrix(p_.M_CC);
    }
    return std::move(result_);
  }

 private:
  // Workspace of one thread.
  struct Workspace {
    PanelSolver solver;
    Matrix X, Y, out;  // transposed panels, w x n_I and w x c
    Workspace(const SupernodeTree& tree, Index width) : solver(tree, width) {}
  };

  std::vector<Index> order() const {
    return {tree_.factor().order, tree_.factor().order + p_.n_interior()};
  }

  void choose() {
    const auto n_I = static_cast<double>(p_.n_interior()),
               c = static_cast<double>(p_.n_interface());
    const double whole_bytes = 8 * n_I * c * (p_.lumped && !options_.keep_Psi ? 1 : 2);
    result_.way = options_.way;
    if (result_.way == CondensationWay::automatic || result_.way == CondensationWay::fronts) {
      const double second_flops = tree_.all().flops_per_column + wanted_.flops_per_column;
      const bool solve_is_cheaper = solve_penalty * second_flops < n_I * c;
      const bool fits = whole_bytes <= options_.memory;
      result_.way =
          fits && !solve_is_cheaper ? CondensationWay::product : CondensationWay::second_solve;
    }
    const double column_bytes = 8 * n_I * (p_.lumped ? 1 : 2) * n_threads();
    const auto fitting =
        static_cast<Index>(std::min(options_.memory / std::max(column_bytes, 1.0), 1e9));
    result_.panel = std::clamp(options_.panel > 0 ? options_.panel : std::min(good_panel, fitting),
                               Index{1}, std::max<Index>(p_.n_interface(), 1));
  }

  // M_kc = Phi^T M_IC + (M_II Phi)^T Psi   (k x c). The second term is -W^T K_IC, W = K_II^-1 M_II
  // Phi: k right-hand sides more in the place of a product with all of Psi, where that is cheaper.
  void couple(const Matrix& Phi) {
    const Index k = Phi.cols(), n_I = p_.n_interior(), c = p_.n_interface();
    result_.M_kc = Matrix::Zero(k, c);
    if (k == 0 || c == 0 || n_I == 0) return;
    result_.M_kc = product(SparseMatrix(p_.M_IC.transpose()), Phi).transpose();
    Matrix W = product(p_.M_II, Phi);
    const double solve_flops = 2 * tree_.all().flops_per_column * static_cast<double>(k);
    const double product_flops = 2.0 * static_cast<double>(n_I) * static_cast<double>(k * c);
    if (!options_.one_Psi && solve_penalty * solve_flops < product_flops) {
      factor_.solve_in_place(W);
      result_.M_kc -= product(SparseMatrix(p_.K_IC.transpose()), W).transpose();
      result_.solve_flops += solve_flops;
    } else {
      M_Phi_ = W(order(), Eigen::all);
      result_.product_flops += product_flops;
    }
  }

  template <typename Work>
  void for_panels(const Work& do_one) {
    const Index c = p_.n_interface(), n_panels = (c + result_.panel - 1) / result_.panel;
    std::atomic<Index> next{0};
    {
      const SingleThreadedBlas blas;
      run_threads(static_cast<int>(std::min<Index>(n_threads(), n_panels)), [&](int) {
        Workspace work(tree_, result_.panel);
        for (Index i = next++; i < n_panels; i = next++)
          do_one(i * result_.panel, std::min(result_.panel, c - i * result_.panel), work);
      });
    }
    report_.end_progress();
  }

  void panels() {
    const Index c = p_.n_interface(), n_I = p_.n_interior();
    const bool whole = result_.way == CondensationWay::product;
    if (options_.keep_Psi) result_.Psi.resize(n_I, c);
    if (whole) S_.resize(c, n_I);
    if (whole && !p_.lumped) Y_.resize(c, n_I);
    result_.K_cc.setZero(c, c);
    result_.M_cc.setZero(c, c);
    m_.setZero(c, p_.rigid.count());
    for_panels([&](Index first, Index width, Workspace& work) { do_panel(first, width, work); });
    if (whole) multiply();
    add_upper(p_.K_CC, result_.K_cc);
    add_upper(p_.M_CC, result_.M_cc);
    restore_order(columns_, result_.K_cc);
    restore_order(columns_, result_.M_cc);
  }

  // A_CC, in the order of the panels' columns, into the upper triangle.
  void add_upper(const SparseMatrix& A, Matrix& upper) const {
    const std::vector<Index> rank = inverse(columns_);
    for (Index q = 0; q < A.cols(); ++q) {
      for (SparseMatrix::InnerIterator it(A, q); it; ++it) {
        const Index i = rank[it.row()], j = rank[q];
        if (i <= j) upper(i, j) += it.value();
      }
    }
  }

  void do_panel(Index first, Index width, Workspace& work) {
    constraint_modes(first, width, work);
    const Index left = p_.n_interface() - first;
    // K_cc = K_CC + K_CI Psi: the columns from the panel's own on, as the rest is the other
    // triangle
    work.out.setZero(width, left);
    K_IC_.add(work.X, 1, work.out);
    result_.K_cc.block(first, first, width, left) = work.out;
    if (options_.keep_Psi) keep(first, work.X);
    if (M_Phi_.cols() > 0) couple_panel(first, work.X);
    if (m_.cols() > 0) rigid_panel(first, work.X);
    if (p_.lumped) {
      lumped_mass(first, left, work);
    } else {
      consistent_mass(first, left, work);
    }
  }

  // Columns of Psi = -K_II^-1 K_IC
  void constraint_modes(Index first, Index width, Workspace& work) {
    work.X.setZero(width, p_.n_interior());
    const SparseMatrix& K = K_IC_.sparse();
    for (Index j = 0; j < width; ++j)
      for (SparseMatrix::InnerIterator it(K, first + j); it; ++it)
        work.X(j, it.row()) = -it.value();
    const SupernodeSet reached = tree_.reach(rows_of(K, first, width));
    work.solver.forward(work.X, reached);
    work.solver.backward(work.X, tree_.all());
    const std::scoped_lock lock(lock_);
    result_.solve_flops +=
        static_cast<double>(width) * (reached.flops_per_column + tree_.all().flops_per_column);
    done_ += width;
    report_.progress("constraint modes",
                     static_cast<double>(done_) / static_cast<double>(p_.n_interface()));
  }

  void couple_panel(Index first, const Matrix& X) {
    const Matrix part = M_Phi_.transpose() * X.transpose();
    for (Index j = 0; j < X.rows(); ++j) result_.M_kc.col(columns_[first + j]) += part.col(j);
  }

  // Rows of m = T^T M R = Psi^T (M R)_I + (M R)_C
  void rigid_panel(Index first, const Matrix& X) {
    Matrix rows = Matrix::Zero(X.rows(), m_.cols());
    P_I_.add(X, 1, rows);
    for (Index j = 0; j < X.rows(); ++j) m_.row(columns_[first + j]) = rows.row(j);
  }

  // With Psi + (R_I - Psi R_C) G from here on
  void follow() {
    const RigidMotions& rigid = p_.rigid;
    if (rigid.count() == 0) return;
    m_ += rigid.P_C;
    result_.rigid = follow_rigid_motions(rigid, m_, result_.K_cc, result_.M_cc);
    result_.G = rigid_content(rigid, result_.M_cc);
    follow_rigid_motions(rigid, result_.G, rigid.momentum(Phi_), result_.M_kc);
    if (!options_.keep_Psi) return;
    const Matrix missing = Matrix(rigid.R_I) - result_.Psi * rigid.R_C;
    result_.Psi += missing * result_.G;
  }

  void keep(Index first, const Matrix& X) {
    const Index* order = tree_.factor().order;
    constexpr Index line = 8;
    for (Index j = 0; j < X.rows(); j += line)
      for (Index i = 0; i < X.cols(); ++i)
        for (Index l = j; l < std::min(j + line, X.rows()); ++l)
          result_.Psi(order[i], columns_[first + l]) = X(l, i);
  }

  // M_cc = M_CC + Psi^T M_II Psi: S = M_II^1/2 Psi for the product, or -K_CI K_II^-1 (M_II Psi) at
  // once
  void lumped_mass(Index first, Index left, Workspace& work) {
    if (result_.way == CondensationWay::product) {
      for (Index i = 0; i < work.X.cols(); ++i) work.X.col(i) *= std::sqrt(mass_(i));
      S_.middleRows(first, work.X.rows()) = work.X;
      return;
    }
    for (Index i = 0; i < work.X.cols(); ++i) work.X.col(i) *= mass_(i);
    work.out.setZero(work.X.rows(), left);
    second_solve(first, work.X, work);
  }

  // M_cc = M_CC + Psi^T M_IC + Y^T Psi, Y = M_IC + M_II Psi
  void consistent_mass(Index first, Index left, Workspace& work) {
    work.Y.setZero(work.X.rows(), work.X.cols());
    M_II_.add(work.X, 1, work.Y);
    for (Index j = 0; j < work.X.rows(); ++j)
      for (SparseMatrix::InnerIterator it(M_IC_.sparse(), first + j); it; ++it)
        work.Y(j, it.row()) += it.value();
    work.out.setZero(work.X.rows(), left);
    M_IC_.add(work.X, 1, work.out);
    if (result_.way == CondensationWay::product) {
      result_.M_cc.block(first, first, work.X.rows(), left) = work.out;
      S_.middleRows(first, work.X.rows()) = work.X;
      Y_.middleRows(first, work.X.rows()) = work.Y;
      return;
    }
    second_solve(first, work.Y, work);
  }

  // M_cc += out - (K_II^-1 Y)^T K_IC, of which only the rows of the solution are computed that K_IC
  // has
  void second_solve(Index first, Matrix& Y, Workspace& work) {
    work.solver.forward(Y, tree_.all());
    work.solver.backward(Y, wanted_);
    K_IC_.add(Y, -1, work.out);
    result_.M_cc.block(first, first, Y.rows(), work.out.cols()) = work.out;
    const std::scoped_lock lock(lock_);
    result_.solve_flops +=
        static_cast<double>(Y.rows()) * (tree_.all().flops_per_column + wanted_.flops_per_column);
  }

  // M_cc += Y^T Psi, or S^T S, on one triangle   (c x c)
  void multiply() {
    const Index c = p_.n_interface();
    const double flops =
        static_cast<double>(p_.n_interior()) * static_cast<double>(c) * static_cast<double>(c);
    const LargeBlasWork blas(flops);
    if (p_.lumped) {
      result_.M_cc.selfadjointView<Eigen::Upper>().rankUpdate(S_);
    } else {
      constexpr Index block = 512;
      for (Index j = 0; j < c; j += block) {
        const Index columns = std::min(block, c - j);
        result_.M_cc.block(0, j, j + columns, columns).noalias() +=
            Y_.topRows(j + columns) * S_.middleRows(j, columns).transpose();
      }
    }
    result_.product_flops += flops;
    S_.resize(0, 0);
    Y_.resize(0, 0);
  }

  const Partition& p_;
  const SparseCholesky& factor_;
  const SupernodeTree& tree_;
  const CondensationOptions& options_;
  Report& report_;
  // of the interior's rows in the order of elimination; the order of the panels' columns
  std::vector<Index> place_, columns_;
  PanelProduct K_IC_, M_IC_, M_II_;  // in these orders
  PanelProduct P_I_;                 // (M R)_I, its rows in this order
  const Matrix& Phi_;
  SupernodeSet wanted_;  // of a solution, read by K_CI
  Vector mass_;          // lumped: the diagonal of M_II
  // n_I x k, in the order of elimination; empty when M_kc has been found by a solve
  Matrix M_Phi_;
  Matrix S_, Y_;  // c x n_I, for the product
  Matrix m_;      // c x r, T^T M R of the rigid motions
  std::mutex lock_;
  Index done_ = 0;
  Condensation result_;
};

}  // namespace

Condensation condense(const Partition& partition, const SparseCholesky& factor, const Matrix& Phi,
                      const CondensationOptions& options, Report& report) {
  return Condenser(partition, factor, Phi, options, report).run();
}

Condensation complete(const Partition& p, const SparseCholesky& factor, const Matrix& Phi,
                      Condensed&& condensed) {
  Condensation result;
  result.way = CondensationWay::fronts;
  result.front_flops = condensed.flops;
  result.K_cc = std::move(condensed.K);
  result.M_cc = std::move(condensed.M);
  const Index k = Phi.cols(), r = p.rigid.count();
  // [M_II Phi, (M R)_I], and Psi^T of it   (n_I x (k + r), c x (k + r))
  Matrix W(p.n_interior(), k + r);
  W.leftCols(k) = product(p.M_II, Phi);
  W.rightCols(r) = p.rigid.P_I;
  factor.solve_in_place(W);
  const Matrix T = -product(SparseMatrix(p.K_IC.transpose()), W);
  result.solve_flops = 2 * factor.tree().all().flops_per_column * static_cast<double>(k + r);
  result.M_kc = T.leftCols(k).transpose();
  if (p.M_IC.nonZeros() > 0)
    result.M_kc += product(SparseMatrix(p.M_IC.transpose()), Phi).transpose();
  const Matrix m = Matrix(p.rigid.P_C) + T.rightCols(r);
  result.rigid = follow_rigid_motions(p.rigid, m, result.K_cc, result.M_cc);
  result.G = rigid_content(p.rigid, result.M_cc);
  follow_rigid_motions(p.rigid, result.G, p.rigid.momentum(Phi), result.M_kc);
  return result;
}

Matrix mode_coupling_of_one_Psi(const Partition& p, const SparseCholesky& factor, const Matrix& Phi,
                                const CondensationOptions& options, Report& report) {
  if (Phi.cols() == 0 || p.n_interface() == 0 || p.n_interior() == 0)
    return Matrix::Zero(Phi.cols(), p.n_interface());
  CondensationOptions one = options;
  one.one_Psi = true;
  return Condenser(p, factor, Phi, one, report).coupling();
}

Matrix mode_coupling(const Interior& interior, const Matrix& Phi) {
  const Partition& p = interior.p;
  if (Phi.cols() == 0 || p.n_interface() == 0) return Matrix::Zero(Phi.cols(), p.n_interface());
  Matrix W = interior.times_mass(Phi);
  interior.solve_in_place(W);
  Matrix M_kc = interior.sum(p.M_IC.transpose() * Phi - p.K_IC.transpose() * W).transpose();
  follow_rigid_motions(p.rigid, p.rigid.G, interior.sum(p.rigid.momentum(Phi)), M_kc);
  return M_kc;
}

double half_of_memory() { return 0.5 * machine_memory_bytes(); }

void require_memory_for_interface(Index c, double memory) {
  const double bytes = 16.0 * static_cast<double>(c) * static_cast<double>(c);
  if (bytes <= memory) return;
  throw InputError("the interface has " + std::to_string(c) +
                   " dofs, whose dense mass and stiffness take " + human_bytes(bytes) +
                   ", the machine has " + human_bytes(memory) +
                   ": keep fewer faces, or use instances as: mesh");
}

double panel_memory(double given, const Partition& p, const SparseCholesky& factor,
                    const Matrix& Phi) {
  if (given > 0) return given;
  const auto c = static_cast<double>(p.n_interface());
  const double held = factor.bytes() + 32 * static_cast<double>(p.M_II.nonZeros()) +
                      8 * static_cast<double>(Phi.size()) + 32 * c * c;
  // Some is given in any case: without panels nothing goes
  const double all = machine_memory_bytes();
  return std::min(0.5 * all, std::max(0.05 * all, 0.85 * all - held));
}

}  // namespace cbr
