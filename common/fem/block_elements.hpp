// SPDX-License-Identifier: GPL-3.0-or-later
// The elements of a block: of what kind they are, where, and the share of each thread.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

inline bool is_volume(const Block& block) { return dimension(block.type) == 3; }
inline bool is_shell(const Block& block) { return is_structure(block) && !is_volume(block); }

// n x 3, in the element's order of nodes.
inline Points element_points(const Mesh& mesh, const Block& block, Index e) {
  Points X(block.connectivity.cols(), 3);
  for (Index i = 0; i < X.rows(); ++i) X.row(i) = mesh.coordinates.row(block.connectivity(e, i));
  return X;
}

// The share of 0 .. n - 1 that thread t of n_threads does.
struct Share {
  Index begin, end;
  Share(Index n, int t, int n_threads) : begin(n * t / n_threads), end(n * (t + 1) / n_threads) {}
};

// x^T M x of each column of X (dofs of the model x m), M the consistent mass of all solids.
Vector consistent_mass_products(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                const FiniteElementModel& model, const Matrix& X);

}  // namespace cbr
