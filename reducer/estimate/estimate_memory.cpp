// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes that steps read, and memory while reducing.
#include <algorithm>

#include "common/linalg/blas_threads.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

// Rates relative to dgemm's of solves for constraint modes, of nnz(L) times 4 flops a column, and
// of products with them. And the fraction of those flops that the forward solve does not skip.
constexpr double solve_rate = 0.5, product_rate = 0.8, solved_share = 0.8;
// Of the last front, K and M, and of its children's updates: squares of c.
constexpr double front_squares = 4;
constexpr double bytes_of_program = 32e6;

bool product_is_taken(const DomainEstimate& d, double memory) {
  return 8 * d.n_interior() * d.c() <= memory &&
         solved_share * 4 * d.factor_nonzeros / solve_rate >= d.n_interior() * d.c() / product_rate;
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

StepBytes step_bytes(const Estimate& estimate) {
  double blocks = 0;
  for (const auto& d : estimate.domains) blocks += step_entries(d);
  if (estimate.second) blocks = step_entries(*estimate.second);
  const double n = estimate.n_final(),
               c = 3 * static_cast<double>(estimate.second ? estimate.n_interface_nodes
                                                           : estimate.n_joined_nodes);
  StepBytes bytes;
  bytes.exact = 8 * 8 * n;
  bytes.exact_in_contact =
      8 * 8 * n + 2 * 8 * n * 3 * static_cast<double>(estimate.n_interface_nodes);
  if (estimate.few_shapes) {
    // Displacements along the forces and responses to them; the statics' factor, forward and
    // backward
    const auto s = static_cast<double>(estimate.few_shapes->n_static);
    const double looked_at = s > 0 ? s : 3 * static_cast<double>(estimate.n_interface_nodes);
    bytes.exact_in_contact = 8 * 8 * n + 2 * 8 * n * looked_at + 8 * s * s;
  }
  // K_cc and M_kc of each domain, and the factor forward and backward.
  bytes.coupled = 8 * (blocks + 2 * estimate.joined_factor_nonzeros + 8 * (n + c));
  if (estimate.few_shapes) bytes.coupled = bytes.exact;
  bytes.mesh =
      76.0 / 9 * estimate.mesh_nonzeros + 8 * 8 * 3 * static_cast<double>(estimate.n_nodes);
  return bytes;
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
