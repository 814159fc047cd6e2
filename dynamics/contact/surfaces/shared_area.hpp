// SPDX-License-Identifier: GPL-3.0-or-later
// The area that two surfaces share, by the nodes of one.
#pragma once

#include <vector>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Area vectors (undeformed area x present outward normal) of the part of the slave that lies over
// the master, by slot of the slave: n x 3, 0 elsewhere. Each face divides its part equally among
// those of its corners that are over the master or have a point. Only faces with a point count.
// `slave_positions`, `master_positions`: of the contact nodes.
Points shared_areas(const ContactSurface& slave, const Points& slave_positions,
                    const ContactSurface& master, const Points& master_positions,
                    const std::vector<char>& has_point);

}  // namespace cbr
