// SPDX-License-Identifier: GPL-3.0-or-later
// The methods for the impulses of one W, and what they keep between right-hand sides.
// contact_solver.cpp has their order.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/cone/cone_impulses.hpp"
#include "dynamics/contact/solve/newton/contact_newton.hpp"
#include "dynamics/contact/solve/newton/inexact_newton.hpp"

namespace cbr {

bool has_friction(const ContactProblem& problem);
bool all_frictionless(const ContactProblem& problem);

// The best so far; p within the laws' cones. None at first, which is what stays when magnitudes are
// beyond a double's reach.
struct BestImpulses {
  explicit BestImpulses(const Vector& g) : p(Vector::Zero(g.size())), gap(g) {}
  Vector p, gap;
  double residual = std::numeric_limits<double>::infinity();  // a length
  // a residual that calls for no other method
  double good = 0;
  int iterations = 0;

  bool done() const { return residual <= good; }
  // Taken where it is better. `scale`: the largest |g|.
  void offer(const ContactProblem& problem, double scale, Vector new_p, Vector new_gap,
             double new_residual);
};

// Each method offers its impulses to `best` and adds its iterations. `scale`: the largest |g|.
class ContactMethods {
 public:
  // A share of the largest |g|: what is aimed at.
  static constexpr double aim = 1e-12;
  // Rows from which Krylov methods are faster than factors where W stands for some steps
  // (docs/decisions/contact-solver.md), and where it is another in each.
  static constexpr Index krylov_rows_of_kept_W = 128, krylov_rows_of_new_W = 700;
  static constexpr int newton_iterations = 30, retry_iterations = 12;

  explicit ContactMethods(ContactProblem problem, Index krylov_rows = krylov_rows_of_kept_W);
  Index krylov_rows() const { return krylov_rows_; }
  const ContactProblem& problem() const { return problem_; }
  bool friction() const { return has_friction(problem_); }
  bool is_finite() const { return is_finite_; }  // of W

  void newton(const Vector& g, const Vector& p, const Vector& gap, LinearSolver linear,
              int iterations, double scale, BestImpulses& best);
  // Of a dense W with many rows: false when it does not solve it.
  bool inexact(const Vector& g, Vector p, Vector gap, double scale, const GapsOf& gaps_of,
               BestImpulses& best);
  // With what is factored for the last set.
  NewtonResult standing(const Vector& g, double scale, BestImpulses& best);
  bool standing_impulses(const Vector& g, Vector& p);
  // Newton with the share of all friction coefficients; p and gap are where to start from, and the
  // result when it converged.
  bool newton_with(double share, const Vector& g, double scale, BestImpulses& best, Vector& p,
                   Vector& gap);
  void sweep(const Vector& g, Vector p, int n, double scale, BestImpulses& best);
  void gradients(const Vector& g, Vector p, double scale, BestImpulses& best);
  // Of a dense W with friction: false when it is regular, too large, or the impulses are not good
  // enough.
  bool cones(const Vector& g, const Vector& guess, double scale, BestImpulses& best);
  // Of a dense W without friction or ties.
  void basic(const Vector& g, double scale, BestImpulses& best);

  // g + W p; of the last solution's impulses without a product.
  Vector gap_of(const Vector& g, const Vector& p) const;
  void remember(const Vector& g, const Vector& p, const Vector& gap);
  void renumber(GapResponse W, std::vector<PointLaw> laws, const std::vector<Index>& from);
  // The rest follows from W and the laws, whenever it is asked for.
  void keep_state(StateArchive& archive);
  void begin_as(const ContactMethods& other);

  Index n_factored() const { return newton_.n_factored(); }
  bool cones_first() const { return cones_first_; }
  bool singular_with_friction() const { return cones_ && cones_->rank() > 0; }
  bool basic_first() const {
    return basic_first_ && !problem_.W.is_sparse && all_frictionless(problem_);
  }

 private:
  bool is_last(const Vector& p) const { return p.size() == last_.p.size() && p == last_.p; }
  // From the last impulses as they have changed lately, where that violates the laws less.
  void go_on(const Vector& g, Vector& p, Vector& gap) const;

  ContactProblem problem_;
  Index krylov_rows_;
  bool is_finite_ = true;
  ContactNewton newton_;
  InexactNewton inexact_;
  struct Remembered {
    Vector p, answer;  // answer = W p
  };
  Remembered last_, before_;  // of the last solution, and of the one before it
  bool basic_first_ = false;  // it has solved what Newton's method did not
  bool cones_first_ = false;  // the same, with friction
  std::optional<ConeProblem> cones_;
  std::optional<BlockGaussSeidel> sweeps_;
  double norm_ = 0;  // of W scaled to a unit diagonal, once known
};

}  // namespace cbr
