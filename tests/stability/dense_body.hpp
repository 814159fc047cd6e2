// SPDX-License-Identifier: GPL-3.0-or-later
// One body of dense matrices: its free motion and its response to impulses.
#pragma once

#include <cmath>
#include <vector>

#include "common/linalg/dense.hpp"
#include "common/scene/scene.hpp"
#include "tests/stability/dense_oracle.hpp"

namespace cbr::test {

struct DenseBody {
  Matrix K, M;               // of the free coordinates q
  Matrix B;                  // 3 n x q: displacements of its n visible nodes, scene axes
  Points X;                  // n x 3, scene axes
  Vector velocity;           // initial q'
  std::vector<Vector> load;  // amplitude of each load on q
  std::vector<History> history;
  enum class Scheme { exact, central, newmark } scheme = Scheme::exact;
  // impulses of contact have the compliance of a constant force (docs/theory.md, (35))
  bool lasting = false;
};

// Modes of the body's motion; `inverse`: V^-1.
struct DenseMotionModes {
  Vector omega;
  Matrix V, inverse;
};
DenseMotionModes dense_motion_modes(const DenseBody& body);

// B S(h) B^T of all visible dofs: response at the end of a step to impulses at its start
// (docs/theory.md, (34), (36), (37)).
Matrix dense_response(const DenseBody& body, double h);

// A step: predict(), then push() any number of times, accept(). Impulses on the visible dofs, 3 n.
class DenseStepper {
 public:
  DenseStepper(const DenseBody& body, double h);
  void predict();
  void push(const Vector& impulse);
  // at the end of the step, with constant positions (docs/theory.md, (38))
  void push_velocities(const Vector& impulse);
  void accept();

  const Points& start() const { return start_; }  // n x 3
  const Points& end() const { return end_; }
  Vector end_velocity() const { return body_.B * v_; }  // 3 n
  const Matrix& response() const { return W_; }
  Matrix velocity_response() const { return body_.B * inverse_.solve(Matrix(body_.B.transpose())); }
  double largest_frequency() const { return modes_.omega.size() > 0 ? modes_.omega.maxCoeff() : 0; }
  bool is_newmark() const { return body_.scheme == DenseBody::Scheme::newmark; }

 private:
  Vector force(double t) const;
  void advance();  // from the start of the step, with the impulse on q
  void advance_exactly(const Vector& impulse);
  Points positions(const Vector& q) const {
    return body_.X + (body_.B * q).reshaped<Eigen::RowMajor>(body_.X.rows(), 3);
  }

  const DenseBody& body_;
  double h_, t_ = 0;
  DenseMotionModes modes_;
  Cholesky inverse_, inverse_A_;  // of M; of M + h^2 / 4 K
  Matrix W_;
  Vector q_, v_, a_;     // at the end of the step
  Vector q0_, v0_, a0_;  // at its start
  Vector impulse_;
  Points start_, end_;
};

}  // namespace cbr::test
