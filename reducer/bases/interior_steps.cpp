// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduction_steps.hpp"

#include <utility>

#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/linalg/huge_pages.hpp"
#include "reducer/bases/bases.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/condensation/residual_mass.hpp"
#include "reducer/judgement/condition_numbers.hpp"

namespace cbr {
namespace {

constexpr double singular_pivot = 1e-14;

// Judges K_II by its factor. InputError: it is singular.
void judge_interior(Reduction& r, const SparseCholesky& factor) {
  return_room();
  if (r.p.n_interior() == 0) return;
  if (!factor.ok() || factor.smallest_pivot() < singular_pivot) {
    throw InputError("the stiffness of the interior is singular at " +
                     node_of_interior_dof(r, factor.weakest_column()) +
                     ": a part of it can move freely, as elements do that share only an edge or a "
                     "node with the rest, or is held "
                     "too weakly for a double, as very thin parts are and what an interface nearly "
                     "on one line holds; correct the mesh "
                     "there or put nodes of that part into the interface" +
                     (r.model.n_rotations > 0
                          ? "; the edge of a shell on solids is a hinge, unless the shell goes on "
                            "along their faces"
                          : ""));
  }
  Conditioning& condition = r.figures.condition;
  condition.smallest_pivot = factor.smallest_pivot();
  condition.weakest = node_of_interior_dof(r, factor.weakest_column());
  condition.K_II = condition_numbers(r.p.K_II, factor);
  r.figures.factor_nonzeros = factor.n_nonzeros();
  r.figures.factor_flops = factor.flops();
}

CondensationOptions condensation_options(const Reduction& r, const SparseCholesky& factor,
                                         const Matrix& Phi) {
  CondensationOptions options;
  options.memory = panel_memory(r.settings.memory, r.p, factor, Phi);
  options.way = r.settings.way;
  options.panel = r.settings.panel;
  options.keep_Psi = r.options.recovery;
  options.one_Psi = needs_one_Psi(r.figures.condition.K_II.scaled);
  return options;
}

}  // namespace

void return_room() { return_unused_heap(0.1 * machine_memory_bytes()); }

SparseCholesky factorise(Reduction& r) {
  const auto phase = r.report.phase("factorisation");
  SparseCholesky factor(r.p.K_II, {},
                        [&](double share) { r.report.progress("factorisation", share); });
  judge_interior(r, factor);
  return factor;
}

bool may_condense_by_fronts(const Reduction& r) {
  const bool asked = r.settings.way == CondensationWay::fronts;
  return !r.options.recovery && (asked || r.settings.way == CondensationWay::automatic) &&
         r.settings.panel == 0;
}

FactorAndCondensed factorise_and_condense(Reduction& r) {
  if (may_condense_by_fronts(r)) {
    const auto phase = r.report.phase("factorisation and condensation");
    Condensed condensed;
    std::optional<SparseCholesky> factor = SparseCholesky::condensing(
        r.model.K, r.model.M, dofs_of(r.p.interface_nodes), condensed,
        r.settings.way == CondensationWay::fronts,
        [&](double share) { r.report.progress("factorisation and condensation", share); });
    if (factor) {
      if (!r.options.is_massless()) {
        r.model.K = SparseMatrix();
        r.model.M = SparseMatrix();
      }
      judge_interior(r, *factor);
      return {std::move(*factor), std::move(condensed)};
    }
  }
  if (!r.options.is_massless()) {
    r.model.K = SparseMatrix();
    r.model.M = SparseMatrix();
  }
  return {factorise(r), {}};
}

FreeFactor factorise_free(Reduction& r, const FreeComponent& model, Index n_forces) {
  const auto phase = r.report.phase("factorisation");
  FreeFactor free = free_factor(model, r.p, n_forces,
                                [&](double share) { r.report.progress("factorisation", share); });
  if (free.interior) judge_interior(r, *free.interior);
  return free;
}

Condensation condense_with(Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                           std::optional<Condensed>&& by_fronts) {
  const CondensationOptions options = condensation_options(r, factor, Phi);
  const auto phase = r.report.phase("condensation");
  const auto &inside = r.p.interior_nodes, &on_interface = r.p.interface_nodes;
  r.p.rigid = rigid_motions(r.p, coordinates_of(r, inside), parts_of_nodes(r, inside), 0,
                            coordinates_of(r, on_interface), parts_of_nodes(r, on_interface));
  // Of an ill-conditioned K_II all comes from one Psi
  Condensation condensed = by_fronts && !options.one_Psi
                               ? complete(r.p, factor, Phi, std::move(*by_fronts))
                               : condense(r.p, factor, Phi, options, r.report);
  r.figures.solve_flops = condensed.solve_flops;
  r.figures.product_flops = condensed.product_flops;
  r.figures.front_flops = condensed.front_flops;
  r.figures.way = condensed.way;
  r.figures.panel = condensed.panel;
  return condensed;
}

void couple_again(Reduction& r, const SparseCholesky& factor, const Matrix& Phi, const Matrix& M_cc,
                  Condensation& condensed) {
  const auto phase = r.report.phase("condensation");
  CondensationOptions options = condensation_options(r, factor, Phi);
  options.panel = r.figures.panel;  // of which round-off depends
  condensed.M_kc = mode_coupling_of_one_Psi(r.p, factor, Phi, M_cc, options, r.report);
}

Matrix constraint_modes(const Reduction& r, const SparseCholesky& factor) {
  Matrix Psi = -Matrix(r.p.K_IC);
  factor.solve_in_place(Psi);
  return Psi;
}

}  // namespace cbr
