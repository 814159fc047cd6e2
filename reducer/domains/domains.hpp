// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/domains: a component in several domains, and their second reduction.
//
// One component in several domains: each reduced by itself, all at once.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/superelement/superelement_group.hpp"
#include "reducer/bases/reduce.hpp"

namespace cbr {

struct DomainFigures {
  Index n_elements = 0;
  Index modes_missing = 0;  // asked for beyond the interior's dofs
  ReductionFigures reduction;
  std::vector<std::string> warnings;
};

struct GroupFigures {
  Index n_dofs = 0;          // of the whole mesh
  Index n_shared_nodes = 0;  // in more than one domain
  std::vector<DomainFigures> domains;
  int n_workers = 1;  // threads of each process
  int n_processes = 1;
  double seconds = 0;  // of the domains' reduction, all together
};

// Work of one of several processes (reducer/distributed/processes.hpp). By default of
// one alone.
struct DomainShare {
  bool is_first = true;
  int processes = 1, here = 1;  // here: on this machine
  std::function<bool(std::size_t)> is_own = [](std::size_t) { return true; };
  // An error that one has is thrown in all.
  std::function<void(const std::function<void()>&)> together =
      [](const std::function<void()>& work) { work(); };
  // To the first process, of each domain.
  std::function<void(std::vector<Superelement>&, std::vector<DomainFigures>&)> gather =
      [](std::vector<Superelement>&, std::vector<DomainFigures>&) {};
};

// Cuts the mesh into options.domains parts and reduces each with `modes` (all of its own when it
// has fewer) or `cutoff_hz`. Fills all but content_hash and provenance. Workers: n_threads(), each
// with one thread of BLAS and its share of the memory; their number does not change the domains'
// bytes. The diagonal form is that of the joined superelement, stored for n up to
// settings.diagonal_limit. InputErrors as of reduce(), with the domain's number. Of several
// processes the first gets the group, others an empty one.
SuperelementGroup reduce_domains(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 GroupFigures* figures = nullptr, const DomainShare& share = {});

// Ids of the nodes that the component keeps, in the order of the mesh.
std::vector<Index> component_interface(const Mesh& mesh, const std::vector<std::string>& sets);

// rho_res along x, y, z of the joined domains: r^T S r / m, r a translation of `interface_ids`
// (mesh ids). S is the Schur complement of the joined mass after elimination of modes and the
// domains' other nodes. A dense factor of these nodes' dofs: none above `most` of them.
std::optional<Vector3> residual_mass_share(const SuperelementGroup& group,
                                           const std::vector<Index>& interface_ids,
                                           Index most = 6000);

// Per node id the connected part of the mesh that it belongs to: connected_parts(), for
// add_diagonal_form().
std::vector<Index> parts_of(const Mesh& mesh, const std::vector<Index>& node_ids);

// --- the domains, put together and reduced once more to the component's own interface ---

// Interior: the modal coordinates of all domains and the shared nodes that the component does not
// keep; interface: the joined nodes with an id of `interface_ids`. Statically the same as one
// reduction of the whole; its modes lie in the span of the domains' modes. `options`: second_modes
// or second_cutoff_hz (lowest modes), recovery (the domains must have theirs). Sets everything but
// content_hash, provenance and the diagonal form, which add_diagonal_form() adds. InputError: more
// modes than there are, a part that the interface does not constrain.
Superelement reduce_again(const SuperelementGroup& group, const std::vector<Index>& interface_ids,
                          const ReductionOptions& options, const ReduceSettings& settings,
                          Report& report, ReductionFigures* figures = nullptr);

}  // namespace cbr
