// SPDX-License-Identifier: GPL-3.0-or-later
// Faces for contact: linear, without repetition, outward.
#pragma once

#include <string>
#include <vector>

#include "common/fem/shell_model.hpp"
#include "common/scene/scene.hpp"
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

// The scene's active fictitious shells: stiffness and mass on an instance's own nodes. Faces of the
// instance in the skin, as SURFACE or INSTANCE.SURFACE, linear, without repetition: f x 4; none if
// the skin is inactive.
IndexTable skin_faces(const Scene& scene, const std::string& instance, const Geometry& geometry);

// Shells on these faces, at the nodes of `geometry`; component axes. InputError at the skin's line.
ShellModel skin_shells(const Scene& scene, const std::string& instance, const Geometry& geometry);

}  // namespace cbr
