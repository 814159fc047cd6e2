// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduce.hpp"

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/fem/block_elements.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/bases/bases.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

void make_basis(Reduction& r, Superelement& s) {
  if (r.options.is_characteristic() && make_basis_of_free_shapes(r, s)) return;
  require_memory_for_interface(r.p.n_interface(), machine_memory_bytes());
  FactorAndCondensed first = factorise_and_condense(r);
  const SparseCholesky factor = std::move(first.factor);
  FixedInterfaceModes modes = first_modes(r, factor);
  // Later steps only need its factor, and memory may be short. An inertia count of later modes
  // reads K_II itself, and so do parts
  if (!r.options.tolerance && !has_parts(r))
    r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
  Condensation condensed = condense_with(r, factor, modes.Phi, std::move(first.condensed));
  // One point alone: all that it does moves the part as a rigid body, and K_cc is round-off
  if (r.p.rigid.count() == r.p.n_interface()) {
    condensed.K_cc.setZero();
    condensed.rigid.force = 0;
  }
  r.figures.rigid = condensed.rigid;
  if (r.p.rigid.count() > 0)
    judge_rigid(condensed.rigid, r.figures.condition.K_II.scaled, r.figures.condition.weakest,
                r.report);
  s.K_cc = std::move(condensed.K_cc);
  s.M_cc = std::move(condensed.M_cc);
  if (r.options.is_massless()) return make_basis_massless(r, factor, s);
  keep_modes(r, modes, condensed);
  Ingredients given{factor, std::move(modes), std::move(condensed)};
  return r.options.is_characteristic() ? make_basis_characteristic(r, std::move(given), s)
                                       : make_basis_craig_bampton(r, std::move(given), s);
}

// Of the full K, as it was assembled.
void check_rigid_motions(Reduction& r, const Vector3& center) {
  const RigidResidual rigid =
      rigid_residual(r.model.K, rigid_modes(r.x, center, r.model.n_rotations));
  r.figures.condition.rigid = rigid.value;
  if (rigid.row >= 0)
    r.figures.condition.rigid_node = name_of_node(r.mesh, mesh_node(r, rigid.row / 3));
}

// Without the copies that Eigen 3.4 makes of a sparse matrix that is assigned.
void take(FiniteElementModel&& made, FiniteElementModel& model) {
  model.K.swap(made.K);
  model.M.swap(made.M);
  model.nodes = std::move(made.nodes);
  model.row = std::move(made.row);
  model.n_rotations = made.n_rotations;
}

// From here on the model has the points in the place of their sets' nodes.
void take_points_in(Reduction& r) {
  if (r.settings.points.empty()) return;
  if (has_parts(r))
    throw InputError(r.options.source.text() +
                     ": reduction.points: the component has several parts, which nothing joins, "
                     "and points need one: give each part a component of its own");
  if (r.model.n_rotations > 0)
    throw InputError(r.options.source.text() +
                     ": reduction.points does not know shells (blocks.NAME.thickness), whose nodes "
                     "have rotations of their own: name their sets in reduction.interface, which "
                     "keeps these");
  couple_rigidly(r.mesh, r.settings.points, r.model, r.x);
  r.p.n_points = static_cast<Index>(r.settings.points.size());
  r.part.assign(r.model.nodes.size(), 0);
}

// Rotations of kept nodes are kept too, unless they are to be condensed. kept: ascending
void keep_rotations(const Reduction& r, std::vector<Index>& kept) {
  if (r.options.condenses_rotations) return;
  const std::vector<Index> nodes = kept;
  for (Index i = r.model.n_translations(); i < static_cast<Index>(r.model.nodes.size()); ++i)
    if (std::binary_search(nodes.begin(), nodes.end(),
                           r.model.row[static_cast<std::size_t>(mesh_node(r, i))]))
      kept.push_back(i);
}

// Model nodes of the options' sets, and those of points.
std::vector<Index> kept_nodes(const Reduction& r) {
  std::vector<Index> kept = nodes_of_sets(r.mesh, r.model, r.options);
  const auto n = static_cast<Index>(r.model.nodes.size());
  for (Index i = n - 2 * r.p.n_points; i < n; ++i) kept.push_back(i);
  return kept;
}

// Rayleigh quotients of the lowest modes, of phi^T M phi = 1, with consistent mass.
Vector shift_by_consistent_mass(const Reduction& r,
                                const std::vector<BlockProperties>& properties) {
  if (r.lowest.cols() == 0 || r.model.n_rotations > 0 || r.p.n_points > 0) return {};
  Matrix X = Matrix::Zero(3 * static_cast<Index>(r.model.nodes.size()), r.lowest.cols());
  X(dofs_of(r.p.interior_nodes), Eigen::all) = r.lowest;
  return consistent_mass_products(r.mesh, properties, r.model, X)
             .cwiseSqrt()
             .cwiseInverse()
             .array() -
         1;
}

// `interface`: mesh nodes, or none: those of the options' sets.
Superelement reduce_to(const std::vector<Index>* interface, const Mesh& mesh,
                       const std::vector<BlockProperties>& properties, MassKind mass,
                       const ReductionOptions& options, const ReduceSettings& settings,
                       Report& report, ReductionFigures* figures) {
  Reduction r{mesh, options, settings, report, {}, {}, {}, {}, {}, {}};
  Superelement s;
  {
    const auto phase = report.phase("assembly");
    take(assemble(mesh, properties, mass), r.model);
    std::vector<Index> kept;
    r.part = connected_parts(mesh, r.model);
    if (!settings.is_domain) tell_of_parts(mesh, r.model, r.part, report);
    r.x = mesh.coordinates(r.model.nodes, Eigen::all);
    s.rigid_body = rigid_body(r.model.M, r.x, r.model.n_rotations);
    check_rigid_motions(r, s.rigid_body.center);
    r.figures.n_dofs = r.model.K.rows();
    take_points_in(r);
    if (interface == nullptr) {
      kept = kept_nodes(r);
    } else {
      for (const Index node : *interface)
        kept.push_back(r.model.row[static_cast<std::size_t>(node)]);
    }
    if (r.model.n_rotations > 0) keep_rotations(r, kept);
    if (!options.is_characteristic())
      require_memory_for_interface(3 * static_cast<Index>(kept.size()), machine_memory_bytes());
    partition(r.model, kept, r.p);
    r.figures.n_interior = r.p.n_interior();
    if (!options.is_massless() && !options.is_characteristic() && !may_condense_by_fronts(r)) {
      r.model.K = SparseMatrix();
      r.model.M = SparseMatrix();
    }
  }
  check_interface_holds(mesh, r.model, r.p, r.part);
  describe_interface(r, s);
  s.basis = word_of(basis_words, options.basis);
  make_basis(r, s);
  if (mass == MassKind::lumped && !settings.is_domain)
    r.figures.mass_shift = shift_by_consistent_mass(r, properties);
  // of domains in their order, when all are done
  if (!settings.is_domain) report_conditioning(r.figures.condition, report);
  warn_of_conditioning(r.figures.condition, report);
  s.conditioning = r.figures.condition;
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const ReduceSettings& settings, Report& report,
                    ReductionFigures* figures) {
  return reduce_to(nullptr, mesh, properties, mass, options, settings, report, figures);
}

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const std::vector<Index>& interface,
                    const ReduceSettings& settings, Report& report, ReductionFigures* figures) {
  return reduce_to(&interface, mesh, properties, mass, options, settings, report, figures);
}

}  // namespace cbr
