// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh cut into domains: which element is in which, and each domain as a mesh of its own.
#pragma once

#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

struct Decomposition {
  Index n_domains = 1;
  // per volume element, in the order of the mesh's blocks: 0 .. n_domains - 1
  std::vector<Index> domain;
};

// Cuts the volume elements into n domains of about the same number of element nodes with few nodes
// shared. Two elements are neighbours when they share a face (its corner nodes). Each domain is
// connected by faces: constrained at three nodes off one line it can neither fall apart nor hinge.
// Domains hold several parts only where the mesh has more than n. Deterministic. InputError: n
// below 1, or more domains than elements.
Decomposition decompose(const Mesh& mesh, Index n);

struct Domain {
  // volume blocks of the whole that have elements here, with their names; nodes ascending
  Mesh mesh;
  std::vector<Index> node;  // per node of `mesh` its index in the whole mesh
  // nodes of `mesh` that are kept, ascending: of the component's interface, and shared ones
  std::vector<Index> interface;
  std::vector<Index> block;  // per block of `mesh` its index in the whole mesh
};

// Nodes that elements of more than one domain use, ascending: indices into mesh.coordinates.
std::vector<Index> shared_nodes(const Mesh& mesh, const Decomposition& decomposition);

// `interface`: nodes of the whole mesh that the component keeps. `sets`: names of the sidesets and
// nodesets that the domains take along, each as far as it lies in a domain.
std::vector<Domain> split(const Mesh& mesh, const Decomposition& decomposition,
                          const std::vector<Index>& interface,
                          const std::vector<std::string>& sets);

}  // namespace cbr
