// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/modal_form.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

constexpr double no_force = 1e-6;  // of |K| |R_s|

// R^T M R about the centre of mass.
Matrix6 rigid_mass(const RigidBody& body) {
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = body.mass * Matrix3::Identity();
  A.bottomRightCorner<3, 3>() = body.inertia;
  return A;
}

// M^ R with K_kc = 0, M_kk = I and R = [0; R_c]: [M_kc R_c; M_cc R_c]   ((k + c) x 6)
Matrix mass_times_rigid(const Superelement& s, const Matrix& R) {
  if (s.fixed.any()) return s.fixed.momentum;
  Matrix MR(s.n(), 6);
  const auto R_c = R.bottomRows(s.c());
  MR.topRows(s.k()).noalias() = s.M_kc * R_c;
  MR.bottomRows(s.c()).noalias() = s.M_cc * R_c;
  return MR;
}

void require_converged(const Eigenpairs& pairs, Index n, const std::string& where) {
  if (!pairs.converged || pairs.n_converged < n)
    throw RunError(
        where +
        ": the diagonal form cannot be computed: the reduced mass is not positive definite");
  // Rigid motions round to either side of 0, by far less
  if (n > 0 && pairs.lambda.minCoeff() < -1e-6 * pairs.lambda.cwiseAbs().maxCoeff())
    throw RunError(
        where +
        ": the diagonal form cannot be computed: the reduced stiffness has a negative eigenvalue");
}

// Columns 0 .. 5 of V become R L^-T with L L^T = R^T M R, when they span the same motions; E
// accordingly.
bool replace_rigid_modes(const Matrix& R, const RigidBody& body, ModalForm& form) {
  const Matrix6 S = Vector(rigid_scales(body)).asDiagonal(), mass = S * rigid_mass(body) * S;
  const std::optional<Matrix6> L = small_cholesky(mass);
  if (form.n_rigid < 6 || !L) return false;  // a mechanism has more, its rigid ones first
  // V_r = R X; then X^T (R^T M R) X = I when the file's inertia is that of its matrices.
  const Matrix R_s = R * S;
  const PivotedQr qr(R_s);
  if (qr.rank() < 6) return false;
  const Matrix V_r = form.V.leftCols(6);
  const Matrix6 X = qr.solve(V_r);
  const double spanned = (V_r - R_s * X).norm() / V_r.norm();
  const double normal = (X.transpose() * mass * X - Matrix6::Identity()).norm();
  if (spanned > 1e-6 || normal > 1e-6) return false;
  Matrix exact = R_s;
  divide_by_upper(*L, exact);
  form.V.leftCols(6) = exact;
  form.E = Matrix::Zero(form.omega.size(), 6);
  form.E.topRows(6) = L->transpose() * S.diagonal().cwiseInverse().asDiagonal();
  return true;
}

// E from V_r E_r = R, V_r the rigid columns of V: for a component of several parts, which has more
// than six. False when they do not span R.
bool rigid_modes_span(const Matrix& R, const RigidBody& body, ModalForm& form) {
  const Vector S = rigid_scales(body);
  const Matrix V_r = form.V.leftCols(form.n_rigid);
  const Matrix R_s = R * S.asDiagonal(), E_r = PivotedQr(V_r).solve(R_s);
  if ((V_r * E_r - R_s).norm() > 1e-8 * R_s.norm()) return false;
  form.E = Matrix::Zero(form.omega.size(), 6);
  form.E.topRows(form.n_rigid) = E_r * S.cwiseInverse().asDiagonal();
  return true;
}

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

// Z (c x (c - held)): orthonormal basis of the interface displacements that held directions leave
// free.
static SparseMatrix free_interface_basis(const Superelement& s,
                                         const std::vector<HeldDirection>& held) {
  const IndexTable rows = displacement_rows(s);
  std::vector<std::vector<Vector3>> of_node(s.node_ids.size());
  for (const auto& h : held) of_node[h.node].push_back(h.direction);
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index column = 0;
  for (Index node = 0; node < static_cast<Index>(of_node.size()); ++node) {
    const Matrix3 Q = complete_basis(of_node[node]);
    for (Index f = static_cast<Index>(of_node[node].size()); f < 3; ++f) {
      bool used = false;
      for (int c = 0; c < 3; ++c) {
        if (rows(node, c) < 0 || Q(c, f) == 0) continue;
        entries.emplace_back(rows(node, c) - s.k(), column, Q(c, f));
        used = true;
      }
      column += used ? 1 : 0;
    }
  }
  SparseMatrix Z(s.c(), column);
  Z.setFromTriplets(entries.begin(), entries.end());
  return Z;
}

