// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/laws: the laws of contact at one point and at all.
//
// What every solver of contact impulses works on, and by what each is judged: gap = g + W p, a law
// at every point.
#pragma once

#include <cmath>
#include <vector>

#include "dynamics/contact/response/response.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

struct ContactProblem {
  GapResponse W;
  std::vector<PointLaw> laws;
  std::vector<Index> first;  // first row of each point, all rows at the end
  // Per point: the largest diagonal entry of W in its rows, the gap that a unit impulse opens. 0:
  // no impulse moves it.
  Vector w;
  Vector diagonal;  // of W; 0 in rows that supports hold on both sides
  Index n_points() const { return static_cast<Index>(laws.size()); }
  Index n_rows() const { return first.back(); }
};

ContactProblem contact_problem(GapResponse W, std::vector<PointLaw> laws);

// The point's rows and columns of W (3 x 3); the first entry alone has a meaning where the point
// has one row.
Matrix3 point_block(const ContactProblem& problem, Index point);

// W p, from one triangle of W: half the memory to read.
Vector respond(const ContactProblem& problem, const Vector& p);

// y += W(:, rows of the point) x change; `change` has as many entries as the point has rows.
void add_response(const ContactProblem& problem, Index point, const double* change, Vector& y);

// The length of (a, b): std::hypot, but without its care where squares keep their digits.
inline double length_of(double a, double b) {
  const double square = a * a + b * b;
  return square > 1e-280 && square < 1e280 ? std::sqrt(square) : std::hypot(a, b);
}

// The nearest impulses that the laws allow: p_n >= 0, then |p_t| <= mu p_n by shortening p_t.
void project(const ContactProblem& problem, Vector& p);

// The natural map of each law as a length: w |p - P(p - gap / w)|, P the projection onto what the
// law allows (for the tangential rows: onto the disc of the radius mu p_n). 0 where and only where
// the law holds.
Vector law_violations(const ContactProblem& problem, const Vector& p, const Vector& gap);

// What round-off alone makes of gaps, as a length: a few units of the last place of the terms that
// sum to W p.
double gap_round_off(const ContactProblem& problem, const Vector& p);

}  // namespace cbr
