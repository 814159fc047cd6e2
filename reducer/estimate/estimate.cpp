// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/estimate/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "common/base/error.hpp"
#include "common/fem/block_elements.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/bases/characteristic/characteristic.hpp"
#include "reducer/bases/characteristic/free_shapes.hpp"
#include "reducer/bases/characteristic/statics.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/interface_sets.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

constexpr double dofs_per_hex = 24;

// Entries of a factor that c interface dofs add when they come last, over c^2: half for themselves,
// the others in the interior's columns.
constexpr double nonzeros_with_interface = 1.5;

// Volume elements by their nodes (rows of the model), one after the other.
struct Elements {
  std::vector<std::vector<Index>> nodes;
  // Weyl's law: those of each one's volume below f are this times f^3; empty without a cutoff
  std::vector<double> modes_per_hz3;
};

// N = V omega^3 / (6 pi^2) (1 / c_p^3 + 2 / c_s^3): modes of an elastic body of volume V below
// omega, to leading order. Of V = 1 and 1 Hz.
double weyl_density(const Material& m) {
  const double shear = m.youngs_modulus / (2 * (1 + m.poissons_ratio));
  const double c_s = std::sqrt(shear / m.density);
  const double c_p = c_s * std::sqrt((2 - 2 * m.poissons_ratio) / (1 - 2 * m.poissons_ratio));
  return 4 * std::numbers::pi / 3 * (1 / std::pow(c_p, 3) + 2 / std::pow(c_s, 3));
}

Elements volume_elements(const Mesh& mesh, const FiniteElementModel& model,
                         const std::vector<BlockProperties>& properties, bool with_modes) {
  Elements elements;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_volume(block)) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      auto& nodes = elements.nodes.emplace_back();
      for (const Index node : block.connectivity.row(e)) nodes.push_back(model.row[node]);
      if (!with_modes) continue;
      const double volume =
          element_lumped_mass(block.type, element_points(mesh, block, e), 1).sum();
      elements.modes_per_hz3.push_back(volume * weyl_density(properties[b].material));
    }
  }
  return elements;
}

// Lower triangle of the pattern: an entry where two of the nodes (local numbers, -1: not taken)
// share an element of the list.
SparseMatrix node_graph(const Elements& elements, const std::vector<Index>& list,
                        const std::vector<Index>& local, Index n) {
  std::vector<std::vector<Index>> around(n);  // elements of each node
  for (const Index e : list) {
    for (const Index node : elements.nodes[e]) {
      if (local[node] >= 0) around[local[node]].push_back(e);
    }
  }
  SparseMatrix graph(n, n);
  std::vector<Index> rows;
  std::vector<Index> seen(n, -1);
  for (Index j = 0; j < n; ++j) {
    rows.clear();
    for (const Index e : around[j]) {
      for (const Index node : elements.nodes[e]) {
        const Index i = local[node];
        if (i < j || seen[i] == j) continue;
        seen[i] = j;
        rows.push_back(i);
      }
    }
    std::sort(rows.begin(), rows.end());
    graph.startVec(j);
    for (const Index i : rows) graph.insertBack(i, j) = 1;
  }
  graph.finalize();
  graph.makeCompressed();
  return graph;
}

// Non-zeros of K, both triangles, that a node graph's lower triangle stands for.
double nonzeros_of(const SparseMatrix& graph) {
  return 9 * (2 * static_cast<double>(graph.nonZeros()) - static_cast<double>(graph.rows()));
}

