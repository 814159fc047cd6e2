// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/characteristic/free_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/condensation/panel_product.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

constexpr Index large_interface = 1500;  // dofs: below, dense matrices of it cost little
constexpr Index most_kept = 300;         // dofs with a coordinate each, of which each takes a solve
constexpr double twin = 1e-6;            // relative distance of two equal eigenvalues
constexpr double singular_whole = 1e-13;
// of a shape's mass: with a smaller remainder it is in the span of the others
constexpr double least_part = 1e-10;
constexpr Index largest_dense = 15000;

// Solves of the free component, inertia in balance with the loads, no rigid motion in the answers.
class FreeSolver {
 public:
  FreeSolver(const SparseCholesky& factor, const Matrix& N, const Matrix& P)
      : factor_(factor), N_(N), P_(P) {}

  // (1 - N P^T) K^-1 (1 - P N^T) B
  Matrix operator()(Matrix B) const {
    const Matrix force = N_.transpose() * B;
    B.noalias() -= P_ * force;
    factor_.solve_in_place(B);
    const Matrix motion = P_.transpose() * B;
    B.noalias() -= N_ * motion;
    return B;
  }

  // B^T (1 - N P^T) K^-1 (1 - P N^T) B X   (s x q)
  Matrix answers(const SparseMatrix& B, const Matrix& X, const Progress& progress) const {
    constexpr Index at_once = 64;
    Matrix Y(X.rows(), X.cols());
    for (Index j = 0; j < X.cols(); j += at_once) {
      const Index n = std::min(at_once, X.cols() - j);
      progress(static_cast<double>(j) / static_cast<double>(X.cols()));
      Y.middleCols(j, n) = B.transpose() * (*this)(B * X.middleCols(j, n));
    }
    return Y;
  }

  // B^T (1 - N P^T) K^-1 (1 - P N^T) B: with r = B^T N and g = B^T K^-1 P
  //   B^T K^-1 B - r g^T - g r^T + r (P^T K^-1 P) r^T   (s x s)
  Matrix compliance(const SparseMatrix& B) const {
    Matrix C = reached_compliance(factor_, B);
    const Matrix Y = factor_.solve(P_), r = B.transpose() * N_, g = B.transpose() * Y;
    const Matrix h = 0.5 * r * (P_.transpose() * Y) - g;
    C.noalias() += r * h.transpose();
    C.noalias() += h * r.transpose();
    return 0.5 * (C + C.transpose());
  }

 private:
  const SparseCholesky& factor_;
  const Matrix &N_, &P_;
};

// Static forces on the component's dofs   (N x s)
SparseMatrix loads_of(const StaticShare& forces, const Partition& p, const Superelement& s,
                      Index n_dofs) {
  SparseMatrix places(n_dofs, s.c());
  places.reserve(Eigen::VectorXi::Ones(s.c()));
  for (Index i = 0; i < s.c(); ++i) places.insert(p.interface_rows[i], i) = 1;
  return places * forces_on_dofs(forces, s);
}

// Rows of the interface's dofs at their places in the component   (N x columns)
Matrix of_component(const Matrix& B, const Partition& p, Index n_dofs) {
  Matrix all = Matrix::Zero(n_dofs, B.cols());
  all(p.interface_rows, Eigen::all) = B;
  return all;
}

std::vector<Index> kept_dofs(const CharacteristicOptions& options, const Superelement& s) {
  const std::vector<char> is_kept = kept_nodes(options, s);
  std::vector<Index> dofs;
  for (Index i = 0; i < s.c(); ++i)
    if (is_kept[s.dof_node[i]] != 0) dofs.push_back(i);
  return dofs;
}

// uniform_loads() on each of the surfaces   (c x tractions)
Matrix loads_of_surfaces(const CharacteristicOptions& options, const Superelement& s) {
  const std::vector<const Surface*> surfaces = pressed_surfaces(options, kept_nodes(options, s), s);
  const Index of_each = options.shear ? 3 : 1;
  Matrix B(s.c(), of_each * static_cast<Index>(surfaces.size()));
  for (Index f = 0; f * of_each < B.cols(); ++f)
    B.middleCols(f * of_each, of_each) = uniform_loads(s, *surfaces[f], options.shear);
  return B;
}

