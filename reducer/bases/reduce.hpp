// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/bases: one component, from its mesh to a superelement of the basis that is
// asked for.
//
// One component: from mesh and materials to its superelement.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/characteristic/characteristic.hpp"
#include "reducer/bases/massless.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/rigid_points.hpp"

namespace cbr {

struct ReduceSettings {
  // bytes that Psi and its companions may take, 0: half of this machine's
  double memory = 0;
  // the diagonal form is stored, and frequencies are estimated, for n up to this
  Index diagonal_limit = 6000;
  // false: nothing reads the diagonal form, so that it is neither computed nor stored
  bool is_diagonal_read = true;
  CondensationWay way = CondensationWay::automatic;
  Index panel = 0;
  // of a component: constraints beside its own elements are unknown here
  bool is_domain = false;
  // of the interface, beside the sets: rigid_points()
  std::vector<RigidPoint> points = {};
};

// For the summary, beyond the superelement itself.
struct ReductionFigures : CondensationFigures {
  Index n_dofs = 0, n_interior = 0;
  double mesh_nonzeros = 0;      // of K, both triangles; 0: several processes
  Index n_candidates = 0;        // modes computed; more than k with pick: participation
  double highest_frequency = 0;  // Hz, of the kept fixed-interface modes; 0 without any
  std::string mode_method;
  bool modes_proven = false;
  double factor_nonzeros = 0, factor_flops = 0;
  Conditioning condition;
  // of lumped mass: relative shift of the lowest frequencies by consistent mass, to first order; of
  // free elastic modes or of fixed-interface modes
  Vector mass_shift;
  // of basis characteristic: worst_of_ten beside Craig-Bampton's own; NaN: not known
  double shapes_error = NAN;
  MasslessFigures massless;              // of basis massless
  CharacteristicFigures characteristic;  // of basis characteristic
};

// Fills all of the superelement but content_hash and provenance. `options`: modes or cutoff_hz,
// pick, interface_sets, recovery. InputError: everything wrong with the mesh, the sets, the
// options; a singular K_II (floating or hinged interior, by node id).
Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const ReduceSettings& settings, Report& report,
                    ReductionFigures* figures = nullptr);

// The same, keeping these nodes of the mesh (ascending indices of nodes that volume elements use)
// whatever options.interface_sets says.
Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const std::vector<Index>& interface,
                    const ReduceSettings& settings, Report& report,
                    ReductionFigures* figures = nullptr);

}  // namespace cbr
