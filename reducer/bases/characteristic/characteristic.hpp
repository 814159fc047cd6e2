// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/bases/characteristic: the algebra of basis characteristic, shapes of the
// interface and statics.
//
// Basis characteristic: the interface moves in a few shapes of its own (Castanier, Tan, Pierre
// 2001, doi 10.2514/2.1445), with static responses to uniform pressures where it touches.
// docs/theory.md, "An interface of few shapes".
#pragma once

#include <vector>

#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/characteristic/statics.hpp"
#include "reducer/judgement/condition_numbers.hpp"

namespace cbr {

// For the summary.
struct CharacteristicFigures {
  Index n_fixed = 0;  // fixed-interface modes
  Index n_rigid = 0;  // 0 with kept nodes, whose coordinates have them
  // characteristic constraint modes, or modes of the free component
  Index n_modes = 0;
  bool free_modes = false;  // the latter
  Index n_kept = 0;         // dofs of kept nodes
  // responses to uniform pressures, and those that the others span already
  Index n_uniform = 0, n_dropped = 0;
  Index n_loads = 0;  // responses to the scene's loads, and beside kept nodes to inertia
  std::vector<std::string> bare;  // sets_without_statics()
  double highest = 0;             // rad/s, of the last characteristic mode
  ConditionNumbers mass;          // of the shapes' reduced mass
  // residual_mass_share() of Craig-Bampton's form, which rigid motions of the interface keep
  Vector3 rho = Vector3::Zero();
};

// s: a reduction to Craig-Bampton's form with its sets; K_cc, M_cc and M_kc are used up. part: of
// the component, per node of s. Recovery data go along. InputError: a set that the interface does
// not keep; more modes than dofs; kept nodes that do not hold the rest; nothing to reduce.
// RunError: of the eigensolver.
CharacteristicFigures make_characteristic(const CharacteristicOptions& options,
                                          const std::vector<Index>& part,
                                          const InteriorInertia& inertia, Superelement& s);

// Condition of its mass and frequencies. The interface dof that a motion without stiffness moves
// most; -1: there is none.
Index examine_characteristic(const Superelement& s, const CharacteristicFigures& figures,
                             const std::vector<Index>& part, Conditioning& condition);

// The surfaces that get responses to uniform pressures: those with statics, but for those that are
// kept whole. is_kept: kept_nodes(). InputError: one that the interface does not keep.
std::vector<const Surface*> pressed_surfaces(const CharacteristicOptions& options,
                                             const std::vector<char>& is_kept,
                                             const Superelement& s);
// InputError: not fewer shapes than dofs.
// Number of elastic shapes of an interface of `dofs` free dofs: as given, else the default, or all
// but one.
Index n_shapes(const CharacteristicOptions& options, Index dofs);
void require_fewer(Index modes, Index dofs);

// Forces of a unit pressure on the interface's dofs   (c x 1); with shear of unit tractions along
// x, y and z   (c x 3).
Matrix uniform_loads(const Superelement& s, const Surface& surface, bool shear);

}  // namespace cbr