// The lowest elastic modes of the free component: shapes, which only span a space, and frequencies.
Eigenpairs free_modes(const FreeComponent& model, const SparseCholesky& factor, const Matrix& N,
                      Index count, Report& report) {
  const Index n = N.rows();
  Eigenpairs pairs;
  if (!dense_is_faster(n, count, factor.n_nonzeros())) {
    pairs = sparse_eigenpairs_beyond(model.M, factor, N, count, basis_residual, [&](double share) {
      report.progress("shapes of the interface", share);
    });
  }
  if (!pairs.converged && n <= largest_dense) {
    pairs = dense_eigenpairs_beside(Matrix(model.K), Matrix(model.M), N, N.cols() + count);
    pairs.lambda = Vector(pairs.lambda.tail(pairs.lambda.size() - N.cols()));
    pairs.Phi = Matrix(pairs.Phi.rightCols(pairs.lambda.size()));
  }
  if (!pairs.converged)
    throw RunError(
        "the elastic modes of the free component could not be found: ask for a few more or fewer");
  return pairs;
}

// Shapes of unit displacements at kept dofs: Y (e_a^T Y)^-1 of the answers Y to unit forces there
// (N x a)
Matrix kept_shapes(const FreeSolver& solve, const std::vector<Index>& dofs, Index n_dofs) {
  Matrix E = Matrix::Zero(n_dofs, static_cast<Index>(dofs.size()));
  for (std::size_t i = 0; i < dofs.size(); ++i) E(dofs[i], static_cast<Index>(i)) = 1;
  const Matrix Y = solve(std::move(E));
  const Matrix F = Y(dofs, Eigen::all);
  return Ldlt(0.5 * (F + F.transpose())).solve(Matrix(Y.transpose())).transpose();
}

ComplianceProbes probes_of(const StaticShare& forces, const Superelement& s) {
  const std::set<Index> nodes(forces.node.begin(), forces.node.end());
  return {s.coordinates(forces.node, Eigen::all), forces.direction,
          static_cast<double>(forces.size()) / static_cast<double>(nodes.size())};
}

// Columns of a Gram matrix G that no others before them span.
std::vector<Index> independent(const Matrix& G) {
  const Vector size = G.diagonal().cwiseMax(0.0).cwiseSqrt();
  Matrix L = Matrix::Zero(G.rows(), G.rows());  // row j: of the j-th that is kept, all columns
  std::vector<Index> kept;
  for (Index j = 0; j < G.rows(); ++j) {
    if (!(size(j) > 0)) continue;
    const auto m = static_cast<Index>(kept.size());
    const Vector row = L.topRows(m).col(j);
    const double pivot = 1 - row.squaredNorm();
    if (!(pivot > least_part)) continue;
    const Vector scaled =
        G.row(j).transpose().cwiseQuotient(size * size(j)).unaryExpr([](double v) {
          return std::isfinite(v) ? v : 0.0;
        });
    L.row(m) = (scaled - L.topRows(m).transpose() * row).transpose() / std::sqrt(pivot);
    kept.push_back(j);
  }
  return kept;
}

}  // namespace

bool few_enough(const CharacteristicOptions& options, bool one_part, Index n_interior,
                const Superelement& s) {
  if (!one_part || n_interior == 0 || s.c() <= large_interface) return false;
  const auto n_kept = static_cast<Index>(kept_dofs(options, s).size());
  return n_kept <= most_kept && n_kept < s.c();
}

