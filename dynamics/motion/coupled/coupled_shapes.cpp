// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/coupled/coupled_shapes.hpp"

#include "dynamics/motion/coupled/coupled_statics.hpp"

namespace cbr {
namespace {

// Equilibrium under forces at the held directions alone, which stay where psi has them: psi - K^+ K
// psi. What nothing holds stays where it is. The second pass takes round-off out.
void relax(CoupledSystem& system, Vector& psi) {
  Vector d(psi.size());
  for (int pass = 0; pass < 2; ++pass) {
    system.multiply_stiffness(psi, d);
    system.drop_held(d);
    system.statics().solve(d);
    psi -= d;
  }
}

}  // namespace

SupportShapes coupled_shapes(const std::shared_ptr<const CoupledModel>& model,
                             const std::vector<HeldDirection>& held, const Matrix& motion,
                             const std::string& where) {
  CoupledSystem system(model, held, where);
  const Index n = system.n(), m = motion.cols(), k = system.n_modal();
  SupportShapes shapes;
  shapes.psi.setZero(n, m);
  shapes.inertia.resize(n, m);
  Matrix force(n, m);
  Vector psi(n), product(n);
  for (Index j = 0; j < m; ++j) {
    psi.setZero();
    for (std::size_t i = 0; i < held.size(); ++i)
      psi.segment<3>(k + 3 * held[i].node) += motion(static_cast<Index>(i), j) * held[i].direction;
    if (!psi.isZero(0)) relax(system, psi);
    shapes.psi.col(j) = psi;
    system.multiply_mass(psi, product);
    shapes.inertia.col(j) = product;
    system.multiply_stiffness(psi, product);
    force.col(j) = product;
  }
  const Matrix stiffness = shapes.psi.transpose() * force;
  shapes.stiffness = 0.5 * (stiffness + stiffness.transpose());
  shapes.momentum = system.rigid_momentum().transpose() * shapes.psi;
  return shapes;
}

}  // namespace cbr
