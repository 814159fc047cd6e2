// SPDX-License-Identifier: GPL-3.0-or-later
// How a mesh leaves the equilibrium that it starts from, and what it keeps for checkpoints.
#include "common/files/state_archive.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"

namespace cbr {

// Rates are those half a step before, of a body at rest under all forces.
void MeshBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  add_loads(loads);
  take_still();
  last_h_ = h;
  Ku_is_current_ = v_now_is_current_ = false;
  still_.reset();
}

// Displacements as equilibrium has them.
void MeshBody::take_still() {
  Points u, v;
  still_->displacements(u, v);
  const Points local = u * placement_.T;
  for (Index i = 0; i < local.rows(); ++i) u_.row(model_->row_of_node[i]) = local.row(i);
}

// K u is formed anew where it was known: from it and in the pass that forms it velocities are the
// same, but not when it is formed.
void MeshBody::own_keep_state(StateArchive& archive) {
  archive.expect(u_.rows());
  archive(u_, v_, t_, last_h_, work_, lasting_);
  if (turning_) keep_turning(archive);
  if (still_) {
    still_->keep_state(archive);
    if (archive.restores()) take_still();
  }
  bool is_known = Ku_is_current_;
  archive(is_known);
  if (!archive.restores()) return;
  Ku_is_current_ = v_now_is_current_ = false;
  if (is_known) internal_forces();
}

}  // namespace cbr
