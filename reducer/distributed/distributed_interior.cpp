// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/distributed_interior.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "reducer/distributed/processes.hpp"

namespace cbr {
namespace {

constexpr Index panel_width = 128;
constexpr double round_off = 1e-10;  // as in interior_loads.cpp

// R <- R L^-T with R^T M R = L L^T
void orthonormalise(RigidRows& rigid) {
  const Cholesky cholesky(inner(rigid.R_I, rigid.P_I) + rigid.R_C.transpose() * rigid.P_C);
  if (!cholesky.ok()) throw RunError("the mass of the rigid motions is not positive definite");
  for (Matrix* A : {&rigid.R_I, &rigid.R_C, &rigid.P_I, &rigid.P_C}) cholesky.divide_by_upper(*A);
}

// M R of the own rows, and this process's part of that of the interface
void times_mass(const DistributedInterior& interior, const Matrix& R_I, const Matrix& R_C,
                Matrix& P_I, Matrix& part_C) {
  P_I = interior.solver->times_mass(R_I) + interior.rows.M_IC * R_C;
  part_C = interior.rows.M_IC.transpose() * R_I + interior.rows.M_CC * R_C;
}

Matrix dense(const SparseMatrix& A, Index first, Index width) {
  return Matrix(A.middleCols(first, width));
}

void make_symmetric(Matrix& A) {
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < j; ++i) A(i, j) = A(j, i) = 0.5 * (A(i, j) + A(j, i));
}

// M_kc + (Phi^T P_I - M_kc R_C) G in the first process
void follow(const RigidRows& rigid, const Matrix& M_cc, const Matrix& Phi, Matrix& M_kc) {
  const Matrix content = inner(Phi, rigid.P_I);
  if (M_kc.cols() == 0 || M_cc.rows() == 0 || M_kc.rows() != Phi.cols()) return;
  const Matrix G = (M_cc * rigid.R_C).transpose();
  M_kc += (content - M_kc * rigid.R_C) * G;
}

// Rows of the whole interior, in the order in which processes have them.
std::vector<Index> order_of_rows(const InteriorRows& rows) {
  Vector own(rows.n_own);
  for (Index i = 0; i < rows.n_own; ++i)
    own(i) = static_cast<double>(3 * rows.nodes[static_cast<std::size_t>(i / 3)] + i % 3);
  std::vector<Index> order;
  for (const double row : gather_in_first(own)) order.push_back(static_cast<Index>(row));
  return order;
}

// Columns `first` and up of B, in the first process
void gather_columns(const std::vector<Index>& order, const Matrix& own, Index first, Matrix& B) {
  for (Index j = 0; j < own.cols(); ++j) {
    const Vector all = gather_in_first(own.col(j));
    for (Index i = 0; i < all.size(); ++i)
      B(order[static_cast<std::size_t>(i)], first + j) = all(i);
  }
}

// Psi + (R_I - Psi R_C) G, in the first process
void follow_inside(const DistributedInterior& interior, const Matrix& M_cc, Matrix& Psi) {
  const RigidRows& rigid = interior.rigid;
  Matrix missing = gather_rows(interior.rows, rigid.R_I);
  if (missing.rows() == 0) return;
  missing -= Psi * rigid.R_C;
  Psi.noalias() += missing * (M_cc * rigid.R_C).transpose();
}

}  // namespace

Matrix gather_rows(const InteriorRows& rows, const Matrix& own) {
  const std::vector<Index> order = order_of_rows(rows);
  Matrix all(static_cast<Index>(order.size()), own.cols());
  gather_columns(order, own, 0, all);
  return all;
}

RigidMotions RigidRows::on_interface() const {
  RigidMotions rigid;
  rigid.R_C = R_C.sparseView(0.0, 0.0);
  return rigid;
}

Matrix inner(const Matrix& A, const Matrix& B) { return sum(A.transpose() * B); }

Matrix rigid_inertia(const DistributedInterior& interior, const Vector3& center) {
  const Matrix R_I = rigid_modes(interior.x_I, center), R_C = rigid_modes(interior.x_C, center);
  Matrix P_I, part_C;
  times_mass(interior, R_I, R_C, P_I, part_C);
  return sum(R_I.transpose() * P_I + R_C.transpose() * part_C);
}

RigidRows rigid_rows(const DistributedInterior& interior) {
  const Vector3 middle = interior.x_C.colwise().mean().transpose();
  double size = 0;
  for (const Points* x : {&interior.x_I, &interior.x_C})
    if (x->rows() > 0)
      size = std::max(size, (x->rowwise() - middle.transpose()).rowwise().norm().maxCoeff());
  size = largest(size);
  RigidRows rigid;
  rigid.R_I = rigid_modes(interior.x_I / size, middle / size);
  rigid.R_C = rigid_modes(interior.x_C / size, middle / size);
  Matrix part_C;
  times_mass(interior, rigid.R_I, rigid.R_C, rigid.P_I, part_C);
  rigid.P_C = sum(part_C);
  // the first leaves cond(L) times round-off
  for (int pass = 0; pass < 2; ++pass) orthonormalise(rigid);
  return rigid;
}