// Nodes that lie in the same domains are one weighted node here; those of one domain all meet.
// Eliminated by least degree.
FactorCost joined_factor_cost(const std::map<std::vector<Index>, Index>& nodes_by_domains) {
  std::vector<double> weight;  // dofs
  std::map<Index, std::vector<std::size_t>> of_domain;
  for (const auto& [domains, count] : nodes_by_domains) {
    for (const Index d : domains) of_domain[d].push_back(weight.size());
    weight.push_back(3 * static_cast<double>(count));
  }
  std::vector<std::set<std::size_t>> near(weight.size());
  for (const auto& [d, members] : of_domain) {
    for (const std::size_t i : members) near[i].insert(members.begin(), members.end());
  }
  const auto degree = [&](std::size_t i) {
    return std::accumulate(near[i].begin(), near[i].end(), 0.0,
                           [&](double sum, std::size_t j) { return sum + weight[j]; });
  };
  FactorCost cost;
  std::set<std::size_t> left;
  for (std::size_t i = 0; i < weight.size(); ++i) left.insert(i);
  while (!left.empty()) {
    const std::size_t i = *std::min_element(left.begin(), left.end(),
                                            [&](auto a, auto b) { return degree(a) < degree(b); });
    const double rows = degree(i), w = weight[i];
    // Columns of rows, rows - 1, ... rows - w + 1 entries.
    cost.n_nonzeros += w * rows - w * (w - 1) / 2;
    cost.flops += w * rows * rows - rows * w * (w - 1) + (w - 1) * w * (2 * w - 1) / 6;
    near[i].erase(i);
    for (const std::size_t j : near[i]) {
      near[j].insert(near[i].begin(), near[i].end());
      near[j].erase(i);
    }
    left.erase(i);
  }
  return cost;
}

// Sorted list of the domains that each node is in.
std::vector<std::vector<Index>> domains_of_nodes(const Elements& elements,
                                                 const std::vector<Index>& domain,
                                                 std::size_t n_nodes) {
  std::vector<std::vector<Index>> in(n_nodes);
  for (std::size_t e = 0; e < elements.nodes.size(); ++e) {
    for (const Index node : elements.nodes[e]) {
      auto& list = in[node];
      const auto at = std::lower_bound(list.begin(), list.end(), domain[e]);
      if (at == list.end() || *at != domain[e]) list.insert(at, domain[e]);
    }
  }
  return in;
}

// Of blocks, measured (docs/decisions/mode-tolerance.md): 47 at 1e-2, 297 at 1e-3. Slender parts
// need fewer.
Index modes_of_tolerance_about(double tolerance) {
  return static_cast<Index>(std::min(1.2 * std::pow(tolerance, -0.8), 1e9));
}

Index modes_of_domain(const Elements& elements, const std::vector<Index>& list,
                      const ReductionOptions& options, Index n_interior) {
  // a domain keeps all when it has fewer
  if (options.modes) return std::min(*options.modes, n_interior);
  if (options.tolerance) return std::min(modes_of_tolerance_about(*options.tolerance), n_interior);
  double modes = 0;
  for (const Index e : list) modes += elements.modes_per_hz3[e];
  modes *= std::pow(*options.cutoff_hz, 3);
  return static_cast<Index>(std::min(std::round(modes), static_cast<double>(n_interior)));
}

DomainEstimate domain_estimate(const Elements& elements, const std::vector<Index>& list,
                               const std::vector<bool>& kept, const ReductionOptions& options) {
  DomainEstimate d;
  d.n_elements = static_cast<Index>(list.size());
  std::vector<Index> all(kept.size(), -1), interior(kept.size(), -1);
  for (const Index e : list) {
    for (const Index node : elements.nodes[e]) all[node] = 0;
  }
  Index n_interior = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (all[i] < 0) continue;
    all[i] = d.n_nodes++;
    if (!kept[i]) interior[i] = n_interior++;
  }
  d.n_interface_nodes = d.n_nodes - n_interior;
  d.n_interior_dofs = 3 * n_interior;
  d.n_modes = modes_of_domain(elements, list, options, 3 * n_interior);
  d.n_candidates = n_mode_candidates(options.pick, d.n_modes, 3 * n_interior);
  if (options.tolerance)
    d.n_candidates = std::min(std::max<Index>(2 * d.n_modes, 64), 3 * n_interior);
  d.mesh_nonzeros = nonzeros_of(node_graph(elements, list, all, d.n_nodes));
  const FactorCost factor = factor_cost(node_graph(elements, list, interior, n_interior), 3);
  d.factor_nonzeros = factor.n_nonzeros;
  d.factor_flops = factor.flops;
  return d;
}

