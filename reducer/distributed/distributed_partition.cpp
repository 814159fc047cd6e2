// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/distributed_partition.hpp"

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/fem/connected_parts.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

// Psi is put together in the first process, and written by it.
void require_memory_for_recovery(Index n_I, Index c) {
  const double bytes = 8.0 * static_cast<double>(n_I) * static_cast<double>(c);
  if (bytes > machine_memory_bytes())
    throw InputError("recovery: the motion of " + std::to_string(n_I) + " dofs inside with " +
                     std::to_string(c) + " on the interface takes " + human_bytes(bytes) +
                     " in the first process, whose machine has " +
                     human_bytes(machine_memory_bytes()) +
                     ": leave it out, take a smaller interface, or domains");
}

}  // namespace

void refuse(const std::string& what) {
  throw InputError(what +
                   " is not known to several processes and --engine petsc: reduce this component "
                   "in one process without it");
}

void refuse_unknown(const ReductionOptions& options) {
  if (options.is_massless()) refuse("basis: massless");
  if (options.tolerance) refuse("tolerance");
  if (options.recovery && options.is_characteristic())
    refuse("basis: characteristic with recovery");
  if (options.pick == Pick::participation && options.cutoff_hz)
    throw InputError("pick: participation needs `modes`: a cutoff keeps every mode below it");
  check_modes_wanted(options);
}

std::vector<Index> places(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> place(r.mesh.node_ids.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place[mesh_node(r, nodes[i])] = static_cast<Index>(i);
  return place;
}

void divide(Reduction& r) {
  r.model = number_nodes(r.mesh);
  r.x = r.mesh.coordinates(r.model.nodes, Eigen::all);
  r.p.interface_nodes = interface_nodes(r.mesh, r.model, r.options.interface_sets);
  const auto n = static_cast<Index>(r.model.nodes.size());
  std::vector<bool> kept(n, false);
  for (const Index i : r.p.interface_nodes) kept[i] = true;
  for (Index i = 0; i < n; ++i)
    if (!kept[i]) r.p.interior_nodes.push_back(i);
  const auto n_I = 3 * static_cast<Index>(r.p.interior_nodes.size()),
             c = 3 * static_cast<Index>(r.p.interface_nodes.size());
  r.p.K_II.resize(n_I, n_I);
  r.p.K_CC.resize(c, c);  // their sizes alone
  r.part = connected_parts(r.mesh, r.model);
  if (has_parts(r)) refuse("a component of several parts that share no node");
  if (n_I == 0) refuse("a component whose nodes are all on the interface");
  check_interface_holds(r.mesh, r.model, r.p, r.part);
  require_memory_for_interface(c, machine_memory_bytes());
  if (r.options.recovery) require_memory_for_recovery(n_I, c);
  r.figures.n_dofs = 3 * n;
  r.figures.n_interior = n_I;
}

}  // namespace cbr
