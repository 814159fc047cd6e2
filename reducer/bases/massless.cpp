// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/massless.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/modes/component_parts.hpp"

namespace cbr {
namespace {

// of F, as a share of the elastic compliance: below, it is round-off
constexpr double least_pivot = 1e-10;
constexpr double no_strain = 1e-6;  // of the lowest elastic eigenvalue: a mechanism
// of it: round-off above this mixes rigid motions with elastic modes
constexpr double rigid_tolerance = 1e-2;
constexpr Index most_ahead = 20;
// of the mean: docs/decisions/energy.md has the figures for others
constexpr double takes_part = 0.05;
constexpr double no_part = 1e-20;  // of |p|^2 |V_j|^2: round-off

// Forces of a uniform pressure on each surface   (c x surfaces)
Matrix pressures(const Superelement& s) {
  Matrix P(s.c(), static_cast<Index>(s.surfaces.size()));
  for (Index q = 0; q < P.cols(); ++q) {
    const Points n = face_normals(s.surfaces[q], s.coordinates);
    for (Index i = 0; i < s.c(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      P(i, q) = n(s.dof_node[at], s.dof_component[at]);
    }
  }
  return P;
}

// How many modes beyond `elastic` ones are looked at for the end of their fall; at least 1.
Index modes_ahead(Index elastic) { return std::clamp<Index>((elastic + 1) / 2, 1, most_ahead); }

// End of the taper (rad/s), where interface rows of the first k modes fall to 0. It is the
// frequency of the first of the modes_ahead() that takes part in a uniform pressure on one of the
// surfaces of `s`. At the latest it is that of the last of them; without surfaces, of the first. A
// mode takes part when its response to the impulse, (p^T V_j)^2, is a twentieth of the kept modes'
// mean. The mean weighs each mode by its own response, and rigid motions as one. lambda: at least
// k, ascending, n_rigid zeros first. V: c x lambda.size(), or without the last; not tapered.
// Without eigenvalues beyond k the end is extrapolated as for evenly spaced frequencies.
double end_of_fall(const Superelement& s, const Matrix& V, const Vector& lambda, Index k,
                   Index n_rigid) {
  const Index e = k - n_rigid, last_looked_at = std::min(k + modes_ahead(e), lambda.size()) - 1;
  const Matrix P = pressures(s), answers = (P.transpose() * V).cwiseAbs2();  // surfaces x modes
  Vector enough = Vector::Constant(P.cols(), HUGE_VAL);
  bool any = false;
  for (Index q = 0; q < P.cols(); ++q) {
    const double rigid = answers.row(q).head(n_rigid).sum();
    const auto elastic = answers.row(q).segment(n_rigid, e);
    const double sum = rigid + elastic.sum(), mean = (rigid * rigid + elastic.squaredNorm()) / sum;
    if (!(sum > 0) || !(mean > no_part * P.col(q).squaredNorm() *
                                   V.leftCols(k).colwise().squaredNorm().maxCoeff()))
      continue;
    enough(q) = takes_part * mean;
    any = true;
  }
  const double last = k > 0 ? lambda(k - 1) : 0;
  Index j = k;
  const auto ends_here = [&] {
    return lambda(j) > last && (!any || (answers.col(j) - enough).maxCoeff() >= 0);
  };
  while (j < last_looked_at && !ends_here()) ++j;
  const double above = 1 + 1 / static_cast<double>(std::max<Index>(e, 1));
  return std::sqrt(j < lambda.size() && lambda(j) > last ? lambda(j) : above * above * last);
}

// sqrt(1 - (omega_j / end)^3), k numbers: factors of the columns of V.
Vector falling_weights(const Vector& lambda, double end) {
  return (1 - (lambda.array().sqrt() / end).cube()).max(0.0).sqrt();
}

// Six of each part, about its middle and of its size, N^T M N = I   (N x 6 parts)
Matrix rigid_motions(const FreeModel& model) {
  const auto unit = [&](Matrix N) {
    orthonormalise([&](const Matrix& X) { return Matrix(model.M * X); }, N, "the rigid motions");
    return N;
  };
  if (model.left) return unit(*model.left);
  const Index n_parts = *std::max_element(model.part.begin(), model.part.end()) + 1;
  Matrix N = Matrix::Zero(model.K.rows(), 6 * n_parts);
  for (Index number = 0; number < n_parts; ++number) {
    Vector3 lower = Vector3::Constant(HUGE_VAL), upper = -lower;
    for (std::size_t i = 0; i < model.part.size(); ++i) {
      if (model.part[i] != number) continue;
      const Vector3 x = model.x.row(static_cast<Index>(i));
      lower = lower.cwiseMin(x);
      upper = upper.cwiseMax(x);
    }
    const double size = (upper - lower).norm();
    Matrix all = rigid_modes(model.x, 0.5 * (lower + upper), model.n_rotations);
    if (size > 0) all.rightCols(3) /= size;
    for (std::size_t i = 0; i < model.part.size(); ++i) {
      const auto row = 3 * static_cast<Index>(i);
      if (model.part[i] == number) N.block(row, 6 * number, 3, 6) = all.middleRows(row, 3);
    }
  }
  return unit(std::move(N));
}

// A generalised inverse of K_cc, N_c being the rigid motions of the interface   (c x c)
Matrix compliance_of_interface(const Matrix& K_cc, const Matrix& N_c) {
  Matrix K = hold_rigid_motions(K_cc, N_c).K;
  if (!dense_cholesky(K))
    throw InputError(
        "basis: massless: the reduced stiffness of the interface is lost in round-off, as that of "
        "very thin parts is: use larger or less flat elements, or basis: craig-bampton");
  dense_inverse_of_cholesky(K);
  return K;
}

// Solves K u = f for loads f in equilibrium, with the matrices of a reduction. (u_c; u_I) = G f, K
// G K = K.
class ReductionSolver {
 public:
  ReductionSolver(const FreeModel& model, const Partition& p, const SparseCholesky& factor,
                  const Superelement& s)
      : model_(model), p_(p), factor_(factor), I_(p.interior_rows), C_(p.interface_rows) {
    N_ = rigid_motions(model);
    P_ = model.M * N_;
    N_c_ = N_(C_, Eigen::all);
    K_ = compliance_of_interface(s.K_cc, N_c_);
  }

  const Matrix& N() const { return N_; }
  const Matrix& N_c() const { return N_c_; }
  const std::vector<Index>& interface_dofs() const { return C_; }

  // (I - N P^T) G (I - P N^T) on the interface, P = M N. With T = [I; Psi], N = T N_c and a = K~
  // M_cc N_c:
  //   F = K~ - N_c a^T - a N_c^T + N_c (N_c^T M_cc a + P_I^T K_II^-1 P_I) N_c^T   (c x c)
  Matrix elastic_compliance(const Matrix& M_cc) const {
    const Matrix m = M_cc * N_c_, a = K_ * m;
    Matrix Q = m.transpose() * a;
    if (!I_.empty()) {
      const Matrix P_I = P_(I_, Eigen::all);
      Q += P_I.transpose() * factor_.solve(P_I);
    }
    Matrix B = 0.5 * N_c_ * Q - a;
    Matrix F = K_;
    F.noalias() += N_c_ * B.transpose();
    F.noalias() += B * N_c_.transpose();
    return 0.5 * (F + F.transpose());
  }

  // Estimates the lowest elastic eigenvalue by Rayleigh's quotient of the response to an
  // unsymmetric load.
  double low_eigenvalue() const {
    Vector y(model_.K.rows());
    for (Index i = 0; i < y.size(); ++i) y[i] = 1 + std::sin(1.0 + 2.7 * static_cast<double>(i));
    double lambda = 0;
    for (int i = 0; i < 3; ++i) {
      y -= N_ * (P_.transpose() * y);
      y = solve(model_.M * y);
      y -= N_ * (P_.transpose() * y);
      lambda = y.dot(model_.K * y) / y.dot(model_.M * y);
      y /= y.norm();
    }
    return lambda;
  }

 private:
  // G f   (N)
  Vector solve(const Vector& f) const {
    Vector u(f.size());
    if (I_.empty()) {
      u(C_) = K_ * f(C_);
      return u;
    }
    const Vector w = factor_.solve(Matrix(f(I_)));
    const Vector u_c = K_ * (Vector(f(C_)) - p_.K_IC.transpose() * w);
    u(C_) = u_c;
    u(I_) = w - factor_.solve(Matrix(p_.K_IC * u_c));
    return u;
  }

  const FreeModel& model_;
  const Partition& p_;
  const SparseCholesky& factor_;
  std::vector<Index> I_, C_;
  Matrix N_, P_, N_c_, K_;
};

// Modes of K - sigma M, sigma < 0, as if all dofs were interior, to reuse the search, count and
// proof of fixed-interface modes. Tapered modes include those ahead; n_kept: without them.
FixedInterfaceModes free_modes(const FreeModel& model, const Partition& p, double sigma,
                               Index n_rigid, const FreeModesWanted& wanted, Index& n_kept,
                               MasslessFigures& figures, Report& report) {
  Partition all;
  all.K_II = model.K - SparseMatrix(sigma * model.M);
  all.M_II = model.M;
  all.lumped = p.lumped;
  const SparseCholesky factor(all.K_II);
  if (!factor.ok()) throw RunError("free modes: the shifted stiffness is not positive definite");
  Index k = wanted.modes + n_rigid;
  if (wanted.cutoff_hz > 0) {
    const double omega = 2 * std::numbers::pi * wanted.cutoff_hz;
    k = std::max(n_rigid, count_modes_below(
                              all, factor,
                              std::sqrt(omega * omega - sigma) / (2 * std::numbers::pi), report));
  }
  if (k > model.K.rows()) {
    throw InputError("modes: " + std::to_string(wanted.modes) +
                     " requested, but the component has only " +
                     std::to_string(model.K.rows() - n_rigid) + " elastic modes");
  }
  n_kept = k;
  if (wanted.tapered && k > n_rigid)
    k = std::min(k + modes_ahead(k - n_rigid) - 1, model.K.rows());  // and the next one's frequency
  const bool one_part = *std::max_element(model.part.begin(), model.part.end()) == 0;
  FixedInterfaceModes modes = one_part ? fixed_interface_modes(all, factor, k, report)
                                       : fixed_interface_modes_by_part(split(all, model.part, {}),
                                                                       model.K.rows(), k, report);
  const LocalInterior interior(all, factor);
  figures.modes = check_modes(interior, modes.lambda, modes.Phi);
  require_independent(interior, modes.Phi, figures.modes);
  modes.lambda.array() += sigma;
  if (modes.next > 0) modes.next += sigma;
  return modes;
}

void require_only_rigid(const Vector& lambda, Index n_rigid, double low) {
  const double round_off = n_rigid > 0 ? lambda.head(n_rigid).cwiseAbs().maxCoeff() : 0;
  if (n_rigid < lambda.size() && lambda(n_rigid) <= std::max(no_strain * low, 10 * round_off))
    throw InputError(
        "basis: massless: the component moves without strain in more ways than as a rigid body: a "
        "mechanism, a part that hangs by "
        "an edge, or one too thin for a double: correct the mesh, or use basis: craig-bampton");
  if (round_off > rigid_tolerance * low)
    throw InputError(
        "basis: massless: by round-off the stiffness resists rigid motions, so that the free modes "
        "cannot be told from them: look for parts of very unlike stiffness, very thin parts, "
        "slivers, Poisson's ratio near 0.5, or use basis: craig-bampton");
}

// Tapers the rows of the first k modes, given those of all; modes beyond k determine the end.
void taper(const FixedInterfaceModes& modes, const Matrix& V, Index k, Index n_rigid,
           Superelement& s) {
  auto& m = s.massless;
  Vector lambda = modes.lambda;
  if (modes.next > 0) {
    lambda.conservativeResize(lambda.size() + 1);
    lambda(lambda.size() - 1) = modes.next;
  }
  m.omega_fall = end_of_fall(s, V, lambda, k, n_rigid);
  m.V = V.leftCols(k) * falling_weights(lambda.head(k), m.omega_fall).asDiagonal();
}

// The residual compliance F beside the first k modes and its Cholesky factor L; its smallest pivot
// relative to `elastic`, 0 where it is not definite.
double take_modes(const FixedInterfaceModes& modes, const Matrix& V, Index k, Index n_rigid,
                  const Matrix& elastic, Matrix& L, Superelement& s) {
  auto& m = s.massless;
  if (m.modes == "tapered" && k > n_rigid) {
    taper(modes, V, k, n_rigid, s);
  } else {
    m.V = V.leftCols(k);
  }
  s.eigenvalues = modes.lambda.head(k);
  // F = F_elastic - V_e diag(1 / lambda) V_e^T   (c x c)
  m.F = elastic;
  const Index e = k - n_rigid;
  if (e > 0) {
    const Matrix B =
        m.V.rightCols(e) * s.eigenvalues.tail(e).cwiseSqrt().cwiseInverse().asDiagonal();
    m.F.selfadjointView<Eigen::Lower>().rankUpdate(B, -1);
    mirror_lower(m.F);
  }
  L = m.F;
  return dense_cholesky(L) ? (L.diagonal().cwiseAbs2().cwiseQuotient(elastic.diagonal())).minCoeff()
                           : 0;
}

// How many elastic modes leave the interface compliance of its own, fewer than k: the more modes,
// the smaller each pivot. 0: none.
Index most_modes(const FixedInterfaceModes& modes, const Matrix& V, Index k, Index n_rigid,
                 const Matrix& elastic, Superelement s) {
  Index works = n_rigid;
  for (Matrix L; k > works + 1;) {
    const Index middle = (works + k) / 2;
    const double pivot = take_modes(modes, V, middle, n_rigid, elastic, L, s);
    (pivot > least_pivot ? works : k) = middle;
  }
  return works - n_rigid;
}

// Definiteness of the residual compliance; omega_closed.
void finish(const Matrix& V, Index k, const Matrix& elastic, MasslessFigures& figures,
            Superelement& s) {
  auto& m = s.massless;
  Matrix L;
  const double pivot = take_modes(figures.free, V, k, figures.n_rigid, elastic, L, s);
  if (!(pivot > least_pivot)) {
    const Index most = most_modes(figures.free, V, k, figures.n_rigid, elastic, s);
    std::string cure = "use basis: craig-bampton";
    if (m.modes == "free") cure = "massless_modes: tapered, whose modes share it, or " + cure;
    if (most > 0) cure = "take modes: " + std::to_string(most) + ", or " + cure;
    throw InputError("modes: " + std::to_string(k - figures.n_rigid) +
                     " free modes leave the interface of " + std::to_string(s.c()) +
                     " dofs no compliance of its own, by which it answers contact: " + cure);
  }
  figures.smallest_pivot = pivot;
  for (int axis = 0; axis < 3; ++axis) {
    Vector t(s.c());
    for (Index i = 0; i < s.c(); ++i) t[i] = s.dof_component[i] == axis ? 1 : 0;
    const double whole = t.dot(elastic * t);
    figures.left[axis] = whole > 0 ? t.dot(m.F * t) / whole : 0;
  }
  // Interface held: diag(lambda) + V^T F^-1 V   (k x k)
  const Matrix W = L.triangularView<Eigen::Lower>().solve(m.V);
  const auto times = [&](const Vector& q, Vector& y) {
    y = s.eigenvalues.cwiseProduct(q) + W.transpose() * (W * q);
  };
  const double lambda = largest_eigenvalue(s.k(), times, [](const Vector& q, Vector& y) { y = q; });
  m.omega_closed = std::sqrt(std::max(lambda, s.eigenvalues.maxCoeff()));
}

void forget_matrices(Superelement& s) {
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
}

}  // namespace

MasslessFigures make_massless(const FreeModel& model, const Partition& p,
                              const SparseCholesky& factor_of_K_II, const FreeModesWanted& wanted,
                              Superelement& s, Report& report) {
  MasslessFigures figures;
  const LargeBlasWork blas(std::pow(static_cast<double>(s.c()), 3));
  Matrix elastic, V;
  FixedInterfaceModes& modes = figures.free;
  Index k = 0;
  {
    const ReductionSolver solver(model, p, factor_of_K_II, s);
    elastic = solver.elastic_compliance(s.M_cc);
    forget_matrices(s);
    const Matrix& N = solver.N();
    const Index r = figures.n_rigid = N.cols();
    const double low = solver.low_eigenvalue();
    if (!(low > 0)) throw RunError("free modes: no elastic motion found");
    modes = free_modes(model, p, -low, r, wanted, k, figures, report);
    require_only_rigid(modes.lambda, r, low);
    // The rigid ones exactly, and nothing of them in the others
    modes.lambda.head(r).setZero();
    auto Phi_e = modes.Phi.rightCols(modes.Phi.cols() - r);
    const Matrix overlap = (model.M * N).transpose() * Phi_e;
    Phi_e.noalias() -= N * overlap;
    modes.Phi.leftCols(r) = N;
    V = modes.Phi(solver.interface_dofs(), Eigen::all);
  }
  s.massless.modes = wanted.tapered ? "tapered" : "free";
  finish(V, k, elastic, figures, s);
  if (const Index e = k - figures.n_rigid; wanted.tapered && e > 0)
    figures.share = s.massless.V.rightCols(e).colwise().squaredNorm().transpose().cwiseQuotient(
        V.middleCols(figures.n_rigid, e).colwise().squaredNorm().transpose());
  if (modes.lambda.size() > k) modes.next = modes.lambda(k);
  return figures;
}

void refuse_mechanism(const SoftestMotion& softest, const std::string& node) {
  if (std::isnan(softest.stiffness))
    throw InputError(
        "basis: massless: the stiffness of the interface is lost in round-off, as that of very "
        "thin parts is" +
        (node.empty() ? "" : ", first at " + node) +
        ": use larger or less flat elements, or basis: craig-bampton");
  if (is_without_stiffness(softest.stiffness))
    throw InputError(
        "basis: massless: the interface has a motion without stiffness that is not rigid, which "
        "moves most at " +
        node +
        ": a mechanism, as elements make that share only an edge or a node, or a part too thin for "
        "a double; mend the mesh there, or use basis: craig-bampton");
}

}  // namespace cbr
