// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/domains/second_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/domains/joined_recovery.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {
namespace {

constexpr double singular_pivot = 1e-14;

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
      const Index node =
          dof[static_cast<std::size_t>(joined.place[d][static_cast<std::size_t>(s.dof_node[at])])];
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
      const Index row = of[static_cast<std::size_t>(i)], column = of[static_cast<std::size_t>(j)];
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
  std::vector<Index> part(joined.node_ids.size());
  std::iota(part.begin(), part.end(), Index{0});
  const auto root = [&](Index i) {
    while (part[static_cast<std::size_t>(i)] != i)
      i = part[static_cast<std::size_t>(i)] =
          part[static_cast<std::size_t>(part[static_cast<std::size_t>(i)])];
    return i;
  };
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const auto node = [&](Index dof) {
      return joined.place[d][static_cast<std::size_t>(s.dof_node[static_cast<std::size_t>(dof)])];
    };
    for (Index j = 0; j < s.c(); ++j)
      for (Index i = j + 1; i < s.c(); ++i)
        if (s.K_cc(i, j) != 0) part[static_cast<std::size_t>(root(node(i)))] = root(node(j));
  }
  for (Index i = 0; i < static_cast<Index>(part.size()); ++i)
    part[static_cast<std::size_t>(i)] = root(i);
  return part;
}

RigidMotions rigid_motions_of(const SuperelementGroup& group, const JoinedNodes& joined,
                              const JoinedPlaces& places, const Partition& p) {
  const std::vector<Index> part = parts_of(group, joined);
  const auto of = [&](const std::vector<Index>& nodes) {
    std::vector<Index> numbers;
    for (const Index node : nodes) numbers.push_back(part[static_cast<std::size_t>(node)]);
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
  const Index node = places.shared_nodes[static_cast<std::size_t>((row - n_modal) / 3)];
  return "node id " + std::to_string(joined.node_ids[static_cast<std::size_t>(node)]) + " in " +
         "xyz"[(row - n_modal) % 3];
}

SparseCholesky factorise(const Partition& p, const JoinedNodes& joined,
                         const JoinedPlaces& places) {
  SparseCholesky factor(p.K_II);
  if (p.n_interior() == 0 || (factor.ok() && factor.smallest_pivot() >= singular_pivot))
    return factor;
  throw InputError("second_reduction: the stiffness of the joined domains is singular at " +
                   name_of(joined, places, factor.weakest_column()) +
                   ": a part of it could float or turn, or is held too weakly for a double, as "
                   "very thin parts are; put nodes of "
                   "that part into the "
                   "interface, or leave second_reduction out");
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
    place[static_cast<std::size_t>(node)] = i;
    s.node_ids.push_back(joined.node_ids[static_cast<std::size_t>(node)]);
    for (int component = 0; component < 3; ++component) {
      s.dof_node.push_back(i);
      s.dof_component.push_back(component);
    }
  }
  s.coordinates = joined.coordinates(places.interface_nodes, Eigen::all);
  s.surfaces = joined.surfaces;
  for (Surface& surface : s.surfaces) {
    for (Index& node : surface.faces.reshaped()) node = place[static_cast<std::size_t>(node)];
  }
  s.nodesets = joined.nodesets;
  for (auto& [name, nodes] : s.nodesets) {
    for (Index& node : nodes) node = place[static_cast<std::size_t>(node)];
  }
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
  f.rigid = condensed.rigid;
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
  f.solve_flops = condensed.solve_flops;
  f.product_flops = condensed.product_flops;
  f.way = condensed.way;
  f.panel = condensed.panel;
  if (s.k() > 0) f.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  return s;
}

}  // namespace cbr
