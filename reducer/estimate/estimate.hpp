// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/estimate: size and memory of a reduction before it is done.
//
// What a reduction would cost and give, from the mesh's connectivity alone: no element, no matrix,
// no factor is computed.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// The paper's Eqs 6-17 for a cube of N^3 hexes whose whole surface is interface, cut n_cuts times
// in each direction. N and n_cuts need not be whole: any mesh and number of domains has its
// equivalent ones.
struct CubeFormulas {
  double n_elements_per_line = 0;  // N_EPL
  double n_cuts = 0;

  double n_domains() const;                // Eq 6
  double n_nodes() const;                  // Eq 7, which calls them dofs
  double n_nodes_per_domain_line() const;  // Eq 8
  // Eq 9, exact when N_EPL / (n_cuts + 1) is whole
  double interface_dofs_of_domain() const;
  double interface_dofs_of_domain_by_N() const;     // Eq 10
  double interface_dofs_of_domain_by_dofs() const;  // Eq 11
  double interface_dofs_in_all() const;             // Eq 12
  // Eqs 13 and 14 square Eq 11, so their factor is 18^2 = 324; the paper has 36.
  double nonzeros_of_domain(double factor) const;  // Eq 13
  double nonzeros_in_all(double factor) const;     // Eq 14
  // Bounds on the non-zeros of the mesh's K from 24 x 24 entries of each hex. Eqs 16 and 17 have
  // the number of nodes, not of elements.
  double mesh_nonzeros_cube() const;       // Eq 15
  double mesh_nonzeros_of_domain() const;  // Eq 16
  double mesh_nonzeros_in_all() const;     // Eq 17
};
CubeFormulas equivalent_cube(Index n_nodes, Index n_domains);

struct DomainEstimate {
  Index n_elements = 0, n_nodes = 0, n_interface_nodes = 0;
  Index n_modes = 0, n_candidates = 0;  // kept, and computed for that
  Index n_interior_dofs = 0;
  double mesh_nonzeros = 0;                      // of the domain's own K, both triangles
  double factor_nonzeros = 0, factor_flops = 0;  // of K_II

  double n_interior() const { return static_cast<double>(n_interior_dofs); }
  double c() const { return 3 * static_cast<double>(n_interface_nodes); }
  double k() const { return static_cast<double>(n_modes); }
  // in the file: K_cc, M_cc, M_kc, eigenvalues
  double block_nonzeros() const { return 2 * c() * c() + k() * c() + k(); }
};

// Size of the reduced interface of basis characteristic.
struct FewShapesEstimate {
  Index n_shapes = 0;          // rigid motions, elastic shapes, kept dofs, responses
  Index n_static = 0;          // forces whose statics are kept
  double static_nonzeros = 0;  // of their compliance
  bool is_sparse = false;  // by sparse solves alone; else from Craig and Bampton's dense matrices
  double whole_nonzeros = 0;  // of the free component's factor
};

struct Estimate {
  Index n_elements = 0, n_nodes = 0;  // that volume elements use
  // as many hexes and nodes as a cube with whole N has; its shape is not looked at
  bool is_cube_of_hexes = false;
  Index n_interface_nodes = 0;  // of the component
  Index n_joined_nodes = 0;     // interface nodes of all domains, each once
  double mesh_nonzeros = 0;     // of K, both triangles
  std::vector<DomainEstimate> domains;
  // Of a Cholesky factor of the domains' interface dofs put together, which a step of central
  // differences or Newmark solves with.
  double joined_factor_nonzeros = 0;
  bool has_diagonal_form = false;
  bool has_recovery = false;
  bool modes_are_estimated = false;     // by Weyl's law, from a cutoff; or
  bool modes_are_of_tolerance = false;  // as blocks have needed for it

  // The joined domains reduced again: its interior are the domains' modes and the dofs that the
  // component does not keep.
  std::optional<DomainEstimate> second;
  std::optional<FewShapesEstimate> few_shapes;

  double total(double (DomainEstimate::*figure)() const) const;
  double largest(double (DomainEstimate::*figure)() const) const;
  // coordinates
  double n_joined() const {
    return total(&DomainEstimate::k) + 3 * static_cast<double>(n_joined_nodes);
  }
  // Coordinates in the file
  double n_final() const {
    if (few_shapes) return total(&DomainEstimate::k) + static_cast<double>(few_shapes->n_shapes);
    return second ? second->k() + second->c() : n_joined();
  }
  // omega and V
  double diagonal_nonzeros() const { return has_diagonal_form ? n_final() * (n_final() + 1) : 0; }
  // Of few shapes: eigenvalues, displacements of the interface, compliance of the static forces.
  double shapes_nonzeros() const {
    return n_final() * (1 + 3 * static_cast<double>(n_interface_nodes)) +
           few_shapes->static_nonzeros;
  }
  // Psi and Phi: the displacements of the interior from the coordinates.
  double recovery_nonzeros() const {
    if (!has_recovery) return 0;
    if (second) return 3 * static_cast<double>(n_nodes - n_interface_nodes) * n_final();
    if (few_shapes) return domains.front().n_interior() * n_final();
    double sum = 0;
    for (const auto& d : domains) sum += d.n_interior() * (d.c() + d.k());
    return sum;
  }
  double file_nonzeros() const {
    if (few_shapes) return recovery_nonzeros() + shapes_nonzeros();
    return recovery_nonzeros() +
           (second ? second->block_nonzeros() : total(&DomainEstimate::block_nonzeros)) +
           diagonal_nonzeros();
  }
};

// `domain`: per volume element, in the order of the mesh's blocks, the number of its domain from 0.
// InputErrors as of a reduction: sets that are not there, more modes than interior dofs, an
// interface that does not hold the interior.
Estimate estimate(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                  const ReductionOptions& options, const std::vector<Index>& domain,
                  Index diagonal_limit);

// Bytes that one step in contact reads of a superelement in diagonal form: the state of its n
// coordinates, and their rows at the faces. And of the mesh, by its stiffness.
double bytes_in_contact(double n, double n_rows);
double bytes_of_mesh(double nonzeros, double n_dofs);
// Times those of the mesh: beyond, the mesh is likely faster where contact lasts. Steps of both
// have about the same length where faces are most of the mesh.
constexpr double many_bytes = 2.5;

// Bytes that one step reads. In diagonal form, without contact and with the whole interface in it;
// of central differences and Newmark, of the stored matrices; of central differences, of the full
// mesh.
struct StepBytes {
  double exact = 0, exact_in_contact = 0, coupled = 0, mesh = 0;
};
StepBytes step_bytes(const Estimate& estimate);

// Bytes while reducing: the largest domain's matrices, factor, modes and constraint modes (or
// panels of them).
double reduction_memory(const Estimate& estimate, double memory);

// The table, as Markdown: docs/formats.md. `title`: a line above it.
void print_estimate(const Estimate& estimate, double memory, const std::string& title,
                    std::ostream& out);

}  // namespace cbr
