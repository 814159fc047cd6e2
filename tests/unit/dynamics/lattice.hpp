// SPDX-License-Identifier: GPL-3.0-or-later
// A block of springs and point masses: a minimal three-dimensional elastic body, for tests without
// elements.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr::test {

struct Lattice {
  Points points;  // n[0] x n[1] x n[2] nodes, x fastest
  Matrix K;       // dense, 3 N x 3 N
  Vector mass;    // N
  std::array<Index, 3> n{};
  Index node(Index i, Index j, Index k) const { return i + n[0] * (j + n[1] * k); }
};

Lattice lattice(std::array<Index, 3> n, double spacing, double stiffness, double mass);
// of 4 x 3 x 3 nodes
const Lattice& block();

RigidBody rigid_body_of(const Lattice& body);

// The two x faces as surfaces "x_min" and "x_max"; faces are positions in `nodes`.
std::vector<Surface> x_faces(const Lattice& body, const std::vector<Index>& nodes);

// Nodes of the selected x faces.
std::vector<Index> x_nodes(const Lattice& body, bool minimum, bool maximum);

// Craig-Bampton with dense algebra, k lowest modes, no stored diagonal form.
Superelement reduce(const Lattice& body, const std::vector<Index>& interface_nodes, Index k);

// Fills omega and V like cbr-reduce.
void store_diagonal_form(Superelement& s);

struct Model {
  std::shared_ptr<Superelement> superelement;
  std::shared_ptr<const ModalForm> form;
};

Model model(Superelement s);

// Oblique axes, mirrored or not, with a velocity.
Placement oblique(bool mirrored);

Points random_points(std::mt19937& random, Index n, double size);

}  // namespace cbr::test
