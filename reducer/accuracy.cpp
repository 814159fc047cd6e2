// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/accuracy.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/linalg/dense_factor.hpp"
#include "common/mesh/face_weights.hpp"
#include "reducer/diagonal_form.hpp"

namespace cbr {
namespace {

constexpr double nearly_flat = 0.9;       // |sum of area vectors| / area, from here on a surface has a normal
constexpr double no_strain = 1e-12;       // of the largest: a rigid motion that does not bend the interior
constexpr Index largest_dense = 6000;     // interface dofs up to which K_cc and M_res are factored for this
constexpr double enough = 0.1;            // relative error of an eigenvalue: those above are of no interest
constexpr Index block = 8, most = 32;     // modes that are estimated
constexpr double good_eigenvalue = 0.02;  // 1 % of the frequency

// Area vectors of the surface at its nodes' dofs   (c)
Vector normals_on_dofs(const Superelement& s, const Surface& surface) {
  const Points normals = face_normals(surface, s.coordinates);
  Vector f(s.c());
  for (Index i = 0; i < s.c(); ++i) f(i) = normals(s.dof_node[i], s.dof_component[i]);
  return f;
}

bool is_nearly_flat(const Superelement& s, const Surface& surface) {
  if (surface.n_faces() == 0) return false;
  const Vector3 whole = face_normals(surface, s.coordinates).colwise().sum();
  return whole.norm() > nearly_flat * face_weights(surface, s.coordinates).sum();
}

// Statics of the free component under a uniform pressure on each of the surfaces, inertia of the rigid motion that they set going
// in balance with them   (c x surfaces); without columns when K_cc does not let it.
Matrix pressure_motions(const Superelement& s, const std::vector<const Surface*>& surfaces, const std::vector<Index>& part) {
  if (surfaces.empty() || s.c() > largest_dense) return Matrix(s.c(), 0);
  const Matrix R = rigid_motions_of_parts(s, part).bottomRows(s.c());
  Matrix F(s.c(), static_cast<Index>(surfaces.size()));
  for (Index j = 0; j < F.cols(); ++j) F.col(j) = normals_on_dofs(s, *surfaces[j]);
  // F <- F - M_cc R (R^T M_cc R)^-1 R^T F
  const Matrix MR = s.M_cc * R;
  F -= MR * Matrix(R.transpose() * MR).ldlt().solve(R.transpose() * F);
  const Matrix N = Eigen::HouseholderQR<Matrix>(R).householderQ() * Matrix::Identity(R.rows(), R.cols());
  Matrix K = s.K_cc;
  K.noalias() += s.K_cc.diagonal().mean() * N * N.transpose();
  const Eigen::LLT<Matrix> llt(K);
  if (llt.info() != Eigen::Success) return Matrix(s.c(), 0);
  return llt.solve(F);
}

}  // namespace

Matrix inertia_forces(const Partition& p, const SparseCholesky& factor, const Matrix& W) {
  Matrix X = p.K_IC * W;
  factor.solve_in_place(X);
  return p.M_IC * W - p.M_II * X;
}

InterfaceMotions interface_motions(const Partition& p, const SparseCholesky& factor, const Superelement& s,
                                   const std::vector<Index>& part) {
  InterfaceMotions motions;
  std::vector<const Surface*> flat;
  for (const Surface& surface : s.surfaces)
    if (is_nearly_flat(s, surface)) flat.push_back(&surface);
  const Matrix pressed = pressure_motions(s, flat, part);
  motions.W.resize(s.c(), InterfaceMotions::n_rigid + pressed.cols());
  motions.W << reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c()), pressed;
  for (Index j = 0; j < pressed.cols(); ++j) motions.surfaces.push_back(flat[j]->name);
  if (p.n_interior() == 0) {
    motions.Y.resize(0, motions.size());
    motions.E = Matrix::Zero(motions.size(), motions.size());
    return motions;
  }
  motions.Y = inertia_forces(p, factor, motions.W);
  Matrix X = motions.Y;
  factor.solve_in_place(X);
  motions.E.noalias() = motions.Y.transpose() * X;
  motions.E = (0.5 * (motions.E + motions.E.transpose())).eval();
  return motions;
}

StrainLeftOut strain_left_out(const InterfaceMotions& motions, const Matrix& B) {
  const Index m = motions.size(), r = InterfaceMotions::n_rigid;
  StrainLeftOut left;
  left.of_motion.setZero(m);
  left.worst.setZero(r);
  const Vector scale = motions.E.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Matrix caught = B.rows() > 0 ? Matrix(B.transpose() * B) : Matrix(Matrix::Zero(m, m));
  for (Index j = 0; j < m; ++j)
    if (scale(j) > 0) left.of_motion(j) = std::max(0.0, 1 - caught(j, j) / motions.E(j, j));
  // (E - B^T B) x = share E x on the rigid motions, by E = S (Q diag(e) Q^T) S
  const Vector inverse = scale.head(r).unaryExpr([](double v) { return v > 0 ? 1 / v : 0.0; });
  const Matrix E = inverse.asDiagonal() * motions.E.topLeftCorner(r, r) * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> whole(E);
  const Vector& e = whole.eigenvalues();
  std::vector<Index> kept;
  for (Index j = 0; j < r; ++j)
    if (e(j) > no_strain * e(r - 1) && e(j) > 0) kept.push_back(j);
  if (kept.empty()) return left;
  const Vector root = Vector(e(kept)).cwiseSqrt().cwiseInverse();
  const Matrix T = inverse.asDiagonal() * Matrix(whole.eigenvectors()(Eigen::all, kept)) * root.asDiagonal();
  const Matrix share = Matrix::Identity(T.cols(), T.cols()) - T.transpose() * caught.topLeftCorner(r, r) * T;
  const Eigen::SelfAdjointEigenSolver<Matrix> shares(share);
  left.largest = std::max(0.0, shares.eigenvalues()(T.cols() - 1));
  left.worst = T * shares.eigenvectors().col(T.cols() - 1);
  return left;
}

