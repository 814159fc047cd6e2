// SPDX-License-Identifier: GPL-3.0-or-later
// Residual compliance of many forces from few solves: loads of many forces at once that are far
// from each other. docs/theory.md, "Compliance in levels".
#pragma once

#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/compliance_levels.hpp"

namespace cbr {

// Loads whose answers tell a compliance, and its levels from the answers. The same forces give the
// same loads.
class ComplianceProbes {
 public:
  // x, direction: places and unit directions of the forces (s x 3); of_node: forces at a node
  ComplianceProbes(const Points& x, const Points& direction, double of_node);

  Index count() const { return loads_.cols(); }
  const Matrix& loads() const { return loads_; }  // X, s x count
  // Of answers F X (s x count) of a symmetric, positive semi-definite F. The levels are positive
  // semi-definite, too.
  std::vector<ComplianceLevel> levels(const Matrix& answers) const;

 private:
  struct Level {
    std::vector<Index> places;  // forces
    SparseMatrix P;
    SparseMatrix near;           // k x k, 1 where S has entries; empty: everywhere
    std::vector<Index> load_of;  // of each place: its load, among all
    Index first = 0, last = 0;   // loads of this level
  };
  Level level_of(Index n_places, double spacing, double reach) const;
  Matrix at_places(const Level& level, const Matrix& Y) const;
  void add_loads(Level level);

  Points x_, direction_;
  std::vector<Index> order_;  // forces, each as far as can be from those before it
  std::vector<Level> levels_;
  Matrix loads_;
};

}  // namespace cbr
