// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/rigid_motions.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/dense.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

constexpr double independent = 1e-10;  // of the rigid motions on the interface
constexpr double moves_none = 1e-9;    // of fixed dofs
// Inertia that is put right is right to round-off. Of a soft block beside one 1e8 to 1e12 times as
// stiff a lag of 5e-6 to 5e-2 (forces of 1e-7 to 1.5e-3) left the lowest eigenvalues within 4e-7 to
// 2e-3, against 64 bits of mantissa; of thin sheets about as far off as the lag.
constexpr double poor_lag = 1e-6, lost_lag = 0.1, poor_force = 1e-8, lost_force = 1e-2,
                 poor_mass = 1e-9, lost_mass = 1e-6;

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

struct PartNodes {
  std::vector<Index> interior, interface;  // nodes
};

std::vector<PartNodes> parts_of_nodes(const std::vector<Index>& part_I,
                                      const std::vector<Index>& part_C) {
  Index n = 0;
  for (const auto* part : {&part_I, &part_C})
    for (const Index number : *part) n = std::max(n, number + 1);
  std::vector<PartNodes> parts(n);
  for (std::size_t i = 0; i < part_I.size(); ++i)
    parts[part_I[i]].interior.push_back(static_cast<Index>(i));
  for (std::size_t i = 0; i < part_C.size(); ++i)
    parts[part_C[i]].interface.push_back(static_cast<Index>(i));
  return parts;
}

// About the middle of all nodes and of their size   (3 nodes x 6, those inside first)
Matrix motions_of(const Partition& p, const PartNodes& part, const Points& x_I, const Points& x_C) {
  Points x(static_cast<Index>(part.interior.size() + part.interface.size()), 3);
  x << Points(x_I(part.interior, Eigen::all)), Points(x_C(part.interface, Eigen::all));
  const Eigen::RowVector3d middle = x.colwise().mean();
  x.rowwise() -= middle;
  const double size = x.rowwise().norm().maxCoeff();
  Matrix R = rigid_modes(size > 0 ? Points(x / size) : x, Vector3::Zero());
  if (!p.has_rotations()) return R;  // and the partition may have no lists of nodes
  const auto turn = [&](std::size_t row) {
    auto rows = R.middleRows(3 * static_cast<Index>(row), 3);
    rows.setZero();
    rows.rightCols(3).diagonal().setConstant(size > 0 ? 1 / size : 1);
  };
  for (std::size_t i = 0; i < part.interior.size(); ++i)
    if (p.is_interior_rotation(part.interior[i])) turn(i);
  for (std::size_t i = 0; i < part.interface.size(); ++i)
    if (p.is_rotation(part.interface[i])) turn(part.interior.size() + i);
  return R;
}

void add_rows(const Matrix& R, const std::vector<Index>& nodes, Index first_dof, Index first_column,
              Triplets& triplets) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (Index d = 0; d < 3; ++d)
      for (Index j = 0; j < 6; ++j)
        if (const double value = R(3 * static_cast<Index>(i) + d, j); value != 0)
          triplets.emplace_back(first_dof + 3 * nodes[i] + d, first_column + j, value);
}

SparseMatrix sparse(Index rows, Index columns, const Triplets& triplets) {
  SparseMatrix A(rows, columns);
  A.setFromTriplets(triplets.begin(), triplets.end());
  return A;
}

// Of m rows and columns each
SparseMatrix block_diagonal(const std::vector<Matrix>& blocks, Index m) {
  Triplets triplets;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i)
        triplets.emplace_back(m * static_cast<Index>(b) + i, m * static_cast<Index>(b) + j,
                              blocks[b](i, j));
  const auto n = m * static_cast<Index>(blocks.size());
  return sparse(n, n, triplets);
}

