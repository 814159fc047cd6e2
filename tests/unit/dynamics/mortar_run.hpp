// SPDX-License-Identifier: GPL-3.0-or-later
// One mortar search between two grids of faces, and sums over its points.
#pragma once

#include "dynamics/contact/search/mortar.hpp"
#include "face_grid.hpp"

namespace cbr::test {

ContactList run(FaceGrid& slave, FaceGrid& master, PairMemory& memory, bool initial = false);

ContactList run(FaceGrid& slave, FaceGrid& master);

// sum of coefficient x field over the terms of one body, or of both
Vector3 apply(const ContactList& list, const ContactPoint& point, const Points& slave,
              const Points& master);

double shared_area(const ContactList& list);

// Forces of a uniform unit pressure: sum of area x coefficient per node.
Vector pressure_forces(const ContactList& list, Index body, Index n_nodes);

}  // namespace cbr::test
