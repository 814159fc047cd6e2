// SPDX-License-Identifier: GPL-3.0-or-later
// Small coupled models: a row of superelements that share planes of nodes, with random shells on
// some of them; and their supports and loads.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "dynamics/motion/coupled/coupled_body.hpp"
#include "dynamics/motion/coupled/coupled_model.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::test {

struct Chain {
  std::vector<std::shared_ptr<const Superelement>> domains;
  Points coordinates;
  std::vector<std::vector<Index>> place;
  RigidBody body;
  CoupledModel model() const { return coupled_model(domains, coordinates, place, body); }
};

// Lattices of 3 x 2 x 3 nodes that share planes of constant x, which are the interface. k modes
// each.
Chain chain(Index n_domains, Index k);

// A random stiffness with the six rigid motions of nodes with rotations as its kernel, and lumped
// masses.
ShellModel random_shells(const Points& points, const std::vector<Index>& nodes, double stiffness,
                         double mass);

// Two domains with shells on the first plane.
CoupledModel chain_with_shells(Index k);

// K and M of all coordinates, dense (n x n), assembled as in the header of coupled_model.hpp.
Matrix whole_stiffness(const CoupledModel& model);

Matrix whole_mass(const CoupledModel& model);

std::vector<HeldDirection> some_held();

// Basis of the free coordinates of the whole model.
Matrix whole_free_basis(const CoupledModel& model, const std::vector<HeldDirection>& held);

struct Method {
  Scheme scheme;
  double alpha;
};
extern const std::vector<Method> methods;

// A load history with kinks.
extern const History ramp;

std::shared_ptr<const CoupledModel> shared(CoupledModel model);

}  // namespace cbr::test
