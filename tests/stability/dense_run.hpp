// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies in contact, step by step, in dense arithmetic.
#pragma once

#include <optional>
#include <vector>

#include "tests/stability/dense_body.hpp"
#include "tests/stability/dense_search.hpp"

namespace cbr::test {

struct DensePair {
  DenseSurface slave;
  std::optional<DenseSurface> master;  // or the wall
  DenseWall wall;
  bool penalty = false, two_way = false;
  double friction = 0, damping = 0;
};

struct DenseMotion {
  struct OfBody {
    std::vector<Points> x;        // at each output: positions of its visible nodes
    std::vector<Points> impulse;  // of contact, on each node since the last output
  };
  std::vector<OfBody> bodies;
  std::vector<Index> n_pushes;  // of each pair: points with an impulse, summed over the steps
  // see dense_depth(): the largest at the end of a step, for impulses between bodies
  double depth = 0;
  bool is_unique = true;  // no step had two solutions of Coulomb's law
};

DenseMotion dense_motion(const std::vector<DenseBody>& bodies, const std::vector<DensePair>& pairs,
                         double h, Index n_outputs, Index steps_per_output);

}  // namespace cbr::test
