// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/characteristic/characteristic.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"
#include "reducer/modes/diagonal_form.hpp"

namespace cbr {
namespace {

// of a response's length: a smaller remainder is in the span of the basis
constexpr double least_left = 1e-5;
constexpr double rigid_in_span = 1e-8;  // of rigid motions, in the span of the shapes
constexpr const char* the_shapes = "the interface's shapes";

[[noreturn]] void fail(const std::string& what) { throw InputError("characteristic." + what); }

// Names the keepers of nodes: "characteristic.keep (left), and what the scene holds, ties or makes
// rigid (right)".
std::string keepers(const CharacteristicOptions& options) {
  std::string text;
  if (!options.keep.empty()) text = "characteristic.keep (" + join(options.keep) + ")";
  if (!options.needs.held.empty())
    text += (text.empty() ? "" : ", and ") +
            std::string("what the scene holds, ties or makes rigid (") + join(options.needs.held) +
            ")";
  return text;
}

// Dofs of the kept nodes, and the others.
std::pair<std::vector<Index>, std::vector<Index>> split(const Superelement& s,
                                                        const std::vector<char>& is_kept) {
  std::pair<std::vector<Index>, std::vector<Index>> dofs;
  for (Index i = 0; i < s.c(); ++i)
    (is_kept[s.dof_node[i]] != 0 ? dofs.first : dofs.second).push_back(i);
  return dofs;
}

// B <- (L L^T)^-1 B
void solve_cholesky(const Matrix& L, Matrix& B) {
  L.triangularView<Eigen::Lower>().solveInPlace(B);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(B);
}

void require_found(const Eigenpairs& pairs) {
  if (!pairs.converged)
    throw RunError(
        "the characteristic constraint modes could not be found: is the mass of the interface "
        "definite?");
}

// Of all of the interface: rigid motions R and the lowest elastic modes, K_cc X = M_cc X mu   (c x
// (r + modes))
Matrix shapes_of_all(const Superelement& s, Index modes, const Matrix& R,
                     CharacteristicFigures& figures) {
  const Index r = R.cols();
  figures.n_rigid = r;
  figures.n_modes = modes;
  require_fewer(r + modes, s.c());
  Matrix T(s.c(), r + modes);
  T.leftCols(r) = R;
  if (modes == 0) return T;
  // Beside the rigid motions: a mechanism has their frequency, and would be cut in two with them
  const Eigenpairs pairs = dense_eigenpairs_beside(s.K_cc, s.M_cc, R, r + modes);
  require_found(pairs);
  figures.highest = std::sqrt(std::max(pairs.lambda(r + modes - 1), 0.0));
  Matrix X = pairs.Phi.rightCols(modes);
  for (int pass = 0; pass < 2; ++pass) X -= R * ((s.M_cc * R).transpose() * X).eval();
  orthonormalise(s.M_cc, X, the_shapes);
  T.rightCols(modes) = X;
  return T;
}

// Psi + (R_b - Psi R_a) R_a^+: corrects round-off of K_bb^-1, so that rigid motions R   (c x r) are
// exact.
void follow_rigid_motions(const Matrix& R_a, const Matrix& R_b, Matrix& Psi) {
  const PivotedQr qr(R_a);
  if (qr.rank() < R_a.cols()) return;
  const Matrix missing = R_b - Psi * R_a;
  Psi.noalias() += missing * qr.solve(Matrix::Identity(R_a.rows(), R_a.rows()));
}

// Constraint and fixed-interface modes of the interface, with the kept dofs a as its boundary: [I
// 0; -K_bb^-1 K_ba X], K_bb X = M_bb X mu   (c x (a + modes))
Matrix shapes_beside_kept(const Superelement& s, const CharacteristicOptions& options,
                          const std::vector<Index>& a, const std::vector<Index>& b, const Matrix& R,
                          CharacteristicFigures& figures) {
  const auto n_a = static_cast<Index>(a.size()), n_b = static_cast<Index>(b.size());
  const Index modes = n_shapes(options, n_b);
  figures.n_kept = n_a;
  figures.n_modes = modes;
  if (n_b == 0)
    throw InputError(
        "basis: characteristic: nothing is left to reduce: every node of the interface is kept "
        "by " +
        keepers(options) + ": use basis: craig-bampton");
  require_fewer(modes, n_b);
  Matrix K = s.K_cc(b, b);
  const Matrix K_bb = K;
  const double stiffest = K.diagonal().maxCoeff();
  if (!dense_cholesky(K) || K.diagonal().cwiseAbs2().minCoeff() < 1e-13 * stiffest)
    throw InputError("basis: characteristic: the nodes that are kept by " + keepers(options) +
                     " do not hold the others: keep three or more that are not on one line, of "
                     "each part (characteristic.keep)");
  Matrix Psi = -s.K_cc(b, a);
  solve_cholesky(K, Psi);
  follow_rigid_motions(R(a, Eigen::all), R(b, Eigen::all), Psi);
  Matrix T = Matrix::Zero(s.c(), n_a + modes);
  for (Index i = 0; i < n_a; ++i) T(a[i], i) = 1;
  T(b, Eigen::seqN(0, n_a)) = Psi;
  if (modes == 0) return T;
  const Eigenpairs pairs = dense_eigenpairs(K_bb, Matrix(s.M_cc(b, b)), modes);
  require_found(pairs);
  figures.highest = std::sqrt(std::max(pairs.lambda(modes - 1), 0.0));
  T(b, Eigen::lastN(modes)) = pairs.Phi;
  return T;
}

// Static answers to loads (c x m) with the kept nodes held, which move as T has it.
Matrix answers_beside_kept(const Superelement& s, const std::vector<Index>& b,
                           const Matrix& loads) {
  Matrix K = s.K_cc(b, b), of_b = loads(b, Eigen::all), answers = Matrix::Zero(s.c(), loads.cols());
  if (!dense_cholesky(K)) return answers;  // which shapes_beside_kept() has refused
  solve_cholesky(K, of_b);
  answers(b, Eigen::all) = of_b;
  return answers;
}

// Static responses of a free interface, loads being balanced by the inertia of its rigid motions R,
// R^T M_cc R = I.
class Statics {
 public:
  Statics(const Superelement& s, const Matrix& R)
      : R_(R), P_(s.M_cc * R), held_(hold_rigid_motions(s.K_cc, R)) {
    if (!dense_cholesky(held_.K))
      fail(
          "statics: the interface moves without strain in more ways than as a rigid body, or is "
          "too thin for a double: mend the "
          "mesh, or use less flat elements, or use basis: craig-bampton");
  }

