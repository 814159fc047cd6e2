// SPDX-License-Identifier: GPL-3.0-or-later
// Data of the steps of one reduction (reduce.cpp), and these steps.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/component_parts.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/modes/free_factor.hpp"

namespace cbr {

class Engine;

// Data common to the steps of one reduction.
struct Reduction {
  const Mesh& mesh;
  const std::vector<BlockProperties>& properties;
  MassKind mass;
  const ReductionOptions& options;
  const ReduceSettings& settings;
  Report& report;
  Engine* engine = nullptr;
  FiniteElementModel model = {};  // K and M in one process alone, while a step reads them
  Partition p = {};
  std::vector<Index> part = {};  // per model node
  Points x = {};                 // of the model's nodes
  // Of fixed dofs alone: M of all dofs times the six rigid motions   (rows of the model x 6)
  Matrix momentum = {};
  ReductionFigures figures = {};
  ModesNotKept not_kept = {};
  Matrix lowest = {};  // n_rows x m: the lowest of the kept modes; of free ones all dofs x m
  std::optional<SparseCholesky> factor = {};    // of K_II in one process
  std::unique_ptr<const Interior> inside = {};  // from the factorisation on
};

Index mesh_node(const Reduction& r, Index model_node);
std::string node_of_interior_dof(const Reduction& r, Index row);  // with its axis
std::string node_of_interface_dof(const Reduction& r, Index row);

// Per node the number of its connected part.
std::vector<Index> parts_of_nodes(const Reduction& r, const std::vector<Index>& nodes);
std::vector<Index> parts_of_interface(const Reduction& r);
bool has_parts(const Reduction& r);  // more than one
// None when the component is one part.
std::vector<ComponentPart> parts(const Reduction& r);

Points coordinates_of(const Reduction& r, const std::vector<Index>& nodes);
// Model nodes of the interior that this process has.
std::vector<Index> own_nodes(const Reduction& r);
// s.fixed.momentum of Craig-Bampton's coordinates.
void add_momentum(const Reduction& r, const Matrix& Phi, Superelement& s);
void describe_interface(const Reduction& r, Superelement& s);
// Psi: of the first process; Phi: n_rows x k.
void add_recovery(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s);

// --- local_engine.cpp: K_II of one process ---

// Fronts, or a Lanczos basis, have left room in the heap that may be needed as one piece elsewhere.
void return_room();

// True if the factorisation may condense, too: nothing reads Psi, no option asks for another way.
bool may_condense_by_fronts(const Reduction& r);

void take_factor(Reduction& r, SparseCholesky&& factor);
// These two: InputError: K_II is singular.
void factorise_interior(Reduction& r);
// Of the free component, n_forces of which get their answers.
FreeFactor factorise_free(Reduction& r, const FreeComponent& model, Index n_forces);

// M_kc by the Psi that K_cc and M_cc are made with, of modes that were not known then.
void couple_again(Reduction& r, const Matrix& Phi, Condensation& condensed);

// Psi of the interior, column by column   (n_I x c)
Matrix constraint_modes(const Reduction& r);

// --- mode_steps.cpp: computes, selects and completes modes ---

// Modes that are known before the condensation; none where it decides about them, or the basis has
// free modes.
FixedInterfaceModes first_modes(Reduction& r);

// Of `pick: participation` those that are kept; r.not_kept has the others.
void keep_modes(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed);

// Of the modes that are kept, ascending: r.lowest.
void keep_lowest(Reduction& r, const Eigen::Ref<const Matrix>& Phi);

// Motions of the interface for the errors (is_judged) or for a tolerance.
InterfaceMotions motions_to_judge(Reduction& r, bool is_judged, const Superelement& s);

// The modes that option `tolerance` needs and residual vectors of loads inside; then s takes M_kc
// and the eigenvalues. InputError: a mass that is lost in round-off.
void complete_modes(Reduction& r, const InterfaceMotions& motions, FixedInterfaceModes& modes,
                    Condensation& condensed, Superelement& s);

// --- error_steps.cpp: error estimates of a reduction, in the first process ---

// How far rigid motions of the interface are from costing no force.
void judge_reduced_rigid(Reduction& r, const Superelement& s);

// Of Craig-Bampton's form. M_res: residual_mass_factor(), of the first process.
void add_accuracy(Reduction& r, const InterfaceMotions& motions, const Matrix& Phi,
                  const Cholesky* M_res, Superelement& s);

// Accuracy of Craig-Bampton's form and its lowest free modes, before s changes to another basis.
FreeEigenvalues look_before(Reduction& r, const Matrix& Phi, Superelement& s);
// And of the basis that it became, whose elastic eigenvalues come after the rigid ones.
void look_after(const FreeEigenvalues& free, Index n_rigid, Superelement& s);

// Strain energy outside the fixed-interface modes, and errors of the lowest frequencies against the
// full component's, `free`.
void add_accuracy_of_shapes(Reduction& r, const FixedInterfaceModes& modes, const Vector& free,
                            Superelement& s);

// --- the bases, each in a file of its name: from the condensed matrices to a superelement ---

// Ingredients of a basis beside K_cc and M_cc, which the superelement has already.
struct Ingredients {
  FixedInterfaceModes modes;  // of first_modes(), those that are kept
  Condensation condensed;
};

// basis_craig_bampton.cpp
void make_basis_craig_bampton(Reduction& r, Ingredients&& given, Superelement& s);

// basis_massless.cpp. Of free modes, which it computes itself.
void make_basis_massless(Reduction& r, Superelement& s);

// basis_characteristic.cpp
void make_basis_characteristic(Reduction& r, Ingredients&& given, Superelement& s);
// The same by sparse solves alone, without a condensation: of one factor, or of two, one after the
// other. False: the component is for make_basis_characteristic().
bool make_basis_of_free_shapes(Reduction& r, Superelement& s);

}  // namespace cbr
