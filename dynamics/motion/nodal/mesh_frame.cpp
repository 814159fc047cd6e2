// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_frame.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/motion/nodal/mesh_kernels.hpp"

namespace cbr {
namespace {

// 2 w of the skew part [w x] of A, as sum Y_i x z_i of A = sum z_i Y_i^T.
Vector3 twist(const Matrix3& A) {
  return {A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)};
}

// sum a_i b_i^T, column by column: the same bits wherever it is computed.
Matrix3 products(const Field& a, const Field& b) {
  Matrix3 sum;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) sum(r, c) = a.col(r).dot(b.col(c));
  return sum;
}

Matrix3 cross(const Vector3& w) {
  Matrix3 A;
  A << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
  return A;
}

// Sums over blocks of rows, each by one thread: the same bits for any number of threads.
template <std::size_t N, typename Sum>
std::array<double, N> block_sums(Index n, RowThreads& threads, const Sum& sum) {
  constexpr Index rows = 1024;
  const Index n_blocks = (n + rows - 1) / rows;
  std::vector<std::array<double, N>> of_block(static_cast<std::size_t>(n_blocks));
  threads.for_rows(n_blocks, [&](Index begin, Index end) {
    for (Index block = begin; block < end; ++block)
      sum(block * rows, std::min(rows, n - block * rows), of_block[block].data());
  });
  std::array<double, N> all{};
  for (const auto& of : of_block)
    for (std::size_t k = 0; k < N; ++k) all[k] += of[k];
  return all;
}

MeshFrame::Sums sums_of(const std::array<double, 12>& all) {
  MeshFrame::Sums sums;
  sums.momentum = Eigen::Map<const Vector3>(all.data());
  sums.A = Eigen::Map<const Matrix3>(all.data() + 3);
  return sums;
}

Matrix3 inertia_of(const Matrix3& S) { return S.trace() * Matrix3::Identity() - S; }

// Of smaller angles the series below are exact to round-off.
constexpr double small_angle = 1e-2;

Eigen::Quaterniond exponential(const Vector3& u) {
  const double square = u.squaredNorm(), angle = std::sqrt(square), half = 0.5 * angle;
  const bool is_small = angle < small_angle;
  const double x = square / 4;
  Eigen::Quaterniond q;
  q.w() = is_small ? 1 - x / 2 * (1 - x / 12 * (1 - x / 30)) : std::cos(half);
  q.vec() = (is_small ? 0.5 * (1 - x / 6 * (1 - x / 20)) : std::sin(half) / angle) * u;
  return q;
}

// The vector of at most half a turn.
Vector3 logarithm(const Eigen::Quaterniond& q) {
  const double square = q.vec().squaredNorm(), sine = std::sqrt(square), sign = q.w() < 0 ? -1 : 1;
  const double angle_over_sine = sine < small_angle
                                     ? 1 + square * (1.0 / 6 + square * (3.0 / 40 + square / 22.4))
                                     : std::atan2(sine, sign * q.w()) / sine;
  return sign * 2 * angle_over_sine * q.vec();
}

// J^-1 a of the rotation vector u, and with -u J^-T a
Vector3 inverse_jacobian(const Vector3& u, const Vector3& a) {
  constexpr double small = 1e-4;
  const double angle = u.norm(), half = 0.5 * angle;
  const double c = angle > small ? (1 - half / std::tan(half)) / (angle * angle) : 1.0 / 12;
  return a - 0.5 * u.cross(a) + c * u.cross(u.cross(a));
}

}  // namespace

MeshFrame::MeshFrame(const MeshModel& model)
    : mass_(model.mass),
      total_(model.rigid_body.mass),
      Y_(model.mass.size(), 3),
      rotations_(model.rotations) {
  const auto& order = model.forces.order();
  for (Index i = 0; i < Y_.rows(); ++i)
    Y_.row(i) = model.coordinates.row(order[i]) - model.rigid_body.center.transpose();
  mass_(rotations_).setZero();
  Y_(rotations_, Eigen::all).setZero();
  if (model.M.size() > 0) {
    const Points by_node = Y_;  // a consistent mass has its rows in the order of the nodes
    const Vector arms = model.M * Eigen::Map<const Vector>(by_node.data(), by_node.size());
    arms_ = Eigen::Map<const Points>(arms.data(), Y_.rows(), 3);
  } else {
    arms_ = model.arms;
  }
  S_0_ = products(Y_, arms_);
  S_0_ = Matrix3(0.5 * (S_0_ + S_0_.transpose()));
  const Vector3 moments = symmetric_eigenvalues3(inertia_of(S_0_));
  if (!(moments[0] > 1e-12 * moments[2]))
    throw RunError("the mesh has no inertia about one of its axes");
}

MeshFrame::Sums MeshFrame::sums(const Field& u, RowThreads& threads) const {
  const Index n = u.rows();
  return sums_of(block_sums<12>(n, threads, [&](Index at, Index count, double* sums) {
    fit_sums(u.data() + at, arms_.data() + at, mass_.data() + at, n, count, sums);
  }));
}

void MeshFrame::add(Index row, const Vector3& u, Sums& sums) const {
  sums.momentum += mass_[row] * u;
  sums.A += u * arms_.row(row);
}