template <typename Rows>
RigidResidual worst_row(Index n, const Matrix& R, Rows absolute_sum, const Matrix& KR) {
  RigidResidual worst;
  const Eigen::RowVectorXd size = R.cwiseAbs().colwise().maxCoeff();
  for (Index i = 0; i < n; ++i) {
    for (Index c = 0; c < R.cols(); ++c) {
      const double scale = absolute_sum(i) * size(c);
      const double share = scale > 0 ? std::abs(KR(i, c)) / scale : 0.0;
      if (share > worst.value) worst = {share, i};
    }
  }
  return worst;
}

// R <- R L^-T with R^T M R = L L^T; twice, as the first pass leaves cond(L) times round-off.
void orthonormalise(RigidMotions& rigid) {
  for (int pass = 0; pass < 2; ++pass) {
    const SparseMatrix M = SparseMatrix(rigid.R_I.transpose()) * rigid.P_I +
                           SparseMatrix(rigid.R_C.transpose()) * rigid.P_C;
    const Index m = rigid.of_part;
    std::vector<Matrix> blocks;
    for (Index first = 0; first < rigid.count(); first += m) {
      const Cholesky cholesky(Matrix(M.middleCols(first, m)).middleRows(first, m));
      if (!cholesky.ok()) throw RunError("the mass of the rigid motions is not positive definite");
      blocks.emplace_back(Matrix::Identity(m, m));
      cholesky.solve_upper_in_place(blocks.back());
    }
    const SparseMatrix T = block_diagonal(blocks, m);
    for (SparseMatrix* A : {&rigid.R_I, &rigid.R_C, &rigid.P_I, &rigid.P_C})
      *A = SparseMatrix(*A * T);
  }
}

// A += H G + (H G)^T, both triangles the same   (c x c)
void add_symmetric(const Matrix& H, const SparseMatrix& G, Matrix& A) {
  constexpr Index block = 256;
  const Index c = A.rows();
  for (Index j = 0; j < c; j += block) {
    const Index width = std::min(block, c - j), rows = c - j;
    auto lower = A.block(j, j, rows, width);
    lower += H.bottomRows(rows) * G.middleCols(j, width);
    lower +=
        SparseMatrix(G.rightCols(rows).transpose()) * Matrix(H.middleRows(j, width).transpose());
  }
  mirror_lower(A);
}

// Orthonormal columns that span those of each part's R_C; N^T   (r x c)
SparseMatrix orthonormal(const SparseMatrix& R_C, Index m) {
  Triplets triplets;
  for (Index first = 0; first < R_C.cols(); first += m) {
    std::vector<Index> rows;
    for (Index j = first; j < first + m; ++j)
      for (SparseMatrix::InnerIterator it(R_C, j); it; ++it) rows.push_back(it.row());
    sort_uniquely(rows);
    const Matrix R = Matrix(R_C.middleCols(first, m))(rows, Eigen::all);
    const Matrix N = orthonormal_basis(R);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (Index j = 0; j < m; ++j)
        triplets.emplace_back(first + j, rows[i], N(static_cast<Index>(i), j));
  }
  return sparse(R_C.cols(), R_C.rows(), triplets);
}

// S^-1 m^T, part by part   (r x c)
SparseMatrix content(const RigidMotions& rigid, const Matrix& m, const Matrix& S) {
  const Index n = rigid.of_part;
  Matrix G(m.cols(), m.rows());
  for (Index first = 0; first < rigid.count(); first += n)
    G.middleRows(first, n) =
        Lu(S.block(first, first, n, n)).solve(m.middleCols(first, n).transpose());
  return G.sparseView(0.0, 0.0);
}

double from_identity(const Matrix& A) {
  return A.rows() > 0 ? (A - Matrix::Identity(A.rows(), A.cols())).cwiseAbs().maxCoeff() : 0;
}

std::string cure(const std::string& where) {
  return "; look for very thin parts, slivers, an interface nearly on one line, parts of very "
         "unlike stiffness" +
         (where.empty() ? "" : ", first at " + where);
}

}  // namespace

