// SPDX-License-Identifier: GPL-3.0-or-later
// Where the domains' coordinates are in their second reduction, and their interiors by way of it.
#pragma once

#include <vector>

#include "common/superelement/superelement_group.hpp"

namespace cbr {

// Interior of a joined group: [modes of domain 1; ...; modes of domain N; x, y, z of the shared
// nodes]; interface: x, y, z of the nodes that are kept.
struct JoinedPlaces {
  Index n_interior = 0, n_interface = 0;
  // joined nodes, ascending: kept, and in the interior
  std::vector<Index> interface_nodes, shared_nodes;
  // Per domain and coordinate of it ([k; c]) its number: from 0 in the interior, on_interface(j)
  // for dof j of the interface.
  std::vector<std::vector<Index>> of_domain;
  static Index on_interface(Index dof) { return -1 - dof; }
  static Index of_interface(Index place) { return -1 - place; }
};

// u = Psi u_c + Phi q_k for the shared nodes and the interiors of all domains, from Psi (n_interior
// x c) and Phi (n_interior x k) of the joined interior: each domain's own recovery times these.
// Blocks of one name and type are one again. InputError: a domain has no recovery.
Superelement::Recovery joined_recovery(const SuperelementGroup& group, const JoinedNodes& joined,
                                       const JoinedPlaces& places, const Matrix& Psi,
                                       const Matrix& Phi);

}  // namespace cbr
