// SPDX-License-Identifier: GPL-3.0-or-later
// Projected conjugate gradients for many points without friction.
#pragma once

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

// Minimises p W p / 2 + g p over p_n >= 0 of frictionless points, tied ones free: MPRGP (Dostal,
// Schoeberl 2005, doi 10.1007/s10589-005-4557-7) in the unknowns sqrt(W_ii) p_i, with Gamma = 1.
// Descends, so it cannot cycle; W may be singular. `largest`: an estimate of the largest eigenvalue
// of W scaled to a unit diagonal, see scaled_norm. p (m), feasible, and gap = g + W p are updated.
// Ends when no gap violates its law by more than `tolerance` (a length), after max_products
// products with W, or when the energy has no bottom. Returns the number of products.
int projected_gradients(const ContactProblem& problem, const Vector& g, double largest,
                        int max_products, double tolerance, Vector& p, Vector& gap);

// Largest eigenvalue of W scaled to a unit diagonal, by power iteration.
double scaled_norm(const ContactProblem& problem);

}  // namespace cbr