DomainEstimate second_estimate(const Elements& elements,
                               const std::map<std::vector<Index>, Index>& interior_by_domains,
                               const ReductionOptions& options, const Estimate& e) {
  DomainEstimate second;
  second.n_interface_nodes = e.n_interface_nodes;
  second.n_interior_dofs = static_cast<Index>(e.n_joined()) - 3 * e.n_interface_nodes;
  ReductionOptions again = options;
  again.modes = options.second_modes;
  again.cutoff_hz = options.second_cutoff_hz;
  again.tolerance.reset();
  second.n_modes = second.n_candidates = modes_of_domain(
      elements, first_numbers(elements.nodes.size()), again, second.n_interior_dofs);
  const FactorCost factor = joined_factor_cost(interior_by_domains);
  second.factor_nonzeros = factor.n_nonzeros + e.total(&DomainEstimate::k);
  second.factor_flops = factor.flops;
  return second;
}

bool is_cube_of_hexes(const Mesh& mesh, const Estimate& estimate) {
  const double N = std::round(std::cbrt(static_cast<double>(estimate.n_elements)));
  const bool hexes = std::all_of(mesh.blocks.begin(), mesh.blocks.end(), [](const Block& b) {
    return !is_volume(b) || b.type == ElementType::hex8;
  });
  return hexes && N * N * N == static_cast<double>(estimate.n_elements) &&
         (N + 1) * (N + 1) * (N + 1) == static_cast<double>(estimate.n_nodes);
}

// The interface's nodes and the sets on it, as the reduction describes them; no matrices.
Superelement bare_interface(const Mesh& mesh, const FiniteElementModel& model,
                            const std::vector<Index>& interface,
                            const std::vector<std::string>& sets) {
  Superelement s;
  std::vector<Index> place(mesh.coordinates.rows(), -1);
  s.coordinates.resize(static_cast<Index>(interface.size()), 3);
  for (std::size_t i = 0; i < interface.size(); ++i) {
    const Index node = model.nodes[interface[i]];
    place[node] = static_cast<Index>(i);
    s.coordinates.row(static_cast<Index>(i)) = mesh.coordinates.row(node);
    s.node_ids.push_back(mesh.node_ids[node]);
    for (int component = 0; component < 3; ++component) {
      s.dof_node.push_back(static_cast<Index>(i));
      s.dof_component.push_back(component);
    }
  }
  add_interface_sets(mesh, place, sets, s);
  return s;
}

// Of compliance in levels, in the file, for each force: 38 to 50 measured.
constexpr double numbers_of_levels = 40;

FewShapesEstimate few_shapes_estimate(const CharacteristicOptions& options,
                                      const Superelement& interface, const DomainEstimate& d,
                                      bool one_part) {
  FewShapesEstimate few;
  const std::vector<char> is_kept = kept_nodes(options, interface);
  const Index c = interface.c(), kept = 3 * std::count(is_kept.begin(), is_kept.end(), 1);
  const auto n_pressed = static_cast<Index>(pressed_surfaces(options, is_kept, interface).size());
  const Index rigid = std::min<Index>(6, c - kept);
  few.n_static = static_forces(options, interface).size();
  few.n_shapes = rigid + n_shapes(options, c - kept - rigid) + kept +
                 (options.shear ? 3 : 1) * n_pressed +
                 load_columns(options, is_kept, interface).cols();
  few.is_sparse = few_enough(options, one_part, d.n_interior_dofs, interface);
  const auto s = static_cast<double>(few.n_static);
  few.static_nonzeros =
      few.is_sparse && few.n_static > most_dense_forces ? numbers_of_levels * s : s * s;
  if (!few.is_sparse) return few;
  const double n_ratio = (d.n_interior() + d.c()) / d.n_interior();
  const FreeFactorCost cost =
      free_factor_cost({d.factor_nonzeros, d.factor_flops}, n_ratio, c, few.n_static);
  few.whole_nonzeros = cost.is_one_factor
                           ? d.factor_nonzeros + nonzeros_with_interface * d.c() * d.c()
                           : n_ratio * d.factor_nonzeros;
  return few;
}