ConditionNumbers condition_numbers(const InteriorSolver& solver) {
  const Vector D = solver.diagonal().cwiseSqrt().cwiseInverse(), one = Vector::Ones(D.size());
  const Index n =
      static_cast<Index>(sum(Matrix::Constant(1, 1, static_cast<double>(D.size())))(0, 0));
  std::array<double, 2> norms{};
  for (const bool scaled : {false, true}) {
    const Vector& scale = scaled ? D : one;
    Index here = 0;
    in_first([&] { here = n; });
    InverseNorm search(here);  // the first process's, whose questions all answer
    while (any(!search.is_done())) {
      Matrix x = scatter_from_first(search.asked(), D.size()).cwiseQuotient(scale);
      solver.solve_in_place(x);
      const Vector answer = gather_in_first(Vector(x.col(0)).cwiseQuotient(scale));
      if (here > 0) search.answer(answer);
    }
    norms[scaled ? 1 : 0] =
        (scaled ? solver.scaled_norm() : solver.norm()) * largest(search.norm());
  }
  return {norms[0], norms[1]};
}

ModeCheck check_modes(const InteriorSolver& solver, const Vector& lambda, const Matrix& Phi) {
  if (lambda.size() == 0) return {};
  Vector z(lambda.size());
  for (Index j = 0; j < z.size(); ++j) z(j) = (j * 7919 + j / 3) % 2 == 0 ? 1 : -1;
  const Matrix w = Phi * z.cwiseQuotient(lambda), M_Phi_z = solver.times_mass(Phi * z);
  const Matrix difference = solver.times_stiffness(w) - M_Phi_z;
  ModeCheck check;
  check.orthogonality = Vector(inner(Phi, M_Phi_z) - z).cwiseAbs().maxCoeff(&check.worst);
  check.residual = std::sqrt(inner(difference, difference)(0, 0) / inner(M_Phi_z, M_Phi_z)(0, 0));
  return check;
}

Condensation condense(const DistributedInterior& interior, const Matrix& Phi, bool keep_Psi,
                      Report& report) {
  const InteriorRows& rows = interior.rows;
  const Index c = interior.c();
  Condensation result;
  result.way = CondensationWay::second_solve;
  result.panel = std::min(panel_width, c);
  in_first([&] {
    result.K_cc.resize(c, c);
    result.M_cc.resize(c, c);
    result.M_kc.resize(Phi.cols(), c);
  });
  const std::vector<Index> order = keep_Psi ? order_of_rows(rows) : std::vector<Index>();
  together([&] { result.Psi.resize(static_cast<Index>(order.size()), keep_Psi ? c : 0); });
  const Matrix M_Phi = interior.solver->times_mass(Phi);
  Matrix m = interior.rigid.P_C;
  for (Index first = 0; first < c; first += panel_width) {
    const Index width = std::min(panel_width, c - first);
    report.progress("constraint modes", static_cast<double>(first) / static_cast<double>(c));
    const Matrix M_IC = dense(rows.M_IC, first, width);
    Matrix X = -dense(rows.K_IC, first, width);
    interior.solver->solve_in_place(X);  // Psi of the panel
    if (keep_Psi) gather_columns(order, X, first, result.Psi);
    const Matrix K = sum_to_first(rows.K_IC.transpose() * X + dense(rows.K_CC, first, width));
    const Matrix coupling = sum_to_first(Phi.transpose() * M_IC + M_Phi.transpose() * X);
    m.middleRows(first, width) += inner(X, interior.rigid.P_I);
    // M_cc = M_CC + M_CI Psi - K_CI K_II^-1 (M_IC + M_II Psi)
    Matrix Y = M_IC + interior.solver->times_mass(X);
    interior.solver->solve_in_place(Y);
    const Matrix M = sum_to_first(rows.M_IC.transpose() * X + dense(rows.M_CC, first, width) -
                                  rows.K_IC.transpose() * Y);
    if (K.rows() == 0) continue;
    result.K_cc.middleCols(first, width) = K;
    result.M_cc.middleCols(first, width) = M;
    result.M_kc.middleCols(first, width) = coupling;
  }
  report.end_progress();
  make_symmetric(result.K_cc);
  make_symmetric(result.M_cc);
  in_first([&] {
    result.rigid = follow_rigid_motions(interior.rigid.on_interface(), m, result.K_cc, result.M_cc);
  });
  follow(interior.rigid, result.M_cc, Phi, result.M_kc);
  if (keep_Psi) follow_inside(interior, result.M_cc, result.Psi);
  return result;
}

