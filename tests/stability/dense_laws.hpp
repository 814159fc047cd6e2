// SPDX-License-Identifier: GPL-3.0-or-later
// Contact laws by brute force: docs/theory.md, (33) and (42).
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

// Impulses p with gap = g + W p, by points: one row (normal) if mu is 0, else three (normal, two
// tangents). 0 <= p_n, 0 <= gap_n, p_n gap_n = 0; |p_t| <= mu p_n, no slip below it, slip against
// p_t at equality. RuntimeError if W is definite and no frictionless solution is found to 1e-13 of
// the largest |g|. Without friction the motion W p is unique, and p if W is definite (not if a node
// touches more than three faces). With friction a solution exists, but may not be unique. So the
// iteration starts twice, from zero and from very large impulses. `several`: it finds two, or does
// not reach 1e-13 (two points of one node in a corner).
struct DenseImpulses {
  Vector p;
  bool several = false, several_motions = false;  // p; W p
};
DenseImpulses dense_impulses(const Matrix& W, const Vector& g, const std::vector<double>& mu);

// Violation of the laws, as a length: 0 if p satisfies them.
double law_violation(const Matrix& W, const Vector& g, const std::vector<double>& mu,
                     const Vector& p);

}  // namespace cbr::test
