// SPDX-License-Identifier: GPL-3.0-or-later
// Loads on faces that a superelement does not keep, and residual vectors that make it right under
// them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/modes/component_parts.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/interior.hpp"

namespace cbr {

// Nodal forces of a unit traction along x, y and z on each of some sidesets: three columns each.
struct InteriorLoads {
  std::vector<std::string> names;
  std::vector<double> areas;
  Matrix F_I, F_C;  // n_I x 3 sets, c x 3 sets

  bool any() const { return !names.empty(); }
};

// Of those sidesets of `sets` that have a node inside the part; nodesets are kept whole.
// InputError: a name that is no set of the mesh.
InteriorLoads interior_loads(const Mesh& mesh, const FiniteElementModel& model, const Partition& p,
                             const std::vector<std::string>& sets);

// InputError unless all of each of `sets` lies within the interface that the sets of the reduction
// make. `takes_faces_in`: supports interior loads, of sidesets; nodes that carry a load by
// themselves are kept in any case.
void refuse_loads_inside(const Mesh& mesh, const ReductionOptions& reduction,
                         const std::vector<std::string>& sets, bool takes_faces_in);

// Appends residual vectors to Phi, with lambda of their own: X = K_II^-1 F - Phi Lambda^-1 Phi^T F,
// orthonormalised by the Ritz problem X^T K_II X, X^T M_II X (Rubin 1975; MacNeal 1971). They are
// K- and M-orthogonal to the modes, so that K_kk stays diagonal, M_kk = I and K_kc = 0, and K_II^-1
// F is in the span. Drops dependent vectors and round-off. Returns their number.
Index add_residual_vectors(const Interior& interior, const Matrix& F_I, FixedInterfaceModes& modes);
// Of several parts, each of whose modes and vectors moves it alone.
Index add_residual_vectors(const std::vector<ComponentPart>& parts, const Matrix& F_I,
                           FixedInterfaceModes& modes);

// Forces on the coordinates: [Phi^T F_I; F_C + Psi^T F_I], Psi^T F_I = -K_CI K_II^-1 F_I   (k + c x
// columns of F). Resultants on rigid motions of the interface are exactly those of F. F_C: the same
// in all processes.
Matrix generalised_forces(const Interior& interior, const Matrix& F_I, const Matrix& F_C,
                          const Matrix& Phi);
std::map<std::string, Superelement::InteriorLoad> generalised_loads(const Interior& interior,
                                                                    const InteriorLoads& loads,
                                                                    const Matrix& Phi);

// Change of a component's inertia as it deforms: centrifugal forces on its coordinates.
//
// Displacements of the six unit strains xx, yy, zz, xy, yz, xz about the center   (3 m x 6)
Matrix unit_strains(const Points& X, const Vector3& center);

// S_j = sym of the integral of rho x u_j^T, of each coordinate's displacement u_j, x from the
// centre of mass: xx, yy, zz, xy, yz, xz as columns, kg m per unit of the coordinate   ((k + c) x
// 6). The inertia changes by 2 (tr S 1 - S), and the centrifugal force of a spin w is |w|^2 tr S -
// w . S w (Shabana, Dynamics of Multibody Systems, 2013, section 5.3). X_I, X_C: places of this
// process's nodes inside and of the nodes on the interface.
Matrix spin_moments(const Interior& interior, const Points& X_I, const Points& X_C,
                    const Vector3& center, const Matrix& Phi);

// P_ij = integral of rho phi_i phi_j^T (3 x 3 blocks, kg per unit of the coordinates squared) for
// Coriolis forces and the inertia of second order   (3 m x 3 m, exactly symmetric). phi_i: modes of
// the full component, whose coordinates are the columns of V ((k + c) x m). Needs m solves.
Matrix spin_couplings(const Interior& interior, const Matrix& Phi, const Matrix& V);

}  // namespace cbr