void check_options(const Mesh& mesh, const FiniteElementModel& model,
                   const std::vector<Index>& interface, const ReductionOptions& options) {
  Partition p;
  p.interface_nodes = interface;
  p.interior_nodes = other_nodes(model, interface);
  check_interface_holds(mesh, model, p, connected_parts(mesh, model));
  const auto n_interior = 3 * static_cast<Index>(p.interior_nodes.size());
  if (options.modes && *options.modes > n_interior && !options.is_decomposed()) {
    throw InputError("modes: " + std::to_string(*options.modes) +
                     " requested, but the interior has only " + std::to_string(n_interior) +
                     " dofs: ask for at most that many");
  }
}

}  // namespace

double CubeFormulas::n_domains() const { return std::pow(n_cuts + 1, 3); }
double CubeFormulas::n_nodes() const { return std::pow(n_elements_per_line + 1, 3); }
double CubeFormulas::n_nodes_per_domain_line() const {
  return n_elements_per_line / (n_cuts + 1) + 1;
}
double CubeFormulas::interface_dofs_of_domain() const {
  const double n = n_nodes_per_domain_line();
  return 3 * (6 * n * n - 12 * n + 8);
}
double CubeFormulas::interface_dofs_of_domain_by_N() const {
  return 18 * n_elements_per_line * n_elements_per_line / std::pow(n_domains(), 2.0 / 3);
}
double CubeFormulas::interface_dofs_of_domain_by_dofs() const {
  return 18 * std::pow(n_nodes() / n_domains(), 2.0 / 3);
}
double CubeFormulas::interface_dofs_in_all() const {
  return 18 * std::pow(n_nodes(), 2.0 / 3) * std::cbrt(n_domains());
}
double CubeFormulas::nonzeros_of_domain(double factor) const {
  return factor * std::pow(n_nodes() / n_domains(), 4.0 / 3);
}
double CubeFormulas::nonzeros_in_all(double factor) const {
  return factor * std::cbrt(std::pow(n_nodes(), 4) / n_domains());
}
double CubeFormulas::mesh_nonzeros_cube() const {
  return std::pow(n_elements_per_line, 3) * dofs_per_hex * dofs_per_hex;
}
double CubeFormulas::mesh_nonzeros_of_domain() const {
  return n_nodes() / n_domains() * dofs_per_hex * dofs_per_hex;
}
double CubeFormulas::mesh_nonzeros_in_all() const {
  return n_nodes() * dofs_per_hex * dofs_per_hex;
}

CubeFormulas equivalent_cube(Index n_nodes, Index n_domains) {
  return {std::cbrt(static_cast<double>(n_nodes)) - 1,
          std::cbrt(static_cast<double>(n_domains)) - 1};
}

double Estimate::total(double (DomainEstimate::*figure)() const) const {
  double sum = 0;
  for (const auto& d : domains) sum += (d.*figure)();
  return sum;
}

double Estimate::largest(double (DomainEstimate::*figure)() const) const {
  double most = 0;
  for (const auto& d : domains) most = std::max(most, (d.*figure)());
  return most;
}

