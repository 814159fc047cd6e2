// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/judgement/missing_modes.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/diagonal_form.hpp"

namespace cbr {
namespace {

// |sum of area vectors| / area, from here on a surface has a normal
constexpr double nearly_flat = 0.9;
// of the largest: a rigid motion that does not bend the interior
constexpr double no_strain = 1e-12;
// interface dofs up to which K_cc and M_res are factored for this
constexpr Index largest_dense = 6000;
// relative error of an eigenvalue: those above are of no interest
constexpr double good_enough = 0.1;
// Of the frequency of the first missing fixed-interface mode. Estimates nearer to it were 0.4 to
// 2.5 of the true errors. Above it the full model has modes outside the basis, so that there is
// nothing to compare.
constexpr double trusted = 0.95;
// 1 % of the frequency, for modes beyond those looked at
constexpr double good_eigenvalue = 0.95 * (1 - 0.99 * 0.99);

// Area vectors of the surface at its nodes' dofs   (c)
Vector normals_on_dofs(const Superelement& s, const Surface& surface) {
  const Points normals = face_normals(surface, s.coordinates);
  Vector f(s.c());
  for (Index i = 0; i < s.c(); ++i)
    f(i) = s.dof_component[i] < 3 ? normals(s.dof_node[i], s.dof_component[i]) : 0;
  return f;
}

bool is_nearly_flat(const Superelement& s, const Surface& surface) {
  if (surface.n_faces() == 0) return false;
  const Vector3 whole = face_normals(surface, s.coordinates).colwise().sum();
  return whole.norm() > nearly_flat * face_weights(surface, s.coordinates).sum();
}

// Hz, below which no fixed-interface mode is missing.
double complete_below(const ModesNotKept& m, const Superelement& s) {
  const Index own = s.k() - s.n_residual;
  double lowest = m.beyond > 0 ? m.beyond : HUGE_VAL;
  if (m.lambda.size() > 0) lowest = std::min(lowest, m.lambda.minCoeff());
  if (lowest == HUGE_VAL) lowest = own > 0 ? s.eigenvalues.head(own).maxCoeff() : 0;
  return std::sqrt(lowest) / (2 * std::numbers::pi);
}

// Static displacements of the free component under a uniform pressure on each of the surfaces, in
// balance with rigid-body inertia   (c x surfaces). Without columns when K_cc is singular otherwise
// than by rigid motions.
Matrix pressure_motions(const Superelement& s, const std::vector<const Surface*>& surfaces,
                        const std::vector<Index>& part) {
  if (surfaces.empty() || s.c() > largest_dense) return Matrix(s.c(), 0);
  const Matrix R = rigid_motions_of_parts(s, part).bottomRows(s.c());
  Matrix F(s.c(), static_cast<Index>(surfaces.size()));
  for (Index j = 0; j < F.cols(); ++j) F.col(j) = normals_on_dofs(s, *surfaces[j]);
  // F <- F - M_cc R (R^T M_cc R)^-1 R^T F
  const Matrix MR = s.M_cc * R;
  const Ldlt mass_of_rigid(R.transpose() * MR);
  F -= MR * mass_of_rigid.solve(R.transpose() * F);
  const Cholesky cholesky(hold_rigid_motions(s.K_cc, R).K);
  if (!cholesky.ok()) return Matrix(s.c(), 0);
  Matrix W = cholesky.solve(F);
  // No rigid motion in it, in the mass, whatever the mesh: W <- W - R (R^T M_cc R)^-1 R^T M_cc W
  W -= R * mass_of_rigid.solve(MR.transpose() * W);
  return W;
}

}  // namespace

ModesNotKept settled(ModesNotKept m, const Interior& interior, const Superelement& s) {
  const Index n = interior.p.n_interior(), n_known = s.k() - s.n_residual + m.lambda.size();
  if (n_known >= n) {
    m.beyond = 0;
  } else if (m.beyond == 0) {
    const auto times_mass = [&](const Vector& x, Vector& y) { y = interior.times_mass(x); };
    m.beyond = 1 / largest_eigenvalue(n, times_mass, [&](const Vector& x, Vector& y) {
                 Matrix X = x;
                 interior.solve_in_place(X);
                 y = X;
               });
  }
  if (s.n_residual > 0 && m.lambda.size() > 0) {
    m.beyond = m.beyond > 0 ? std::min(m.beyond, m.lambda.minCoeff()) : m.lambda.minCoeff();
    m.lambda.resize(0);
    m.Phi.resize(interior.n_rows(), 0);
  }
  return m;
}

InterfaceMotions interface_motions(const Interior& interior, const Superelement& s,
                                   const std::vector<Index>& part, bool of_faces) {
  InterfaceMotions motions;
  motions.W = interior.from_first([&] {
    std::vector<const Surface*> flat;
    for (const Surface& surface : s.surfaces)
      if (of_faces && is_nearly_flat(s, surface)) flat.push_back(&surface);
    const Matrix pressed = pressure_motions(s, flat, part);
    Matrix W(s.c(), InterfaceMotions::n_rigid + pressed.cols());
    W << reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c()), pressed;
    for (Index j = 0; j < pressed.cols(); ++j) motions.surfaces.push_back(flat[j]->name);
    return W;
  });
  if (interior.p.n_interior() == 0) {
    motions.Y.resize(0, motions.size());
    motions.E = Matrix::Zero(motions.size(), motions.size());
    return motions;
  }
  motions.Y = inertia_forces(interior, motions.W);
  Matrix X = motions.Y;
  interior.solve_in_place(X);
  motions.E = interior.inner(motions.Y, X);
  motions.E = (0.5 * (motions.E + motions.E.transpose())).eval();
  return motions;
}

