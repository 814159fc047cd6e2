// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion/modal/forms: coordinates in which a body moves exactly.
//
// The modes of a superelement of any basis, of a mesh or of a rigid body, ready for time stepping.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/form_cache.hpp"
#include "dynamics/motion/prescribed_motion.hpp"

namespace cbr {

struct ResidualCompliance;

// q = V eta, eta'' + omega^2 eta = V^T f. With constraints V has fewer columns than rows.
struct ModalForm {
  Vector omega;  // n, rad/s; the first n_rigid are 0
  RowMatrix V;   // (k + c) x n
  Index n_rigid = 0;
  // n x 6, V^T M^ R: rigid motions (about the centre of mass, component axes) in modal coordinates.
  // Momentum is E^T eta'. Free body: only rigid modes carry any, so the other rows are exactly
  // zero.
  Matrix E;
  // of forces on the interface, beside the modes; null: none
  std::shared_ptr<const ResidualCompliance> residual;
  mutable FormCache shared;

  double highest() const { return omega.size() ? omega.maxCoeff() : 0; }  // of omega
};

// A constrained displacement component: direction . u(node) = 0, component axes.
struct HeldDirection {
  Index node = 0;     // index into the superelement's nodes
  Vector3 direction;  // unit; the directions of one node are orthogonal
  bool operator==(const HeldDirection& other) const {
    return node == other.node && direction == other.direction;
  }
};

// Orthonormal basis of space whose first columns span `directions` (at most three, orthogonal): the
// rest is what they leave free.
Matrix3 complete_basis(const std::vector<Vector3>& directions);

// Of a superelement without held directions, free or held inside: the stored form when there is one
// (taken out of `superelement`), else LAPACK on the reduced matrices. The rigid modes are replaced
// by exact rigid motions, so that impulses change the momentum by exactly their sum. RunError when
// the eigenvalue problem fails (reduced mass not positive definite), InputError when rigid modes,
// nodes and mass of a free body do not agree, named by `where`.
ModalForm free_modal_form(Superelement& superelement, const std::string& where);

// Of a superelement with held directions. Needs the matrices.
ModalForm held_modal_form(const Superelement& superelement, const std::vector<HeldDirection>& held,
                          const std::string& where);

// Of basis characteristic: u_c = V_c q, q'' + diag(eigenvalues) q = V_c^T f_c: V of the form is [I;
// V_c], ((k + c) x k). InputError, which calls V_c `dataset`, when the modes of frequency 0 are not
// the rigid motions of /rigid_body.
ModalForm form_of_modes(const Superelement& superelement, const Matrix& V_c,
                        const std::string& dataset, const std::string& where);

ModalForm free_characteristic_form(const Superelement& superelement, const std::string& where);

// With held directions, which take a coordinate each. InputError when the interface's coordinates
// cannot hold them one by one, as then they would hold more than themselves.
ModalForm held_characteristic_form(const Superelement& superelement,
                                   const std::vector<HeldDirection>& held,
                                   const std::string& where);

// Of a rigid body: the nodes of a mesh move by rigid motions alone, as many as its supports leave.
// nodes: all of the mesh, with its mass and inertia; no matrices. The form has up to six columns,
// all of frequency 0, and none when the supports hold every rigid motion. RunError, named by
// `where`: a mass or an inertia that is not positive.
std::shared_ptr<const ModalForm> rigid_form(const Superelement& nodes,
                                            const std::vector<HeldDirection>& held,
                                            const std::string& where);

// The last steps of the forms of all kinds of systems. lambda: all eigenvalues, ascending; the
// first n_rigid become 0 exactly.
void take_frequencies(const Vector& lambda, Index n_rigid, ModalForm& form);
// The rigid modes of a free system become R L^-T, L L^T = R^T M R (R: its rigid motions about the
// centre of mass, rows of V), and E follows from them. False, and `form` as it was, when they
// do not span the same motions.
bool use_exact_rigid_modes(const Matrix& R, const RigidBody& body, ModalForm& form);
// InputError: a free body's rigid modes, or its matrices, do not fit its mass and its nodes.
[[noreturn]] void refuse_rigid_modes(const std::string& where);
// Of the rigid motions R_s (n x 6, by rigid_scales()) those that the stiffness resists, orthonormal
// combinations of its columns   (r x 6): none of a free part; other makers' may be held inside.
// Forces count from 1e-6 of |K| |R_s| on: far above what the digits of a float leave, far below
// that of one clamped node.
Matrix resisted_rigid_motions(const Matrix& K, const Matrix& R_s);
// of its K_cc; none when that is not read
Matrix resisted_rigid_motions(const Superelement& superelement);
// The independent rigid motions that move no held direction, as combinations of R's columns (6 x
// r); rows(node, component): of R, -1 for none; resisted (r x 6): more that are not free.
Matrix free_rigid_motions(const Matrix& R, const RigidBody& body, const IndexTable& rows,
                          const std::vector<HeldDirection>& held,
                          const Matrix& resisted = Matrix(0, 6));

// Row of V of each node and component, n_nodes x 3; -1 where the superelement has no such dof.
IndexTable displacement_rows(const Superelement& superelement);
// x += of_rows, as displacement_rows() has them; of_rows: rows of V, x: of Body::coordinates().
void add_to_coordinates(const IndexTable& rows, const Vector& of_rows, Vector& x);

// Of u_c = V_c q + F f_c, as the bases massless and characteristic (without F) have it. `free`: its
// free form. Column j of `motion` (held x m) moves the held directions in the j-th motion.
SupportShapes modal_shapes(const Superelement& superelement, const ModalForm& free,
                           const std::vector<HeldDirection>& held, const Matrix& motion);

// Of the nodes of a rigid body. InputError, after `where`: motions that would strain it.
SupportShapes rigid_shapes(const Superelement& nodes, const std::vector<HeldDirection>& held,
                           const Matrix& motion, const std::string& where);

}  // namespace cbr
