// SPDX-License-Identifier: GPL-3.0-or-later
// Sparse approximate inverse of a Newton step's matrix, from each unknown's neighbours.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/solve/newton/closed_unknowns.hpp"

namespace cbr {

class StateArchive;

// For each point the points whose normal gaps respond most to its normal impulse, largest first.
// Gaps and impulses are scaled by the roots of W_ii. On a face these are the nearest points.
class Neighbours {
 public:
  Neighbours() = default;
  explicit Neighbours(const ContactProblem& problem);
  static constexpr Index most = 40;
  const std::vector<Index>& of(Index point) const { return nearest_[point]; }
  Index n_points() const { return static_cast<Index>(nearest_.size()); }
  void keep_state(StateArchive& archive);

 private:
  std::vector<std::vector<Index>> nearest_;
};

// G^T G ~ (R^T W R + diag(alpha))^-1, G lower triangular. Row i has the unknowns of i's point and
// of its nearest earlier points, normal and tangential ones separately. It is the last row of the
// inverse Cholesky factor of their block (Kolotilina, Yeremin 1993, doi 10.1137/0614004). Static
// compliance decays like 1 / distance, its inverse like 1 / distance^3, so that a few neighbours
// suffice.
class LocalInverse {
 public:
  // With the same W since the last forget().
  void build(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
             const Neighbours& neighbours);
  void forget() { of_normals_.clear(); }
  void apply(FloatVector& x) const;  // x := G^T G x

  // Earlier points in a row of G; more gave no benefit (docs/decisions/contact-solver.md).
  static constexpr int normal_neighbours = 5, tangential_neighbours = 4;
  static constexpr int most_in_row = 2 * (tangential_neighbours + 1);

  struct Row {
    int n = 0;
    std::array<int, most_in_row> column;
    std::array<float, most_in_row> value;
  };

 private:
  void set_normal_row(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
                      const std::vector<Index>& nearest, Index point);

  std::vector<Row> rows_;
  // Row of a point's normal unknown, valid while its block has the same points.
  struct Kept {
    int n_points = 0, n = 0;
    std::array<int, normal_neighbours + 1> points;
    std::array<float, normal_neighbours + 1> value;
  };
  std::vector<Kept> of_normals_;  // per point
  mutable FloatVector y_;
};

}  // namespace cbr
