// SPDX-License-Identifier: GPL-3.0-or-later
// A free or constrained block with and without modal mass scaling, and a comparison of two bodies
// that must move equally.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "dynamics/motion/scaled/scaled_body.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::test {

enum class Shape { free, held, hinged };

struct Case {
  Shape shape = Shape::free;
  bool mirrored = false;
  Index k = 10;
  double clip = 0.4;  // relative to the highest frequency
};

const Lattice& block();

std::vector<HeldDirection> held_directions(Shape shape);

Model model_of(const Case& c);

// All modes; each one above the clip gets the clip frequency.
std::shared_ptr<const DiagonalForm> slowed(const DiagonalForm& form, double clip);

inline double energy(const Body& body) {
  return body.state().kinetic_energy + body.state().strain_energy;
}

inline double difference(const Points& a, const Points& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Expects equal motion of both bodies under the same loads, impulses and steps.
void expect_equal_motion(Body& body, Body& reference, double h, int steps, double tolerance,
                         double contact_step = 0);

}  // namespace cbr::test
