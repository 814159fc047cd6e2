// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/residual_mass.hpp"

#include <utility>

namespace cbr {

Cholesky residual_mass_factor(const Superelement& s) {
  Matrix M_res = s.M_cc;
  if (s.k() > 0) M_res.noalias() -= s.M_kc.transpose() * s.M_kc;
  return Cholesky(std::move(M_res));
}

}  // namespace cbr
