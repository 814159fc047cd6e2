// SPDX-License-Identifier: GPL-3.0-or-later
// Connected parts of a component, each as a component of its own: nothing of K and M is between
// them.
#pragma once

#include <vector>

#include "common/app/report.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

struct ComponentPart {
  // with the whole's rigid motions of it; no lists of nodes
  Partition p;
  std::vector<Index> inside, on_interface;  // rows of the whole's u_I and u_C, ascending
  std::vector<Index> interface_nodes;       // of the whole's superelement

  // the part of each node
  std::vector<Index> one() const { return std::vector<Index>(interface_nodes.size(), 0); }
};

// part_I, part_C: per node inside and on the interface the number of its part (of
// connected_parts()). Numbers without a node are left out. K_II is needed.
std::vector<ComponentPart> split(const Partition& p, const std::vector<Index>& part_I,
                                 const std::vector<Index>& part_C);

// K_cc, M_cc and the interface of one part; the rest is empty. Its centre is that of its interface
// nodes.
Superelement part_of(const Superelement& s, const ComponentPart& part);

// Which of `parts` each column of Phi (n_I x k) moves: the one with most of it.
std::vector<std::size_t> owners(const std::vector<ComponentPart>& parts, const Matrix& Phi);

// Modes of the parts as modes of the whole of n_I interior dofs, 0 outside their part, ascending;
// of equal ones the first part's first. The method is that of the first that has one; `next` and
// `counts` are not set.
FixedInterfaceModes joined(const std::vector<ComponentPart>& parts,
                           const std::vector<FixedInterfaceModes>& modes, Index n_I);

// The k lowest fixed-interface modes of all parts together. Each part's own problem gives its
// likely number of them, and more until none can be missing. So a solver sees equal parts as no
// multiple eigenvalues. Errors: fixed_interface_modes().
FixedInterfaceModes fixed_interface_modes_by_part(const std::vector<ComponentPart>& parts,
                                                  Index n_I, Index k, Report& report);

}  // namespace cbr
