// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/joint_body.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// A^-1 over the rows that are not 0, elsewhere 0.
Matrix6 inverse_where_not_zero(const Matrix6& A) {
  std::vector<Index> rows;
  for (Index i = 0; i < 6; ++i)
    if (!A.row(i).isZero(0)) rows.push_back(i);
  Matrix6 inverse = Matrix6::Zero();
  const auto n = static_cast<Index>(rows.size());
  if (n == 0) return inverse;
  const Cholesky factor(A(rows, rows));
  assert(factor.ok());
  inverse(rows, rows) = factor.solve(Matrix(Matrix::Identity(n, n)));
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

JointBody::JointBody(Joint joint, Scheme scheme)
    : Body({.name = joint.name,
            .scheme = scheme,
            .n_dofs = joint.is_mass() ? 6 : 0,
            .positions = std::make_shared<const Points>(joint.at.transpose().replicate(2, 1)),
            .bends = joint.bends()}),
      joint_(std::move(joint)) {
  if (!joint_.is_mass()) return;
  inverse_mass_ = inverse_where_not_zero(joint_.mass);
  v_ = joint_.rates;
}

void JointBody::follow(Index node, const Matrix3& to_scene) {
  if (!follows_) maps_.fill(joint_.axes.transpose());
  follows_ = true;
  maps_[node] = to_scene;
}

Matrix6 JointBody::in_scene_axes(const Matrix6& A) const {
  Matrix6 turned;
  for (Index i = 0; i < 6; i += 3)
    for (Index j = 0; j < 6; j += 3)
      turned.block<3, 3>(i, j) =
          to_scene(i / 3) * A.block<3, 3>(i, j) * to_scene(j / 3).transpose();
  return turned;
}

Index JointBody::own_track(const std::vector<Index>& nodes) {
  sets_.push_back(nodes);
  return static_cast<Index>(sets_.size()) - 1;
}

void JointBody::fill(const Vector6& r, Index set, Points& x) const {
  const std::vector<Index>& nodes = sets_[set];
  x.resize(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) {
    const Index node = nodes[i];
    x.row(i) = (joint_.at + to_scene(node) * r.segment<3>(3 * node)).transpose();
  }
}

Vector6 JointBody::gathered(Index set, const Points& impulses) const {
  const std::vector<Index>& nodes = sets_[set];
  Vector6 P = Vector6::Zero();
  for (Index i = 0; i < impulses.rows(); ++i) {
    const Index node = nodes[i];
    P.segment<3>(3 * node) += to_scene(node).transpose() * impulses.row(i).transpose();
  }
  return P;
}

void JointBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  Points x;
  fill(r_, set, x);
  position = x.colwise().mean().transpose();
  velocity = to_scene(0) * v_.head<3>();
}

bool Joint::bends() const {
  return friction.maxCoeff() > 0 ||
         std::any_of(force.begin(), force.end(), [](const auto& table) { return !table.empty(); });
}

std::array<double, 2> JointBody::range(Index m, const Vector6& r) const {
  if (is_static_ || joint_.is_late) return {r[m], r[m]};
  if (is_newmark()) return {r_[m], r[m]};
  return {r_[m] - 0.5 * last_h_ * v_[m], 0.5 * (r_[m] + r[m])};
}

Vector6 JointBody::impulse(const Vector6& r, double h) const {
  const Matrix6 &K = joint_.stiffness, &C = joint_.damping;
  const Vector6 way = r - r_;
  Vector6 P;
  if (is_static_) {
    P = K * r;
  } else if (is_newmark()) {
    P = 0.5 * h * (K * (r_ + r)) + C * way;
  } else if (joint_.is_late) {
    P = h * (K * r) + C * (1.5 * way - 0.5 * h * v_);
  } else {
    P = h * (K * (r_ + 0.25 * (way - last_h_ * v_))) + 0.5 * (C * (way + h * v_));
  }
  for (Index m = 0; m < 6; ++m) {
    const ForceTable& table = joint_.force[m];
    if (!table.empty()) P[m] += h * table.mean(range(m, r)[0], range(m, r)[1]);
    P[m] += h * joint_.friction[m] * slides_[m];
  }
  return P;
}

