// SPDX-License-Identifier: GPL-3.0-or-later
// Contact in static equilibrium, with floating bodies.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

// Rigid motions of a body without stiffness against them, at its contact nodes.
struct FloatingNodes {
  Matrix R;         // 3 m x k, scene axes
  Index first = 0;  // column of the first one among those of all bodies
};

class StaticSystem;

// State that stays valid while the rows do not change.
struct StaticMemory {
  ContactList rows;
  std::vector<PointLaw> laws;
  std::vector<Index> columns;
  Matrix motions;
  SparseMatrix A;   // of ContactUnknowns; empty: every point is an unknown
  Vector diagonal;  // of A^T W A
  std::shared_ptr<StaticSystem> system;
  // The largest gap of this load step, to which the residual is relative: gaps of late iterations
  // are round-off where bodies float without a force
  double gap = 0;
};

// Rows of points that a dense W serves.
constexpr Index most_rows_of_points = 4000;

struct StaticResult {
  EnforcementResult of_points;
  Vector moves;  // amplitudes of the columns
  // of the columns: unbalanced forces, 0 in equilibrium; and the largest acting force
  Vector left;
  double largest_force = 0;
};

// Solves for forces p of contact, ties and links, and amplitudes a of floating motions:
//   gap = g + W p + B a,   B^T p + c = 0,   the laws of contact on (p, gap).
// W: static compliance of the bodies. B: gaps per unit motion of `floating` along `motions`
// (columns x k, orthonormal). c: forces along them, from the `columns` of `forces`, those of all
// bodies (total FETI: Dostal, Horak, Kucera 2006, doi 10.1002/cnm.881). Ties and the motions that
// they constrain are eliminated first, exactly; dependent rows are omitted. Contact alone
// constrains the remaining motions, which Newton's method finds from B^T p + c. If it fails, each p
// is found by the solver of contact. Motions stay within most_way; larger ones need a new search.
// largest_force: of the forces that sum to c. Adds to the bodies' impulses. `searches`: with
// functions as unknowns instead of their points (contact_unknowns.hpp), chosen by the gaps that
// points would have without their own forces, until the choice repeats.
StaticResult enforce_static(const ContactList& list, const std::vector<PointLaw>& laws,
                            const Points& guess, const std::vector<FloatingNodes>& floating,
                            const std::vector<Index>& columns, const Matrix& motions,
                            const Vector& forces, double largest_force, double most_way,
                            std::vector<ContactBody>& bodies,
                            const std::vector<FunctionsOfSearch>& searches, StaticMemory& memory);

}  // namespace cbr
