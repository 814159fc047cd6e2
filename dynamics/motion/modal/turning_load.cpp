// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_load.hpp"

#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {

TurningLoad::TurningLoad(const VectorForce& force, const LoadHistory& history,
                         const ModalBody& modal)
    : value_(force.value),
      follows_(force.follows),
      history_(history),
      elastic_(Matrix::Zero(modal.n_dofs(), 3)),
      bend_(Matrix::Zero(modal.n_dofs(), 9)) {
  const Vector3 c = modal.center_of_mass();
  const Points& X = modal.own_nodes();
  const Matrix& V = modal.form().V;
  for (Index a = 0; a < 3; ++a) {
    const ForcePattern& pattern = force.patterns[a];
    elastic_.col(a) = modal.modal_force(pattern);
    const Points forces = pattern.forces.on_nodes();
    for (Index i = 0; i < forces.rows(); ++i) {
      const Vector3 f = forces.row(i).transpose();
      if (f.isZero(0)) continue;
      resultant_.col(a) += f;
      moment_.col(a) += Vector3(X.row(i).transpose() - c).cross(f);
      for (int d = 0; d < 3; ++d) {
        const Index row = modal.rows()(i, d);
        if (row < 0) continue;
        const Vector3 arm = modal.axes().col(d);  // scene axes, of the component's axis d
        bend_.middleCols(3 * a, 3) += V.row(row).transpose() * arm.cross(f).transpose();
      }
    }
  }
  const Index n_rigid = modal.form().n_rigid;
  elastic_.topRows(n_rigid).setZero();
  bend_.topRows(n_rigid).setZero();
}

Vector3 TurningLoad::moment(const Eigen::Quaterniond& q, const Vector& eta) const {
  const Vector bent = bend_.transpose() * eta;
  const Matrix3 all = moment_ + Eigen::Map<const Matrix3>(bent.data());
  return q * (all * vector(q));
}

}  // namespace cbr
