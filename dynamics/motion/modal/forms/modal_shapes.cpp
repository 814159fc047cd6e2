// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/modal_shapes.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Of rigid motions that move a held direction, against the one that moves it most: less is none.
constexpr double moves_none = 1e-9;
// Of a motion of supports, what a rigid body may leave of it: round-off.
constexpr double rigid_round_off = 1e-8;

// An orthonormal basis of what moves the rows of A: of those columns, n x rank.
Matrix acting(const Matrix& A) {
  if (A.cols() == 0) return A.transpose() * A;
  const PivotedQr qr(A.transpose(), moves_none);
  return qr.Q().leftCols(qr.rank());
}

// C u_c = u along the held directions, held x c; rows below k of displacement_rows().
Matrix held_rows(const Superelement& s, const std::vector<HeldDirection>& held) {
  const IndexTable rows = displacement_rows(s);
  Matrix C = Matrix::Zero(static_cast<Index>(held.size()), s.c());
  for (Index i = 0; i < C.rows(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index row = rows(held[i].node, d); row >= 0)
        C(i, row - s.k()) = held[i].direction[d];
  return C;
}

}  // namespace

// diag(omega^2) q = V_b^T f and V_b q + F_bb f = u_b, where b is what is held and f acts on it:
//   (F_bb + V_e omega^-2 V_e^T) f + V_r q_r = u_b,   V_r^T f = 0,
// e the elastic modes and r the rigid motions, of which those that move nothing held stay 0.
SupportShapes modal_shapes(const Superelement& s, const ModalForm& free,
                           const std::vector<HeldDirection>& held, const Matrix& motion) {
  const Index k = s.k(), c = s.c(), r = free.n_rigid, b = motion.rows(), m = motion.cols();
  const Matrix C = held_rows(s, held), V = free.V.bottomRows(c), V_b = C * V;
  const Matrix of_modes = free.omega.tail(k - r).cwiseAbs2().cwiseInverse().asDiagonal() *
                          V_b.rightCols(k - r).transpose();
  Matrix S = V_b.rightCols(k - r) * of_modes, FC;
  if (s.is_massless()) {
    FC = s.massless.F * C.transpose();
    S += C * FC;
  }
  const Matrix Q = acting(V_b.leftCols(r));
  const double largest = V_b.leftCols(r).size() > 0 ? V_b.leftCols(r).cwiseAbs().maxCoeff() : 0;
  const double scale = largest > 0 ? S.trace() / static_cast<double>(b) / largest : 1;
  const Matrix G = scale * V_b.leftCols(r) * Q;
  Matrix A = Matrix::Zero(b + G.cols(), b + G.cols()), right = Matrix::Zero(A.rows(), m);
  A.topLeftCorner(b, b) = S;
  A.topRightCorner(b, G.cols()) = G;
  A.bottomLeftCorner(G.cols(), b) = G.transpose();
  right.topRows(b) = motion;
  const Matrix x = Lu(std::move(A)).solve(right), f = x.topRows(b);
  Matrix q(k, m);
  q.topRows(r) = scale * Q * x.bottomRows(G.cols());
  q.bottomRows(k - r) = of_modes * f;
  Matrix u = V * q;
  if (s.is_massless()) u += FC * f;
  SupportShapes shapes;
  const Index n = s.coordinates.rows();
  shapes.psi.setZero(k + 3 * n, m);
  shapes.inertia.setZero(k + 3 * n, m);
  shapes.psi.topRows(k) = shapes.inertia.topRows(k) = q;
  for (Index i = 0; i < c; ++i)
    shapes.psi.row(k + 3 * s.dof_node[i] + s.dof_component[i] % 3) = u.row(i);
  const Matrix stiffness = motion.transpose() * f;
  shapes.stiffness = 0.5 * (stiffness + stiffness.transpose());
  shapes.momentum = free.E.transpose() * q;
  return shapes;
}

SupportShapes rigid_shapes(const Superelement& nodes, const std::vector<HeldDirection>& held,
                           const Matrix& motion, const std::string& where) {
  const RigidBody& body = nodes.rigid_body;
  const auto n_turning = std::count_if(nodes.dof_component.begin(), nodes.dof_component.end(),
                                       [](int component) { return component > 2; });
  const Vector scales = rigid_scales(body);
  const Matrix R =
      rigid_modes(nodes.coordinates, body.center, n_turning / 3) * scales.asDiagonal();  // 3 N x 6
  Matrix CR(motion.rows(), 6);
  for (Index i = 0; i < CR.rows(); ++i) {
    const HeldDirection& h = held[i];
    CR.row(i) = h.direction.transpose() * R.middleRows(3 * h.node, 3);
  }
  const Matrix Q = acting(CR), y = Q * PivotedQr(CR * Q).solve(motion);  // 6 x m
  const double largest = motion.size() > 0 ? motion.cwiseAbs().maxCoeff() : 0;
  if ((CR * y - motion).cwiseAbs().maxCoeff() > rigid_round_off * largest) throw InputError(where);
  Matrix mass = Matrix::Zero(6, 6);
  mass.topLeftCorner(3, 3).diagonal().setConstant(body.mass);
  mass.bottomRightCorner(3, 3) = body.inertia;
  SupportShapes shapes;
  shapes.psi = R * y;
  shapes.momentum = mass * scales.asDiagonal() * y;
  // Forces of the nodes that have this momentum: what moves them is rigid
  const Matrix RR = R.transpose() * R;
  shapes.inertia = R * Cholesky(RR).solve(Matrix(scales.asDiagonal() * shapes.momentum));
  shapes.stiffness = Matrix::Zero(motion.cols(), motion.cols());
  return shapes;
}

}  // namespace cbr
