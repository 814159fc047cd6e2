// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_body.hpp"

namespace cbr {

// Rates are those half a step before, of a body at rest under all forces.
void MeshBody::start_motion(double h) {
  if (!still_) return;
  Points u, v;
  still_->displacements(u, v);
  const Points local = u * placement_.T;
  for (Index i = 0; i < local.rows(); ++i) u_.row(model_->row_of_node[i]) = local.row(i);
  last_h_ = h;
  Ku_is_current_ = v_now_is_current_ = false;
  still_.reset();
}

}  // namespace cbr
