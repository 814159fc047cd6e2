// SPDX-License-Identifier: GPL-3.0-or-later

#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/domains/domains.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

constexpr double singular_pivot = 1e-14;

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

JoinedPlaces places_of(const SuperelementGroup& group, const JoinedNodes& joined,
                       const std::vector<Index>& interface_ids) {
  const std::set<Index> kept(interface_ids.begin(), interface_ids.end());
  JoinedPlaces places;
  // first of the node: from 0 in the interior, from -1 downwards on the interface
  std::vector<Index> dof(joined.node_ids.size());
  for (const auto& s : group.domains) places.n_interior += s.k();
  for (std::size_t i = 0; i < dof.size(); ++i) {
    const bool interface = kept.contains(joined.node_ids[i]);
    (interface ? places.interface_nodes : places.shared_nodes).push_back(static_cast<Index>(i));
    dof[i] = interface ? JoinedPlaces::on_interface(places.n_interface) : places.n_interior;
    (interface ? places.n_interface : places.n_interior) += 3;
  }
  Index first = 0;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    auto& of = places.of_domain.emplace_back();
    for (Index j = 0; j < s.k(); ++j) of.push_back(first++);
    for (Index i = 0; i < s.c(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Index node = dof[joined.place[d][s.dof_node[at]]];
      of.push_back(node >= 0 ? node + s.dof_component[at] : node - s.dof_component[at]);
    }
  }
  return places;
}

enum class Which { K, M };
using Triplets = std::vector<Eigen::Triplet<double, Index>>;

// Calls take(row, column, value) for all non-zeros of a domain's K or M in its coordinates [k; c].
template <typename Take>
void for_entries(const Superelement& s, Which which, Take take) {
  for (Index j = 0; j < s.k(); ++j) take(j, j, which == Which::K ? s.eigenvalues(j) : 1.0);
  const Matrix& cc = which == Which::K ? s.K_cc : s.M_cc;
  for (Index j = 0; j < s.c(); ++j) {
    for (Index i = 0; i < s.c(); ++i) {
      if (cc(i, j) != 0) take(s.k() + i, s.k() + j, cc(i, j));
    }
  }
  if (which == Which::K) return;
  for (Index j = 0; j < s.c(); ++j) {
    for (Index i = 0; i < s.k(); ++i) {
      take(i, s.k() + j, s.M_kc(i, j));
      take(s.k() + j, i, s.M_kc(i, j));
    }
  }
}

// One block of the joined K or M: rows and columns of the interior or of the interface.
SparseMatrix joined_block(const SuperelementGroup& group, const JoinedPlaces& places, Which which,
                          bool rows_interior, bool columns_interior) {
  Triplets triplets;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const auto& of = places.of_domain[d];
    for_entries(group.domains[d], which, [&](Index i, Index j, double value) {
      const Index row = of[i], column = of[j];
      if ((row >= 0) != rows_interior || (column >= 0) != columns_interior) return;
      triplets.emplace_back(row >= 0 ? row : JoinedPlaces::of_interface(row),
                            column >= 0 ? column : JoinedPlaces::of_interface(column), value);
    });
  }
  SparseMatrix A(rows_interior ? places.n_interior : places.n_interface,
                 columns_interior ? places.n_interior : places.n_interface);
  A.setFromTriplets(triplets.begin(), triplets.end());
  return A;
}

Partition partition_of(const SuperelementGroup& group, const JoinedPlaces& places) {
  Partition p;  // its lists of nodes stay empty: the interior is more than nodes
  p.K_II = joined_block(group, places, Which::K, true, true);
  p.K_IC = joined_block(group, places, Which::K, true, false);
  p.K_CC = joined_block(group, places, Which::K, false, false);
  p.M_II = joined_block(group, places, Which::M, true, true);
  p.M_IC = joined_block(group, places, Which::M, true, false);
  p.M_CC = joined_block(group, places, Which::M, false, false);
  return p;
}

