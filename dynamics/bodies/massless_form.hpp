// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement of basis massless, made ready for time stepping; shared by the instances of a component.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/bodies/diagonal_form.hpp"

namespace cbr {

// u_c = V_c eta + F f_c, eta'' + omega^2 eta = V_c^T f_c. V of `modal` has the coordinates q_k of the file above V_c.
struct MasslessForm {
  DiagonalForm modal;
  Matrix F;                 // c x c; semi-definite when directions are held
  double omega_closed = 0;  // rad/s, with the interface held

  // F / h on the dofs of these nodes, 0 where the superelement has none (3 m x 3 m, component axes); kept for those that ask for
  // the same again. rows: displacement_rows() of the superelement, which start at k.
  std::shared_ptr<const Matrix> response(const IndexTable& rows, const std::vector<Index>& nodes, double h) const;

 private:
  struct Known {
    std::vector<Index> nodes;
    double h = 0;
    std::shared_ptr<const Matrix> block;
  };
  mutable std::vector<Known> known_;
};

// InputError when the rigid modes do not agree with /rigid_body, named by `where`.
std::shared_ptr<const MasslessForm> free_massless_form(const Superelement& superelement, const std::string& where);
// With held directions: their reactions are forces on an interface without inertia, so that they are eliminated as contact is.
std::shared_ptr<const MasslessForm> held_massless_form(const Superelement& superelement, const MasslessForm& free,
                                                       const std::vector<HeldDirection>& held, const std::string& where);

}  // namespace cbr