  Matrix in_equilibrium(const Matrix& B) const { return B - P_ * (R_.transpose() * B); }

  Matrix solve(Matrix B) const {
    solve_cholesky(held_.K, B);
    return B;
  }

  // Of the component under forces B on its interface in balance with inertia; Q is the interior's:
  //   f^T K_cc^+ f + (R^T B)^T Q R^T B,   f = B - P R^T B   (m x m)
  Matrix compliance(const Matrix& B, const Matrix& Q) const {
    Matrix f = in_equilibrium(B);
    held_.K.triangularView<Eigen::Lower>().solveInPlace(f);
    Matrix C = Matrix::Zero(B.cols(), B.cols());
    C.selfadjointView<Eigen::Lower>().rankUpdate(f.transpose());
    const Matrix r = R_.transpose() * B;
    C += r.transpose() * Q * r;
    mirror_lower(C);
    return C;
  }

 private:
  Matrix R_, P_;
  HeldStiffness held_;  // K: its Cholesky factor
};

// Orthonormalises U against T and itself in M's product, and appends the independent rest. T need
// not be orthonormal.
Index append(const Matrix& M, const Matrix& U, Matrix& T) {
  Matrix Q = T;
  orthonormalise(M, Q, the_shapes);
  Index kept = 0;
  for (Index j = 0; j < U.cols(); ++j) {
    Vector u = U.col(j);
    const double length = std::sqrt(u.dot(M * u));
    if (!(length > 0)) continue;
    u /= length;
    for (int pass = 0; pass < 2; ++pass) u -= Q * (Q.transpose() * (M * u));
    const double left = std::sqrt(u.dot(M * u));
    if (!(left > least_left)) continue;
    u /= left;
    Q.conservativeResize(Eigen::NoChange, Q.cols() + 1);
    T.conservativeResize(Eigen::NoChange, T.cols() + 1);
    Q.rightCols(1) = T.rightCols(1) = u;
    ++kept;
  }
  return kept;
}

// Responses U = F P B to the uniform pressure, or to uniform tractions along three axes.
void add_uniform(const Surface& surface, bool shear, const Statics& statics, const Superelement& s,
                 Matrix& T, CharacteristicFigures& figures) {
  const Matrix B = uniform_loads(s, surface, shear);
  const Index kept = append(s.M_cc, statics.solve(statics.in_equilibrium(B)), T);
  figures.n_uniform += kept;
  figures.n_dropped += B.cols() - kept;
}

// inertia_of() as far as the fixed-interface modes have it: their share of P_I^T K_II^-1 P_I of R.
Matrix inertia_in_modes(const Superelement& s, const Matrix& R) {
  const Matrix pushed = s.M_kc * R;
  return pushed.transpose() * s.eigenvalues.cwiseInverse().asDiagonal() * pushed;
}

// Superelement in the coordinates [k; those of T], which stand in the place of the interface's
// dofs.
Superelement in_shapes(const Superelement& s, const Matrix& T) {
  Superelement t;
  t.eigenvalues = s.eigenvalues;
  t.K_cc = T.transpose() * (s.K_cc * T);
  t.M_cc = T.transpose() * (s.M_cc * T);
  t.K_cc = 0.5 * (t.K_cc + t.K_cc.transpose()).eval();
  t.M_cc = 0.5 * (t.M_cc + t.M_cc.transpose()).eval();
  t.M_kc.resize(s.k(), T.cols());
  if (s.k() > 0) t.M_kc.noalias() = s.M_kc * T;
  t.dof_node.assign(T.cols(), 0);
  return t;
}

// Coordinates of the rigid motions R_c (c x r) in the shapes: T y = R_c
Matrix in_span(const Matrix& T, const Matrix& R_c) {
  if (R_c.cols() == 0) return Matrix(T.cols(), 0);
  const Matrix y = PivotedQr(T).solve(R_c);
  if ((T * y - R_c).norm() > rigid_in_span * R_c.norm())
    throw RunError("the interface's shapes do not hold its rigid motions");
  return y;
}

}  // namespace

std::vector<const Surface*> pressed_surfaces(const CharacteristicOptions& options,
                                             const std::vector<char>& is_kept,
                                             const Superelement& s) {
  std::vector<const Surface*> pressed;
  for (const auto& touching : touching_surfaces(options, s)) pressed.push_back(touching.surface);
  // Of a face that is kept whole the basis has all responses
  std::erase_if(pressed, [&](const Surface* surface) {
    const std::vector<Index> nodes = surface_nodes(*surface);
    return std::all_of(nodes.begin(), nodes.end(), [&](Index node) { return is_kept[node] != 0; });
  });
  return pressed;
}

Index n_shapes(const CharacteristicOptions& options, Index dofs) {
  return options.is_default_modes ? std::clamp<Index>(dofs - 1, 0, options.modes) : options.modes;
}

void require_fewer(Index modes, Index dofs) {
  if (modes < dofs) return;
  fail("modes: " + std::to_string(modes) + " requested, but only " + std::to_string(dofs) +
       " dofs are to be reduced: take fewer, or basis: craig-bampton, which keeps them all");
}

Matrix uniform_loads(const Superelement& s, const Surface& surface, bool shear) {
  const Points of_node = shear ? Points(face_weights(surface, s.coordinates).replicate(1, 3))
                               : Points(-face_normals(surface, s.coordinates));
  Matrix B = Matrix::Zero(s.c(), shear ? 3 : 1);
  for (Index i = 0; i < s.c(); ++i) {
    const int d = s.dof_component[i];
    if (d < 3) B(i, shear ? d : 0) = of_node(s.dof_node[i], d);
  }
  return B;
}

CharacteristicFigures make_characteristic(const CharacteristicOptions& options,
                                          const std::vector<Index>& part,
                                          const InteriorInertia& inertia, Superelement& s) {
  CharacteristicFigures figures;
  const LargeBlasWork blas(std::pow(static_cast<double>(s.c()), 3));
  figures.n_fixed = s.k();
  figures.rho = residual_mass_share(s);
  Matrix R = rigid_motions_of_parts(s, part).bottomRows(s.c());
  orthonormalise(s.M_cc, R, the_shapes);
  const std::vector<char> is_kept = kept_nodes(options, s);
  const auto [kept, others] = split(s, is_kept);
  Matrix T = kept.empty() ? shapes_of_all(s, n_shapes(options, s.c() - R.cols()), R, figures)
                          : shapes_beside_kept(s, options, kept, others, R, figures);
  const std::vector<const Surface*> pressed = pressed_surfaces(options, is_kept, s);
  StaticShare& share = s.characteristic.statics = static_forces(options, s);
  figures.bare = sets_without_statics(options, is_kept, s);
  Matrix loads = load_columns(options, is_kept, s);
  // Forces on kept nodes alone are no equilibrium: inertia of rigid motion balances them, too
  if (!kept.empty()) {
    loads.conservativeResize(Eigen::NoChange, loads.cols() + R.cols());
    loads.rightCols(R.cols()) = s.M_cc * R;
  }
  Matrix compliance;
  if (!pressed.empty() || !share.empty() || loads.cols() > 0) {
    const Statics statics(s, R);
    for (const Surface* surface : pressed)
      add_uniform(*surface, options.shear, statics, s, T, figures);
    const Matrix answers = kept.empty() ? statics.solve(statics.in_equilibrium(loads))
                                        : answers_beside_kept(s, others, loads);
    figures.n_loads = append(s.M_cc, answers, T);
    figures.n_dropped += loads.cols() - figures.n_loads;
    // Answers to loads and to forces on kept nodes have the interior's strain under inertia from
    // fixed-interface modes alone. Forces of contact that are in balance with them take the same,
    // so that the two cancel.
    if (!share.empty())
      compliance =
          statics.compliance(Matrix(forces_on_dofs(share, s)),
                             figures.n_loads > 0 ? inertia_in_modes(s, R) : inertia_of(inertia, R));
  }
  Superelement t = in_shapes(s, T);
  figures.mass = reduced_mass_condition(t);
  const Matrix y = in_span(T, R);
  Matrix R_t = Matrix::Zero(t.n(), R.cols());
  R_t.bottomRows(T.cols()) = y;
  add_diagonal_form(t, std::move(R_t));
  const Index k = s.k(), n = t.n();
  s.eigenvalues = t.omega.cwiseAbs2();
  s.characteristic.V.noalias() = T * t.V.bottomRows(T.cols());
  // The rigid ones, t.V = y X, are R X: T y is R but for round-off
  if (R.cols() > 0) {
    const Matrix X = PivotedQr(y).solve(t.V.bottomLeftCorner(T.cols(), R.cols()));
    s.characteristic.V.leftCols(R.cols()).noalias() = R * X;
  }
  if (s.fixed.any()) {
    const Matrix of_modes = s.fixed.momentum.topRows(k),
                 of_dofs = s.fixed.momentum.bottomRows(s.c());
    s.fixed.momentum = t.V.topRows(k).transpose() * of_modes +
                       t.V.bottomRows(T.cols()).transpose() * Matrix(T.transpose() * of_dofs);
  }
  for (auto& recovery : s.recovery) {
    Matrix Phi = Matrix::Zero(recovery.Phi.rows(), n);
    if (k > 0 && Phi.rows() > 0) Phi.noalias() = recovery.Phi * t.V.topRows(k);
    recovery.Phi = std::move(Phi);
  }
  if (!share.empty()) share.F = compliance_that_is_left(std::move(compliance), share, R.cols(), s);
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  return figures;
}

Index examine_characteristic(const Superelement& s, const CharacteristicFigures& figures,
                             const std::vector<Index>& part, Conditioning& condition) {
  const Vector omega = s.eigenvalues.cwiseSqrt();
  condition.mass = figures.mass;
  condition.n_rigid = rigid_motions_of_parts(s, part).cols();
  condition.n_zero = (omega.array() == 0).count();
  if (omega.size() > 0) condition.largest_omega = omega(omega.size() - 1);
  if (condition.n_zero < omega.size()) condition.lowest_omega = omega(condition.n_zero);
  Index dof = -1;
  if (condition.n_zero > condition.n_rigid)
    s.characteristic.V.col(condition.n_rigid).cwiseAbs().maxCoeff(&dof);
  return dof;
}

}  // namespace cbr
