// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condition.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.hpp"
#include "common/format_text.hpp"

namespace cbr {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Beyond these a warning is due: four digits are left of sixteen; a mode in another; forces on a body that only moves.
constexpr double poor_condition = 1e12, poor_pivot = 1e-11, poor_modes = 1e-6, poor_rigid = 1e-8, lost_rigid = 1e-6;
// Of the stiffness against a motion beside that of its own diagonal: below it is a mechanism, or as good as one.
constexpr double no_stiffness = 1e-12;
// Of the largest eigenvalue's round-off: a lowest elastic one below it has less than three digits.
constexpr double few_digits = 1e3;

Vector random_signs(Index n) {
  Vector z(n);
  std::uint64_t state = 1;
  for (double& entry : z) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    entry = (state >> 63) != 0 ? 1.0 : -1.0;
  }
  return z;
}

double column_norm(const SparseMatrix& A, const Vector& D) {
  double largest = 0;
  for (Index j = 0; j < A.cols(); ++j) {
    double sum = 0;
    for (SparseMatrix::InnerIterator it(A, j); it; ++it) sum += std::abs(it.value()) * D(it.row());
    largest = std::max(largest, sum * D(j));
  }
  return largest;
}

// Of M^ scaled by D on both sides.
double mass_norm(const Superelement& s, const Vector& D) {
  const auto D_k = D.head(s.k()), D_c = D.tail(s.c());
  double largest = 0;
  for (Index j = 0; j < s.c(); ++j) {
    double sum = s.M_cc.col(j).cwiseAbs().dot(D_c);
    if (s.k() > 0) sum += s.M_kc.col(j).cwiseAbs().dot(D_k);
    largest = std::max(largest, sum * D_c(j));
  }
  for (Index i = 0; i < s.k(); ++i) largest = std::max(largest, (D_k(i) + s.M_kc.row(i).transpose().cwiseAbs().dot(D_c)) * D_k(i));
  return largest;
}

template <typename Rows>
RigidResidual worst_row(Index n, const Matrix& R, Rows absolute_sum, const Matrix& KR) {
  RigidResidual worst;
  const Eigen::RowVectorXd size = R.cwiseAbs().colwise().maxCoeff();
  for (Index i = 0; i < n; ++i) {
    for (Index c = 0; c < R.cols(); ++c) {
      const double scale = absolute_sum(i) * size(c);
      const double share = scale > 0 ? std::abs(KR(i, c)) / scale : 0.0;
      if (share > worst.value) worst = {share, i};
    }
  }
  return worst;
}

std::string known(double value) { return std::isnan(value) ? "not computed" : format_text("%.1e", value); }

double hertz(double omega) { return omega / (2 * std::numbers::pi); }

int digits_lost(double condition) { return static_cast<int>(std::min(15L, std::lround(std::log10(std::max(condition, 1.0))))); }

}  // namespace

double inverse_norm(Index n, const std::function<void(Vector&)>& solve) {
  if (n == 0) return 0;
  constexpr int most_rounds = 5;
  Vector x = Vector::Constant(n, 1.0 / static_cast<double>(n));
  double norm = 0;
  Index last = -1;
  for (int round = 0; round < most_rounds; ++round) {
    Vector y = x;
    solve(y);
    const double found = y.lpNorm<1>();
    if (round > 0 && !(found > norm)) break;
    norm = found;
    Vector z = y.unaryExpr([](double v) { return v >= 0 ? 1.0 : -1.0; });
    solve(z);
    Index j = 0;
    const double steepest = z.cwiseAbs().maxCoeff(&j);
    if (!(steepest > z.dot(x)) || j == last) break;
    x.setZero();
    x(j) = 1;
    last = j;
  }
  // Higham's second guess, for matrices that are made to mislead the first.
  for (Index i = 0; i < n; ++i)
    x(i) = (i % 2 == 0 ? 1 : -1) * (1 + static_cast<double>(i) / static_cast<double>(std::max<Index>(n - 1, 1)));
  solve(x);
  return std::max(norm, 2 * x.lpNorm<1>() / (3 * static_cast<double>(n)));
}