Matrix residual_mass_factor(const Superelement& s) {
  Matrix M_res = s.M_cc;
  if (s.k() > 0) M_res.noalias() -= s.M_kc.transpose() * s.M_kc;
  return dense_cholesky(M_res) ? M_res : Matrix();
}

double impact_share(const Superelement& s, const Matrix& L, const Surface& surface) {
  const Vector3 normal = Vector3(face_normals(surface, s.coordinates).colwise().sum()).normalized();
  const Points at_node = face_normals(surface, s.coordinates);
  // G^T: unit normals of the surface's nodes   (c x nodes); r: the translation   (c)
  std::vector<Index> column(s.node_ids.size(), -1);
  Index n = 0;
  for (const Index node : surface_nodes(surface))
    if (at_node.row(node).norm() > 0) column[node] = n++;
  Matrix G = Matrix::Zero(s.c(), n);
  Vector r(s.c());
  for (Index i = 0; i < s.c(); ++i) {
    const Index node = s.dof_node[i];
    r(i) = normal(s.dof_component[i]);
    if (column[node] >= 0) G(i, column[node]) = at_node(node, s.dof_component[i]) / at_node.row(node).norm();
  }
  if (n == 0 || L.rows() == 0) return 0;
  const Vector stopped = G.transpose() * r;
  // W = G M_res^-1 G^T by L^-1 G^T   (nodes x nodes)
  L.triangularView<Eigen::Lower>().solveInPlace(G);
  const Eigen::LLT<Matrix> W(G.transpose() * G);
  const double energy = r.dot(s.M_cc * r);
  if (W.info() != Eigen::Success || !(energy > 0)) return 0;
  return stopped.dot(W.solve(stopped)) / energy;
}

void estimate_eigenvalue_errors(const Partition& p, const SparseCholesky& factor, const Superelement& s, Index n_rigid,
                                Superelement::Accuracy& accuracy) {
  const Index last = std::min(s.n(), n_rigid + most);
  std::vector<double> frequency, error;
  bool good = true;
  for (Index first = n_rigid; first < last && (error.empty() || error.back() < enough); first += block) {
    const Index count = std::min(block, last - first);
    const Matrix U = s.V.block(s.k(), first, s.c(), count);
    Matrix Y(p.n_interior(), count), X(p.n_interior(), count);
    if (p.n_interior() > 0) X = Y = inertia_forces(p, factor, U), factor.solve_in_place(X);
    // r_I = lambda (M_II Phi M_kc u_c - Y u_c), as the row of the modes holds exactly; so
    // eta = lambda (y^T K_II^-1 y - a^T Lambda^-1 a),  a = M_kc u_c
    const Matrix A = s.k() > 0 ? Matrix(s.M_kc * U) : Matrix(0, count);
    for (Index j = 0; j < count; ++j) {
      const double lambda = s.omega(first + j) * s.omega(first + j);
      double left = Y.col(j).dot(X.col(j));
      if (s.k() > 0) left -= A.col(j).cwiseAbs2().dot(s.eigenvalues.cwiseInverse());
      frequency.push_back(s.omega(first + j) / (2 * std::numbers::pi));
      error.push_back(std::max(0.0, lambda * left));
      good = good && error.back() <= good_eigenvalue;
      if (good) accuracy.covered_hz = frequency.back();
    }
  }
  accuracy.frequency_hz = Eigen::Map<const Vector>(frequency.data(), static_cast<Index>(frequency.size()));
  accuracy.eigenvalue_error = Eigen::Map<const Vector>(error.data(), static_cast<Index>(error.size()));
}

Superelement::Accuracy accuracy_of(const Partition& p, const SparseCholesky& factor, const InterfaceMotions& motions,
                                   const Superelement& s, Index n_rigid) {
  Superelement::Accuracy a;
  a.rho_res = residual_mass_share(s);
  if (p.lumped) {
    Vector3 floor = Vector3::Zero();
    for (Index i = 0; i < s.c(); ++i) floor(s.dof_component[i]) += p.M_CC.coeff(i, i);
    a.rho_floor = floor / s.rigid_body.mass;
  }
  // B = Lambda^-1/2 M_kc W   (k x m), as Phi^T Y = M_kc W
  Matrix B(0, motions.size());
  if (s.k() > 0) B = s.eigenvalues.cwiseSqrt().cwiseInverse().asDiagonal() * Matrix(s.M_kc * motions.W);
  const StrainLeftOut left = strain_left_out(motions, B);
  a.strain_left_out = left.of_motion.head(InterfaceMotions::n_rigid);
  a.largest_left_out = left.largest;
  for (std::size_t i = 0; i < motions.surfaces.size(); ++i)
    a.surfaces[motions.surfaces[i]].strain_left_out = left.of_motion(InterfaceMotions::n_rigid + static_cast<Index>(i));
  const bool any_flat = std::any_of(s.surfaces.begin(), s.surfaces.end(), [&](const Surface& f) { return is_nearly_flat(s, f); });
  const Matrix L = any_flat && s.c() <= largest_dense ? residual_mass_factor(s) : Matrix();
  for (const Surface& surface : s.surfaces)
    if (L.rows() > 0 && is_nearly_flat(s, surface)) a.surfaces[surface.name].impact = impact_share(s, L, surface);
  if (s.has_diagonal_form()) estimate_eigenvalue_errors(p, factor, s, n_rigid, a);
  return a;
}

}  // namespace cbr
