// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement of basis characteristic, made ready for time stepping: its coordinates are those
// of its diagonal form.
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/modal/forms/diagonal_form.hpp"

namespace cbr {

// u_c = V_c q, q'' + diag(eigenvalues) q = V_c^T f_c: V of the form is [I; V_c], ((k + c) x k).
// InputError, which calls V_c `dataset`, when the modes of frequency 0 are not the rigid motions of
// /rigid_body.
DiagonalForm form_of_modes(const Superelement& superelement, const Matrix& V_c,
                           const std::string& dataset, const std::string& where);

DiagonalForm free_characteristic_form(const Superelement& superelement, const std::string& where);

// With held directions, which take a coordinate each. InputError when the interface's coordinates
// cannot hold them one by one, as then they would hold more than themselves.
DiagonalForm held_characteristic_form(const Superelement& superelement,
                                      const std::vector<HeldDirection>& held,
                                      const std::string& where);

}  // namespace cbr
