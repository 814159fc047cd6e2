// SPDX-License-Identifier: GPL-3.0-or-later
// The exact solution of uncoupled oscillators eta'' + omega^2 eta = f over a step h with f linear
// in time.
#pragma once

#include "common/base/types.hpp"
#include "dynamics/motion/damping.hpp"

namespace cbr {

// Modal coordinates and their rates, n each.
struct ModalState {
  Vector eta, v;
};
// Kinetic and strain energy.
double modal_energy(const Vector& omega, const ModalState& state);

// Coefficients per mode (n) for one step length. With x = omega h:
//   eta(h) = c eta0 + s v0 + a0 f0 + a1 f1,   v(h) = -omega sin(x) eta0 + c v0 + b0 f0 + b1 f1,
//   integral of eta over the step = s eta0 + b1 h v0 + i0 f0 + i1 f1     (for the work of a
//   load)
struct ModalPropagator {
  double h = 0;
  Vector c, s;  // cos x, sin(x)/omega (h for a rigid mode)
  // omega tan(y / 2), +1 for y = x; where cos x < 0 y = x - pi, and -1
  Vector t, sign;
  Vector a0, a1, b0, b1, i0, i1;  // load terms; empty unless requested
  // With damping eta'' + c eta' + omega^2 eta = f, else empty (then t and sign are):
  //   eta(h) = c eta0 + s v0 + ...,   v(h) = back eta0 + stay v0 + ...,   integral = j0 eta0 + j1
  //   v0 + ...
  Vector back, stay, j0, j1;
  std::size_t damping = 0;  // hash of the rates; 0: without
  bool is_damped() const { return stay.size() > 0; }
  // v(h) of a unit velocity at the start.
  const Vector& velocity_left() const { return is_damped() ? stay : c; }
};

// G(1) of g'' + d g' + x^2 g = 0, g(0) = 0, g'(0) = 1, its slope, and G integrated once, twice and
// three times from 0 to 1: the parts of all coefficients of a damped step, under, at and above
// critical damping. x, d >= 0.
struct DampedStep {
  double G, slope, P1, P2, P3;
};
DampedStep damped_step(double x, double d);

// damping: n, 1/s, >= 0.
ModalPropagator damped_propagator(const Vector& omega, const Vector& damping, double h,
                                  bool with_loads);

// omega: n, rad/s, >= 0. No cancellation for small omega h: power series below x = 1.
ModalPropagator modal_propagator(const Vector& omega, double h, bool with_loads);
// Damped where there are rates of damping.
ModalPropagator modal_propagator(const Vector& omega, const ModalRates& damping, double h,
                                 bool with_loads);

// (eta, v) at the start -> at the end, without loads, as three shears:
//   v* = v0 - t eta0,   eta(h) = sign eta0 + s v*,   v(h) = sign v* - t eta(h).
// Each has determinant 1 whatever its coefficient, while cos^2 x + sin^2 x of rounded coefficients
// is 1 to some 1e-16 only, by which each step would multiply the energy: a million steps would
// change it by 1e-10. The outputs may not alias the inputs.
void propagate_free(const ModalPropagator& step, const Vector& eta, const Vector& v,
                    Vector& eta_end, Vector& v_end);

// Adds the part of a load with modal amplitude f0 at the start and f1 at the end, linear in
// between.
void add_load(const ModalPropagator& step, const Vector& f0, const Vector& f1, Vector& eta_end,
              Vector& v_end);

struct LinearForce {
  const Vector &start, &end;
};
// Work of one load over the step, exact for the exact motion that starts at (eta, v) and ends at
// eta_end under `all` loads together, itself among them.
double load_work(const ModalPropagator& step, const Vector& eta, const Vector& v,
                 const Vector& eta_end, const LinearForce& all, const LinearForce& of);

// Of each mode: tan x / x, x = omega h / 2 < pi / 2. A force F that acts as an impulse F h at the
// start of every step h leaves a mode that moves exactly at F / omega^2 times x / tan x at the
// steps' ends, where contact is tested, and not at F / omega^2: bodies would be stiffer in contact
// than they are (by 8 % at omega h = 1, 36 % at 2). Impulses of contact are given to modes with
// this gain, which makes the compression under a lasting force exact, at any step; rigid motions
// have gain 1. It is a modal mass and stiffness smaller by the gain for all that contact sees, so
// that energies are weighed by its inverse (docs/theory.md, "Compliance that lasts").
Vector contact_gain(const Vector& omega, double h);
// The same of damped modes, (P1 (1 - G') + G^2) / G of damped_step(): of no damping tan x / x too.
// The first n_rigid have gain 1.
Vector contact_gain(const Vector& omega, const Vector& damping, Index n_rigid, double h);

}  // namespace cbr
