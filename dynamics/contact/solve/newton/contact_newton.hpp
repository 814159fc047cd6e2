// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/solve/newton: Newton's method, with factors or Krylov methods.
//
// Semismooth Newton on the laws of all points at once.
#pragma once

#include <memory>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/laws/contact_set.hpp"
#include "dynamics/contact/solve/newton/set_matrix.hpp"

namespace cbr {

class StateArchive;

struct NewtonResult {
  Vector p, gap;  // the best of all iterates, within the laws' cones
  // largest violation of a law, a length; infinite, and p = 0, on overflow
  double residual = 0;
  int iterations = 0;
  bool converged = false;
  // of solve_standing(): the impulses of `gap`, possibly outside of the cones
  Vector outside;
};

// Without sliding points this is the primal-dual active set (Hintermueller, Ito, Kunisch 2002, doi
// 10.1137/S1052623401383558), whose symmetric factor is reused while the set stays. A sliding point
// is in the form of Alart and Curnier (1991, doi 10.1016/0045-7825(91)90022-X) with one r = 1 / w
// for its three rows. It has two unknowns: p_n, and p_s across the slip's direction d;
//   gap_n = 0,  gap_s + alpha p_s = 0,  p_t = mu p_n d + p_s d_perp,
//   alpha = (|tau_t| - mu tau_n) / (mu tau_n r),  tau = p - r gap.
// A singular W is shifted by 1e-8 of its diagonal and refined. That gives the least-norm impulses
// among those that close the same gaps.
class ContactNewton {
 public:
  ContactNewton();
  ~ContactNewton();
  ContactNewton(ContactNewton&&) noexcept;
  ContactNewton& operator=(ContactNewton&&) noexcept;

  // Starts at p (m) and gap = g + W p; `tolerance` is a length. The problem must be the same in
  // every call.
  NewtonResult solve(const ContactProblem& problem, const Vector& g, Vector p, Vector gap,
                     LinearSolver linear, int max_iterations, double tolerance);
  // By the factor of the last solve's final rows, if any. Converged if it solves this g too.
  NewtonResult solve_standing(const ContactProblem& problem, const Vector& g, double tolerance);
  // Impulses that close the rows of that set, if there is a factor and they are within the cones;
  // without other checks.
  bool standing_impulses(const ContactProblem& problem, const Vector& g, Vector& p);
  // `problem`: that of the last solve.
  void keep_state(StateArchive& archive, const ContactProblem& problem);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