Matrix6 JointBody::slope(const Vector6& r, double h) const {
  const Matrix6 &K = joint_.stiffness, &C = joint_.damping;
  const bool at_end = is_static_ || joint_.is_late;
  Matrix6 A = is_static_       ? K
              : is_newmark()   ? Matrix6(0.5 * h * K + C)
              : joint_.is_late ? Matrix6(h * K + 1.5 * C)
                               : Matrix6(0.25 * h * K + 0.5 * C);
  // Of a gap and of a slip: so small that a motion makes no force, so large that a force is no
  // round-off
  constexpr double of_gap = 1e-4, of_slip = 1e-3;
  for (Index m = 0; m < 6; ++m) {
    if (!joint_.bends(m)) continue;
    const ForceTable& table = joint_.force[m];
    double least = of_slip * h * joint_.friction[m] / (m < 3 ? joint_.size : 1);
    if (!table.empty()) {
      // d mean / d r: all of the end where the range is one point, else the end's share
      const double share = at_end ? 2 : is_newmark() ? 1 : 0.5;
      A(m, m) += h * share * table.mean_slope(range(m, r)[0], range(m, r)[1]);
      least = std::max(least, of_gap * h * table.steepest());
    }
    A(m, m) = std::max(A(m, m), least);
    if (!(joint_.friction[m] > 0) || slides_[m] != 0) continue;
    A.row(m).setZero();
    A.col(m).setZero();
  }
  return A;
}

Matrix6 JointBody::answer(double h) const {
  if (joint_.is_mass()) return (is_newmark() ? 0.5 * h : h) * inverse_mass_;
  return joint_.bends() ? answer_ : inverse_where_not_zero(slope(r_, h));
}

void JointBody::linearise(Vector6 at, double h) {
  for (Index m = 0; m < 6; ++m)
    if (joint_.friction[m] > 0 && slides_[m] == 0) at[m] = is_static_ ? begin_[m] : r_[m];
  answer_ = inverse_where_not_zero(slope(at, h));
  r_end_ = at - answer_ * (impulse(at, h) - pushed_);
}

void JointBody::predict_end() {
  const double h = h_;
  is_static_ = false;
  if (joint_.is_mass()) {
    answer_ = answer(h);
    r_end_ = r_ + h * v_;
    v_end_ = v_;
    return;
  }
  pushed_.setZero();
  if (joint_.bends()) {
    for (Index m = 0; m < 6; ++m) slides_[m] = (v_[m] > 0) - (v_[m] < 0);
    linearise(r_ + h * v_, h);
    is_new_ = answer_ != first_answer_;
    first_answer_ = answer_;
    return;
  }
  if (answer_h_ != h) answer_ = answer(h);
  answer_h_ = h;
  r_end_ = r_ - answer_ * impulse(r_, h);
}

// Whether friction begins or ceases to slip, by the impulses and the way so far.
bool JointBody::change_slides(Vector6& at, double h) {
  constexpr double beyond = 1 + 1e-9;
  bool any = false;
  for (Index m = 0; m < 6; ++m) {
    if (!(joint_.friction[m] > 0)) continue;
    const double start = is_static_ ? begin_[m] : r_[m];
    const double held = pushed_[m] - impulse(at, h)[m];
    const double before = slides_[m];
    if (before == 0 && std::abs(held) > beyond * h * joint_.friction[m]) {
      slides_[m] = held > 0 ? 1 : -1;
    } else if (before * (at[m] - start) < 0) {
      slides_[m] = 0;
      at[m] = start;
    }
    any |= slides_[m] != before;
  }
  return any;
}

void JointBody::linearise_again() {
  Vector6 at = r_end_;
  change_slides(at, h_);
  linearise(at, h_);
}

void JointBody::own_take_impulses(Index set, const Impulses& impulses) {
  const Vector6 P = gathered(set, impulses.all);
  pushed_ += P;
  r_end_ += answer_ * P;
  v_end_ += inverse_mass_ * P;
}