MeshFit MeshFrame::fit(const Sums& sums, const MeshFit& from) const {
  constexpr int most = 30;
  MeshFit fit;
  fit.shift = sums.momentum / total_;
  const Matrix3 A = S_0_ + sums.A;
  // Newton's method: quadratic, from a turn of one step in two or three
  fit.q = from.q;
  for (int i = 0;; ++i) {
    fit.R = fit.q.toRotationMatrix();
    const Matrix3 S = fit.R.transpose() * A;
    const Matrix3 G = inertia_of(0.5 * (S + S.transpose()));
    fit.inverse_G = G.inverse();
    const Vector3 theta = fit.inverse_G * twist(S);
    if (!(theta.squaredNorm() > 1e-32) || i == most) break;
    Eigen::Quaterniond turn;
    turn.w() = 1;
    turn.vec() = 0.5 * theta;
    fit.q = (fit.q * turn).normalized();
  }
  const Matrix3 v = cross(fit.q.vec());
  fit.less_one = 2 * (fit.q.w() * v + v * v);
  return fit;
}

void MeshFrame::strain(const MeshFit& fit, const Field& u, Field& d, RowThreads& threads) const {
  const Vector3 shift = fit.R.transpose() * fit.shift;
  const Index n = u.rows();
  threads.for_rows(n, [&](Index begin, Index end) {
    turned_strain(u.data() + begin, Y_.data() + begin, n, fit.R.data(), fit.less_one.data(),
                  shift.data(), d.data() + begin, end - begin);
  });
  threads.for_rows(static_cast<Index>(rotations_.size()), [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const Index i = rotations_[k];
      d.row(i) = logarithm(fit.q.conjugate() * exponential(u.row(i).transpose())).transpose();
    }
  });
}

Vector3 MeshFrame::turned(const Vector3& turn, const Vector3& u) {
  return logarithm(exponential(turn) * exponential(u));
}

void MeshFrame::turn_moments(const Field& d, Field& f) const {
  for (const Index i : rotations_)
    f.row(i) = inverse_jacobian(-d.row(i).transpose(), f.row(i).transpose()).transpose();
}

Vector3 MeshFrame::strain(const MeshFit& fit, const Field& u, Index row) const {
  if (std::binary_search(rotations_.begin(), rotations_.end(), row))
    return logarithm(fit.q.conjugate() * exponential(u.row(row).transpose()));
  return fit.R.transpose() * (u.row(row).transpose() - fit.shift) +
         fit.less_one.transpose() * Y_.row(row).transpose();
}

Vector3 MeshFrame::turn(const MeshFit& fit, const Field& v) const {
  return fit.inverse_G * twist(fit.R.transpose() * products(v, arms_));
}

// R^T (v - v_c) - theta x (Y + d)
void MeshFrame::strain_rates(const MeshFit& fit, const Field& d, const Field& v,
                             Field& rates) const {
  const Vector3 theta = turn(fit, v);
  Vector3 v_c;
  for (int c = 0; c < 3; ++c) v_c[c] = mass_.dot(v.col(c)) / total_;
  const Field z = Y_ + d;
  rates.noalias() = (v.rowwise() - v_c.transpose()) * fit.R;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    rates.col(c) -= theta[a] * z.col(b) - theta[b] * z.col(a);
  }
  for (const Index i : rotations_)
    rates.row(i) =
        inverse_jacobian(d.row(i).transpose(), fit.R.transpose() * v.row(i).transpose() - theta)
            .transpose();
}

Vector3 MeshFrame::lambda(const MeshFit& fit, const Field& d, const Field& f,
                          RowThreads& threads) const {
  const Index n = d.rows();
  const auto moment = block_sums<3>(n, threads, [&](Index at, Index count, double* sums) {
    moment_sums(Y_.data() + at, d.data() + at, f.data() + at, n, count, sums);
  });
  Vector3 sum(moment[0], moment[1], moment[2]);
  for (const Index i : rotations_) {
    const Vector3 of_node = f.row(i).transpose();
    sum += of_node - Vector3(d.row(i).transpose()).cross(of_node);
  }
  return fit.inverse_G * sum;
}

void MeshFrame::pull_back(const MeshFit& fit, const Vector3& lambda, const Field& f,
                          Field& gradient) const {
  const Matrix3 along = fit.R * cross(lambda);
  gradient.noalias() = f * fit.R.transpose();
  gradient.noalias() -= arms_ * along.transpose();
}

MeshFrame::Sums MeshFrame::leap(const MeshFit& fit, const Vector3& lambda, const Step& step,
                                RowThreads& threads) const {
  const Matrix3 along = fit.R * cross(lambda);
  const Index n = step.u.rows();
  return sums_of(block_sums<12>(n, threads, [&](Index at, Index count, double* sums) {
    turned_leapfrog({step.f.data() + at, step.load ? step.load->data() + at : nullptr,
                     mass_.data() + at, step.inverse_mass.data() + at, step.u.data() + at,
                     Y_.data() + at, step.v.data() + at, step.u_end.data() + at},
                    n, count, fit.R.data(), along.data(), step.s, step.h, sums);
  }));
}

}  // namespace cbr
