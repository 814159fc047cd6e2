// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/turning_body.hpp"

#include <cassert>
#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

TurningBody::TurningBody(std::string name, std::shared_ptr<const Superelement> superelement,
                         std::shared_ptr<const DiagonalForm> form, const Placement& placement, const Vector3& angular_velocity)
    : inner_(std::move(name), superelement, std::move(form), placement, Scheme::exact),
      free_(placement.T * superelement->rigid_body.inertia * placement.T.transpose()),
      L_(free_.J * angular_velocity) {}

// Rows of x: c + R (x - c). A body without spin keeps its bits.
void TurningBody::turn_about(const Vector3& centre, const Eigen::Quaterniond& q, Points& x) const {
  if (q.vec().isZero(0)) return;
  const Matrix3 R = q.toRotationMatrix();
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = (centre + R * (x.row(i).transpose() - centre)).transpose();
}

void TurningBody::positions(Index set, Points& x) const {
  inner_.positions(set, x);
  turn_about(inner_.state().center_of_mass, q_, x);
}

void TurningBody::predicted_positions(Index set, Points& x) const {
  inner_.predicted_positions(set, x);
  turn_about(inner_.predicted_center_of_mass(), q_end_, x);
}

// No turn takes a node farther from where it is without turn than twice its distance from the centre of mass.
MotionBound TurningBody::motion_bound(Index set) const {
  Points x;
  inner_.positions(set, x);
  const Vector3 centre = inner_.state().center_of_mass;
  const double radius = (x.rowwise() - centre.transpose()).rowwise().norm().maxCoeff();
  MotionBound bound = inner_.motion_bound(set);
  bound.lower.array() -= 2 * radius;
  bound.upper.array() += 2 * radius;
  return bound;
}

void TurningBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  inner_.mean_motion(set, position, velocity);
  const BodyState inner = inner_.state();
  const Vector3 v_c = inner.momentum / inner_.mass();
  const Vector3 arm = q_ * (position - inner.center_of_mass);
  position = inner.center_of_mass + arm;
  velocity = v_c + free_.angular_velocity(q_, L_).cross(arm) + q_ * (velocity - v_c);
}

void TurningBody::predict(double t, double h) {
  inner_.predict(t, h);
  q_end_ = free_.turned(q_, L_, h);
}

void TurningBody::accept() {
  inner_.accept();
  q_ = q_end_;
}

void TurningBody::add_impulses(Index, const Points&, ImpulseKind) { assert(false); }

Vector3 TurningBody::add_velocities(Index, const Points&, const Vector3&) {
  assert(false);
  return Vector3::Zero();
}

NodeResponse TurningBody::response(Index, double) const {
  assert(false);
  return {};
}

Points TurningBody::nodal_masses(Index) const {
  assert(false);
  return {};
}

void TurningBody::add_force(const Points&, const LoadHistory&) { assert(false); }

BodyState TurningBody::state() const {
  BodyState state = inner_.state();
  state.angular_momentum = L_ + state.center_of_mass.cross(state.momentum);
  state.kinetic_energy += 0.5 * L_.dot(free_.angular_velocity(q_, L_));
  state.rotation = 0;
  state.orientation = Eigen::Vector4d(q_.w(), q_.x(), q_.y(), q_.z());
  return state;
}

// X: n x 3, scene axes, undeformed; u, v: as they would be without the turn, and then as they are.
void TurningBody::turn(const Points& X, Points& u, Points& v) const {
  const BodyState inner = inner_.state();
  const Vector3 v_c = inner.momentum / inner_.mass(), w = free_.angular_velocity(q_, L_);
  const Matrix3 R = q_.toRotationMatrix();
  for (Index i = 0; i < X.rows(); ++i) {
    const Vector3 arm = R * (X.row(i) + u.row(i) - inner.center_of_mass.transpose()).transpose();
    const Vector3 rate = R * (v.row(i).transpose() - v_c);
    u.row(i) = (inner.center_of_mass + arm).transpose() - X.row(i);
    v.row(i) = (v_c + w.cross(arm) + rate).transpose();
  }
}

void TurningBody::displacements(Points& u, Points& v) const {
  inner_.displacements(u, v);
  turn(reference_positions(), u, v);
}

void TurningBody::keep_state(StateArchive& archive) {
  inner_.keep_state(archive);
  archive(q_.coeffs(), L_);
}

}  // namespace cbr