// Numbers of the connected parts that the joined nodes belong to: those that a domain's stiffness
// connects.
std::vector<Index> parts_of(const SuperelementGroup& group, const JoinedNodes& joined) {
  std::vector<Index> part = first_numbers(joined.node_ids.size());
  const auto root = [&](Index i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const auto node = [&](Index dof) { return joined.place[d][s.dof_node[dof]]; };
    for (Index j = 0; j < s.c(); ++j)
      for (Index i = j + 1; i < s.c(); ++i)
        if (s.K_cc(i, j) != 0) part[root(node(i))] = root(node(j));
  }
  for (Index i = 0; i < static_cast<Index>(part.size()); ++i) part[i] = root(i);
  return part;
}

RigidMotions rigid_motions_of(const SuperelementGroup& group, const JoinedNodes& joined,
                              const JoinedPlaces& places, const Partition& p) {
  const std::vector<Index> part = parts_of(group, joined);
  const auto of = [&](const std::vector<Index>& nodes) {
    std::vector<Index> numbers;
    for (const Index node : nodes) numbers.push_back(part[node]);
    return numbers;
  };
  const Index n_modal = places.n_interior - 3 * static_cast<Index>(places.shared_nodes.size());
  return rigid_motions(
      p, joined.coordinates(places.shared_nodes, Eigen::all), of(places.shared_nodes), n_modal,
      joined.coordinates(places.interface_nodes, Eigen::all), of(places.interface_nodes));
}

// Name of a coordinate of the joined interior in messages.
std::string name_of(const JoinedNodes& joined, const JoinedPlaces& places, Index row) {
  const Index n_modal = places.n_interior - 3 * static_cast<Index>(places.shared_nodes.size());
  if (row < n_modal) return "a mode of a domain";
  const Index node = places.shared_nodes[(row - n_modal) / 3];
  return "node id " + std::to_string(joined.node_ids[node]) + " in " + "xyz"[(row - n_modal) % 3];
}

SparseCholesky factorise(const Partition& p, const JoinedNodes& joined,
                         const JoinedPlaces& places) {
  SparseCholesky factor(p.K_II);
  if (p.n_interior() == 0 || (factor.ok() && factor.smallest_pivot() >= singular_pivot))
    return factor;
  throw InputError("second_reduction: the stiffness of the joined domains is singular at " +
                   name_of(joined, places, factor.weakest_column()) +
                   ": a part of it could float or turn, or is held too weakly for a double, as "
                   "very thin parts are; put nodes of that part into the interface, or leave "
                   "second_reduction out");
}

Index n_modes_wanted(const Partition& p, const SparseCholesky& factor,
                     const ReductionOptions& options, Report& report) {
  if (options.second_modes) {
    if (*options.second_modes > p.n_interior())
      throw InputError("second_reduction.modes: " + std::to_string(*options.second_modes) +
                       " requested, but the domains put together have only " +
                       std::to_string(p.n_interior()) +
                       " coordinates off the interface: ask for at most that many");
    return *options.second_modes;
  }
  return p.n_interior() > 0 ? count_modes_below(p, factor, *options.second_cutoff_hz, report) : 0;
}

void describe_interface(const JoinedNodes& joined, const JoinedPlaces& places, Superelement& s) {
  std::vector<Index> place(joined.node_ids.size(), -1);
  for (const Index node : places.interface_nodes) {
    const auto i = static_cast<Index>(s.node_ids.size());
    place[node] = i;
    s.node_ids.push_back(joined.node_ids[node]);
    for (int component = 0; component < 3; ++component) {
      s.dof_node.push_back(i);
      s.dof_component.push_back(component);
    }
  }
  s.coordinates = joined.coordinates(places.interface_nodes, Eigen::all);
  s.surfaces = joined.surfaces;
  for (Surface& surface : s.surfaces) {
    for (Index& node : surface.faces.reshaped()) node = place[node];
  }
  s.nodesets = joined.nodesets;
  for (auto& [name, nodes] : s.nodesets) {
    for (Index& node : nodes) node = place[node];
  }
}

