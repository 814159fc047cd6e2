// SPDX-License-Identifier: GPL-3.0-or-later
// A rigid body: the nodes of a mesh move by rigid motions alone, as many as its supports leave.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/motion/modal/forms/diagonal_form.hpp"

namespace cbr {

// nodes: all of the mesh, with its mass and inertia; no matrices. The form has up to six columns,
// all of frequency 0, and none when the supports hold every rigid motion. RunError, named by
// `where`: a mass or an inertia that is not positive.
std::shared_ptr<const DiagonalForm> rigid_form(const Superelement& nodes,
                                               const std::vector<HeldDirection>& held,
                                               const std::string& where);

}  // namespace cbr