StrainLeftOut strain_left_out(const InterfaceMotions& motions, const Matrix& D) {
  const Index m = motions.size(), r = InterfaceMotions::n_rigid;
  StrainLeftOut left;
  left.of_motion.setZero(m);
  left.worst.setZero(r);
  const Vector scale = motions.E.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Index j = 0; j < m; ++j)
    if (scale(j) > 0) left.of_motion(j) = std::clamp(D(j, j) / motions.E(j, j), 0.0, 1.0);
  // D x = share E x on the rigid motions, by E = S (Q diag(e) Q^T) S
  const Vector inverse = scale.head(r).unaryExpr([](double v) { return v > 0 ? 1 / v : 0.0; });
  const Matrix E = inverse.asDiagonal() * motions.E.topLeftCorner(r, r) * inverse.asDiagonal();
  const SymmetricEigen whole = symmetric_eigen(E);
  const Vector& e = whole.values;
  std::vector<Index> kept;
  for (Index j = 0; j < r; ++j)
    if (e(j) > no_strain * e(r - 1) && e(j) > 0) kept.push_back(j);
  if (kept.empty()) return left;
  const Vector root = Vector(e(kept)).cwiseSqrt().cwiseInverse();
  const Matrix T =
      inverse.asDiagonal() * Matrix(whole.vectors(Eigen::all, kept)) * root.asDiagonal();
  const Matrix share = T.transpose() * D.topLeftCorner(r, r) * T;
  const SymmetricEigen shares = symmetric_eigen(share);
  left.largest = std::max(0.0, shares.values(T.cols() - 1));
  left.worst = T * shares.vectors.col(T.cols() - 1);
  return left;
}

double impact_share(const Superelement& s, const Cholesky& M_res, const Surface& surface) {
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
    r(i) = s.dof_component[i] < 3 ? normal(s.dof_component[i]) : 0;
    if (column[node] >= 0)
      G(i, column[node]) = at_node(node, s.dof_component[i]) / at_node.row(node).norm();
  }
  if (n == 0 || !M_res.ok()) return 0;
  const Vector stopped = G.transpose() * r;
  // W = G M_res^-1 G^T by L^-1 G^T   (nodes x nodes)
  M_res.solve_lower_in_place(G);
  const Cholesky W(G.transpose() * G);
  const double energy = r.dot(s.M_cc * r);
  if (!W.ok() || !(energy > 0)) return 0;
  return stopped.dot(W.solve(stopped)) / energy;
}

namespace {

// Of the free component's lowest elastic modes: eigenvalues, and their relative excess.
struct Estimates {
  using List = std::vector<std::pair<double, double>>;
  List list, trusted_list;  // trusted: far enough below the part's first held mode that is missing
  double worst_of_ten = 0;  // error, of the ten lowest of each part

