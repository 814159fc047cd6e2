// SPDX-License-Identifier: GPL-3.0-or-later
// Modal truncation with residual compliance: the modes that the steps of a contact cannot resolve
// become quasi-static.
#pragma once

#include <memory>
#include <optional>

#include "dynamics/motion/modal/forms/residual_compliance.hpp"

namespace cbr {

// The highest frequency (rad/s) of dynamic modes of a free Craig-Bampton superelement: up to 2.5
// times its highest fixed-interface mode, above which its interior has no mass of its own. None if
// fewer than a third of the modes are higher. docs/decisions/truncation.md. eigenvalues: (rad/s)^2.
std::optional<double> automatic_limit(const Vector& eigenvalues, const ModalForm& all);
// Whether the forces are at so many nodes that steps pay which do not read every mode for each of
// them.
bool is_large_face(const StaticShare& forces);

// The modes of `all` up to `highest` (rad/s) as they are; those above it (h) are quasi-static along
// `forces` (no F):
//   F = B^T V_h diag(1 / omega_h^2) V_h^T B   (docs/theory.md, "Quasi-static modes").
std::shared_ptr<const ModalForm> truncated_form(double highest,
                                                std::shared_ptr<const ModalForm> all,
                                                const StaticShare& forces,
                                                const Superelement& superelement);

}  // namespace cbr
