// SPDX-License-Identifier: GPL-3.0-or-later
// Algebra of basis massless that a reduction and the half of one (cbr-dyn --check-error) share.
// docs/theory.md, "An interface without mass".
#pragma once

#include "common/superelement/superelement.hpp"

namespace cbr {

// --- massless_modes: tapered ---

// How many modes beyond `elastic` ones are looked at for the end of their fall; at least 1, and no
// more than the other half of twice as many.
Index modes_ahead(Index elastic);

// Where interface rows of the first k modes fall to 0 (rad/s): the first of the modes_ahead() that
// takes part in a uniform pressure on one of the surfaces of `s`, at the latest the last of them;
// the first one without surfaces. A mode takes part when its share of the impulse's answer, (p^T
// V_j)^2, is a twentieth of the kept ones' mean, each weighed by itself, rigid motions as one.
// lambda (at least k, ascending, n_rigid zeros first) and V (c x lambda.size(), or without the
// last), V without a fall. Where nothing beyond is known, as much above the last as evenly spaced
// frequencies would have it.
double end_of_fall(const Superelement& s, const Matrix& V, const Vector& lambda, Index k,
                   Index n_rigid);

// sqrt(1 - (omega_j / end)^3), k numbers: what multiplies the columns of V.
Vector falling_weights(const Vector& lambda, double end);

// --- massless_modes: fixed ---

// Modes with the interface held and what drives them.
struct FixedModes {
  Vector lambda;  // k
  Matrix alpha;   // k x c
  Matrix K_cc;    // c x c
};

// Eigenvalues and `massless` of s from them: what rigid motions lose by an interface without mass
// is given back to the modes. R (c x r): rigid motions, R^T M_cc R = I; momentum = M_cc R. Returns
// the least share of a rigid motion's mass that the modes had. InputError: fewer modes than rigid
// motions, or some that they do not take part in. RunError: of LAPACK.
double take_fixed_modes(FixedModes modes, const Matrix& R, const Matrix& momentum, Superelement& s);

// The modes that a superelement of massless_modes: fixed was made of, to round-off (up to their
// signs, lambda ascending).
FixedModes fixed_modes_of(const Superelement& s);

}  // namespace cbr
