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
// Null: every point is an unknown.
struct FunctionsOfSearch {
  std::size_t first = 0, last = 0;
  const PressureFunctions* functions = nullptr;
};

// From step to step: the search, and the function or the point's slot.
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

  Index size() const { return static_cast<Index>(keys.size()); }
  std::vector<Index> of_searches() const;  // how many are of each
  void keep_state(StateArchive& archive);
};

void keep_state(StateArchive& archive, UnknownKey& key);

// All functions of the searches on their points   (rows of the points x columns).
SparseMatrix function_matrix(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<FunctionsOfSearch>& searches);

// Looks at the gaps that the step would end with without contact. A cell all of whose nodes would
// go in, by at least a fifth of their mean, gets its function; one that is partly open gets its
// points; one that stays open gets none. A function ends where points begin. Where that would be
// too many points, a cell that is closed in the mean keeps its function.
ContactUnknowns choose_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                                const std::vector<FunctionsOfSearch>& searches);

}  // namespace cbr
