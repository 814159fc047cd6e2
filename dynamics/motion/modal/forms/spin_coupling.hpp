// SPDX-License-Identifier: GPL-3.0-or-later
// Coriolis forces and the inertia of second order of the elastic modes of a body that spins.
#pragma once

#include <array>

#include "common/base/types.hpp"

namespace cbr {

// |w|^2 tr S - w . S w = g . S, S as xx, yy, zz, xy, yz, xz   (6)
Vector centrifugal(const Vector3& w);

// With P_ij = integral of rho phi_i phi_j^T and G_a = integral of rho (phi_i x phi_j)_a, the
// angular momentum of modes eta that move at eta' in axes that spin at w is J w + h, with
//   J = J_0 + J_1(eta) + sum eta_i eta_j (tr P_ij 1 - P_ij),   h_a = eta^T G_a eta'.
// The momenta of the modes are p = eta' - G(w) eta, G(w) = sum w_a G_a. In them L = (J - Q) w + h,
// with Q_ab = G_a eta . G_b eta and h_a = eta^T G_a p, and
//   eta' = p + G(w) eta,   p' = ... + G(w) p + (C(w) + G(w)^2) eta,
//   C(w)_ij = |w|^2 tr P_ij - w . P_ij w,
// where ... are the forces without this coupling (docs/theory.md, "Bodies that turn"). Of the first
// m elastic modes; all vectors in component axes, eta and p of all modes (n).
class SpinCoupling {
 public:
  // P: Superelement::spin_couplings. n: modes there are, rigid ones first.
  SpinCoupling(const Matrix& P, Index n_rigid, Index n);

  Index first() const { return first_; }
  Index size() const { return G_[0].rows(); }

  // Of a deformed shape on the rotation.
  struct Shape {
    Matrix3 inertia = Matrix3::Zero();   // of second order, less Q
    Vector3 momentum = Vector3::Zero();  // h
    Matrix drift = Matrix::Zero(0, 3);   // m x 3: G_a eta
  };
  Shape shape(const Vector& eta, const Vector& p) const;
  Vector3 momentum(const Vector& eta, const Vector& p) const { return momentum(drift(eta), p); }

  // Of a spin on the modes.
  struct Pull {
    double w = 0;  // rad/s
    Matrix G, C;   // m x m
  };
  Pull pull(const Vector3& w) const;
  // G eta   (m)
  Vector drift(const Pull& pull, const Vector& eta) const {
    return pull.G * eta.segment(first_, size());
  }
  // The motion of the coupling alone, for a time: exact. damping: rates c of all modes (n) or none;
  // they brake eta', of which others have taken p.
  void move(const Pull& pull, double time, const Vector& damping, Vector& eta, Vector& p) const;

 private:
  Matrix drift(const Vector& eta) const;
  Vector3 momentum(const Matrix& drift, const Vector& p) const {
    return -drift.transpose() * p.segment(first_, size());
  }

  Index first_;
  std::array<Matrix, 3> G_;
  std::array<Matrix, 6> P_;  // xx, yy, zz, xy, yz, xz, symmetric parts
};

}  // namespace cbr
