// SPDX-License-Identifier: GPL-3.0-or-later
// Which elements of a mesh hold together.
#pragma once

#include <string>
#include <vector>

#include "common/fem/assembly.hpp"

namespace cbr {

// Per model node the number (from 0) of the connected part of the mesh that it belongs to: elements
// that share a node are connected.
std::vector<Index> connected_parts(const Mesh& mesh, const FiniteElementModel& model);

// Nodes of two parts (of connected_parts()) that are nearer to each other than a thousandth of the
// shortest edge of either's elements: at one place but for the digits that a mesh file has. Model
// nodes, first < second, ascending.
struct NearNodes {
  Index first = 0, second = 0;
  double apart = 0;
};
std::vector<NearNodes> near_nodes(const Mesh& mesh, const FiniteElementModel& model,
                                  const std::vector<Index>& part);
std::string how_near(double apart);  // "at the same place", "only 5e-07 apart"

// A warning about these, as if a mesh had been put together without joining it; empty when there
// are none.
std::string unjoined_parts(const Mesh& mesh, const FiniteElementModel& model,
                           const std::vector<Index>& part);

// "2 parts that share no node (first node ids 1, 65): ..."; empty for one part.
std::string several_parts(const Mesh& mesh, const FiniteElementModel& model,
                          const std::vector<Index>& part);

}  // namespace cbr
