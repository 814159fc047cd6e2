// SPDX-License-Identifier: GPL-3.0-or-later
// A random scene in dense matrices.
#pragma once

#include "tests/stability/dense_run.hpp"
#include "tests/stability/random_scene.hpp"

namespace cbr::test {

DenseModel dense_model(const RandomBody& body);

// Craig-Bampton with the superelement's dofs, in its order.
DenseReduction dense_reduction(const RandomBody& body, const DenseModel& model,
                               const Superelement& s);

// The scene's body i, with the nodes, faces and sets of `ran`. First as a mesh, then reduced.
DenseBody dense_body(const RandomScene& scene, const Ran& ran, std::size_t i,
                     const DenseModel& model);
DenseBody dense_body(const RandomScene& scene, const Ran& ran, std::size_t i, const Superelement& s,
                     const DenseReduction& reduced);

// The scene's pairs, of two bodies or with a wall.
std::vector<DensePair> dense_pairs(const RandomScene& scene, const Ran& ran);
bool is_of(const RandomPair& pair, const RandomBody& body);

}  // namespace cbr::test