Estimate estimate(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                  const ReductionOptions& options, const std::vector<Index>& domain,
                  Index diagonal_limit) {
  const FiniteElementModel model = number_nodes(mesh);
  const std::vector<Index> interface = interface_nodes(mesh, model, options.interface_sets);
  check_options(mesh, model, interface, options);
  const Elements elements =
      volume_elements(mesh, model, properties, options.cutoff_hz || options.second_cutoff_hz);
  const auto in = domains_of_nodes(elements, domain, model.nodes.size());

  Estimate result;
  result.n_elements = static_cast<Index>(elements.nodes.size());
  result.n_nodes = static_cast<Index>(model.nodes.size());
  result.is_cube_of_hexes = is_cube_of_hexes(mesh, result);
  result.n_interface_nodes = static_cast<Index>(interface.size());
  std::vector<bool> kept(model.nodes.size(), false);
  for (const Index i : interface) kept[i] = true;
  std::map<std::vector<Index>, Index> joined, joined_interior;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (in[i].size() > 1 && !kept[i]) ++joined_interior[in[i]];
    if (in[i].size() > 1) kept[i] = true;
    if (kept[i]) {
      ++joined[in[i]];
      ++result.n_joined_nodes;
    }
  }
  std::vector<std::vector<Index>> lists(
      domain.empty()
          ? 0
          : static_cast<std::size_t>(*std::max_element(domain.begin(), domain.end())) + 1);
  for (std::size_t e = 0; e < domain.size(); ++e) lists[domain[e]].push_back(static_cast<Index>(e));
  for (const auto& list : lists)
    result.domains.push_back(domain_estimate(elements, list, kept, options));
  result.mesh_nonzeros =
      lists.size() == 1 ? result.domains[0].mesh_nonzeros
                        : nonzeros_of(node_graph(elements, first_numbers(elements.nodes.size()),
                                                 first_numbers(result.n_nodes), result.n_nodes));
  const FactorCost joined_factor = joined_factor_cost(joined);
  result.joined_factor_nonzeros = joined_factor.n_nonzeros;
  if (options.has_second_reduction()) {
    result.second = second_estimate(elements, joined_interior, options, result);
    const double c = result.second->c();
    result.joined_factor_nonzeros = c * (c + 1) / 2;
  }
  result.modes_are_of_tolerance = options.tolerance.has_value();
  result.modes_are_estimated = !options.modes || options.second_cutoff_hz;
  result.has_recovery = options.recovery;
  if (options.is_characteristic()) {
    const std::vector<Index> part = connected_parts(mesh, model);
    const bool one_part = part.empty() || *std::max_element(part.begin(), part.end()) == 0;
    result.few_shapes = few_shapes_estimate(
        options.characteristic, bare_interface(mesh, model, interface, options.interface_sets),
        result.domains.front(), one_part);
    return result;
  }
  result.has_diagonal_form = result.n_final() <= static_cast<double>(diagonal_limit);
  return result;
}

namespace {

// Rates relative to dgemm's of solves for constraint modes, of nnz(L) times 4 flops a column, and
// of products with them. And the fraction of those flops that the forward solve does not skip.
constexpr double solve_rate = 0.5, product_rate = 0.8, solved_share = 0.8;
// Of the last front, K and M, and of its children's updates: squares of c.
constexpr double front_squares = 4;
constexpr double bytes_of_program = 32e6;

bool product_is_taken(const DomainEstimate& d, double memory) {
  return 8 * d.n_interior() * d.c() <= memory &&
         solved_share * 4 * d.factor_nonzeros / solve_rate >= d.n_interior() * d.c() / product_rate;
}

// Matrices, factors and, one after the other, a Krylov space and the statics.
double few_shapes_memory(const Estimate& estimate) {
  const DomainEstimate& d = estimate.domains.front();
  const FewShapesEstimate& few = *estimate.few_shapes;
  // Three dense matrices, or loads, their answers and what is left of these: some 400 loads for
  // each force at a node
  const auto s = static_cast<double>(few.n_static);
  const double loads = few.n_static > most_dense_forces
                           ? 400 * s / static_cast<double>(estimate.n_interface_nodes)
                           : s;
  const double matrices = 2 * 16 * d.mesh_nonzeros;
  const double basis = 2 * 8 * d.n_interior() * 2 *
                       static_cast<double>(std::max<Index>(d.n_candidates, n_estimated));
  return bytes_of_program + matrices + 8 * (few.whole_nonzeros + d.factor_nonzeros) +
         std::max(basis, 3 * 8 * s * loads) + 8 * estimate.file_nonzeros();
}

// Entries of half of K_cc, which is symmetric, and of M_kc twice.
double step_entries(const DomainEstimate& d) { return d.c() * (d.c() + 1) / 2 + 2 * d.k() * d.c(); }

}  // namespace