// A domain's coordinates [q_k; u_c] from the whole's [q_k; u_c]   (n_d x (k + c))
Matrix coordinates_of_domain(const std::vector<Index>& places, const Matrix& Psi,
                             const Matrix& Phi) {
  const Index k = Phi.cols(), c = Psi.cols();
  Matrix T(static_cast<Index>(places.size()), k + c);
  for (Index i = 0; i < T.rows(); ++i) {
    const Index place = places[i];
    if (place >= 0) {
      T.row(i) << Phi.row(place), Psi.row(place);
    } else {
      T.row(i) = Vector::Unit(k + c, k + JoinedPlaces::of_interface(place)).transpose();
    }
  }
  return T;
}

Block& block_like(const Block& part, std::vector<Block>& blocks) {
  for (Block& block : blocks) {
    if (block.name == part.name && block.id == part.id && block.type == part.type) return block;
  }
  blocks.push_back({part.name, part.id, part.type, IndexTable(0, part.connectivity.cols()), {}});
  return blocks.back();
}

// Adds a domain's elements; `place`: of its nodes [interface; interior] among the whole's.
void add_blocks(const std::vector<Block>& parts, const std::vector<Index>& place,
                std::vector<Block>& blocks) {
  for (const Block& part : parts) {
    Block& block = block_like(part, blocks);
    const Index first = block.connectivity.rows();
    block.connectivity.conservativeResize(first + part.connectivity.rows(), Eigen::NoChange);
    for (Index e = 0; e < part.connectivity.rows(); ++e) {
      for (Index a = 0; a < part.connectivity.cols(); ++a)
        block.connectivity(first + e, a) = place[part.connectivity(e, a)];
    }
    block.element_ids.insert(block.element_ids.end(), part.element_ids.begin(),
                             part.element_ids.end());
  }
}

// u = Psi u_c + Phi q_k for the shared nodes and the interiors of all domains, from Psi (n_interior
// x c) and Phi (n_interior x k) of the joined interior: each domain's own recovery times these.
// Blocks of one name and type are one again. InputError: a domain has no recovery.
Superelement::Recovery joined_recovery(const SuperelementGroup& group, const JoinedNodes& joined,
                                       const JoinedPlaces& places, const Matrix& Psi,
                                       const Matrix& Phi) {
  const auto n_kept = static_cast<Index>(places.interface_nodes.size()),
             n_shared = static_cast<Index>(places.shared_nodes.size());
  Index n = n_shared;
  for (const auto& s : group.domains) {
    if (s.recovery.empty())
      throw InputError(
          "second_reduction: a domain has no recovery data: reduce the domains with recovery: "
          "true");
    n += static_cast<Index>(s.recovery.front().node_ids.size());
  }
  Superelement::Recovery whole;
  whole.coordinates.resize(n, 3);
  whole.Psi.resize(3 * n, Psi.cols());
  whole.Phi.resize(3 * n, Phi.cols());
  std::vector<Index> place(joined.node_ids.size());  // among [kept; shared; interiors]
  for (Index i = 0; i < n_kept; ++i) place[places.interface_nodes[i]] = i;
  for (Index i = 0; i < n_shared; ++i) {
    const auto node = static_cast<std::size_t>(places.shared_nodes[i]);
    place[node] = n_kept + i;
    whole.node_ids.push_back(joined.node_ids[node]);
    whole.coordinates.row(i) = joined.coordinates.row(static_cast<Index>(node));
  }
  whole.Psi.topRows(3 * n_shared) = Psi.bottomRows(3 * n_shared);
  whole.Phi.topRows(3 * n_shared) = Phi.bottomRows(3 * n_shared);
  Index first = n_shared;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const auto& own = s.recovery.front();
    const auto n_I = static_cast<Index>(own.node_ids.size());
    const Matrix T = coordinates_of_domain(places.of_domain[d], Psi, Phi);
    // u_I = Phi_d q_d + Psi_d u_d   (3 n_I x (k + c))
    const Matrix u = own.Phi * T.topRows(s.k()) + own.Psi * T.bottomRows(s.c());
    whole.Phi.middleRows(3 * first, 3 * n_I) = u.leftCols(Phi.cols());
    whole.Psi.middleRows(3 * first, 3 * n_I) = u.rightCols(Psi.cols());
    whole.coordinates.middleRows(first, n_I) = own.coordinates;
    whole.node_ids.insert(whole.node_ids.end(), own.node_ids.begin(), own.node_ids.end());
    std::vector<Index> local;
    for (const Index node : joined.place[d]) local.push_back(place[node]);
    for (Index i = 0; i < n_I; ++i) local.push_back(n_kept + first + i);
    add_blocks(own.blocks, local, whole.blocks);
    first += n_I;
  }
  return whole;
}

}  // namespace

