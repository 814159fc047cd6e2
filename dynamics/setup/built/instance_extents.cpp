// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/instance_extents.hpp"

namespace cbr {

Box extents(const Body& body, const BuiltScene::OfInstance& instance) {
  const Points& x = body.reference_positions();
  Box box{x.colwise().minCoeff().transpose(), x.colwise().maxCoeff().transpose()};
  if (instance.parts.size() != 1) return box;
  const RigidBody& rigid = instance.parts.front().superelement->rigid_body;
  if (!(rigid.mass > 0)) return box;
  const Matrix3& T = instance.placement.T;
  // int x x^T dm / m = (trace(I) / 2 1 - I) / m; for a box it is a third of the squared half edge
  const Matrix3 spread = T * (0.5 * rigid.inertia.trace() * Matrix3::Identity() - rigid.inertia) *
                         T.transpose() / rigid.mass;
  const Vector3 half = (3 * spread.diagonal()).cwiseMax(0).cwiseSqrt(),
                centre = T * rigid.center + instance.placement.position;
  box.lower = box.lower.cwiseMin(centre - half);
  box.upper = box.upper.cwiseMax(centre + half);
  return box;
}

}  // namespace cbr
