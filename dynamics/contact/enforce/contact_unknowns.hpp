// SPDX-License-Identifier: GPL-3.0-or-later
// Unknowns of contact in a step: pressures of a few functions where a face closes as a whole. Where
// it is partly open, impulses of its points.
#pragma once

#include <vector>

#include "common/mesh/pressure_functions.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

class StateArchive;

// The points [first, last) of one search, in the slots of the surface of `functions`; null: every
// point is an unknown. `corners`: corner_functions() of second-order faces, which replace the nodes
// of these; null if all faces are linear. `memory`: of the pair, for its cells; null: none.
struct FunctionsOfSearch {
  std::size_t first = 0, last = 0;
  const PressureFunctions* functions = nullptr;
  const PressureFunctions* corners = nullptr;
  PairMemory* memory = nullptr;
  double correction = 0;  // of an unknown's depth: share of its way in a step without impulses
  Index pair = -1;
  bool has_any() const { return last > first && (functions != nullptr || corners != nullptr); }
};

// In the last step: whether a point had an impulse, and whether it slid (after load steps).
bool acted(const ContactPoint& point, const PairMemory& memory);
bool slid(const ContactPoint& point, const PointLaw& law, const PairMemory& memory);

// Identity of an unknown across steps: the search, and the function or the point's slot. Corner
// functions are numbered after the others.
struct UnknownKey {
  Index search = 0, function = -1, slot = -1, ordinal = 0;
  bool operator==(const UnknownKey&) const = default;
};

// p = A x, and the gaps of the unknowns are A^T gap, means weighted by the functions. x sums the
// impulses on a function. Not reduced: A is the identity, and all other members are empty.
struct ContactUnknowns {
  bool reduced = false;
  SparseMatrix A;              // rows of the points x rows of the unknowns
  std::vector<PointLaw> laws;  // of the unknowns
  std::vector<UnknownKey> keys;
  std::vector<Index> pairs;  // of the searches
  // For each row of an unknown: its column of function_matrix(), or -1 for a point. And its factor,
  // of the part that is not truncated.
  std::vector<Index> column;
  Vector share;
  // Corner functions: values at the points (points x unknowns), and areas; 0 for other unknowns.
  // Per point: whether corner functions constrain it.
  SparseMatrix values;
  Vector areas;
  std::vector<char> is_held;
  // Points of small patches without unknowns, unlikely to close, ascending. The laws must hold for
  // them too.
  std::vector<std::size_t> left_out;
  std::vector<ChosenCells> cells;  // per search
  Vector depths;                   // <= 0: gaps at which the unknowns act, kept_depths()
  Vector friction_factors;         // of mu, per unknown, by the last step: rotating_slip.hpp

  Index size() const { return static_cast<Index>(keys.size()); }
  std::vector<Index> of_searches() const;  // number of unknowns per search
  // x with approximately p = A x; exact for a uniform pressure.
  Vector guess(const std::vector<PointLaw>& of_points, const Vector& p) const;
  // Gives the cells to the memories of `searches`.
  void remember_cells(const std::vector<FunctionsOfSearch>& searches) const;
  void keep_state(StateArchive& archive);
};

void keep_state(StateArchive& archive, UnknownKey& key);

// Bitwise equality.
bool same_matrix(const SparseMatrix& a, const SparseMatrix& b);

// All functions of the searches at their points   (rows of the points x columns).
SparseMatrix function_matrix(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<FunctionsOfSearch>& searches);

// Chooses unknowns by the gaps at the end of the step without contact. A closed cell gets its
// function: all of its nodes penetrate, by at least a fifth of their mean. A partly open cell gets
// its points, an open one none. Functions end where points begin. If points were too many, a cell
// with a closed mean keeps its function. A function of `corners` replaces its nodes where all of
// them have points with similar normals. Nodal forces of a pressure on second-order faces may be
// negative, which no node's law allows. before: of the last step. A function starts where all of
// its nodes close, and stays while their gaps are similar. Null (statics): wherever possible.
// After load steps motion begins with their unknowns: a cell with an impulse in the last step
// remains as it was, so that bodies at rest stay there, unless points are too many.
// `wanted` (ascending): points to include in any case.
ContactUnknowns choose_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                                const std::vector<FunctionsOfSearch>& searches,
                                const ContactUnknowns* before,
                                const std::vector<std::size_t>& wanted = {});

// Points that corner functions constrain.
struct HeldPoints {
  Vector pressure;  // normal impulse per area; -1: for other points
  Vector area;      // tributary area of the functions with an impulse
};
HeldPoints held_points(const ContactUnknowns& unknowns, const Vector& x);

}  // namespace cbr