ConditionNumbers condition_numbers(const SparseMatrix& A, const SparseCholesky& factor) {
  const Index n = A.rows();
  if (n == 0) return {1, 1};
  const Vector diagonal = A.diagonal(), D = diagonal.cwiseSqrt().cwiseInverse();
  ConditionNumbers numbers;
  numbers.plain = column_norm(A, Vector::Ones(n)) * inverse_norm(n, [&](Vector& x) { factor.solve(x.data(), x.data()); });
  // (D A D)^-1 = D^-1 A^-1 D^-1
  numbers.scaled = column_norm(A, D) * inverse_norm(n, [&](Vector& x) {
                     x = x.cwiseQuotient(D);
                     factor.solve(x.data(), x.data());
                     x = x.cwiseQuotient(D);
                   });
  return numbers;
}

ConditionNumbers reduced_mass_condition(const Superelement& s) {
  const Index k = s.k(), c = s.c(), n = s.n();
  if (n == 0) return {1, 1};
  Matrix M_res = s.M_cc;
  if (k > 0) M_res.noalias() -= s.M_kc.transpose() * s.M_kc;
  const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(M_res);  // in place
  const double infinite = std::numeric_limits<double>::infinity();
  if (cholesky.info() != Eigen::Success) return {infinite, infinite};
  // M^-1 [a; b]: y_c = M_res^-1 (b - M_kc^T a), y_k = a - M_kc y_c
  const auto solve = [&](Vector& x) {
    if (c == 0) return;
    Vector y = x.tail(c);
    if (k > 0) y.noalias() -= s.M_kc.transpose() * x.head(k);
    y = cholesky.solve(y);
    if (k > 0) x.head(k).noalias() -= s.M_kc * y;
    x.tail(c) = y;
  };
  Vector D = Vector::Ones(n);
  ConditionNumbers numbers;
  numbers.plain = mass_norm(s, D) * inverse_norm(n, solve);
  D.tail(c) = s.M_cc.diagonal().cwiseSqrt().cwiseInverse();
  numbers.scaled = mass_norm(s, D) * inverse_norm(n, [&](Vector& x) {
                     x = x.cwiseQuotient(D);
                     solve(x);
                     x = x.cwiseQuotient(D);
                   });
  return numbers;
}

ModeCheck check_modes(const Partition& p, const Vector& lambda, const Matrix& Phi) {
  ModeCheck check;
  const Index k = lambda.size();
  if (k == 0) return check;
  const Vector z = random_signs(k);
  const Vector M_Phi_z = p.M_II * Vector(Phi * z);
  check.orthogonality = (Phi.transpose() * M_Phi_z - z).cwiseAbs().maxCoeff(&check.worst);
  const Vector w = Phi * z.cwiseQuotient(lambda);
  check.residual = (p.K_II * w - M_Phi_z).norm() / M_Phi_z.norm();
  return check;
}

void require_independent(const Partition& p, const Matrix& Phi, const ModeCheck& check) {
  if (check.worst < 0 || check.orthogonality <= poor_modes) return;
  Vector overlap = Phi.transpose() * Vector(p.M_II * Phi.col(check.worst));
  overlap(check.worst) = 0;
  Index other = 0;
  const double share = overlap.cwiseAbs().maxCoeff(&other);
  throw RunError(format_text(
      "fixed-interface modes %lld and %lld are not independent of each other (Phi^T M Phi is %.2g between them, not "
      "0): the eigensolver has found one twice; ask for a few more or fewer modes",
      static_cast<long long>(std::min(other, check.worst) + 1), static_cast<long long>(std::max(other, check.worst) + 1), share));
}

