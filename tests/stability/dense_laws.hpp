// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of contact by brute force: docs/theory.md, (33) and (42).
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

// Points one after the other, of one row (normal) where mu is 0, else of three (normal, two
// tangents). Impulses p with gap = g + W p: 0 <= p_n, 0 <= gap_n, p_n gap_n = 0; |p_t| <= mu p_n,
// no slip below it, slip against p_t when they are equal. RuntimeError when W is definite and none
// is found without friction to 1e-13 of the largest |g|. Without friction there is one motion W p,
// and one p where W is definite (it is not where a node touches more than three faces). With
// friction one solution always exists, and another may: the iteration is begun twice, from nothing
// and from impulses far too large. Where it ends in two, or does not come to 1e-13 (two points of
// one node in a corner), there are `several`.
struct DenseImpulses {
  Vector p;
  bool several = false, several_motions = false;  // p; W p
};
DenseImpulses dense_impulses(const Matrix& W, const Vector& g, const std::vector<double>& mu);

// By how much a law is broken, as a length: 0 where p obeys it.
double law_violation(const Matrix& W, const Vector& g, const std::vector<double>& mu,
                     const Vector& p);

}  // namespace cbr::test
