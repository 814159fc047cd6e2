// SPDX-License-Identifier: GPL-3.0-or-later
// Semismooth Newton on the laws of many points with a dense W, its steps by few products in single
// precision.
#pragma once

#include <memory>

#include "dynamics/contact/solve/newton/contact_newton.hpp"

namespace cbr {

// The method of ContactNewton with inexact steps (Dembo, Eisenstat, Steihaug 1982,
// doi 10.1137/0719025): GMRES in single precision, preconditioned by a LocalInverse, over the
// points that are or were lately closed. Open points cost the normal gap that they may close by.
// Gaps are summed up in single precision from step to step, with W itself near the end, and by
// `gaps_of` before anything is called solved. Nothing depends on what was solved before but the
// order of sums; what is kept saves time only.
class InexactNewton {
 public:
  InexactNewton();
  ~InexactNewton();
  InexactNewton(InexactNewton&&) noexcept;
  InexactNewton& operator=(InexactNewton&&) noexcept;

  // As ContactNewton::solve(). W is dense.
  NewtonResult solve(const ContactProblem& problem, const Vector& g, Vector p, Vector gap,
                     int max_iterations, double tolerance, const GapsOf& gaps_of);
  void forget();  // W is another from now on
  // Of the same bodies' points: which are near each other is taken from there.
  void begin_as(const InexactNewton& other);
  // `problem`: that of the last solve. What is kept decides the order of sums.
  void keep_state(StateArchive& archive, const ContactProblem& problem);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
