// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement of modes, and of statics without mass that these leave out, made ready for time
// stepping; shared by the instances of a component.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/contact/nodes/thin_response.hpp"
#include "dynamics/motion/modal/forms/diagonal_form.hpp"

namespace cbr {

// u_c = V_c eta + B F B^T f_c, eta'' + omega^2 eta = V_c^T f_c. Basis massless: V_c is the modes of
// a body whose interface has no mass, F of all interface dofs. Basis characteristic: V_c are shapes
// with mass, F what they leave of the statics of some faces.
struct StaticsForm {
  DiagonalForm modal;  // V has the coordinates q_k of the file above V_c
  StaticRows rows;     // of all nodes of the superelement, component axes
  // Of truncated modes: the form with all n of them, whose last h are quasi-static, and
  // diag(1 / omega_h^2) V_h^T B (h x s). Null, and empty: forces along the rows displace the rows
  // alone.
  std::shared_ptr<const DiagonalForm> whole;
  Matrix quasi_static;
  bool is_massless = false;
  // rad/s, limits a step: massless, with the interface held; else the highest of `modal`
  double omega_limit = 0;

  // The time tau over which statics follow a force: a force f moves them by F f h / tau in a step.
  // Massless: h, at once. Beside shapes with mass: 1 / omega_limit, else contact bounces on them in
  // short steps; but h / 1.8 or more, as statics swing without end at h / tau = 2. Damping of the
  // stiffness, by beta (s), holds them back. docs/theory.md, (41).
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
  // statics.
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
StaticRows static_rows(const std::vector<Index>& node, const Points& direction,
                       std::shared_ptr<const Matrix> F, Index n);

// Of basis massless, or characteristic with statics. InputError when the rigid modes do not agree
// with /rigid_body, named by `where`.
std::shared_ptr<const StaticsForm> free_statics_form(
    const std::shared_ptr<const Superelement>& superelement, const std::string& where);
// With held directions. Massless: their reactions are forces on an interface without inertia, so
// that they are eliminated as contact is. Characteristic: coordinates are held as in
// held_characteristic_form(), and statics at held nodes are left out.
std::shared_ptr<const StaticsForm> held_statics_form(const Superelement& superelement,
                                                     const StaticsForm& free,
                                                     const std::vector<HeldDirection>& held,
                                                     const std::string& where);

}  // namespace cbr