double JointBody::spring_energy(const Vector6& r) const {
  double energy = 0.5 * r.dot(joint_.stiffness * r);
  for (Index m = 0; m < 6; ++m)
    if (const ForceTable& table = joint_.force[m]; !table.empty()) energy += table.energy(r[m]);
  return energy;
}

// What springs store and dashpots take is what the bodies that they join have done on them, to the
// error of the step.
void JointBody::own_accept() {
  if (joint_.is_mass()) {
    work_.contact += 0.5 * (v_end_.dot(joint_.mass * v_end_) - v_.dot(joint_.mass * v_));
  } else {
    v_end_ = (r_end_ - r_) / h_;
    const bool at_end = is_newmark() || joint_.is_late;
    const Vector6 rates = at_end ? v_end_ : Vector6(0.5 * (v_ + v_end_));
    const double energy = spring_energy(at_end ? r_end_ : Vector6(0.5 * (r_ + r_end_)));
    double lost = h_ * rates.dot(joint_.damping * rates);
    if (joint_.friction.maxCoeff() > 0) {
      Vector6 rubbed = pushed_;
      slides_.setZero();
      rubbed -= impulse(r_end_, h_);
      lost += (joint_.friction.array() > 0).select(rubbed, 0).dot(rates);
    }
    work_.contact += energy - energy_ + lost;
    work_.damping -= lost;
    energy_ = energy;
  }
  r_ = r_end_;
  v_ = v_end_;
  last_h_ = h_;
}

void JointBody::own_end_velocities(Index set, Points& v) {
  fill(v_end_, set, v);
  v.rowwise() -= joint_.at.transpose();
}

NodeResponse JointBody::own_velocity_response(Index set) const {
  return response_of(set, inverse_mass_);
}

void JointBody::own_add_end_impulses(Index set, const Points& impulses) {
  v_end_ += inverse_mass_ * gathered(set, impulses);
}

