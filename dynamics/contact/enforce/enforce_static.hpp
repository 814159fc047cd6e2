// SPDX-License-Identifier: GPL-3.0-or-later
// Contact in equilibrium, of bodies that may float.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

// The motions that a body's stiffness does not resist, at its contact nodes.
struct FloatingNodes {
  Matrix R;         // 3 m x k, scene axes
  Index first = 0;  // column of the first of them among those of all bodies
};

class StaticSystem;

// Kept while rows stand.
struct StaticMemory {
  ContactList rows;
  std::vector<PointLaw> laws;
  std::vector<Index> columns;
  SparseMatrix A;  // of the unknowns, see ContactUnknowns; empty: every point is one
  std::shared_ptr<StaticSystem> system;
};

struct StaticResult {
  EnforcementResult of_points;
  Vector moves;  // of the columns
  // of the columns: forces that are left; 0 when all is in equilibrium. Largest one that acts.
  Vector left;
  double largest_force = 0;
};

// Forces p of contact, ties and links, and moves a of what floats:
//   gap = g + W p + B a,   B^T p + c = 0,   the laws of contact on (p, gap),
// with W the static compliance of the bodies' responses, B what `floating` does to the gaps, and
// `forces` = c of all bodies, of which `columns` take part (total FETI: Dostal, Horak, Kucera 2006,
// doi 10.1002/cnm.881). Ties and what they hold are eliminated first, exactly; a row that others
// imply is left out. What then floats is held by contact alone: its moves are found by Newton's
// method on B^T p + c, each p by the solver of contact, up to most_way; more is for another search.
// largest_force: of what adds up to c. Adds to the bodies' impulses. `searches`: with functions of
// corners, which are unknowns in the place of their points (contact_unknowns.hpp).
StaticResult enforce_static(const ContactList& list, const std::vector<PointLaw>& laws,
                            const Points& guess, const std::vector<FloatingNodes>& floating,
                            const std::vector<Index>& columns, const Vector& forces,
                            double largest_force, double most_way, std::vector<ContactBody>& bodies,
                            const std::vector<FunctionsOfSearch>& searches, StaticMemory& memory);

}  // namespace cbr
