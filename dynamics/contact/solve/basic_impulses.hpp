// SPDX-License-Identifier: GPL-3.0-or-later
// Frictionless impulses where the response is singular: more points than the bodies have ways to
// give way.
#pragma once

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

// min 1/2 p . W p + g . p over p >= 0 by the active set of Lawson and Hanson (1974,
// doi 10.1137/1.9781611971217, chapter 23): pushed are only points whose rows of W are independent;
// a row that depends on them takes the place of one of them. The objective falls in every step, so
// that it ends, without a condition on W. Then the impulses are spread to the least among all
// closed points (each row weighed by the root of its W_ii) as far as none has to pull. W dense, all
// laws frictionless; for ranks up to some hundred.
struct BasicImpulses {
  Vector p, gap;  // as far as it came when not `found`
  // no gap is below -tolerance; false when no impulse opens all gaps, or steps or the rank ran out
  bool found = false;
  bool singular = false;  // some row depends on others
  int steps = 0;
};
BasicImpulses basic_impulses(const ContactProblem& problem, const Vector& g, double tolerance);

}  // namespace cbr