void take_frequencies(const Vector& lambda, Index n_rigid, ModalForm& form) {
  form.omega = lambda.cwiseMax(0).cwiseSqrt();
  // a file may hold fewer coordinates than rigid motions
  form.omega.head(std::min(n_rigid, form.omega.size())).setZero();
  // a mechanism adds to the rigid motions
  form.n_rigid = (form.omega.array() == 0).count();
}

bool use_exact_rigid_modes(const Matrix& R, const RigidBody& body, ModalForm& form) {
  return replace_rigid_modes(R, body, form) ||
         (form.n_rigid > 6 && rigid_modes_span(R, body, form));
}

void refuse_rigid_modes(const std::string& where) {
  throw InputError(where +
                   ": /nodes/coordinates, /rigid_body and the rigid modes of /diagonal or the "
                   "matrices do not agree to 1e-6, as a run in modal coordinates needs: the "
                   "reduction was too ill-conditioned (heed the warnings of cbr-reduce), or the "
                   "file was changed (run cbr-reduce --force), or the density of a skin is beyond "
                   "a double beside the part");
}

Matrix free_rigid_motions(const Matrix& R, const RigidBody& body, const IndexTable& rows,
                          const std::vector<HeldDirection>& held, const Matrix& resisted) {
  const auto n_held = static_cast<Index>(held.size());
  // C x = held displacements of the rigid motion R x, and of the resisted ones
  Matrix C(n_held + resisted.rows(), 6);
  const double size = 1 / rigid_scales(body)(5);
  for (Index i = 0; i < n_held; ++i) {
    C.row(i).setZero();
    for (int c = 0; c < 3; ++c) {
      const Index row = rows(held[i].node, c);
      if (row >= 0) C.row(i) += held[i].direction[c] * R.row(row);
    }
    // rotations in units of length, so that one rank tolerance serves both
    C.row(i).tail<3>() /= size;
  }
  C.bottomRows(resisted.rows()) = resisted;
  if (C.rows() == 0) return Matrix::Identity(6, 6);
  Matrix kernel = null_space(C, 1e-9);
  kernel.bottomRows(3) /= size;
  return kernel;
}

Matrix3 complete_basis(const std::vector<Vector3>& directions) {
  if (directions.empty()) return Matrix3::Identity();
  Matrix H(3, static_cast<Index>(directions.size()));
  for (Index i = 0; i < H.cols(); ++i) H.col(i) = directions[i];
  return orthonormal_axes(H);
}

IndexTable displacement_rows(const Superelement& s) {
  IndexTable rows = IndexTable::Constant(static_cast<Index>(s.node_ids.size()), 3, -1);
  for (Index i = 0; i < s.c(); ++i) rows(s.dof_node[i], s.dof_component[i] % 3) = s.k() + i;
  return rows;
}

Matrix resisted_rigid_motions(const Matrix& K, const Matrix& R_s) {
  if (K.rows() == 0) return Matrix(0, R_s.cols());
  // K R_s = U diag(forces) W^T
  const RightSingular svd = right_singular(K * R_s);
  const Index n = (svd.values.array() > no_force * K.norm() * R_s.norm()).count();
  return svd.V.leftCols(n).transpose();
}

Matrix resisted_rigid_motions(const Superelement& s) {
  if (s.fixed.any()) return s.fixed.resisted;
  if (s.K_cc.rows() != s.c()) return Matrix(0, 6);
  return resisted_rigid_motions(s.K_cc,
                                reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c()) *
                                    rigid_scales(s.rigid_body).asDiagonal());
}

ModalForm free_modal_form(Superelement& s, const std::string& where) {
  ModalForm form;
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  if (s.has_diagonal_form()) {
    form.omega = std::move(s.omega);
    form.V = std::move(s.V);
    form.n_rigid = (form.omega.array() == 0).count();
    s.omega.resize(0);
    s.V.resize(0, 0);
  } else {
    const Matrix K = reduced_stiffness(s);
    const Matrix N =
        R * free_rigid_motions(R, s.rigid_body, {}, {},
                               resisted_rigid_motions(
                                   s));  // all six, or what is free of a part that is held inside
    const Matrix N_1 = N.colwise().normalized();
    const bool known = N.cols() > 0 && PivotedQr(N_1).rank() == N.cols();
    Eigenpairs pairs = dense_eigenpairs_beside(K, reduced_mass(s), known ? N : Matrix(s.n(), 0));
    require_converged(pairs, s.n(), where);
    take_frequencies(pairs.lambda, N.cols(), form);
    form.V = std::move(pairs.Phi);
  }
  if (use_exact_rigid_modes(R, s.rigid_body, form)) return form;
  if (form.n_rigid >= 6) refuse_rigid_modes(where);
  // E = V^T M^ R = V^-1 R   (n x 6)
  if (s.fixed.any() || s.M_cc.rows() == s.c()) {
    form.E.noalias() = form.V.transpose() * mass_times_rigid(s, R);
  } else {
    form.E = Lu(form.V).solve(R);
  }
  return form;
}