namespace {

// Those of one part that its fixed dofs leave: exact on the others.
void leave_fixed(const Partition& p, const Matrix& R_I, const Matrix& R_C, RigidMotions& rigid) {
  std::vector<char> is_fixed(R_I.rows() + R_C.rows(), 1);
  for (const Index dof : p.interior_dofs) is_fixed[dof] = 0;
  for (const Index dof : p.interface_dofs) is_fixed[R_I.rows() + dof] = 0;
  Matrix R(R_I.rows() + R_C.rows(), 6);
  R << R_I, R_C;
  std::vector<Index> fixed;
  for (std::size_t dof = 0; dof < is_fixed.size(); ++dof)
    if (is_fixed[dof] != 0) fixed.push_back(static_cast<Index>(dof));
  const Matrix left = null_space(R(fixed, Eigen::all), moves_none);
  Matrix on_interface = R_C(p.interface_dofs, Eigen::all) * left;
  const bool are_told =
      left.cols() > 0 && PivotedQr(on_interface, independent).rank() == left.cols();
  if (!are_told) on_interface.resize(on_interface.rows(), 0);
  rigid.of_part = on_interface.cols();
  rigid.R_C = on_interface.sparseView(0.0, 0.0);
  rigid.R_I =
      Matrix(R_I(p.interior_dofs, Eigen::all) * left.leftCols(rigid.of_part)).sparseView(0.0, 0.0);
}

}  // namespace

RigidMotions rigid_motions(const Partition& p, const Points& x_I, const std::vector<Index>& part_I,
                           Index first_I, const Points& x_C, const std::vector<Index>& part_C) {
  Triplets inside, on_interface;
  Index r = 0;
  RigidMotions rigid;
  for (const PartNodes& part : parts_of_nodes(part_I, part_C)) {
    if (part.interior.empty() || part.interface.empty()) continue;
    const Matrix R = motions_of(p, part, x_I, x_C);
    const auto n_inside = 3 * static_cast<Index>(part.interior.size());
    if (p.has_fixed()) {
      leave_fixed(p, R.topRows(n_inside), R.bottomRows(R.rows() - n_inside), rigid);
      break;
    }
    if (PivotedQr(R.bottomRows(R.rows() - n_inside), independent).rank() < 6) continue;
    add_rows(R.topRows(n_inside), part.interior, first_I, r, inside);
    add_rows(R.bottomRows(R.rows() - n_inside), part.interface, 0, r, on_interface);
    r += 6;
  }
  if (!p.has_fixed() || rigid.R_C.size() == 0) {
    rigid.R_I = sparse(p.n_interior(), r, inside);
    rigid.R_C = sparse(p.n_interface(), r, on_interface);
  }
  rigid.P_I = SparseMatrix(p.M_II * rigid.R_I) + SparseMatrix(p.M_IC * rigid.R_C);
  rigid.P_C =
      SparseMatrix(SparseMatrix(p.M_IC.transpose()) * rigid.R_I) + SparseMatrix(p.M_CC * rigid.R_C);
  orthonormalise(rigid);
  return rigid;
}

RigidResidual rigid_residual(const SparseMatrix& K, const Matrix& R) {
  Vector sums = Vector::Zero(K.rows());
  for (Index j = 0; j < K.cols(); ++j)
    for (SparseMatrix::InnerIterator it(K, j); it; ++it) sums(it.row()) += std::abs(it.value());
  return worst_row(
      K.rows(), R, [&](Index i) { return sums(i); }, K * R);
}

RigidResidual rigid_residual(const Matrix& K, const Matrix& R) {
  // Rows may be 0 but for round-off: the stiffest row is the measure of all.
  const double largest = K.rows() > 0 ? K.cwiseAbs().rowwise().sum().maxCoeff() : 0.0;
  return worst_row(
      K.rows(), R, [&](Index) { return largest; }, K * R);
}

