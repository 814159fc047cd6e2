// SPDX-License-Identifier: GPL-3.0-or-later
// Predicted times and memory. What the rates of each phase relative to dgemm rest on:
// docs/decisions/decomposition.md.
#include <algorithm>
#include <cmath>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/spectrum_slices.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

// Ordering, symbolic analysis and condition numbers, seconds for each non-zero of K: most of the
// time of a small factorisation.
constexpr double analysis_seconds = 2e-7;
// Shares of dgemm's rate (docs/benchmarks.md, "Reduction").
constexpr double factor_rate = 0.5, solve_rate = 0.5, product_rate = 0.8, count_rate = 0.5;
// Block Lanczos: solves of eight columns, which wait for the factor to come from memory, and
// products with the basis.
constexpr double narrow_solve_rate = 0.5, orthonormalise_rate = 0.2;
// Its vectors for k modes, and what of them where most modes are wanted in outline only. Free modes
// take so many each, and so do modes of a slice.
constexpr double vectors_per_mode = 2.6, first_vectors = 190, in_outline = 0.8,
                 vectors_per_free_mode = 4.5, vectors_per_sliced_mode = 4;
// Of the 4 nnz(L) flops of a column of constraint modes, as the forward solve skips what K_IC does
// not reach; and of a second solve.
constexpr double solved_share = 0.8;
// Condensation with the factorisation: of the factor's flops and of c^3, beyond those of the factor
// (counted: faces of blocks and of an ordinary part).
constexpr double front_share = 3.9, front_cube = 2.0;
// Dense eigenproblems, in n^3 flops at dgemm's rate.
constexpr double dense_standard = 10, dense_general = 20;
// Of the last front, K and M, and of what its children give it: squares of c.
constexpr double front_squares = 4;
constexpr double bytes_of_program = 32e6;

// Solves, and products with all vectors before, of so many vectors of n numbers.
double lanczos_seconds(double vectors, double n, double factor_nonzeros, double flops) {
  return 4 * vectors * factor_nonzeros / (narrow_solve_rate * flops) +
         2 * n * vectors * vectors / (orthonormalise_rate * flops);
}

bool product_is_taken(const DomainEstimate& d, double memory) {
  return 8 * d.n_interior() * d.c() <= memory &&
         solved_share * 4 * d.factor_nonzeros / solve_rate >= d.n_interior() * d.c() / product_rate;
}

double modes_seconds(const DomainEstimate& d, double flops) {
  const double n = d.n_interior(), k = static_cast<double>(d.n_candidates);
  if (k == 0 || n == 0) return 0;
  if (dense_is_faster(static_cast<Index>(n), d.n_candidates, d.factor_nonzeros))
    return dense_standard * n * n * n / flops;
  const Index width = slice_width(static_cast<Index>(n), d.factor_flops);
  const bool outlines = d.n_candidates > d.n_modes;
  if (slices_pay(d.n_candidates, width, outlines)) {
    const auto w = static_cast<double>(width);
    return k / w *
           (lanczos_seconds(vectors_per_sliced_mode * w, n, d.factor_nonzeros, flops) +
            d.factor_flops / (count_rate * flops));
  }
  const double vectors = (vectors_per_mode * k + first_vectors) * (outlines ? in_outline : 1);
  return lanczos_seconds(std::min(vectors, n), n, d.factor_nonzeros, flops) +
         d.factor_flops / (count_rate * flops);
}

// Condensation to the interface, in flops at dgemm's rate: by solves for constraint modes, and
// front by front.
double solves_work(const DomainEstimate& d, double memory) {
  const double solves = solved_share * 4 * d.factor_nonzeros * d.c() / solve_rate;
  const double product = d.n_interior() * d.c() * d.c() / product_rate;
  return solves + (product_is_taken(d, memory) ? product : solves);
}

double fronts_work(const DomainEstimate& d) {
  return (front_share * d.factor_flops + front_cube * std::pow(d.c(), 3)) / factor_rate;
}

// `by_fronts`: nothing reads the constraint modes.
double condensation_seconds(const DomainEstimate& d, double memory, bool by_fronts, double flops) {
  const double coupling = std::min(2 * d.n_interior() * d.k() * d.c() / product_rate,
                                   4 * d.factor_nonzeros * d.k() / solve_rate);
  const double by_solves = solves_work(d, memory);
  const double condensed = by_fronts ? std::min(fronts_work(d), by_solves) : by_solves;
  return (coupling + condensed) / flops;
}

// Dense but for the elimination of the interior: its K is sparse by dense blocks, its M as well.
double second_seconds(const DomainEstimate& d, double flops) {
  const double n = d.n_interior(), c = d.c(), k = d.k();
  const double condensation = (4 * d.factor_nonzeros * c + 2 * n * k * c) / (solve_rate * flops) +
                              n * c * c / (product_rate * flops);
  const double modes =
      lanczos_seconds(vectors_per_mode * k + first_vectors, n, d.factor_nonzeros, flops);
  return d.factor_flops / (factor_rate * flops) + condensation +
         std::min(modes, dense_general * n * n * n / flops);
}

// The lowest elastic modes of the free component, and answers to the static forces.
double shapes_seconds(const FewShapesEstimate& few, double n, double flops) {
  const double looked_at = static_cast<double>(std::max(n_estimated, few.n_shapes - 6));
  return lanczos_seconds(vectors_per_free_mode * looked_at, n, few.whole_nonzeros, flops) +
         few.forces_flops / (solve_rate * flops);
}

