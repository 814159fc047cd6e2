// SPDX-License-Identifier: GPL-3.0-or-later
// One body of dense matrices: how it moves by itself and what impulses do to it.
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
  Vector velocity;           // q' at the start
  std::vector<Vector> load;  // amplitude of each load on q
  std::vector<History> history;
  enum class Scheme { exact, central, newmark } scheme = Scheme::exact;
  // impulses of contact have the compliance of a force that lasts (docs/theory.md, (35))
  bool lasting = false;
  // exact: modes above this frequency have it, by their modal mass: docs/theory.md, (28)
  double clip = HUGE_VAL;
};

// Modes as the body moves in them; `inverse`: V^-1.
struct DenseMotionModes {
  Vector omega;
  Matrix V, inverse;
};
DenseMotionModes dense_motion_modes(const DenseBody& body);

// B S(h) B^T of all visible dofs: what impulses at the start of a step do to its end
// (docs/theory.md, (34), (36), (37)).
Matrix dense_response(const DenseBody& body, double h);

// A step: predict(), then push() any number of times, accept(). Impulses are of the visible dofs, 3
// n.
class DenseStepper {
 public:
  DenseStepper(const DenseBody& body, double h);
  void predict();
  void push(const Vector& impulse);
  // at the end of the step: positions stay (docs/theory.md, (38))
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
  void advance();  // from the start of the step by q and the impulse on it
  void advance_exactly(const Vector& impulse);
  Points positions(const Vector& q) const {
    return body_.X + (body_.B * q).reshaped<Eigen::RowMajor>(body_.X.rows(), 3);
  }

  const DenseBody& body_;
  double h_, t_ = 0;
  DenseMotionModes modes_;
  Cholesky inverse_, inverse_A_;  // of M; of M + h^2 / 4 K
  Matrix W_;
  Vector q_, v_, a_;     // end of the step
  Vector q0_, v0_, a0_;  // its start
  Vector impulse_;
  Points start_, end_;
};

}  // namespace cbr::test
