// SPDX-License-Identifier: GPL-3.0-or-later
// Residual compliance beside the modes of a form; shared by the instances of a component.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contact/nodes/thin_response.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"

namespace cbr {

// u_c = V_c eta + B F B^T f_c, eta'' + omega^2 eta = V_c^T f_c. Basis massless: V_c is the modes of
// a body whose interface has no mass, F of all interface dofs. Basis characteristic: V_c are modes
// with mass, F the residual compliance of some faces. As such modes move those of basis massless,
// too, where it meets bodies of other kinds: these take impulses at the starts of steps, and a
// joint whose force is late on one side gains energy at any step.
struct ResidualCompliance {
  StaticRows rows;  // of all nodes of the superelement, component axes
  // Of truncated modes: the form with all n of them, whose last h are quasi-static, and
  // diag(1 / omega_h^2) V_h^T B (h x s). Null, and empty: forces along the rows displace the rows
  // alone.
  std::shared_ptr<const ModalForm> whole;
  Matrix quasi_static;
  bool is_massless = false;  // takes impulses at the ends of steps
  // rad/s, limits a step: massless, with the interface held; else the highest of the form
  double omega_limit = 0;

  // The time tau over which the compliance follows a force: a force f moves it by F f h / tau in a
  // step. Massless: h, at once. Beside modes with mass: 1 / omega_limit, else contact bounces on it
  // in short steps; but h / 1.8 or more, as it oscillates without end at h / tau = 2. Damping of
  // the stiffness, by beta (s), delays it. docs/theory.md, (41).
  double following(double h, double beta) const;

  // With `whole`: displacements of its coordinates (rows of V) under forces g along the rows (s).
  Vector displacements(const Vector& g) const {
    return whole->V.rightCols(quasi_static.rows()) * (quasi_static * g);
  }

  // The rows of some nodes, numbered by their places in `nodes`, and the shapes that these move in,
  // V_c^T = Q A, kept for those that ask for the same again.
  struct OfNodes {
    std::vector<Index> nodes;
    std::vector<Index> row;  // s', of `rows`
    std::shared_ptr<const StaticRows> rows;
    Matrix Q;                         // n x r; empty where r = n: Q = I
    std::shared_ptr<const Matrix> A;  // r x 3 m; massless: 0 x 3 m
  };
  std::shared_ptr<const OfNodes> of_nodes(const NodeRows& modal_rows) const;
  // As contact sees them, with the weights of the modes; the last few are kept. Velocities have no
  // residual part.
  std::shared_ptr<const ThinResponse> response(const std::shared_ptr<const OfNodes>& nodes,
                                               const ResponseOf& of, const Vector& weight,
                                               double beta) const;

 private:
  struct Known {
    std::shared_ptr<const OfNodes> nodes;
    ResponseOf of;
    std::shared_ptr<const ThinResponse> response;
  };
  mutable std::vector<std::shared_ptr<const OfNodes>> sets_;
  mutable std::vector<Known> known_;
};

// Rows in the order of their nodes (< n), whatever the order of `node`.
StaticRows static_rows(const std::vector<Index>& node, const Points& direction, StaticCompliance F,
                       Index n);

// Of basis massless, or characteristic with residual compliance. meets_others: bodies of other
// kinds. InputError when the rigid modes do not agree with /rigid_body, named by `where`.
std::shared_ptr<const ModalForm> free_residual_form(
    const std::shared_ptr<const Superelement>& superelement, const std::string& where,
    bool meets_others);
// The same with held directions. Massless: their reactions are forces on an interface without
// inertia, so that they are eliminated as contact is. Characteristic: coordinates are held as in
// held_characteristic_form(), and residual compliance at held nodes is left out.
std::shared_ptr<const ModalForm> held_residual_form(const Superelement& superelement,
                                                    const ModalForm& free,
                                                    const std::vector<HeldDirection>& held,
                                                    const std::string& where);

// Modal truncation: modes that the steps of a contact cannot resolve become quasi-static.
//
// The highest frequency (rad/s) of dynamic modes of a free Craig-Bampton superelement: up to 2.5
// times its highest fixed-interface mode, above which its interior has no mass of its own. None if
// fewer than a third of the modes are higher. docs/decisions/truncation.md. eigenvalues: (rad/s)^2.
std::optional<double> automatic_limit(const Vector& eigenvalues, const ModalForm& all);
// Whether the forces are at so many nodes that steps pay which do not read every mode for each of
// them.
bool is_large_face(const StaticShare& forces);

// The modes of `all` up to `highest` (rad/s) as they are; those above it (h) are quasi-static along
// `forces` (no F):
//   F = B^T V_h diag(1 / omega_h^2) V_h^T B   (docs/theory.md, "Quasi-static modes").
std::shared_ptr<const ModalForm> truncated_form(double highest,
                                                std::shared_ptr<const ModalForm> all,
                                                const StaticShare& forces,
                                                const Superelement& superelement);

}  // namespace cbr
