// SPDX-License-Identifier: GPL-3.0-or-later
// What contact solves for in a step: pressures of few functions where a face closes as a whole,
// impulses of its points where it is partly open.
#pragma once

#include <vector>

#include "common/mesh/pressure_functions.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

class StateArchive;

// The points [first, last) of one search, in the slots of the surface that `functions` are of.
// Null: every point is an unknown. `corners`: of faces of second order, corner_functions(), which
// stand for their nodes; null where all faces are linear.
struct FunctionsOfSearch {
  std::size_t first = 0, last = 0;
  const PressureFunctions* functions = nullptr;
  const PressureFunctions* corners = nullptr;
  bool has_any() const { return last > first && (functions != nullptr || corners != nullptr); }
};

// From step to step: the search, and the function or the point's slot. Functions of corners are
// numbered behind the others.
struct UnknownKey {
  Index search = 0, function = -1, slot = -1, ordinal = 0;
  bool operator==(const UnknownKey&) const = default;
};

// p = A x, and the gaps of the unknowns are A^T gap: means that the functions weigh. Impulses on
// functions sum to x. Not reduced: A is the identity, and everything else is empty.
struct ContactUnknowns {
  bool reduced = false;
  SparseMatrix A;              // rows of the points x rows of the unknowns
  std::vector<PointLaw> laws;  // of the unknowns
  std::vector<UnknownKey> keys;
  Index n_searches = 0;
  // Of each row of an unknown: the column of function_matrix() that it is a share of, and the
  // share, as far as it is not cut off; -1 of points.
  std::vector<Index> column;
  Vector share;
  // Functions of corners: their values at the points   (points x unknowns), and their areas, 0 of
  // others. Of each point: whether such functions hold it.
  SparseMatrix values;
  Vector areas;
  std::vector<char> is_held;
  // Points of small patches that are no unknowns, as they will hardly close, ascending. The laws
  // are to hold for them too.
  std::vector<std::size_t> left_out;

  Index size() const { return static_cast<Index>(keys.size()); }
  std::vector<Index> of_searches() const;  // how many are of each
  // x of about p = A x; exact for a uniform pressure.
  Vector guess(const std::vector<PointLaw>& of_points, const Vector& p) const;
  void keep_state(StateArchive& archive);
};

void keep_state(StateArchive& archive, UnknownKey& key);

// To the bit.
bool same_matrix(const SparseMatrix& a, const SparseMatrix& b);

// All functions of the searches on their points   (rows of the points x columns).
SparseMatrix function_matrix(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<FunctionsOfSearch>& searches);

// Looks at the gaps that the step would end with without contact. A cell all of whose nodes would
// go in, by at least a fifth of their mean, gets its function; one that is partly open gets its
// points; one that stays open gets none. A function ends where points begin. Where that would be
// too many points, a cell that is closed in the mean keeps its function.
// Where all nodes of a function of `corners` have points that look the same way, it stands for
// them: nodal forces of a pressure on faces of second order may be negative, as no node's law
// allows. before: of the last step; a function begins where all of its nodes close, and serves as
// long as their gaps are about as large. Null, in statics: wherever it can. `wanted` (ascending):
// points that are not left out.
ContactUnknowns choose_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                                const std::vector<FunctionsOfSearch>& searches,
                                const ContactUnknowns* before,
                                const std::vector<std::size_t>& wanted = {});

// Of searches with `corners`: an unknown that is deep at the start of a step goes no deeper in it,
// and is not pushed out. A mean of gaps lets single nodes in, which may become unknowns by
// themselves, or a part of other functions: pushed out they would bring energy. `g`: of the
// unknowns.
void keep_depths(const ContactList& list, const std::vector<PointLaw>& laws,
                 const std::vector<FunctionsOfSearch>& searches, const ContactUnknowns& unknowns,
                 Vector& g);

// Of points that functions of corners hold.
struct HeldPoints {
  Vector pressure;  // normal impulse per area; -1: of other points
  Vector area;      // their share of the functions with an impulse
};
HeldPoints held_points(const ContactUnknowns& unknowns, const Vector& x);

}  // namespace cbr