Superelement reduce_again(const SuperelementGroup& group, const std::vector<Index>& interface_ids,
                          const ReductionOptions& options, const ReduceSettings& settings,
                          Report& report, ReductionFigures* figures) {
  ReductionFigures own;
  ReductionFigures& f = figures != nullptr ? *figures : own;
  const JoinedNodes joined = join_nodes(group);
  const JoinedPlaces places = places_of(group, joined, interface_ids);
  const auto timed = [&](const char* name, auto work) {
    const auto phase = report.phase(std::string("second reduction: ") + name);
    return work();
  };
  const Partition p = timed("assembly", [&] {
    Partition made = partition_of(group, places);
    made.rigid = rigid_motions_of(group, joined, places, made);
    return made;
  });
  const SparseCholesky factor =
      timed("factorisation", [&] { return factorise(p, joined, places); });
  FixedInterfaceModes modes = timed("modes", [&] {
    f.n_candidates = n_modes_wanted(p, factor, options, report);
    return fixed_interface_modes(p, factor, f.n_candidates, report);
  });
  f.condition.smallest_pivot = factor.smallest_pivot();
  f.condition.K_II = condition_numbers(p.K_II, factor);
  if (p.n_interior() > 0) f.condition.weakest = name_of(joined, places, factor.weakest_column());
  f.condition.counts = modes.counts;
  const LocalInterior interior(p, factor);
  f.condition.modes = check_modes(interior, modes.lambda, modes.Phi);
  require_independent(interior, modes.Phi, f.condition.modes);
  CondensationOptions how;
  how.memory = panel_memory(settings.memory, p, factor, modes.Phi);
  how.way = settings.way;
  how.panel = settings.panel;
  how.keep_Psi = options.recovery;
  how.one_Psi = needs_one_Psi(f.condition.K_II.scaled);
  Condensation condensed =
      timed("condensation", [&] { return condense(p, factor, modes.Phi, how, report); });
  static_cast<CondensationFigures&>(f) = condensed;
  if (p.rigid.count() > 0)
    judge_rigid(f.rigid, f.condition.K_II.scaled, f.condition.weakest, report);
  Superelement s;
  s.rigid_body = group.rigid_body;
  describe_interface(joined, places, s);
  s.eigenvalues = std::move(modes.lambda);
  s.K_cc = std::move(condensed.K_cc);
  s.M_cc = std::move(condensed.M_cc);
  s.M_kc = std::move(condensed.M_kc);
  if (options.recovery)
    s.recovery.push_back(joined_recovery(group, joined, places, condensed.Psi, modes.Phi));
  f.condition.reduced_rigid =
      rigid_residual(s.K_cc, reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c())).value;
  f.n_interior = p.n_interior();
  f.mode_method = modes.method;
  f.modes_proven = modes.proven;
  f.factor_nonzeros = factor.n_nonzeros();
  f.factor_flops = factor.flops();
  if (s.k() > 0) f.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  return s;
}

}  // namespace cbr
