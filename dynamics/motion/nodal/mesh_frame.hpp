// SPDX-License-Identifier: GPL-3.0-or-later
// The axes of a full mesh that turns by any angle.
#pragma once

#include <Eigen/Geometry>

#include "dynamics/motion/nodal/mesh_body.hpp"

namespace cbr {

// Where a mesh is without its strain. Axes are those of the component at the start.
struct MeshFit {
  Vector3 shift = Vector3::Zero();  // of the centre of mass
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Matrix3 R = Matrix3::Identity();          // of q
  Matrix3 less_one = Matrix3::Zero();       // R - 1, without cancellation
  Matrix3 inverse_G = Matrix3::Identity();  // see MeshFrame
};

// R is the rotation of the least sum m_i |x_i - c - R Y_i|^2, with c the centre of mass and Y_i the
// place from it at the start (Horn, Hilden, Negahdaripour 1988, doi 10.1364/JOSAA.5.001127). So
// S = R^T sum m_i (x_i - c) Y_i^T is symmetric, and a change of x turns R by theta = G^-1 sum m_i
// Y_i x R^T dx_i in its own axes, G = tr S 1 - S. With d_i = R^T (x_i - c) - Y_i the energy is 1/2
// d . K d, and -force its gradient in x. A consistent mass weighs alike: m_i Y_i becomes (M Y)_i.
// Rotations of nodes, Q_i = exp(u_i), do not fit the axes: m_i = 0 and Y_i = 0. Their strain is
// d_i = log(R^T Q_i), and the moment on them J(d_i)^-T (K d)_i, J the left Jacobian of exp.
class MeshFrame {
 public:
  // RunError: the mesh has no extent across some axis.
  explicit MeshFrame(const MeshModel& model);

  const Field& Y() const { return Y_; }  // n x 3, by rows of the forces
  // What fits the axes: linear in u.
  struct Sums {
    Vector3 momentum = Vector3::Zero();  // sum m_i u_i
    Matrix3 A = Matrix3::Zero();         // sum u_i (M Y)_i^T
  };
  Sums sums(const Field& u, RowThreads& threads) const;
  // of a displacement of one row more
  void add(Index row, const Vector3& u, Sums& sums) const;
  // from: a fit that is less than a quarter turn away.
  MeshFit fit(const Sums& sums, const MeshFit& from) const;
  // d, axes of the fit; of one row
  void strain(const MeshFit& fit, const Field& u, Field& d, RowThreads& threads) const;
  Vector3 strain(const MeshFit& fit, const Field& u, Index row) const;
  // theta of rates v, axes of the fit
  Vector3 turn(const MeshFit& fit, const Field& v) const;
  // The rates of d
  void strain_rates(const MeshFit& fit, const Field& d, const Field& v, Field& rates) const;
  // f = K d: moments on rotations become those above.
  void turn_moments(const Field& d, Field& f) const;
  // exp(turn) exp(u) as a rotation vector
  static Vector3 turned(const Vector3& turn, const Vector3& u);
  // R (f_i - lambda x (M Y)_i) is the gradient in x of forces f = K d in the axes of the fit: it
  // has no sum and no moment about c. So of any f whose sum is zero, of damping too.
  Vector3 lambda(const MeshFit& fit, const Field& d, const Field& f, RowThreads& threads) const;
  void pull_back(const MeshFit& fit, const Vector3& lambda, const Field& f, Field& gradient) const;
  // Lumped mass: v += s M^-1 (load - gradient), u_end = u + h v; returns the sums of u_end.
  // load: null, zero
  struct Step {
    const Field &f, &u;
    const Field* load;
    const Vector& inverse_mass;
    Field &v, &u_end;
    double s, h;
  };
  Sums leap(const MeshFit& fit, const Vector3& lambda, const Step& step, RowThreads& threads) const;

 private:
  Vector mass_;
  double total_;
  Field Y_, arms_;                // (M Y)_i
  Matrix3 S_0_;                   // sum (M Y)_i Y_i^T
  std::vector<Index> rotations_;  // rows
};

}  // namespace cbr
