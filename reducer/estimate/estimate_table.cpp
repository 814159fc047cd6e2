// SPDX-License-Identifier: GPL-3.0-or-later
// The table of an estimate, as Markdown: docs/formats.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "reducer/estimate/estimate.hpp"

namespace cbr {
namespace {

using Row = std::vector<std::string>;

std::string number(double value) {
  char text[32];
  const bool whole = std::abs(value) < 1e15 && value == std::round(value);
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.5g", value);
  return text;
}

std::string measure(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.3g %s", value, unit);
  return text;
}

// Markdown, columns aligned; `left`: how many of them are text.
void print_rows(std::size_t left, const std::vector<Row>& rows, std::ostream& out) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < width.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t i = 0; i < width.size(); ++i) {
      const std::string pad(width[i] - rows[r][i].size(), ' ');
      out << (i == 0 ? "| " : " | ") << (i < left ? rows[r][i] + pad : pad + rows[r][i]);
    }
    out << " |\n";
    if (r > 0) continue;
    for (std::size_t i = 0; i < width.size(); ++i)
      out << '|' << std::string(width[i] + 1, '-') << (i < left ? '-' : ':');
    out << "|\n";
  }
  out << '\n';
}

std::vector<Row> equations(const Estimate& e, const CubeFormulas& cube) {
  const auto D = static_cast<double>(e.domains.size());
  double squares = 0, most = 0, widest = 0, mesh = 0, largest_mesh = 0;
  for (const auto& d : e.domains) {
    squares += d.c() * d.c();
    most = std::max(most, d.c() * d.c());
    widest = std::max(widest, static_cast<double>(d.n_nodes));
    mesh += d.mesh_nonzeros;
    largest_mesh = std::max(largest_mesh, d.mesh_nonzeros);
  }
  const auto nodes = static_cast<double>(e.n_nodes);
  const double ratio = e.total(&DomainEstimate::c) / e.total(&DomainEstimate::k);
  const double c_max = e.largest(&DomainEstimate::c), c_sum = e.total(&DomainEstimate::c);
  const auto row = [](const char* equation, const char* what, double counted, double right,
                      double printed) {
    return Row{equation, what, number(counted), number(right), number(printed)};
  };
  return {
      {"Eq", "quantity", "counted", "formula", "as printed"},
      {"5", "interface dofs to modes, N_c / N_k",
       e.total(&DomainEstimate::k) > 0 ? number(ratio) : "no modes", ">> 1", "<< 1"},
      row("6", "domains", D, cube.n_domains(), cube.n_domains()),
      row("7", "nodes", nodes, cube.n_nodes(), cube.n_nodes()),
      row("7", "dofs (the paper gives the nodes)", 3 * nodes, 3 * cube.n_nodes(), cube.n_nodes()),
      row("8", "nodes per edge of a domain (cube root of the largest)", std::cbrt(widest),
          cube.n_nodes_per_domain_line(), cube.n_nodes_per_domain_line()),
      row("9", "interface dofs of a domain (the largest)", c_max, cube.interface_dofs_of_domain(),
          cube.interface_dofs_of_domain()),
      row("10", "interface dofs of a domain, about", c_max, cube.interface_dofs_of_domain_by_N(),
          cube.interface_dofs_of_domain_by_N()),
      row("11", "interface dofs of a domain, about", c_max, cube.interface_dofs_of_domain_by_dofs(),
          cube.interface_dofs_of_domain_by_dofs()),
      row("12", "interface dofs of all domains, sum", c_sum, cube.interface_dofs_in_all(),
          cube.interface_dofs_in_all()),
      row("13", "non-zeros of a domain's K_cc (the largest)", most, cube.nonzeros_of_domain(324),
          cube.nonzeros_of_domain(36)),
      row("14", "non-zeros of all K_cc, sum", squares, cube.nonzeros_in_all(324),
          cube.nonzeros_in_all(36)),
      row("15", "non-zeros of the mesh's K, at most", e.mesh_nonzeros, cube.mesh_nonzeros_cube(),
          cube.mesh_nonzeros_cube()),
      row("16", "non-zeros of a domain's mesh K (the largest), at most", largest_mesh,
          cube.mesh_nonzeros_of_domain(), cube.mesh_nonzeros_of_domain()),
      row("17", "non-zeros of all domains' mesh K, at most", mesh, cube.mesh_nonzeros_in_all(),
          cube.mesh_nonzeros_in_all()),
  };
}

