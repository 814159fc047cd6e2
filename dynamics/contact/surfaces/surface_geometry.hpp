// SPDX-License-Identifier: GPL-3.0-or-later
// Where faces look and how surfaces move: what the searches share.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Unit, outward, of a face's diagonals; zero for a face without area.
Vector3 mean_normal(const FaceCorners& x);

// Mean of the corners.
Vector3 centre(const FaceCorners& x);

// Of the surface's nodes over the step: the mean, and the longest one relative to `drift`.
Vector3 mean_motion(const ContactSurface& surface, const ContactBody& body);
double largest_motion(const ContactSurface& surface, const ContactBody& body, const Vector3& drift);

}  // namespace cbr
