// SPDX-License-Identifier: GPL-3.0-or-later
// Orientation of faces and motion of surfaces, for all searches.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Outward unit normal from a face's diagonals; zero for a face without area.
Vector3 mean_normal(const FaceCorners& x);

Vector3 centre(const FaceCorners& x);

// Of the surface's nodes in the step: the mean motion, and the largest one relative to `drift`.
Vector3 mean_motion(const ContactSurface& surface, const ContactBody& body);
double largest_motion(const ContactSurface& surface, const ContactBody& body, const Vector3& drift);

}  // namespace cbr