// Matrices, factors and, one after the other, a Krylov space and the statics.
double few_shapes_memory(const Estimate& estimate) {
  const DomainEstimate& d = estimate.domains.front();
  const FewShapesEstimate& few = *estimate.few_shapes;
  const auto s = static_cast<double>(few.n_static);
  const double matrices = 2 * 16 * d.mesh_nonzeros;
  const double basis = 2 * 8 * d.n_interior() * 2 *
                       static_cast<double>(std::max<Index>(d.n_candidates, n_estimated));
  return bytes_of_program + matrices + 8 * (few.whole_nonzeros + d.factor_nonzeros) +
         std::max(basis, 3 * 8 * s * s) + 8 * estimate.file_nonzeros();
}

// Entries of half of K_cc, which is symmetric, and of M_kc twice.
double step_entries(const DomainEstimate& d) { return d.c() * (d.c() + 1) / 2 + 2 * d.k() * d.c(); }

}  // namespace

PredictedTimes predicted_times(const Estimate& estimate, const MachineRates& rates, double memory) {
  PredictedTimes t;
  double blocks = 0;
  for (const auto& d : estimate.domains) {
    const bool sparse = estimate.few_shapes && estimate.few_shapes->is_sparse;
    const double factor_flops = sparse ? estimate.few_shapes->whole_flops : d.factor_flops;
    t.factorisation +=
        factor_flops / (factor_rate * rates.flops) + analysis_seconds * d.mesh_nonzeros;
    t.modes += modes_seconds(d, rates.flops);
    t.condensation += sparse ? shapes_seconds(*estimate.few_shapes, d.n_interior(), rates.flops)
                             : condensation_seconds(d, memory, !estimate.has_recovery, rates.flops);
    blocks += step_entries(d);
  }
  if (estimate.second) blocks = step_entries(*estimate.second);
  if (estimate.second) t.second = second_seconds(*estimate.second, rates.flops);
  const double n = estimate.n_final(),
               c = 3 * static_cast<double>(estimate.second ? estimate.n_interface_nodes
                                                           : estimate.n_joined_nodes);
  // Few shapes of dense matrices take the eigenvalues of all of the interface's dofs
  if (estimate.few_shapes && !estimate.few_shapes->is_sparse)
    t.diagonal_form = dense_general * c * c * c / rates.flops;
  if (estimate.has_diagonal_form) t.diagonal_form = dense_general * n * n * n / rates.flops;
  const auto step = [&](double bytes) {
    return PredictedTimes::Step{bytes, bytes / rates.bandwidth};
  };
  t.exact = step(8 * 8 * n);
  t.exact_in_contact =
      step(8 * 8 * n + 2 * 8 * n * 3 * static_cast<double>(estimate.n_interface_nodes));
  if (estimate.few_shapes) {
    // Displacements along the forces and responses to them; the statics' factor, forward and
    // backward
    const auto s = static_cast<double>(estimate.few_shapes->n_static);
    const double looked_at = s > 0 ? s : 3 * static_cast<double>(estimate.n_interface_nodes);
    t.exact_in_contact = step(8 * 8 * n + 2 * 8 * n * looked_at + 8 * s * s);
  }
  // K_cc and M_kc of each domain, and the factor forward and backward.
  t.central_difference = step(8 * (blocks + 2 * estimate.joined_factor_nonzeros + 8 * (n + c)));
  if (estimate.few_shapes) t.central_difference = t.exact;
  t.newmark = t.central_difference;
  t.mesh =
      step(76.0 / 9 * estimate.mesh_nonzeros + 8 * 8 * 3 * static_cast<double>(estimate.n_nodes));
  return t;
}

double reduction_memory(const Estimate& estimate, double memory) {
  double most = 0, results = 0;
  for (const auto& d : estimate.domains) {
    results += 8 * d.block_nonzeros();
    const double matrices = 2 * 16 * d.mesh_nonzeros;  // K, and its blocks K_II, K_IC, K_CC
    const double panels =
        std::min(memory, 16 * d.n_interior() * static_cast<double>(good_panel * n_threads()));
    const double Psi = panels + (product_is_taken(d, memory) ? 8 * d.n_interior() * d.c() : 0);
    // the Lanczos basis of about 2 k vectors, and Phi twice
    const double modes = 2 * 8 * d.n_interior() * d.k() * 2;
    // Which way is taken is counted later: as much as the larger of both
    const double fronts = estimate.has_recovery ? 0 : front_squares * 8 * d.c() * d.c();
    const double condensing = std::max(fronts, Psi + modes);
    most = std::max(most, bytes_of_program + matrices + 8 * d.factor_nonzeros +
                              std::max(condensing, 2 * modes));
  }
  const double n = estimate.n_final();
  if (estimate.few_shapes && estimate.few_shapes->is_sparse) return few_shapes_memory(estimate);
  if (estimate.second)
    results += 8 * (2 * estimate.second->n_interior() * estimate.second->c() +
                    estimate.second->factor_nonzeros);
  results += 8 * estimate.recovery_nonzeros();
  return results + std::max(most, estimate.has_diagonal_form ? 4 * 8 * n * n : 0.0);
}

}  // namespace cbr
