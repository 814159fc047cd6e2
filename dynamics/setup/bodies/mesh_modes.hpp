// SPDX-License-Identifier: GPL-3.0-or-later
// A full mesh in its lowest modes, for frequencies, mode shapes and harmonic response.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "dynamics/motion/modal/forms/diagonal_form.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// The nodes of a mesh with its mass and inertia, for bodies that move in their coordinates; without
// matrices.
std::shared_ptr<Superelement> mesh_nodes(const MeshedComponent& component);

struct MeshModes {
  // of the mesh, without modes of its own: what SuperelementBody needs beside the form
  std::shared_ptr<const Superelement> nodes;
  std::shared_ptr<const DiagonalForm> form;  // V: 3 N x n, held directions do not move
  // Z: 3 N x free, orthonormal basis of what the held directions leave free; Z^T K Z, Z^T M Z
  SparseMatrix Z, K, M;

  bool is_complete() const { return form->omega.size() == K.rows(); }  // no mode is left out
  // What the modes that are left out add to the motion under forces (3 N x p, component axes) at
  // omega (rad/s), as a series in omega^2: (K - omega^2 M)^-1 = sum of modes + R_0 + (omega^2 -
  // sigma) R_1 + ..., R_i = sum over the others of phi phi^T / (lambda - sigma)^(i + 1). The first
  // terms R_i forces, each 3 N x p.
  std::vector<Matrix> left_out(const Matrix& forces, int terms) const;
  double sigma() const { return sigma_; }
  // forces of unit accelerations along x, y, z   (3 N x 3)
  const Matrix& inertia() const { return inertia_; }

 private:
  friend MeshModes mesh_modes(const MeshedComponent&, const std::vector<HeldDirection>&,
                              const MeshModesWanted&, const std::string&);
  std::shared_ptr<const SparseCholesky> factor_;
  Matrix inertia_;
  double sigma_ = 0;
};

// RunError, named by `where`: no convergence, a stiffness that is not positive semidefinite.
MeshModes mesh_modes(const MeshedComponent& component, const std::vector<HeldDirection>& held,
                     const MeshModesWanted& wanted, const std::string& where);

}  // namespace cbr
