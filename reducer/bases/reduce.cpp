// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduce.hpp"

#include <utility>

#include "common/base/process.hpp"
#include "common/fem/block_elements.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/bases/engine.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

Condensation condense(Reduction& r, const Matrix& Phi) {
  const auto phase = r.report.phase("condensation");
  Condensation condensed = r.engine->condense(r, Phi);
  r.p.rigid.G = std::move(condensed.G);
  ReductionFigures& figures = r.figures;
  static_cast<CondensationFigures&>(figures) = condensed;
  r.inside->in_first([&] {
    if (r.p.rigid.count() > 0)
      judge_rigid(figures.rigid, figures.condition.K_II.scaled, figures.condition.weakest,
                  r.report);
  });
  return condensed;
}

void make_basis(Reduction& r, Superelement& s) {
  if (r.options.is_characteristic() && make_basis_of_free_shapes(r, s)) return;
  require_memory_for_interface(r.p.n_interface(), machine_memory_bytes());
  r.engine->factorise(r);
  FixedInterfaceModes modes = first_modes(r);
  // Later steps only need its factor, and memory may be short. An inertia count of later modes
  // reads K_II itself, and so do parts
  if (!r.options.tolerance && !has_parts(r))
    r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
  Condensation condensed = condense(r, modes.Phi);
  s.K_cc = std::move(condensed.K_cc);
  s.M_cc = std::move(condensed.M_cc);
  if (r.options.is_massless()) return make_basis_massless(r, s);
  keep_modes(r, modes, condensed);
  Ingredients given{std::move(modes), std::move(condensed)};
  return r.options.is_characteristic() ? make_basis_characteristic(r, std::move(given), s)
                                       : make_basis_craig_bampton(r, std::move(given), s);
}

// Rayleigh quotients of the lowest modes, of phi^T M phi = 1, with consistent mass.
Vector shift_by_consistent_mass(const Reduction& r, const Matrix& lowest) {
  if (lowest.cols() == 0 || r.model.n_rotations > 0 || r.p.n_points > 0) return {};
  const std::vector<Index>&inside = r.p.interior_rows, &kept = r.p.interface_rows;
  Matrix of_rows = lowest;
  if (!r.options.is_massless()) {
    of_rows.setZero(static_cast<Index>(inside.size() + kept.size()), lowest.cols());
    of_rows(inside, Eigen::all) = lowest;
  }
  const std::vector<Index>& row = r.model.row_of_dof;
  Matrix X = row.empty() ? std::move(of_rows)
                         : Matrix::Zero(static_cast<Index>(row.size()), lowest.cols());
  for (std::size_t dof = 0; dof < row.size(); ++dof)
    if (row[dof] >= 0) X.row(static_cast<Index>(dof)) = of_rows.row(row[dof]);
  return consistent_mass_products(r.mesh, r.properties, r.model, X)
             .cwiseSqrt()
             .cwiseInverse()
             .array() -
         1;
}

}  // namespace

Superelement reduce_by(Engine& engine, Reduction& r) {
  r.engine = &engine;
  Superelement s;
  engine.assemble(r, s);
  describe_interface(r, s);
  s.basis = word_of(basis_words, r.options.basis);
  make_basis(r, s);
  if (r.mass == MassKind::lumped) {
    const Matrix lowest = r.inside->gather(std::move(r.lowest));
    r.inside->in_first([&] { r.figures.mass_shift = shift_by_consistent_mass(r, lowest); });
  }
  // of domains in their order, when all are done
  if (!r.settings.is_domain) report_conditioning(r.figures.condition, r.report);
  warn_of_conditioning(r.figures.condition, r.report);
  s.conditioning = r.figures.condition;
  return s;
}

namespace {

Superelement reduce_to(const std::vector<Index>* interface, Reduction&& r,
                       ReductionFigures* figures) {
  LocalEngine engine(interface);
  Superelement s = reduce_by(engine, r);
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const ReduceSettings& settings, Report& report,
                    ReductionFigures* figures) {
  return reduce_to(nullptr, {mesh, properties, mass, options, settings, report}, figures);
}

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const std::vector<Index>& interface,
                    const ReduceSettings& settings, Report& report, ReductionFigures* figures) {
  return reduce_to(&interface, {mesh, properties, mass, options, settings, report}, figures);
}

}  // namespace cbr