std::optional<FreeShapes> free_shapes(const CharacteristicOptions& options,
                                      const FreeComponent& model, const FreeFactor& factor,
                                      const Partition& p, const StaticShare& forces,
                                      const Superelement& s, Report& report, Index most_dense) {
  if (!factor.whole.ok() || factor.whole.smallest_pivot() < singular_whole) return {};
  FreeShapes shapes;
  const Index n = model.K.rows();
  shapes.N = factor.N;
  shapes.P = factor.P;
  std::vector<Index> kept;
  for (const Index dof : kept_dofs(options, s)) kept.push_back(p.interface_rows[dof]);
  const Matrix uniform = of_component(loads_of_surfaces(options, s), p, n);
  const Index n_reduced = s.c() - static_cast<Index>(kept.size());
  const Index n_elastic = n_shapes(options, n_reduced - shapes.N.cols());
  require_fewer(shapes.N.cols() + n_elastic, n_reduced);
  const FreeSolver solve(factor.whole, shapes.N, shapes.P);
  report.progress("shapes of the interface", 0);
  const Index looked_at = std::min(std::max(n_elastic + 1, n_estimated), n - shapes.N.cols());
  Eigenpairs modes = free_modes(model, factor.whole, shapes.N, looked_at, report);
  shapes.lambda = std::move(modes.lambda);
  Index m = std::min(n_elastic, shapes.lambda.size());
  while (m > 0 && m < shapes.lambda.size() &&
         shapes.lambda(m) - shapes.lambda(m - 1) < twin * shapes.lambda(m))
    ++m;
  shapes.n_modes = m;
  shapes.n_kept = static_cast<Index>(kept.size());
  shapes.n_uniform = uniform.cols();
  const std::vector<char> is_kept = kept_nodes(options, s);
  shapes.bare = sets_without_statics(options, is_kept, s);
  const Matrix loads = load_columns(options, is_kept, s);
  shapes.n_loads = loads.cols();
  shapes.U.resize(n, m + shapes.n_kept + shapes.n_uniform + shapes.n_loads);
  shapes.U.leftCols(m) = modes.Phi.leftCols(m);
  if (shapes.n_kept > 0) shapes.U.middleCols(m, shapes.n_kept) = kept_shapes(solve, kept, n);
  if (shapes.n_uniform > 0)
    shapes.U.middleCols(m + shapes.n_kept, shapes.n_uniform) = solve(uniform);
  if (shapes.n_loads > 0) shapes.U.rightCols(shapes.n_loads) = solve(of_component(loads, p, n));
  const SparseMatrix B = loads_of(forces, p, s, n);
  if (forces.size() > most_dense) {
    shapes.probes = probes_of(forces, s);
    shapes.compliance = solve.answers(B, shapes.probes->loads(), [&](double share) {
      report.progress("compliance of the faces that touch", share);
    });
  } else if (!forces.empty()) {
    shapes.compliance = solve.compliance(B);
  }
  if (shapes.n_loads + shapes.n_kept > 0) shapes.pushed = B.transpose() * shapes.N;
  report.end_progress();
  if (shapes.lambda.size() > 0 && !(shapes.lambda(0) > 0)) return {};
  return shapes;
}

void follow_statically(const Partition& p, const SparseCholesky& factor, FreeShapes& shapes) {
  const std::vector<Index>&I = p.interior_rows, &C = p.interface_rows;
  const Matrix U_C = shapes.U(C, Eigen::all);
  Matrix U_I = -(p.K_IC * U_C);
  factor.solve_in_place(U_I);
  // No force of K is left inside
  shapes.K_U.setZero(shapes.U.rows(), shapes.U.cols());
  shapes.K_U(C, Eigen::all) = p.K_CC * U_C + p.K_IC.transpose() * U_I;
  shapes.M_U.resize(shapes.U.rows(), shapes.U.cols());
  shapes.M_U(C, Eigen::all) = p.M_CC * U_C + p.M_IC.transpose() * U_I;
  shapes.M_U(I, Eigen::all) = p.M_II * U_I + p.M_IC * U_C;
  shapes.U(I, Eigen::all) = U_I;
  if (shapes.pushed.size() > 0) {
    const Matrix P_I = shapes.P(I, Eigen::all);
    shapes.inertia = P_I.transpose() * factor.solve(P_I);
  }
  const Matrix rigid = shapes.P.transpose() * shapes.U;
  shapes.U.noalias() -= shapes.N * rigid;
  shapes.M_U.noalias() -= shapes.P * rigid;
}

Matrix coupling_of_eigenvectors(const Partition& p, const Vector& lambda, const Matrix& Phi) {
  Matrix coupling = product(SparseMatrix(p.M_IC.transpose()), Phi).transpose();
  coupling -= lambda.cwiseInverse().asDiagonal() *
              product(SparseMatrix(p.K_IC.transpose()), Phi).transpose();
  return coupling;
}

