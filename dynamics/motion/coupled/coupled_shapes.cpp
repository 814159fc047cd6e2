// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/coupled/coupled_shapes.hpp"

#include "dynamics/motion/coupled/coupled_system.hpp"

namespace cbr {
namespace {

// Moves of an equilibrium: below this share of the whole they are round-off, and there are never
// as many.
constexpr double least_move = 1e-15;
constexpr int most_moves = 60;

// Equilibrium under forces at the held directions alone, which stay where psi has them: by moves d
// of (K + sigma M) d = -K psi, as statics find it, so that what nothing holds stays where it is.
void relax(CoupledSystem& system, Vector& psi) {
  const double theta = 1 / system.static_pull();
  Vector d(psi.size());
  double before = 0;
  for (int i = 0; i < most_moves; ++i) {
    system.multiply_stiffness(psi, d);
    d *= -theta;
    system.drop_held(d);
    system.factor(theta).solve(d);
    const double moved = d.norm();
    if (i > 1 && moved >= 0.5 * before) return;  // round-off is all that is left
    psi += d;
    if (!(moved > least_move * psi.norm())) return;
    before = moved;
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
