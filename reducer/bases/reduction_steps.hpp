// SPDX-License-Identifier: GPL-3.0-or-later
// What the steps of one reduction (reduce.cpp) work on, and what they ask of it.
#pragma once

#include <string>
#include <vector>

#include "reducer/bases/reduce.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/component_parts.hpp"

namespace cbr {

// What every step of one reduction works on.
struct Reduction {
  const Mesh& mesh;
  const ReductionOptions& options;
  const ReduceSettings& settings;
  Report& report;
  FiniteElementModel model;
  Partition p;
  std::vector<Index> part;  // per model node
  Points x;                 // of the model's nodes
  ReductionFigures figures;
  ModesNotKept not_kept;
  Matrix lowest = {};  // n_I x m: the lowest of the kept fixed-interface modes
};

Index mesh_node(const Reduction& r, Index model_node);
std::string node_of_interior_dof(const Reduction& r, Index dof);  // with its axis
std::string node_of_interface_dof(const Reduction& r, Index dof);

// Per node the number of its connected part.
std::vector<Index> parts_of_nodes(const Reduction& r, const std::vector<Index>& nodes);
std::vector<Index> parts_of_interface(const Reduction& r);
bool has_parts(const Reduction& r);  // more than one
// None when the component is one part.
std::vector<ComponentPart> parts(const Reduction& r);

Points coordinates_of(const Reduction& r, const std::vector<Index>& nodes);
void describe_interface(const Reduction& r, Superelement& s);
void add_recovery(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s);

}  // namespace cbr
