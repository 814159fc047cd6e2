// SPDX-License-Identifier: GPL-3.0-or-later
// Faces as contact sees them: linear, each once, outward.
#pragma once

#include <vector>

#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// f x 4, a triangle repeats its last node; faces of second order cut into linear ones. A face that
// is in the surface twice is kept once.
IndexTable contact_faces(const Surface& surface);

// The faces of all surfaces, those in several of them once.
IndexTable all_faces(const Geometry& geometry);
bool has_faces(const Geometry& geometry);
// Without faces that one before has, each of one kind; those without any are left out.
std::vector<Surface> distinct_surfaces(const std::vector<const Surface*>& surfaces);
std::vector<const Surface*> all_surfaces(const Geometry& geometry);
bool is_second_order(const Surface& surface);

// The same as they are, for mortar, f x 9: corners as above, then the nodes between corner a and
// the next (a triangle has three), and the one in the middle; -1 where there is none.
IndexTable whole_faces(const Surface& surface);
IndexTable all_whole_faces(const Geometry& geometry);

// A mirror turns faces inside out: (a b c d) -> (a d c b), a triangle (a b c c) -> (a c b b). f x 4
// or f x 9.
void turn_over(IndexTable& faces);

// Those of `faces` that are not in `all` yet are added to it; a face is its nodes, whichever way it
// is turned.
void join_faces(const IndexTable& faces, IndexTable& all);

// Ascending, each once.
std::vector<Index> nodes_of(const IndexTable& faces);

}  // namespace cbr
