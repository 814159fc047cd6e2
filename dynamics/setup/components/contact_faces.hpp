// SPDX-License-Identifier: GPL-3.0-or-later
// Faces for contact: linear, without repetition, outward.
#pragma once

#include <vector>

#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// f x 4, a triangle repeats its last node; second-order faces cut into linear ones. Repeated faces
// are kept once.
IndexTable contact_faces(const Surface& surface);

// Faces of all surfaces, without repetition.
IndexTable all_faces(const Geometry& geometry);
bool has_faces(const Geometry& geometry);
// The surfaces without the faces of earlier ones; empty surfaces are omitted.
std::vector<Surface> distinct_surfaces(const std::vector<const Surface*>& surfaces);
std::vector<const Surface*> all_surfaces(const Geometry& geometry);
bool is_second_order(const Surface& surface);

// The same without cutting, for mortar, f x 9. Corners as above, then mid-side nodes between corner
// a and the next (a triangle has three), then the central node; -1: none.
IndexTable whole_faces(const Surface& surface);
IndexTable all_whole_faces(const Geometry& geometry);

// Reverses the orientation of faces, for a mirror: (a b c d) -> (a d c b). A triangle: (a b c c) ->
// (a c b b). f x 4 or f x 9.
void turn_over(IndexTable& faces);

// Adds the faces that are not in `all`; a face is identified by its nodes in any order.
void join_faces(const IndexTable& faces, IndexTable& all);

// Ascending, without repetition.
std::vector<Index> nodes_of(const IndexTable& faces);

}  // namespace cbr