ModalForm held_modal_form(const Superelement& s, const std::vector<HeldDirection>& held,
                          const std::string& where) {
  const SparseMatrix Z = free_interface_basis(s, held);
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  const Index k = s.k(), n = k + Z.cols();
  // K_f = [Lambda, 0; 0, Z^T K_cc Z],  M_f = [I, M_kc Z; Z^T M_kc^T, Z^T M_cc Z]   (n x n)
  Matrix K = Matrix::Zero(n, n), M = Matrix::Identity(n, n);
  if (k > 0) K.diagonal().head(k) = s.eigenvalues;
  const Matrix K_Z = s.K_cc * Z, M_Z = s.M_cc * Z;
  K.bottomRightCorner(Z.cols(), Z.cols()) = Z.transpose() * K_Z;
  M.bottomRightCorner(Z.cols(), Z.cols()) = Z.transpose() * M_Z;
  M.topRightCorner(k, Z.cols()) = s.M_kc * Z;
  M.bottomLeftCorner(Z.cols(), k) = M.topRightCorner(k, Z.cols()).transpose();
  const Matrix N =
      free_rigid_motions(R, s.rigid_body, displacement_rows(s), held, resisted_rigid_motions(s));
  Matrix R_f = Matrix::Zero(n, N.cols());
  if (N.cols() > 0) R_f.bottomRows(Z.cols()) = Z.transpose() * (R.bottomRows(s.c()) * N);
  const Eigenpairs pairs = dense_eigenpairs_beside(std::move(K), std::move(M), R_f);
  require_converged(pairs, n, where);
  ModalForm form;
  take_frequencies(pairs.lambda, N.cols(), form);
  form.V.resize(s.n(), n);
  form.V.topRows(k) = pairs.Phi.topRows(k);
  form.V.bottomRows(s.c()).noalias() = Z * pairs.Phi.bottomRows(Z.cols());
  form.E.noalias() = form.V.transpose() * mass_times_rigid(s, R);
  return form;
}

void add_to_coordinates(const IndexTable& rows, const Vector& of_rows, Vector& x) {
  const Index k = x.size() - 3 * rows.rows();
  x.head(k) += of_rows.head(k);
  for (Index i = 0; i < rows.rows(); ++i)
    for (int d = 0; d < 3; ++d)
      if (rows(i, d) >= 0) x[k + 3 * i + d] += of_rows[rows(i, d)];
}

std::shared_ptr<const ModalForm> rigid_form(const Superelement& nodes,
                                            const std::vector<HeldDirection>& held,
                                            const std::string& where) {
  const RigidBody& body = nodes.rigid_body;
  const auto n_turning = std::count_if(nodes.dof_component.begin(), nodes.dof_component.end(),
                                       [](int component) { return component > 2; });
  const Matrix R = rigid_modes(nodes.coordinates, body.center, n_turning / 3);  // 3 N x 6
  Matrix mass = Matrix::Zero(6, 6);
  mass.topLeftCorner(3, 3).diagonal().setConstant(body.mass);
  mass.bottomRightCorner(3, 3) = body.inertia;
  Matrix N = Vector(rigid_scales(body)).asDiagonal();
  if (!held.empty()) N = free_rigid_motions(R, body, displacement_rows(nodes), held);
  auto form = std::make_shared<ModalForm>();
  const Index r = form->n_rigid = N.cols();
  form->omega.setZero(r);
  form->V.resize(R.rows(), r);
  form->E.resize(r, 6);
  if (r == 0) return form;
  // V = R N L^-T with N^T R^T M R N = L L^T, so that V^T M V = I
  const Cholesky factor(N.transpose() * mass * N);
  if (!factor.ok())
    throw RunError(where + ": its mass and inertia are not positive, as a rigid body needs");
  factor.divide_by_upper(N);
  form->V.noalias() = R * N;
  form->E.noalias() = N.transpose() * mass;
  return form;
}

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