RigidFigures follow_rigid_motions(const RigidMotions& rigid, const Matrix& m, Matrix& K_cc,
                                  Matrix& M_cc) {
  RigidFigures figures;
  if (rigid.count() == 0) return figures;
  const SparseMatrix& R_C = rigid.R_C;
  const SparseMatrix R_C_t = R_C.transpose();
  figures.force = rigid_residual(K_cc, Matrix(R_C)).value;
  {
    const SparseMatrix N_t = orthonormal(R_C, rigid.of_part);
    // K <- K + H N^T + N H^T, H = N (N^T K N) / 2 - K N
    Matrix H = K_cc * SparseMatrix(N_t.transpose());
    H = (SparseMatrix(N_t.transpose()) * Matrix(0.5 * (N_t * H)) - H).eval();
    add_symmetric(H, N_t, K_cc);
  }
  const Matrix S = Matrix(R_C_t * m).transpose();
  const SparseMatrix G = content(rigid, m, S);
  // M <- M + H G + G^T H^T, H = G^T (R_C^T M R_C + 1) / 2 - M R_C
  Matrix H = M_cc * R_C;
  Matrix B = R_C_t * H;
  figures.lag = std::max(from_identity(S), from_identity(B));
  B.diagonal().array() += 1;
  H = (SparseMatrix(G.transpose()) * Matrix(0.25 * (B + B.transpose())) - H).eval();
  add_symmetric(H, G, M_cc);
  figures.mass = from_identity(R_C_t * Matrix(M_cc * R_C));
  return figures;
}

SparseMatrix rigid_content(const RigidMotions& rigid, const Matrix& M_cc) {
  if (rigid.count() == 0) return SparseMatrix(0, M_cc.cols());
  return Matrix(Matrix(M_cc * rigid.R_C).transpose()).sparseView(0.0, 0.0);
}

void follow_rigid_motions(const RigidMotions& rigid, const SparseMatrix& G, const Matrix& momentum,
                          Matrix& M_kc) {
  if (rigid.count() == 0 || M_kc.rows() == 0) return;
  const Matrix missing = momentum.transpose() - M_kc * rigid.R_C;
  M_kc += missing * G;
}

void judge_rigid(const RigidFigures& f, double condition, const std::string& where,
                 Report& report) {
  report.detail(format_text(
      "rigid motions of the interior: error %.1e (forces %.1e), of their mass once put right %.1e",
      f.lag, f.force, f.mass));
  if (!(f.lag <= lost_lag) || !(f.mass <= lost_mass))
    throw InputError(
        format_text("the stiffness of the interior is too ill-conditioned (%.0e, scaled by its "
                    "diagonal) to be reduced: by round-off "
                    "it follows rigid motions of the interface with an error of %.0e",
                    condition, std::fmax(f.lag, f.mass)) +
        cure(where) +
        "; use larger or less flat elements there, or keep more of the part in the interface");
  if (!(f.force <= lost_force))
    throw InputError(
        format_text("the stiffness is too ill-conditioned (%.0e, scaled by its diagonal) to be "
                    "reduced: by round-off the reduced one "
                    "resists rigid motions by %.0e of its size",
                    condition, f.force) +
        cure(where) +
        "; use larger or less flat elements there, or keep more of the part in the interface");
  if (f.lag > poor_lag)
    report.warning(format_text("by round-off the interior follows rigid motions of the interface "
                               "with an error of %.0e, which is put "
                               "right; its lowest frequencies may be as far off",
                               f.lag) +
                   cure(where));
  if (f.force > poor_force)
    report.warning(format_text("by round-off the reduced stiffness resists rigid motions by %.0e "
                               "of its size, which is put right; its "
                               "lowest frequencies may be far off",
                               f.force) +
                   cure(where));
  if (f.mass > poor_mass)
    report.warning(format_text("the reduced mass of rigid motions is off by %.0e", f.mass) +
                   cure(where));
}

}  // namespace cbr
