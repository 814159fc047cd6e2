// SPDX-License-Identifier: GPL-3.0-or-later
// The exact motion of kept modes and of the scaled part, from one time to another. For ScaledBody.
#pragma once

#include "dynamics/motion/modal/forms/modal_propagator.hpp"

namespace cbr {

// Kept: eta'' + omega^2 eta = f. Scaled, all at the clip: r'' + clip^2 r = p and y = S r; the last
// entries are of the loads.
struct ScaledState {
  Vector eta, v;        // n_kept
  Vector r, dr, y, dy;  // 3 m + loads

  void set_zero(Index n_kept, Index n_scaled);
};

// What contact_gain() gives to modal impulses: of the kept modes, and the one of the clip.
// Contact's energies are weighed by the inverse.
struct ScaledGain {
  Vector kept, weight;  // n_kept; empty: 1
  double scaled = 1;

  ScaledGain() = default;
  ScaledGain(const Vector& omega, double clip, double h);
};

// Modal and scaled impulses of a step, the gains included.
struct ScaledKick {
  Vector f;      // n_kept
  Vector p, Sp;  // 3 m + loads
  bool any = false;

  void set_zero(Index n_kept, Index n_scaled);
  void add(const ScaledKick& other);
  // Energy that the part `of` of this kick brings to `start`: of . (rates + this / 2), as the gain
  // weighs it; without one that of the modes as they are.
  double work(const ScaledKick& of, const ScaledState& start, const ScaledGain& gain = {}) const;
};

// Amplitudes of the loads at one time.
struct ScaledLoad {
  Vector f;      // n_kept
  Vector a, Sa;  // loads; 3 m + loads

  void set_zero(Index n_kept, Index n_scaled, Index n_loads);
};

struct ScaledStep {
  double h = 0;
  ModalPropagator kept, scaled;  // `scaled` of the one frequency
};

ScaledStep scaled_step(const Vector& omega, double clip, double h, bool with_loads);

// None of these may alias.
void propagate_free(const ScaledStep& step, const ScaledState& start, ScaledState& end);
void add_load(const ScaledStep& step, const ScaledLoad& f0, const ScaledLoad& f1, ScaledState& end);
double load_work(const ScaledStep& step, const ScaledState& start, const ScaledState& end,
                 const ScaledLoad& f0, const ScaledLoad& f1);
// Impulses at the start of the step, seen at its end; and at the start itself.
void add_kick(const ScaledStep& step, const ScaledKick& kick, ScaledState& end);
void add_kick(const ScaledKick& kick, ScaledState& start);

// Kinetic and strain energy of the scaled part: r'.S r' / 2, clip^2 r.S r / 2.
double scaled_kinetic_energy(const ScaledState& state);
double scaled_strain_energy(const ScaledState& state, double clip);

}  // namespace cbr