RigidResidual rigid_residual(const SparseMatrix& K, const Matrix& R) {
  Vector sums = Vector::Zero(K.rows());
  for (Index j = 0; j < K.cols(); ++j)
    for (SparseMatrix::InnerIterator it(K, j); it; ++it) sums(it.row()) += std::abs(it.value());
  return worst_row(
      K.rows(), R, [&](Index i) { return sums(i); }, K * R);
}

RigidResidual rigid_residual(const Matrix& K, const Matrix& R) {
  // Rows may be 0 but for round-off: what is not stiff at all is measured by what is stiffest.
  const double largest = K.rows() > 0 ? K.cwiseAbs().rowwise().sum().maxCoeff() : 0.0;
  return worst_row(
      K.rows(), R, [&](Index) { return largest; }, K * R);
}

SoftestMotion softest_motion(Matrix K, const Matrix& R) {
  const Index n = K.rows();
  if (n <= R.cols()) return {};
  // A row without any stiffness keeps its scale
  const double largest = K.diagonal().maxCoeff();
  if (!(largest > 0)) return {};
  const Vector D = K.diagonal().unaryExpr([&](double d) { return 1 / std::sqrt(d > 0 ? d : largest); });
  K = D.asDiagonal() * K * D.asDiagonal();
  // The rigid motions held by springs of the size of its diagonal; what then is soft still is another motion
  const Matrix Q = Eigen::HouseholderQR<Matrix>(D.cwiseInverse().asDiagonal() * R).householderQ() * Matrix::Identity(n, R.cols());
  const Matrix scaled = K;
  K.noalias() += Q * Q.transpose();
  K.diagonal().array() += 1e-2 * no_stiffness;       // so that a factor exists
  const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(K);  // in place
  if (cholesky.info() != Eigen::Success) return {};
  Vector x = random_signs(n).normalized();
  for (int i = 0; i < 3; ++i) {
    x -= Q * (Q.transpose() * x);
    x = cholesky.solve(x);
    x.normalize();
  }
  x -= Q * (Q.transpose() * x);
  SoftestMotion softest;
  softest.stiffness = std::max(0.0, x.dot(scaled * x) / x.squaredNorm());
  x.cwiseProduct(D).cwiseAbs().maxCoeff(&softest.dof);
  return softest;
}

bool is_without_stiffness(double softest) { return softest < no_stiffness; }

Index examine_reduced(const Superelement& s, const Matrix& rigid, ReductionCondition& c) {
  Index dof = -1;
  c.mass = reduced_mass_condition(s);
  if (!s.has_diagonal_form()) {
    const SoftestMotion softest = softest_motion(s.K_cc, rigid.bottomRows(s.c()));
    c.softest = softest.stiffness;
    return is_without_stiffness(c.softest) ? softest.dof : -1;
  }
  c.n_zero = (s.omega.array() == 0).count();
  c.largest_omega = s.omega(s.n() - 1);
  if (c.n_zero < s.n()) c.lowest_omega = s.omega(c.n_zero);
  if (c.n_zero > c.n_rigid) s.V.col(c.n_rigid).tail(s.c()).cwiseAbs().maxCoeff(&dof);
  return dof;
}

void require_free(const ReductionCondition& c) {
  if (!(c.reduced_rigid > lost_rigid)) return;
  throw InputError(
      format_text("the stiffness is too ill-conditioned (%.0e, scaled by its diagonal) to be reduced: by round-off the reduced one "
                  "resists rigid motions by %.0e of its size",
                  c.K_II.scaled, c.reduced_rigid) +
      "; look for parts of very unlike stiffness, slivers, Poisson's ratio near 0.5, an interface nearly on one line" +
      (c.weakest.empty() ? "" : ", first at " + c.weakest));
}

