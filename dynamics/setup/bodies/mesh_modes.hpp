// SPDX-License-Identifier: GPL-3.0-or-later
// The lowest modes of a full mesh, for frequencies, mode shapes and harmonic response.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Nodes, mass and inertia of a mesh, for bodies in its coordinates; without matrices.
std::shared_ptr<Superelement> mesh_nodes(const MeshedComponent& component);

struct MeshModes {
  // of the mesh, without modes: ModalBody needs it together with the form
  std::shared_ptr<const Superelement> nodes;
  std::shared_ptr<const ModalForm> form;  // V: 3 N x n, 0 in constrained directions
  // Z: 3 N x free, orthonormal basis of unconstrained directions; Z^T K Z, Z^T M Z
  SparseMatrix Z, K, M;

  bool is_complete() const { return form->omega.size() == K.rows(); }  // all modes are present
  // Residual response of the omitted modes to forces (3 N x p, component axes) at omega (rad/s), as
  // a series in omega^2. (K - omega^2 M)^-1 = sum of modes + R_0 + (omega^2 - sigma) R_1 + ..., R_i
  // = sum over omitted modes of phi phi^T / (lambda - sigma)^(i + 1). Returns the first terms R_i
  // forces, each 3 N x p.
  std::vector<Matrix> left_out(const Matrix& forces, int terms) const;
  double sigma() const { return sigma_; }
  // inertia forces of unit accelerations along x, y, z   (3 N x 3)
  const Matrix& inertia() const { return inertia_; }

 private:
  friend MeshModes mesh_modes(const MeshedComponent&, const std::vector<HeldDirection>&,
                              const MeshModesWanted&, const std::string&);
  std::shared_ptr<const SparseCholesky> factor_;
  Matrix inertia_;
  double sigma_ = 0;
};

// Whether all modes of n dofs that are joined cost less, in dense matrices, than the lowest k: up
// to 1000 dofs, or 12 for each mode.
inline bool takes_all_modes(Index n, Index k) { return n <= 1000 || n <= 12 * k; }

inline constexpr const char* no_factor =
    "the mesh has motions without stiffness and mass, as elements of reduced integration in a row "
    "have (C3D20R): mesh two across, or give element: hex8, which integrates them in full";

// Round-off of phi . K phi, relative to |phi| . |K| |phi|. Rigid motions of free meshes had up to a
// twelfth of it.
inline constexpr double energy_round_off = 4 * std::numeric_limits<double>::epsilon();
// Its bound for each column of Phi (n x k): a smaller eigenvalue is one of a motion without strain.
Vector round_off_of_energy(const SparseMatrix& K, const Matrix& Phi);

// RunError, with `where`: no convergence, or motions without stiffness and mass.
MeshModes mesh_modes(const MeshedComponent& component, const std::vector<HeldDirection>& held,
                     const MeshModesWanted& wanted, const std::string& where);

}  // namespace cbr
