// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/fixed_interface_modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/process.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/sparse/fronts.hpp"

namespace cbr {
namespace {

// Two eigenvalues closer than this are one multiple eigenvalue to the inertia count.
constexpr double relative_gap = basis_precision;
constexpr double to_round_off = 1e-13;
// Candidates for pick: participation (docs/decisions/reduction.md).
constexpr Index least_candidates = 200, candidates_per_mode = 2;
// Twice as many where these are a tenth of all modes: a coarse mesh, whose modes are as short as
// its elements.
constexpr Index coarse_mesh = 10;
// Minutes of dense work and 5 GB, as a last resort.
constexpr Index largest_dense = 15000;

// True if a count would fit this machine beside the matrices and the factor.
bool count_fits(const Partition& p, const SparseCholesky& factor) {
  return factor.bytes() + front_bytes(factor.tree()) + 16 * static_cast<double>(p.K_II.nonZeros()) <
         0.9 * machine_memory_bytes();
}

std::string steps_text(const Eigenpairs& pairs) {
  return std::to_string(pairs.iterations) +
         (pairs.method == "block lanczos in slices" ? " shifts" : " restarts");
}

// Number of eigenvalues of (K_II, M_II) below sigma; a shift that hits an eigenvalue is moved up by
// a hair.
Index inertia_below(const Partition& p, const SparseCholesky& factor, double sigma,
                    Report& report) {
  const Progress progress = [&](double share) {
    report.progress("counting modes below a frequency", share);
  };
  for (int attempt = 0; attempt < 5; ++attempt) {
    const Index count = negative_inertia(p.K_II, sigma, p.M_II, factor, progress);
    report.end_progress();
    if (count >= 0) return count;
    sigma *= 1 + 1e-10;
  }
  throw RunError("the eigenvalues below (" + std::to_string(std::sqrt(sigma)) +
                 " rad/s)^2 cannot be counted: every shift nearby meets a vanishing pivot: the "
                 "stiffness is near singular, or a cutoff was chosen among many equal frequencies; "
                 "look at the conditioning (--verbose), or ask for another cutoff, or a few more "
                 "or fewer modes");
}

// The highest gap in lambda that a shift fits into: index j with lambda(j) well above lambda(j -
// 1); 0 when there is none.
Index last_gap(const Vector& lambda) {
  Index j = lambda.size() - 1;
  while (j > 0 && lambda(j) - lambda(j - 1) < relative_gap * lambda(j)) --j;
  return j;
}

// Modes that the eigensolver missed below its last one; 0 when none is. `counts`: a text of the
// counts.
Index n_missed(const Partition& p, const SparseCholesky& factor, const Vector& lambda,
               std::string& counts, Report& report) {
  const Index j = last_gap(lambda);
  const double sigma = j > 0 ? 0.5 * (lambda(j) + lambda(j - 1)) : 0.5 * lambda(0);
  const Index below = inertia_below(p, factor, sigma, report);
  char text[96];
  std::snprintf(text, sizeof text, "%lld below %.6g Hz, %lld found", static_cast<long long>(below),
                std::sqrt(sigma) / (2 * std::numbers::pi), static_cast<long long>(j));
  counts += (counts.empty() ? "" : "; ") + std::string(text);
  return below - j;
}

FixedInterfaceModes dense_modes(const Partition& p, Index k) {
  Eigenpairs pairs = p.lumped ? dense_eigenpairs(Matrix(p.K_II), Vector(p.M_II.diagonal()), k)
                              : dense_eigenpairs(Matrix(p.K_II), Matrix(p.M_II), k);
  if (!pairs.converged) throw RunError("the dense eigensolver failed on the fixed-interface modes");
  return {std::move(pairs.lambda), std::move(pairs.Phi), pairs.method, true};
}

// `k` and one more.
FixedInterfaceModes sparse_modes(const Partition& p, const SparseCholesky& factor, Index k,
                                 double residual, Report& report) {
  const Index n = p.n_interior();
  Index ncv = 0;
  std::string counts;
  for (int attempt = residual > to_round_off ? 0 : 1; attempt < 3; ++attempt) {
    Eigenpairs pairs =
        sparse_eigenpairs(p.K_II, p.M_II, factor, 0, k, attempt == 0 ? residual : to_round_off, ncv,
                          [&](double share) { report.progress("fixed-interface modes", share); });
    if (!pairs.converged && n <= largest_dense) return dense_modes(p, k);
    if (!pairs.converged) {
      throw RunError("fixed-interface modes: " + std::to_string(pairs.n_converged) + " of " +
                     std::to_string(k) + " converged in " + std::to_string(pairs.iterations) +
                     " restarts of the eigensolver: ask for a few more or fewer modes");
    }
    report.end_progress();
    report.detail(pairs.method + ": " + steps_text(pairs));
    FixedInterfaceModes modes{std::move(pairs.lambda), std::move(pairs.Phi), pairs.method, true};
    if (pairs.method != "lapack") modes.proven = count_fits(p, factor);
    const bool is_all = pairs.method == "lapack" || !modes.proven ||
                        n_missed(p, factor, modes.lambda, counts, report) == 0;
    modes.counts = counts;
    if (is_all) return modes;
    // First all to round-off; then a larger Krylov space, which gives the lost copy of a multiple
    // eigenvalue the round-off to grow from.
    if (attempt == 0) {
      report.detail("the inertia count found a missed mode: again, to round-off");
      continue;
    }
    ncv = std::min(n, 3 * k + 40);
    report.detail("the inertia count found a missed mode: again with " + std::to_string(ncv) +
                  " Lanczos vectors");
  }
  // Many identical parts have eigenvalues of high multiplicity, which only the dense solver cannot
  // miss.
  if (n <= largest_dense) return dense_modes(p, k);
  throw RunError(
      "fixed-interface modes: the eigensolver misses one below the last (inertia count), as it may "
      "with many identical parts: reduce the parts on their own");
}

// Both sets of modes in one, ascending.
FixedInterfaceModes merged(FixedInterfaceModes&& a, const Eigenpairs& b) {
  const Index n_a = a.lambda.size(), n = n_a + b.lambda.size();
  Vector lambda(n);
  lambda << a.lambda, b.lambda;
  std::vector<Index> order = order_by(n, [&](Index i, Index j) { return lambda(i) < lambda(j); });
  a.Phi.conservativeResize(Eigen::NoChange, n);
  a.Phi.rightCols(b.lambda.size()) = b.Phi;
  a.lambda = lambda(order);
  if (!std::is_sorted(order.begin(), order.end())) a.Phi = Matrix(a.Phi(Eigen::all, order));
  return std::move(a);
}

// Non-zeros of a factor whose solves cost as much as the products with M_II, where these count:
// joined domains, whose M_II is a sum of dense blocks.
double product_cost(const SparseMatrix& M_II) {
  const auto n = static_cast<double>(M_II.rows()), nonzeros = static_cast<double>(M_II.nonZeros());
  return nonzeros > 0.03 * n * n ? 20 * nonzeros : 0;
}

}  // namespace

bool dense_is_faster(Index n, Index k, double factor_nonzeros) {
  const auto N = static_cast<double>(n), m = static_cast<double>(k);
  // Seconds on the machine of the measurements; only their ratio counts. Dense: the reduction to
  // tridiagonal form. Sparse: about five solves per mode, and the products that keep the basis of
  // its slice orthonormal.
  const double dense = 1.0e-10 * N * N * N;
  const double slice = std::min(m, 120.0);
  const double sparse = m * (1.1e-9 * factor_nonzeros + 5e-9 * N * slice);
  return n <= 200 || 2 * k > n || dense < sparse;
}

void require_dofs_for_modes(Index k, Index n) {
  if (k > n)
    throw InputError("modes: " + std::to_string(k) + " requested, but the interior has only " +
                     std::to_string(n) + " dofs and so " + std::to_string(n) +
                     " fixed-interface modes: ask for at most that many");
}

FixedInterfaceModes fixed_interface_modes(const Partition& partition, const SparseCholesky& factor,
                                          Index k, Report& report, double residual) {
  const Index n = partition.n_interior();
  require_dofs_for_modes(k, n);
  FixedInterfaceModes none{Vector(0), Matrix(n, 0), "none", true};
  if (k == 0) return none;
  const Index asked = std::min(k + 1, n);  // one more, to detect a twin of the last
  FixedInterfaceModes modes =
      dense_is_faster(n, k, factor.n_nonzeros() + product_cost(partition.M_II))
          ? dense_modes(partition, asked)
          : sparse_modes(partition, factor, asked, residual, report);
  if (asked == k) return modes;
  modes.next = modes.lambda(k);
  modes.lambda.conservativeResize(k);
  modes.Phi.conservativeResize(Eigen::NoChange, k);
  return modes;
}

FixedInterfaceModes more_modes(const Partition& partition, const SparseCholesky& factor,
                               FixedInterfaceModes known, Index k, Report& report) {
  const Index n = partition.n_interior(), have = known.lambda.size();
  k = std::min(k, n);
  if (have >= k) return known;
  if (dense_is_faster(n, k, factor.n_nonzeros() + product_cost(partition.M_II)))
    return fixed_interface_modes(partition, factor, n, report);
  if (have == 0) return fixed_interface_modes(partition, factor, k, report);
  const Progress progress = [&](double share) {
    report.progress("fixed-interface modes, " + std::to_string(have) + " to " + std::to_string(k),
                    share);
  };
  FixedInterfaceModes all;
  Eigenpairs found = sparse_eigenpairs_onwards(
      partition.K_II, partition.M_II, factor, {known.lambda, known.Phi}, k, to_round_off, progress);
  if (found.converged) {
    all.lambda = std::move(found.lambda);
    all.Phi = std::move(found.Phi);
  } else {
    found = sparse_eigenpairs_beyond(partition.M_II, factor, known.Phi, k - have, to_round_off,
                                     progress);
    if (found.converged) all = merged(std::move(known), found);
  }
  report.end_progress();
  if (found.converged) {
    all.method = found.method;
    report.detail(found.method + ": " + std::to_string(k - have) + " modes more, " +
                  steps_text(found));
    all.proven = count_fits(partition, factor);
    if (!all.proven || n_missed(partition, factor, all.lambda, all.counts, report) == 0) return all;
  }
  return fixed_interface_modes(partition, factor, k, report);
}

Index count_modes_below(const Partition& partition, const SparseCholesky& factor,
                        double frequency_hz, Report& report) {
  const double omega = 2 * std::numbers::pi * frequency_hz;
  return inertia_below(partition, factor, omega * omega, report);
}

Index n_mode_candidates(Pick pick, Index wanted, Index n_interior) {
  if (pick != Pick::participation || wanted == 0 || wanted >= n_interior) return wanted;
  const Index candidates = candidates_per_mode * wanted;
  const bool is_coarse = 2 * candidates * coarse_mesh > n_interior;
  return std::min(n_interior, std::max((is_coarse ? 2 : 1) * candidates, least_candidates));
}

std::vector<Index> modes_by_participation(const Matrix& M_kc, Index count) {
  const Vector participation = M_kc.rowwise().squaredNorm();
  std::vector<Index> order =
      order_by(M_kc.rows(), [&](Index a, Index b) { return participation(a) > participation(b); });
  order.resize(std::min<Index>(count, M_kc.rows()));
  std::sort(order.begin(), order.end());
  return order;
}

void check_modes_wanted(const ReductionOptions& options) {
  if (options.modes.has_value() + options.cutoff_hz.has_value() + options.tolerance.has_value() !=
      1) {
    throw InputError(
        options.source.text() +
        ": exactly one of modes, cutoff_hz and tolerance says how many modes are kept");
  }
  if (options.tolerance) {
    if (*options.tolerance > 0 && *options.tolerance < 1) return;
    throw InputError("tolerance: " + std::to_string(*options.tolerance) +
                     " found, a share between 0 and 1 is allowed");
  }
  if (options.modes) {
    if (*options.modes < 0)
      throw InputError("modes: " + std::to_string(*options.modes) + " found, 0 or more allowed");
    return;
  }
  if (!(*options.cutoff_hz > 0) || !(*options.cutoff_hz < 1e100)) {
    throw InputError("cutoff_hz: " + number_text(*options.cutoff_hz) +
                     " found, a frequency in Hz above 0 and below 1e100 is allowed");
  }
}

void warn_of_cut_pair(const Vector& lambda, double next, Report& report) {
  constexpr double alike = 1e-6;
  const Index k = lambda.size();
  if (k == 0 || next == 0 || next - lambda(k - 1) > alike * next) return;
  char text[256];
  std::snprintf(text, sizeof text,
                "modes: the last that is kept, number %lld, and the next have the same frequency "
                "(%.6g Hz, to %.0e): which of their shapes is kept depends on round-off, and so on "
                "threads and machine: keep one more, or one fewer",
                static_cast<long long>(k), std::sqrt(next) / (2 * std::numbers::pi),
                1 - std::sqrt(std::max(lambda(k - 1), 0.0) / next));
  report.warning(text);
}

}  // namespace cbr