std::vector<Row> sizes(const Estimate& e, double memory) {
  const auto all = [](const char* what, double largest, double total) {
    return Row{what, number(largest), number(total)};
  };
  double elements = 0, nodes = 0, interior = 0, L = 0, flops = 0;
  for (const auto& d : e.domains) {
    elements = std::max(elements, static_cast<double>(d.n_elements));
    nodes = std::max(nodes, static_cast<double>(d.n_nodes));
    interior += d.n_interior();
    L = std::max(L, d.factor_nonzeros);
    flops = std::max(flops, d.factor_flops);
  }
  double total_L = 0, total_flops = 0;
  for (const auto& d : e.domains) {
    total_L += d.factor_nonzeros;
    total_flops += d.factor_flops;
  }
  const double joined = 3 * static_cast<double>(e.n_joined_nodes);
  return {
      {"size", "largest domain", "all"},
      all("elements", elements, static_cast<double>(e.n_elements)),
      all("nodes", nodes, static_cast<double>(e.n_nodes)),
      {"interface dofs that the component keeps", "",
       number(3 * static_cast<double>(e.n_interface_nodes))},
      {"interface dofs, those of all domains once", number(e.largest(&DomainEstimate::c)),
       number(joined)},
      all("interior dofs", e.largest(&DomainEstimate::n_interior), interior),
      {e.modes_are_of_tolerance
           ? "modes (as blocks need for this tolerance: only the reduction counts them)"
       : e.modes_are_estimated ? "modes (Weyl's law: only the reduction counts them)"
                               : "modes",
       number(e.largest(&DomainEstimate::k)), number(e.total(&DomainEstimate::k))},
      {"coordinates when joined", "", number(e.n_joined())},
      {"coordinates after the second reduction", "",
       e.second ? number(e.n_final()) : "none asked for"},
      e.few_shapes
          ? Row{"non-zeros of the shapes on the interface, and of the statics", "",
                number(e.shapes_nonzeros())}
          : all("non-zeros of K_cc, M_cc, M_kc, K_kk", e.largest(&DomainEstimate::block_nonzeros),
                e.total(&DomainEstimate::block_nonzeros)),
      {"non-zeros of the diagonal form", "",
       e.has_diagonal_form ? number(e.diagonal_nonzeros()) : "not stored"},
      all("non-zeros of the factor of K_II", L, total_L),
      all("flops of that factorisation", flops, total_flops),
      {"non-zeros of the factor that a step solves with", "", number(e.joined_factor_nonzeros)},
      {"non-zeros of the recovery", "",
       e.has_recovery ? number(e.recovery_nonzeros()) : "not stored"},
      {"superelement file", "", human_bytes(8 * e.file_nonzeros())},
      {"memory to reduce, about", "", human_bytes(reduction_memory(e, memory))},
  };
}

std::vector<Row> steps(const Estimate& e) {
  const StepBytes bytes = step_bytes(e);
  return {{"a step reads", "bytes"},
          {"exact, nothing near (diagonal form)", human_bytes(bytes.exact)},
          {"exact, whole interface looked at for contact", human_bytes(bytes.exact_in_contact)},
          {"central-difference, of what is stored", human_bytes(bytes.coupled)},
          {"newmark, of what is stored", human_bytes(bytes.coupled)},
          {"central-difference, of the full mesh instead", human_bytes(bytes.mesh)}};
}

// The main figures first; the tables follow.
void print_first_lines(const Estimate& e, double memory, std::ostream& out) {
  const double full = 3 * static_cast<double>(e.n_nodes), reduced = e.n_final();
  const double modes = e.second ? e.second->k() : e.total(&DomainEstimate::k);
  out << "- dofs: " << number(reduced) << " (" << number(reduced - modes)
      << (e.few_shapes ? " shapes, " : " of nodes, ") << number(modes) << " modes) for "
      << number(full) << " of the mesh\n"
      << "- file: " << human_bytes(8 * e.file_nonzeros());
  if (e.has_recovery) out << ", of which recovery " << human_bytes(8 * e.recovery_nonzeros());
  const StepBytes bytes = step_bytes(e);
  const double step = e.has_diagonal_form || e.few_shapes ? bytes.exact_in_contact : bytes.coupled;
  out << "\n- memory while reducing: about " << human_bytes(reduction_memory(e, memory))
      << "\n- a step in contact reads " << measure(step / bytes.mesh, "times")
      << " the bytes of one of the full mesh; "
      << (step > many_bytes * bytes.mesh ? "as: mesh is likely faster"
                                         : "steps may differ in length")
      << "\n\n";
}

}  // namespace

void print_estimate(const Estimate& e, double memory, const std::string& title, std::ostream& out) {
  const CubeFormulas cube = equivalent_cube(e.n_nodes, static_cast<Index>(e.domains.size()));
  out << title << "\n\n";
  print_first_lines(e, memory, out);
  out << "Eqs 5-17 of the paper. counted: this mesh, these domains, this interface. formula: a "
         "cube of N_EPL^3 hexes, its whole "
         "surface\n"
      << "the interface, cut N_cuts times in each direction; N_EPL = "
      << number(cube.n_elements_per_line) << ", N_cuts = " << number(cube.n_cuts)
      << (e.is_cube_of_hexes ? ".\n"
                             : " are the equivalent ones, from the\nnumbers of nodes and domains: "
                               "this mesh is no cube of hexes.\n")
      << '\n';
  print_rows(2, equations(e, cube), out);
  print_rows(1, sizes(e, memory), out);
  print_rows(1, steps(e), out);
}

}  // namespace cbr
