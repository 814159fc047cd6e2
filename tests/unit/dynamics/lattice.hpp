// SPDX-License-Identifier: GPL-3.0-or-later
// A block of springs and point masses: the smallest three-dimensional elastic body, for tests that
// need no elements.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/diagonal_form.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr::test {

struct Lattice {
  Points points;  // n[0] x n[1] x n[2] nodes, x fastest
  Matrix K;       // dense, 3 N x 3 N
  Vector mass;    // N
  std::array<Index, 3> n{};
  Index node(Index i, Index j, Index k) const { return i + n[0] * (j + n[1] * k); }
};

Lattice lattice(std::array<Index, 3> n, double spacing, double stiffness, double mass);

RigidBody rigid_body_of(const Lattice& body);

// The two x faces as surfaces "x_min" and "x_max", faces indexing `nodes` (positions in it).
std::vector<Surface> x_faces(const Lattice& body, const std::vector<Index>& nodes);

// Nodes of the two x faces, x_max first when only one is asked for.
std::vector<Index> x_nodes(const Lattice& body, bool minimum, bool maximum);

// Craig-Bampton with dense algebra, k lowest modes, no stored diagonal form.
Superelement reduce(const Lattice& body, const std::vector<Index>& interface_nodes, Index k);

// Fills omega and V as cbr-reduce does.
void store_diagonal_form(Superelement& s);

struct Model {
  std::shared_ptr<Superelement> superelement;
  std::shared_ptr<const DiagonalForm> form;
};

Model model(Superelement s);

// In axes of its own, mirrored or not, and under way.
Placement oblique(bool mirrored);

Points random_points(std::mt19937& random, Index n, double size);

}  // namespace cbr::test