NodeResponse JointBody::response_of(Index set, const Matrix6& A) const {
  const std::vector<Index>& nodes = sets_[set];
  const Matrix6 S = in_scene_axes(A);
  const auto n = static_cast<Index>(nodes.size());
  Matrix block(3 * n, 3 * n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      block.block<3, 3>(3 * i, 3 * j) = S.block<3, 3>(3 * nodes[i], 3 * nodes[j]);
  NodeResponse response;
  response.set_block(std::move(block));
  return response;
}

NodeResponse JointBody::own_response(Index set, double h) const {
  return response_of(set, answer(h));
}

template <typename Of>
Matrix6 JointBody::with_tables(const Of& of) const {
  Matrix6 K = joint_.stiffness;
  for (Index m = 0; m < 6; ++m)
    if (const ForceTable& table = joint_.force[m]; !table.empty()) K(m, m) += of(table, r_[m]);
  return K;
}

Matrix6 JointBody::stiffness() const {
  return with_tables([](const ForceTable& table, double r) { return table.slope(r); });
}

Matrix6 JointBody::largest_stiffness() const {
  return with_tables([](const ForceTable& table, double) { return table.steepest(); });
}

Matrix6 JointBody::compliance() const {
  Matrix6 K = stiffness();
  for (Index m = 0; m < 6; ++m) {
    if (!(joint_.friction[m] > 0)) continue;
    K.row(m).setZero();
    K.col(m).setZero();
  }
  return inverse_where_not_zero(K);
}

// Inertia has no part in equilibrium: a mass goes where its point goes.
void JointBody::own_relax(double, double) {
  is_static_ = true;
  pushed_.setZero();
  if (joint_.bends()) {
    linearise(r_, 1);
  } else {
    answer_ = joint_.is_mass() ? Matrix6(Matrix6::Zero()) : compliance();
    r_end_ = joint_.is_mass() ? r_ : Vector6(Vector6::Zero());
  }
}

// Of a mass: each of its coordinates, rotations such that they have the same inertia.
Matrix JointBody::floating() const {
  const double mass = joint_.mass.trace() - joint_.mass.bottomRightCorner<3, 3>().trace(),
               inertia = joint_.mass.bottomRightCorner<3, 3>().trace();
  Matrix R = Matrix::Zero(6, 6);
  Index k = 0;
  for (Index i = 0; i < 6; ++i)
    if (joint_.mass(i, i) > 0) R(i, k++) = i < 3 || !(mass > 0) ? 1 : std::sqrt(mass / inertia);
  return R.leftCols(k);
}

Matrix JointBody::own_floating_motions(Index set) const {
  const std::vector<Index>& nodes = sets_[set];
  const Matrix R = floating();
  Matrix motions(3 * static_cast<Index>(nodes.size()), R.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    motions.middleRows(3 * static_cast<Index>(i), 3) =
        to_scene(nodes[i]) * R.middleRows(3 * nodes[i], 3);
  return motions;
}

FloatingForces JointBody::floating_forces() const {
  const Matrix R = floating();
  return {R.transpose() * pushed_, R.cols() > 0 ? pushed_.lpNorm<Eigen::Infinity>() : 0};
}

void JointBody::float_by(const Vector& move) { r_end_ += floating() * move; }

NodeResponse JointBody::own_static_response(Index set) const { return response_of(set, answer_); }

void JointBody::own_add_static_forces(Index set, const Points& forces) {
  const Vector6 P = gathered(set, forces);
  pushed_ += P;
  r_end_ += answer_ * P;
}

Settled JointBody::own_settle() {
  const Vector6 move = r_end_ - r_;
  Settled settled{2 * spring_energy(move), 2 * spring_energy(r_end_)};
  if (joint_.bends()) {
    settled.change = move.dot(slope(r_, 1) * move);
    // A slip that begins changes energy by its force over the size of the bodies, or by its moment
    const Vector6 before = slides_;
    if (change_slides(r_end_, 1)) {
      const Vector6 work = joint_.friction.cwiseProduct((slides_ - before).cwiseAbs());
      settled.change += joint_.size * work.head<3>().sum() + work.tail<3>().sum();
    }
  }
  r_ = r_end_;
  return settled;
}

void JointBody::own_end_load_step() {
  const double lost = joint_.friction.dot((r_ - begin_).cwiseAbs());
  work_.contact += spring_energy(r_) - energy_ + lost;
  work_.damping -= lost;
  energy_ = spring_energy(r_);
  begin_ = r_;
}

void JointBody::own_start_motion(double h, const std::vector<BodyLoad>&) {
  work_ = BodyWork();
  v_ = joint_.rates;
  last_h_ = h;
}

BodyState JointBody::own_state() const {
  BodyState state;
  state.center_of_mass = joint_.at + to_scene(0) * r_.head<3>();
  state.strain_energy = energy_;
  if (!joint_.is_mass()) return state;
  const Vector6 momenta = joint_.mass * v_;
  state.momentum = to_scene(0) * momenta.head<3>();
  state.angular_momentum =
      to_scene(1) * momenta.tail<3>() + state.center_of_mass.cross(state.momentum);
  state.kinetic_energy = 0.5 * v_.dot(momenta);
  return state;
}

void JointBody::own_displacements(Points& u, Points& v) const {
  u.resize(2, 3);
  v.resize(2, 3);
  for (Index i = 0; i < 2; ++i) {
    u.row(i) = (to_scene(i) * r_.segment<3>(3 * i)).transpose();
    v.row(i) = (to_scene(i) * v_.segment<3>(3 * i)).transpose();
  }
}

void JointBody::own_coordinates(Vector& q, Vector& rates) const {
  q = r_;
  rates = v_;
}

void JointBody::own_keep_state(StateArchive& archive) {
  archive(r_, v_, h_, last_h_, energy_, work_);
  if (joint_.bends()) archive(first_answer_, slides_, begin_);
  if (follows_) archive(maps_[0], maps_[1]);
}

}  // namespace cbr
