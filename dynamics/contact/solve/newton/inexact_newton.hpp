// SPDX-License-Identifier: GPL-3.0-or-later
// Semismooth Newton on the laws of many points with a dense W, with few products in single
// precision per step.
#pragma once

#include <memory>

#include "dynamics/contact/solve/newton/contact_newton.hpp"

namespace cbr {

// ContactNewton's method with inexact steps (Dembo, Eisenstat, Steihaug 1982, doi 10.1137/0719025).
// GMRES in single precision, preconditioned by a LocalInverse, over the points that are or were
// recently closed. Open points need only their normal gap. Gaps are accumulated in single precision
// over the steps, recomputed with W near the end, and verified by `gaps_of`. Earlier solutions
// affect only the order of sums; stored data only save time.
class InexactNewton {
 public:
  InexactNewton();
  ~InexactNewton();
  InexactNewton(InexactNewton&&) noexcept;
  InexactNewton& operator=(InexactNewton&&) noexcept;

  // As ContactNewton::solve(). W is dense.
  NewtonResult solve(const ContactProblem& problem, const Vector& g, Vector p, Vector gap,
                     int max_iterations, double tolerance, const GapsOf& gaps_of);
  void forget();  // for a new W
  // For points of the same bodies: copies their neighbourhood.
  void begin_as(const InexactNewton& other);
  // `problem`: that of the last solve. The state determines the order of sums.
  void keep_state(StateArchive& archive, const ContactProblem& problem);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