double bytes_in_contact(double n, double n_rows) { return 8 * n * (8 + n_rows); }

// Blocks of nine numbers with their column
double bytes_of_mesh(double nonzeros, double n_dofs) {
  return 76.0 / 9 * nonzeros + 8 * 8 * n_dofs;
}

StepBytes step_bytes(const Estimate& estimate) {
  double blocks = 0;
  for (const auto& d : estimate.domains) blocks += step_entries(d);
  if (estimate.second) blocks = step_entries(*estimate.second);
  const double n = estimate.n_final(),
               c = 3 * static_cast<double>(estimate.second ? estimate.n_interface_nodes
                                                           : estimate.n_joined_nodes);
  StepBytes bytes;
  bytes.exact = 8 * 8 * n;
  double n_rows = 3 * static_cast<double>(estimate.n_interface_nodes), statics = 0;
  if (estimate.few_shapes) {
    if (estimate.few_shapes->n_static > 0)
      n_rows = static_cast<double>(estimate.few_shapes->n_static);
    statics = 8 * estimate.few_shapes->static_nonzeros;
  }
  bytes.exact_in_contact = bytes_in_contact(n, n_rows) + statics;
  // K_cc and M_kc of each domain, and the factor forward and backward.
  bytes.coupled = 8 * (blocks + 2 * estimate.joined_factor_nonzeros + 8 * (n + c));
  if (estimate.few_shapes) bytes.coupled = bytes.exact;
  bytes.mesh = bytes_of_mesh(estimate.mesh_nonzeros, 3 * static_cast<double>(estimate.n_nodes));
  return bytes;
}

double reduction_memory(const Estimate& estimate, double memory) {
  double most = 0, results = 0;
  for (const auto& d : estimate.domains) {
    results += 8 * d.block_nonzeros();
    const double matrices = 2 * 16 * d.mesh_nonzeros;  // K, and its blocks K_II, K_IC, K_CC
    const double panels =
        std::min(memory, 16 * d.n_interior() * static_cast<double>(good_panel * n_threads()));
    const double Psi = panels + (product_is_taken(d, memory) ? 8 * d.n_interior() * d.c() : 0);
    // the Lanczos basis of about 2 k vectors, and Phi twice
    const double modes = 2 * 8 * d.n_interior() * d.k() * 2;
    // Which way is taken is counted later: as much as the larger of both
    const double fronts = estimate.has_recovery ? 0 : front_squares * 8 * d.c() * d.c();
    const double condensing = std::max(fronts, Psi + modes);
    most = std::max(most, bytes_of_program + matrices + 8 * d.factor_nonzeros +
                              std::max(condensing, 2 * modes));
  }
  const double n = estimate.n_final();
  if (estimate.few_shapes && estimate.few_shapes->is_sparse) return few_shapes_memory(estimate);
  if (estimate.second)
    results += 8 * (2 * estimate.second->n_interior() * estimate.second->c() +
                    estimate.second->factor_nonzeros);
  results += 8 * estimate.recovery_nonzeros();
  return results + std::max(most, estimate.has_diagonal_form ? 4 * 8 * n * n : 0.0);
}

}  // namespace cbr
