// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic: faces that touch keep the static compliance that a few shapes leave of
// theirs. docs/theory.md, "Statics in full".
#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/scene/static_forces.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/partition/interior.hpp"

namespace cbr {

// More forces have their compliance in levels: 130 MB of a dense one, whose columns are faster.
inline constexpr Index most_dense_forces = 4000;

// Those that `statics` names, or else those of options.needs that the interface keeps. InputError:
// statics names another.
std::vector<TouchingSurface> touching_surfaces(const CharacteristicOptions& options,
                                               const Superelement& s);

// Per node of s: true if it is in a set of `keep`, or in one that the scene constrains. InputError:
// keep names a set that the interface does not keep. (The scene may constrain more than the
// interface: the programs that run it report that.)
std::vector<char> kept_nodes(const CharacteristicOptions& options, const Superelement& s);

// Nodes and directions of forces that statics are stored of: all but F. Kept nodes have no entry,
// as nothing is left of theirs.
StaticShare static_forces(const CharacteristicOptions& options, const Superelement& s);

// Loads of the scene beyond these forces and the kept nodes, on the interface's dofs: unit
// tractions or forces along three axes, a pressure, moments about three axes   (c x loads)
Matrix load_columns(const CharacteristicOptions& options, const std::vector<char>& is_kept,
                    const Superelement& s);

// Kept sets on which a force along some axis is answered by the few shapes alone.
std::vector<std::string> sets_without_statics(const CharacteristicOptions& options,
                                              const std::vector<char>& is_kept,
                                              const Superelement& s);

// B (c x s): column i is force i on the interface's dofs.
SparseMatrix forces_on_dofs(const StaticShare& forces, const Superelement& s);

// Strain energy, twice, of the fixed-interface interior under its inertia in rigid accelerations of
// the interface. Of R_C (c x r) Q = P_I^T K_II^-1 P_I, P = M R. Parts without an interior have no
// columns.
struct InteriorInertia {
  Matrix R_C;
  Matrix Q;
};
InteriorInertia interior_inertia(const Interior& interior);
// The same of other rigid motions, R = R_C X   (r x r)
Matrix inertia_of(const InteriorInertia& inertia, const Matrix& R);

// Residual compliance F = C - B^T V_e diag(1 / eigenvalues) V_e^T B of the compliance C (s x s),
// without that of the elastic modes. The first n_rigid columns of s.characteristic.V are rigid.
Matrix compliance_that_is_left(Matrix C, const StaticShare& forces, Index n_rigid,
                               const Superelement& s);
// F X of C X for loads X (s x q)
Matrix answers_that_are_left(Matrix CX, const Matrix& X, const StaticShare& forces, Index n_rigid,
                             const Superelement& s);

}  // namespace cbr