  // lowest: eigenvalue of that mode
  void add(const Vector& lambda, const Vector& error, double lowest) {
    for (Index j = 0; j < error.size(); ++j) {
      list.emplace_back(lambda(j), error(j));
      if (lambda(j) <= trusted * trusted * lowest) trusted_list.push_back(list.back());
    }
    const Index ten = std::min(error.size(), n_free_modes_of_tolerance);
    if (ten > 0) worst_of_ten = std::max(worst_of_ten, error.head(ten).maxCoeff());
  }
};

Index n_free_motions(const Superelement& s, Index n_rigid) {
  return std::min(s.n(), n_rigid + n_estimated + n_beside);
}

void estimate_eigenvalue_errors(const Superelement& s, Index n_rigid, const MissingModes& missing,
                                Estimates& estimates) {
  const Index count = std::min(s.n() - n_rigid, n_estimated), m = n_free_motions(s, n_rigid);
  const Vector lambda = s.omega.head(m).cwiseAbs2();
  const Vector full = full_eigenvalues(lambda, missing, n_rigid, count);
  Vector error = Vector::Zero(count);
  for (Index j = 0; j < count; ++j)
    if (const double with_basis = lambda(n_rigid + j); with_basis > 0)
      error(j) = std::max(0.0, 1 - full(j) / with_basis);
  estimates.add(lambda.segment(n_rigid, count), error, missing.lowest());
}

// Of one connected part.
void estimate_eigenvalue_errors(const Interior& interior, const Superelement& s, const Matrix& Phi,
                                Index n_rigid, const ModesNotKept& not_kept, Estimates& estimates) {
  const Index own = s.k() - s.n_residual, r = s.n_residual;
  // Of the lowest free modes the interface and the residual vectors   ((c + r) x m)
  const Matrix V = interior.from_first([&] {
    if (!s.has_diagonal_form()) return Matrix();
    const Index m = n_free_motions(s, n_rigid);
    Matrix V(s.c() + r, m);
    V << s.V.block(s.k(), 0, s.c(), m), s.V.block(own, 0, r, m);
    return V;
  });
  if (V.cols() == 0) return;
  // Missing modes are driven by the interface, and by residual vectors, which are no eigenvectors
  Matrix Y = inertia_forces(interior, V.topRows(s.c()));
  if (r > 0) Y += interior.times_mass(Phi.rightCols(r) * V.bottomRows(r));
  MissingModes missing{not_kept.lambda, interior.inner(not_kept.Phi, Y), {}, {}, not_kept.beyond};
  LeftOfAnswer left = left_of_answer(interior, {Phi.leftCols(own), not_kept.Phi},
                                     s.eigenvalues.tail(r), Phi.rightCols(r), std::move(Y));
  missing.D = std::move(left.D);
  missing.D_2 = std::move(left.D_2);
  interior.in_first([&] { estimate_eigenvalue_errors(s, n_rigid, missing, estimates); });
}

Vector sorted(Vector v) {
  std::sort(v.begin(), v.end());
  return v;
}

FreeEigenvalues eigenvalues_of(const Estimates& estimates) {
  const auto n = static_cast<Index>(estimates.list.size());
  FreeEigenvalues of{Vector(n), Vector(n), estimates.worst_of_ten};
  for (Index j = 0; j < n; ++j) {
    const auto& [lambda, error] = estimates.list[j];
    of.with_basis(j) = lambda;
    of.full(j) = lambda * (1 - error);
  }
  of.with_basis = sorted(std::move(of.with_basis));
  of.full = sorted(std::move(of.full));
  return of;
}

// The lowest, up to the first that is of no interest or above end_hz, and up to where they are
// good.
void take_estimates(std::vector<std::pair<double, double>> list, double end_hz,
                    Superelement::Accuracy& accuracy) {
  std::stable_sort(list.begin(), list.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  if (list.size() > n_estimated) list.resize(n_estimated);
  std::erase_if(list, [&](const auto& mode) {
    return std::sqrt(mode.first) > 2 * std::numbers::pi * end_hz;
  });
  const auto above = [&](double most_error) {
    return std::find_if(list.begin(), list.end(),
                        [&](const auto& mode) { return !(mode.second <= most_error); }) -
           list.begin();
  };
  const auto hz = [&](Index j) { return std::sqrt(list[j].first) / (2 * std::numbers::pi); };
  const Index n = std::min<Index>(list.size(), above(good_enough) + 1);
  accuracy.frequency_hz.resize(n);
  accuracy.eigenvalue_error.resize(n);
  for (Index j = 0; j < n; ++j) {
    accuracy.frequency_hz(j) = hz(j);
    accuracy.eigenvalue_error(j) = list[j].second;
  }
  for (Index good = above(good_eigenvalue); good > 0; --good)
    if (hz(good - 1) <= accuracy.complete_hz || accuracy.complete_hz == 0) {
      accuracy.covered_hz = hz(good - 1);
      return;
    }
}

// Strain left out and free modes of each part by itself.
void look_at_parts(const std::vector<ComponentPart>& parts, const Superelement& s,
                   const Matrix& Phi, const ModesNotKept& not_kept, Superelement::Accuracy& a,
                   Estimates& estimates) {
  const std::vector<std::size_t> owner = owners(parts, Phi),
                                 owner_of_others = owners(parts, not_kept.Phi);
  a.largest_left_out = 0;
  for (std::size_t q = 0; q < parts.size(); ++q) {
    const ComponentPart& part = parts[q];
    std::vector<Index> kept, others;
    Superelement own = part_of(s, part);
    for (Index j = 0; j < s.k(); ++j) {
      if (owner[j] != q) continue;
      kept.push_back(j);
      if (j >= s.k() - s.n_residual) ++own.n_residual;
    }
    for (Index j = 0; j < not_kept.lambda.size(); ++j)
      if (owner_of_others[j] == q) others.push_back(j);
    own.eigenvalues = s.eigenvalues(kept);
    own.M_kc = s.M_kc(kept, part.on_interface);
    const Matrix own_Phi = Phi(part.inside, kept);
    ModesNotKept own_others{
        not_kept.lambda(others),
        not_kept.Phi(part.inside, others),
        not_kept.beyond_of_part.empty() ? not_kept.beyond : not_kept.beyond_of_part[q],
        {}};
    const SparseCholesky factor(part.p.K_II);
    const LocalInterior interior(part.p, factor);
    const InterfaceMotions motions = interface_motions(interior, own, part.one());
    const Index k = own.k() - own.n_residual, r = own.n_residual;
    const LeftOfAnswer left = left_of_answer(
        interior, {own_Phi.leftCols(k)}, own.eigenvalues.tail(r), own_Phi.rightCols(r), motions.Y);
    a.largest_left_out = std::max(a.largest_left_out, strain_left_out(motions, left.D).largest);
    if (!s.has_diagonal_form()) continue;
    const Index n_rigid = add_lowest_modes(own, part.one(), n_estimated + n_beside);
    estimate_eigenvalue_errors(interior, own, own_Phi, n_rigid,
                               settled(std::move(own_others), interior, own), estimates);
  }
}

// Of D, which left_of_answer() gives of motions.Y.
Superelement::Accuracy accuracy_of_strain(const InterfaceMotions& motions, const Matrix& D,
                                          const Superelement& s, const ModesNotKept& others) {
  Superelement::Accuracy a;
  const StrainLeftOut left = strain_left_out(motions, D);
  a.strain_left_out = left.of_motion.head(InterfaceMotions::n_rigid);
  a.largest_left_out = left.largest;
  for (std::size_t i = 0; i < motions.surfaces.size(); ++i)
    a.surfaces[motions.surfaces[i]].strain_left_out =
        left.of_motion(InterfaceMotions::n_rigid + static_cast<Index>(i));
  a.complete_hz = complete_below(others, s);
  return a;
}

// Residual mass of the interface, and loss of kinetic energy when a flat face stops.
void add_stops(const Superelement& s, bool of_faces, const Cholesky* M_res,
               Superelement::Accuracy& a) {
  a.rho_res = residual_mass_share(s);
  const bool any_flat =
      of_faces && std::any_of(s.surfaces.begin(), s.surfaces.end(),
                              [&](const Surface& f) { return is_nearly_flat(s, f); });
  if (!any_flat || s.c() > largest_dense) return;
  std::optional<Cholesky> own;
  const Cholesky& L = M_res != nullptr ? *M_res : own.emplace(residual_mass_factor(s));
  for (const Surface& surface : s.surfaces)
    if (L.ok() && is_nearly_flat(s, surface))
      a.surfaces[surface.name].impact = impact_share(s, L, surface);
}

}  // namespace

Superelement::Accuracy accuracy_of_fixed_modes(const Interior& interior,
                                               const InterfaceMotions& motions,
                                               const Superelement& s, const Matrix& Phi,
                                               const ModesNotKept& others) {
  const Index own = s.k() - s.n_residual, r = s.n_residual;
  const LeftOfAnswer unheld = left_of_answer(interior, {Phi.leftCols(own)}, s.eigenvalues.tail(r),
                                             Phi.rightCols(r), motions.Y);
  Superelement::Accuracy a;
  interior.in_first([&] {
    a = accuracy_of_strain(motions, unheld.D, s, others);
    if (!interior.p.lumped) return;
    Vector3 floor = Vector3::Zero();
    for (Index i = 0; i < s.c(); ++i)
      if (s.dof_component[i] < 3) floor(s.dof_component[i]) += interior.p.M_CC.coeff(i, i);
    a.rho_floor = floor / s.rigid_body.mass;
  });
  return a;
}

Superelement::Accuracy accuracy_of(const Interior& interior, const InterfaceMotions& motions,
                                   const Superelement& s, const Matrix& Phi, Index n_rigid,
                                   const ModesNotKept& not_kept,
                                   const std::vector<ComponentPart>& parts, bool of_faces,
                                   FreeEigenvalues* free, const Cholesky* M_res) {
  const ModesNotKept others = settled(not_kept, interior, s);
  Superelement::Accuracy a = accuracy_of_fixed_modes(interior, motions, s, Phi, others);
  Estimates estimates;
  if (!parts.empty()) {
    look_at_parts(parts, s, Phi, not_kept, a, estimates);
  } else {
    estimate_eigenvalue_errors(interior, s, Phi, n_rigid, others, estimates);
  }
  interior.in_first([&] {
    add_stops(s, of_faces, M_res, a);
    *free = eigenvalues_of(estimates);
    if (free->known()) a.worst_of_ten = estimates.worst_of_ten;
    if (others.beyond > 0 || others.lambda.size() > 0) free->end_hz = trusted * a.complete_hz;
    take_estimates(std::move(estimates.trusted_list), HUGE_VAL, a);
  });
  return a;
}

void judge_eigenvalues(const Vector& lambda, const FreeEigenvalues& estimates,
                       Superelement::Accuracy& a) {
  std::vector<std::pair<double, double>> list;
  const Index n = std::min(lambda.size(), estimates.full.size());
  double worst = 0;
  for (Index j = 0; j < n; ++j) {
    const double above = 1 - estimates.full(j) / lambda(j),
                 below = estimates.with_basis(j) / lambda(j) - 1;
    const double error = std::max({0.0, above, below});
    // a mechanism, or round-off where something is very thin: nothing is known
    if (!(lambda(j) > 0) || !std::isfinite(error)) {
      if (j < n_free_modes_of_tolerance) worst = HUGE_VAL;
      break;
    }
    list.emplace_back(lambda(j), error);
    if (j < n_free_modes_of_tolerance) worst = std::max(worst, list.back().second);
  }
  a.covered_hz = 0;
  a.worst_of_ten.reset();
  if (n > 0 && std::isfinite(worst)) a.worst_of_ten = worst;
  take_estimates(std::move(list), estimates.end_hz, a);
}

Superelement::Accuracy accuracy_of_free_modes(const Vector& lambda, double next,
                                              const Vector& share) {
  Superelement::Accuracy a;
  const auto hz = [](double value) { return std::sqrt(value) / (2 * std::numbers::pi); };
  const Index n = lambda.size(), listed = std::min(n, n_estimated);
  if (n > 0) {
    a.covered_hz = a.complete_hz = hz(lambda(n - 1));
    a.worst_of_ten = 0;
  }
  a.complete_hz = std::max(a.complete_hz, next > 0 ? hz(next) : 0.0);
  a.frequency_hz = lambda.head(listed).cwiseMax(0.0).cwiseSqrt() / (2 * std::numbers::pi);
  a.eigenvalue_error.setZero(listed);
  if (share.size() > 0) a.interface_share = share.head(listed);
  return a;
}

}  // namespace cbr
