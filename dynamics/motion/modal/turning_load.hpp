// SPDX-License-Identifier: GPL-3.0-or-later
// A load on a body that turns by any angle.
#pragma once

#include <Eigen/Geometry>

#include "dynamics/motion/body.hpp"

namespace cbr {

class ModalBody;

// A VectorForce on a body in axes that turn with it: all is linear in the vector b there.
class TurningLoad {
 public:
  // axes: those of the scene at the start. modal: undeformed.
  TurningLoad(const VectorForce& force, const LoadHistory& history, const ModalBody& modal);

  // n x 3: forces on the elastic modes, b = unit vectors
  const Matrix& elastic() const { return elastic_; }
  const LoadHistory& history() const { return history_; }
  // b and the resultant, the latter in the scene's axes, of a history of 1; q: unit quaternion of
  // the turn
  Vector3 vector(const Eigen::Quaterniond& q) const {
    return follows_ ? value_ : q.conjugate() * value_;
  }
  Vector3 resultant(const Eigen::Quaterniond& q) const { return q * (resultant_ * vector(q)); }
  // The moment about the centre of mass, scene axes, of a history of 1. eta: the modal coordinates.
  Vector3 moment(const Eigen::Quaterniond& q, const Vector& eta) const;
  // of the largest of the history; arms of the undeformed body
  double largest_vector() const { return value_.norm() * history_.largest(); }
  double largest_moment() const { return largest_of(moment_); }
  double largest_resultant() const { return largest_of(resultant_); }

 private:
  // of a vector that stays as it is, or points anywhere
  double largest_of(const Matrix3& map) const {
    return history_.largest() * (follows_ ? (map * value_).norm() : map.norm() * value_.norm());
  }
  Vector3 value_;
  bool follows_;
  LoadHistory history_;
  Matrix elastic_;
  Matrix3 resultant_ = Matrix3::Zero(), moment_ = Matrix3::Zero();  // columns: of unit vectors b
  Matrix bend_;  // n x 9: change of moment_ by each modal coordinate, column by column
};

}  // namespace cbr