void report_figures(const ReductionCondition& c, Report& report, bool of_domain) {
  report.detail("condition of K_II: " + known(c.K_II.plain) + ", scaled by its diagonal " + known(c.K_II.scaled) +
                "; weakest pivot " + known(c.smallest_pivot) + (c.weakest.empty() ? "" : " at " + c.weakest));
  if (!of_domain)
    report.detail("condition of the reduced mass: " + known(c.mass.plain) + ", scaled by its diagonal " + known(c.mass.scaled));
  report.detail((c.has_modes ? format_text("modes: Phi^T M Phi - I %.1e, residual %.1e; ", c.modes.orthogonality, c.modes.residual)
                             : std::string("modes: not checked; ")) +
                (c.counts.empty() ? "no inertia counted" : "inertia counts " + c.counts));
  report.detail("rigid motions: forces of K " + known(c.rigid) + ", of the reduced K " + known(c.reduced_rigid));
  if (of_domain) return;
  if (c.largest_omega > 0) {
    report.detail(format_text("reduced frequencies: %lld are 0, lowest other %.6g Hz, highest %.6g Hz (critical step %.4g s)",
                              static_cast<long long>(c.n_zero), hertz(c.lowest_omega), hertz(c.largest_omega),
                              2 / c.largest_omega));
  } else {
    report.detail("reduced frequencies: not computed; the least stiffness against a motion that is not rigid, of its diagonal: " +
                  known(c.softest));
  }
}

void warn_of_condition(const ReductionCondition& c, Report& report) {
  if (c.K_II.scaled > poor_condition || c.smallest_pivot < poor_pivot)
    report.warning(format_text("the stiffness of the interior is ill-conditioned (%.0e): about %d of 16 digits are lost; ",
                               c.K_II.scaled, digits_lost(c.K_II.scaled)) +
                   "look for slivers, thin parts, Poisson's ratio near 0.5, parts of very unlike stiffness" +
                   (c.weakest.empty() ? "" : ", first at " + c.weakest));
  if (c.mass.scaled > poor_condition)
    report.warning(
        format_text("the reduced mass is ill-conditioned (%.0e): about %d of 16 digits are lost; ", c.mass.scaled,
                    digits_lost(c.mass.scaled)) +
        "keep fewer modes, or widen the interface: its nodes may hold the rest as a needle's point does, or be much lighter");
  if (c.modes.residual > poor_modes)
    report.warning(
        format_text("the fixed-interface modes are inaccurate (residual %.0e): look for the cause in the stiffness of the "
                    "interior, or ask for fewer modes",
                    c.modes.residual));
  const double rigid = std::fmax(c.rigid, c.reduced_rigid);  // that which is known
  if (rigid > poor_rigid)
    report.warning(format_text("the stiffness resists rigid motions by %.0e of its size", rigid) +
                   (c.rigid_node.empty() ? "" : ", most at " + c.rigid_node) +
                   ": free bodies will not move freely; look for very thin or very distorted elements there");
  if (c.n_zero > c.n_rigid)
    report.warning(
        format_text("the reduced component has %lld motion%s without stiffness beside its %lld rigid ones: a mechanism, which will "
                    "move freely, or a part too soft for a double beside the rest",
                    static_cast<long long>(c.n_zero - c.n_rigid), c.n_zero - c.n_rigid == 1 ? "" : "s",
                    static_cast<long long>(c.n_rigid)) +
        (c.loose_node.empty() ? "" : "; it moves most at " + c.loose_node));
  if (is_without_stiffness(c.softest))
    report.warning(
        format_text("the reduced component has a motion without stiffness (%.0e of its diagonal) beside its rigid ones: a "
                    "mechanism, which will move freely, or a part too soft for a double beside the rest",
                    c.softest) +
        (c.loose_node.empty() ? "" : "; it moves most at " + c.loose_node));
  const double digits = c.lowest_omega * c.lowest_omega / (epsilon * c.largest_omega * c.largest_omega);
  if (c.lowest_omega > 0 && digits < few_digits)
    report.warning(
        format_text("the lowest elastic frequency, %.4g Hz, is so far below the highest, %.4g Hz, that %s of its digits are right: "
                    "use larger or less flat elements where they are stiffest",
                    hertz(c.lowest_omega), hertz(c.largest_omega), digits < 10 ? "none" : "one or two"));
}

}  // namespace cbr
