// SPDX-License-Identifier: GPL-3.0-or-later
// Contact, ties and motions of floating bodies in equilibrium, for given W and B.
#pragma once

#include <optional>
#include <vector>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/laws/contact_set.hpp"
#include "dynamics/contact/solve/contact_solver.hpp"

namespace cbr {

// Of the largest allowed motion: deflection of the springs on floating bodies under the forces if
// all bodies are rigid.
constexpr double rigid_share = 1e-3;

// Amplitudes of unconstrained motions N: along the forces on them if these exceed round-off, else
// 0.
Vector unheld_moves(const Vector& c, const Matrix& N, double force, double way);

// W and B, and their factors. Adding rho B B^T to W and rho B c to g does not change the solution
// in equilibrium. W is then regular for independent rows.
class StaticSystem {
 public:
  // flexibility: length per force of floating bodies, if all bodies are rigid.
  StaticSystem(Matrix W, Matrix B, const std::vector<PointLaw>& laws, double flexibility);

  struct Solution {
    Vector p, gap, moves, left;
    // violation: of a law, a length; scale: its reference
    double violation = 0, scale = 0, largest_force = 0;
    bool fallback = false;
  };
  Solution solve(const Vector& g, const Vector& c, const Vector& guess, double largest_force,
                 double most_way);

 private:
  struct Held {
    Vector p, moves;  // of the rows of ties; of all floating bodies
  };
  void split(const std::vector<PointLaw>& laws);
  void factor_ties();
  void split_moves();
  void reduce(double flexibility);
  Held hold(const Vector& a, const Vector& b) const;
  Vector press(const Vector& g, const Vector& c, double most_way, Solution& solution);
  struct Step {
    Vector p, moved;
  };
  Step step(const SetBases& bases, const Vector& g, const Vector& c, const Vector& moved,
            double hold) const;
  bool newton(const Vector& g, const Vector& c, double most_way, double force, Vector& p,
              Vector& moved) const;
  Vector without_drift(const SetBases& bases, const Vector& moved) const;
  Vector search(const Vector& g, const Vector& c, double most_way, double force, Vector& p);
  Matrix stiffness_of_contact(const Vector& p, const Vector& gap) const;
  Vector next_move(const Matrix& H, const Vector& r, const Vector& moved, double most_way,
                   double hold) const;

  Matrix W_, B_;
  double rho_ = 0;
  std::vector<Index> tie_rows_, contact_rows_;  // independent rows of ties only
  std::vector<PointLaw> contact_laws_;
  // W of the ties = L L^T in rows times scale_, U = L^-1 B Q, S = U^T U. Q: motions that ties
  // constrain, N: the remaining ones, orthonormal
  Vector scale_;
  std::optional<Cholesky> L_, S_;
  Matrix U_, Q_, N_;
  // B and W of contact, ties eliminated; and with springs on the motions N
  Matrix contact_B_;
  double spring_ = 0;  // length per force
  ContactProblem problem_;
  std::optional<ContactProblem> sprung_;  // formed on demand
  // The last motions changed no force, as all points slide. Newton's method would not converge.
  bool slides_ = false;
};

}  // namespace cbr