CharacteristicFigures take_free_shapes(const FreeShapes& shapes, const Vector& lambda,
                                       const Matrix& Phi, const Partition& p, Superelement& s,
                                       Matrix* interior) {
  const std::vector<Index>&I = p.interior_rows, &C = p.interface_rows;
  const Index r = shapes.U.cols(), k = lambda.size(), n_rigid = shapes.N.cols();
  // Phi - N c has no rigid motion in it, c = P_I^T Phi   (6 x k)
  const Matrix c = Matrix(shapes.P(I, Eigen::all)).transpose() * Phi;
  Matrix M(r + k, r + k), K(r + k, r + k);
  M.topLeftCorner(r, r) = shapes.U.transpose() * shapes.M_U;
  K.topLeftCorner(r, r) = shapes.U.transpose() * shapes.K_U;
  M.topRightCorner(r, k) = Matrix(shapes.M_U(I, Eigen::all)).transpose() * Phi;
  K.topRightCorner(r, k).setZero();  // as K_U has none inside
  M.bottomRightCorner(k, k) = Matrix::Identity(k, k) - c.transpose() * c;
  K.bottomRightCorner(k, k) = Matrix(lambda.asDiagonal());
  M.triangularView<Eigen::StrictlyLower>() = M.transpose();
  K.triangularView<Eigen::StrictlyLower>() = K.transpose();
  const std::vector<Index> kept = independent(M);
  const auto e = static_cast<Index>(kept.size());
  const Matrix M_kept = M(kept, kept);
  const Eigenpairs pairs = dense_eigenpairs(Matrix(K(kept, kept)), M_kept, e);
  if (!pairs.converged)
    throw RunError("the interface's shapes and the fixed-interface modes are not independent");
  Matrix y = Matrix::Zero(r + k, e);
  y(kept, Eigen::all) = pairs.Phi;
  const Matrix rigid = c * y.bottomRows(k);
  s.eigenvalues = Vector::Zero(n_rigid + e);
  s.eigenvalues.tail(e) = pairs.lambda.cwiseMax(0.0);
  Matrix& V = s.characteristic.V;
  V.resize(s.c(), n_rigid + e);
  V.leftCols(n_rigid) = shapes.N(C, Eigen::all);
  V.rightCols(e) =
      Matrix(shapes.U(C, Eigen::all)) * y.topRows(r) - Matrix(shapes.N(C, Eigen::all)) * rigid;
  if (interior != nullptr) {
    interior->resize(static_cast<Index>(I.size()), n_rigid + e);
    interior->leftCols(n_rigid) = shapes.N(I, Eigen::all);
    interior->rightCols(e) =
        Matrix(shapes.U(I, Eigen::all)) * y.topRows(r) - Matrix(shapes.N(I, Eigen::all)) * rigid;
    interior->rightCols(e).noalias() += Phi * y.bottomRows(k);
  }
  StaticShare& share = s.characteristic.statics;
  Matrix compliance = shapes.compliance;
  // As make_characteristic(): strain under inertia as the fixed-interface modes have it
  if (shapes.pushed.size() > 0) {
    const Matrix strain = shapes.inertia - c * lambda.cwiseInverse().asDiagonal() * c.transpose();
    Matrix pushed = shapes.pushed.transpose();
    if (shapes.probes) pushed = pushed * shapes.probes->loads();
    compliance.noalias() -= shapes.pushed * (strain * pushed);
  }
  if (shapes.probes)
    share.levels = shapes.probes->levels(
        answers_that_are_left(std::move(compliance), shapes.probes->loads(), share, n_rigid, s));
  else if (!share.empty())
    share.F = compliance_that_is_left(std::move(compliance), share, n_rigid, s);
  CharacteristicFigures figures;
  figures.n_fixed = k;
  figures.n_rigid = n_rigid;
  figures.n_modes = shapes.n_modes;
  figures.n_kept = shapes.n_kept;
  figures.n_dropped = r + k - e;
  figures.n_uniform = shapes.n_uniform;
  figures.n_loads = shapes.n_loads;
  figures.bare = shapes.bare;
  figures.free_modes = true;
  if (shapes.n_modes > 0) figures.highest = std::sqrt(shapes.lambda(shapes.n_modes - 1));
  Superelement of_shapes;
  of_shapes.dof_node.resize(kept.size());
  of_shapes.M_cc = M_kept;
  figures.mass = reduced_mass_condition(of_shapes);
  return figures;
}

}  // namespace cbr