Matrix mode_coupling(const DistributedInterior& interior, const Matrix& Phi, const Matrix& M_cc) {
  Matrix W = interior.solver->times_mass(Phi);
  interior.solver->solve_in_place(W);
  Matrix M_kc = sum_to_first(
      Matrix(Phi.transpose() * interior.rows.M_IC - W.transpose() * interior.rows.K_IC));
  follow(interior.rigid, M_cc, Phi, M_kc);
  return M_kc;
}

Index add_residual_vectors(const InteriorSolver& solver, const Matrix& F_I,
                           FixedInterfaceModes& modes) {
  const Index k = modes.lambda.size();
  Matrix X = F_I, F = F_I;
  solver.solve_in_place(X);
  const Vector energy = inner(F_I, X).diagonal();
  // X <- X - Phi (Phi^T M_II X) twice; K_II X goes along by M_II Phi Lambda
  for (int pass = 0; pass < 2 && k > 0; ++pass) {
    const Matrix overlap = inner(modes.Phi, solver.times_mass(X));
    X.noalias() -= modes.Phi * overlap;
    F -= solver.times_mass(modes.Phi * Matrix(modes.lambda.asDiagonal() * overlap));
  }
  const Vector scale = energy.unaryExpr([](double e) { return e > 0 ? 1 / std::sqrt(e) : 0.0; });
  X = X * scale.asDiagonal();
  Matrix K = inner(X, F) * scale.asDiagonal();
  make_symmetric(K);
  const SymmetricEigen independent = symmetric_eigen(K);
  std::vector<Index> kept;
  for (Index j = 0; j < K.cols(); ++j)
    if (independent.values(j) > round_off) kept.push_back(j);
  if (kept.empty()) return 0;
  const Vector root = Vector(independent.values(kept)).cwiseSqrt().cwiseInverse();
  // X^T K_II X = 1
  X = X * Matrix(Matrix(independent.vectors(Eigen::all, kept)) * root.asDiagonal());
  const SymmetricEigen ritz = symmetric_eigen(inner(X, solver.times_mass(X)));
  const Vector mu = ritz.values.reverse();  // 1 / lambda, lambda ascending
  const Index r = mu.size();
  modes.lambda.conservativeResize(k + r);
  modes.lambda.tail(r) = mu.cwiseInverse();
  modes.Phi.conservativeResize(Eigen::NoChange, k + r);
  modes.Phi.rightCols(r) = X * Matrix(ritz.vectors.rowwise().reverse()) *
                           Matrix(mu.cwiseSqrt().cwiseInverse().asDiagonal());
  return r;
}

Matrix generalised_forces(const DistributedInterior& interior, const Matrix& F_I, const Matrix& F_C,
                          const Matrix& Phi, const Matrix& M_cc) {
  Matrix X = F_I;
  interior.solver->solve_in_place(X);
  const Matrix F_c = F_C - sum(interior.rows.K_IC.transpose() * X);
  Matrix Q(Phi.cols() + interior.c(), F_I.cols());
  Q << inner(Phi, F_I), F_c;
  const RigidRows& rigid = interior.rigid;
  const Matrix missing = inner(rigid.R_I, F_I) + rigid.R_C.transpose() * (F_C - F_c);
  if (M_cc.rows() > 0) Q.bottomRows(interior.c()) += M_cc * rigid.R_C * missing;  // G^T = M_cc R_C
  return Q;
}

Matrix inertia_forces(const DistributedInterior& interior, const Matrix& M_cc, const Matrix& U) {
  const RigidRows& rigid = interior.rigid;
  const Matrix rigid_part =
      from_first(M_cc.rows() > 0 ? Matrix((M_cc * rigid.R_C).transpose() * U) : Matrix());
  const Matrix rest = U - rigid.R_C * rigid_part;
  Matrix X = interior.rows.K_IC * rest;
  interior.solver->solve_in_place(X);
  return rigid.P_I * rigid_part + interior.rows.M_IC * rest - interior.solver->times_mass(X);
}

LeftOfAnswer left_of_answer(const InteriorSolver& solver,
                            const std::vector<Eigen::Ref<const Matrix>>& modes,
                            const Vector& lambda, const Matrix& residual, Matrix Y) {
  constexpr int passes = 2;
  for (int pass = 0; pass < passes; ++pass)
    for (const auto& Phi : modes) Y -= solver.times_mass(Phi * inner(Phi, Y));
  Matrix X = Y;
  solver.solve_in_place(X);
  for (int pass = 0; pass < passes; ++pass)
    for (const auto& Phi : modes) X -= Phi * inner(Phi, solver.times_mass(X));
  if (residual.cols() > 0)
    X -= residual * Matrix(lambda.cwiseInverse().asDiagonal() * inner(residual, Y));
  LeftOfAnswer left{inner(Y, X), inner(X, solver.times_mass(X))};
  make_symmetric(left.D);
  make_symmetric(left.D_2);
  return left;
}

}  // namespace cbr
