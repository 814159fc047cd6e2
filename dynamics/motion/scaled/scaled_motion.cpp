// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/scaled/scaled_motion.hpp"

#include <cmath>

#include "dynamics/motion/modal/contact_gain.hpp"

namespace cbr {

void ScaledState::set_zero(Index n_kept, Index n_scaled) {
  for (Vector* x : {&eta, &v}) x->setZero(n_kept);
  for (Vector* x : {&r, &dr, &y, &dy}) x->setZero(n_scaled);
}

void ScaledKick::set_zero(Index n_kept, Index n_scaled) {
  f.setZero(n_kept);
  p.setZero(n_scaled);
  Sp.setZero(n_scaled);
  any = false;
}

void ScaledKick::add(const ScaledKick& other) {
  if (any) {
    f += other.f;
    p += other.p;
    Sp += other.Sp;
  } else {
    f = other.f;
    p = other.p;
    Sp = other.Sp;
  }
  any = true;
}

ScaledGain::ScaledGain(const Vector& omega, double clip, double h)
    : kept(contact_gain(omega, h)),
      weight(kept.cwiseInverse()),
      scaled(clip < HUGE_VAL ? contact_gain(Vector::Constant(1, clip), h)[0] : 1) {}

double ScaledKick::work(const ScaledKick& of, const ScaledState& start,
                        const ScaledGain& gain) const {
  const auto modal = of.f.array() * (start.v.array() + 0.5 * f.array());
  return (gain.weight.size() > 0 ? (modal * gain.weight.array()).sum() : modal.sum()) +
         (of.p.dot(start.dy) + 0.5 * of.p.dot(Sp)) / gain.scaled;
}

void ScaledLoad::set_zero(Index n_kept, Index n_scaled, Index n_loads) {
  f.setZero(n_kept);
  a.setZero(n_loads);
  Sa.setZero(n_scaled);
}

ScaledStep scaled_step(const Vector& omega, double clip, double h, bool with_loads) {
  return {h, modal_propagator(omega, h, with_loads),
          modal_propagator(Vector::Constant(1, clip), h, with_loads)};
}

void propagate_free(const ScaledStep& step, const ScaledState& start, ScaledState& end) {
  propagate_free(step.kept, start.eta, start.v, end.eta, end.v);
  const double s = step.scaled.s[0], t = step.scaled.t[0], sign = step.scaled.sign[0];
  end.dr = start.dr - t * start.r;
  end.dy = start.dy - t * start.y;
  end.r = sign * start.r + s * end.dr;
  end.y = sign * start.y + s * end.dy;
  end.dr = sign * end.dr - t * end.r;
  end.dy = sign * end.dy - t * end.y;
}

void add_load(const ScaledStep& step, const ScaledLoad& f0, const ScaledLoad& f1,
              ScaledState& end) {
  add_load(step.kept, f0.f, f1.f, end.eta, end.v);
  if (end.r.size() == 0) return;
  const ModalPropagator& s = step.scaled;
  end.r.tail(f0.a.size()) += s.a0[0] * f0.a + s.a1[0] * f1.a;
  end.dr.tail(f0.a.size()) += s.b0[0] * f0.a + s.b1[0] * f1.a;
  end.y += s.a0[0] * f0.Sa + s.a1[0] * f1.Sa;
  end.dy += s.b0[0] * f0.Sa + s.b1[0] * f1.Sa;
}

double load_work(const ScaledStep& step, const ScaledState& start, const ScaledState& end,
                 const ScaledLoad& f0, const ScaledLoad& f1) {
  const double kept = load_work(step.kept, start.eta, start.v, end.eta, f0.f, f1.f);
  const Index n = f0.a.size();
  if (end.r.size() == 0) return kept;
  // By parts as in modal_propagator.cpp, of the displacement y along each load: a0 (y1 - y0) + (a1
  // - a0) (y1 - (int y dt) / h)
  const ModalPropagator& s = step.scaled;
  const auto integral = s.s[0] * start.y.tail(n).array() +
                        s.b1[0] * step.h * start.dy.tail(n).array() +
                        s.i0[0] * f0.Sa.tail(n).array() + s.i1[0] * f1.Sa.tail(n).array();
  return kept + (f0.a.array() * (end.y - start.y).tail(n).array() +
                 (f1.a - f0.a).array() * (end.y.tail(n).array() - integral / step.h))
                    .sum();
}

void add_kick(const ScaledStep& step, const ScaledKick& kick, ScaledState& end) {
  end.eta.array() += step.kept.s.array() * kick.f.array();
  end.v.array() += step.kept.c.array() * kick.f.array();
  const double c = step.scaled.c[0], s = step.scaled.s[0];
  end.r += s * kick.p;
  end.dr += c * kick.p;
  end.y += s * kick.Sp;
  end.dy += c * kick.Sp;
}

void add_kick(const ScaledKick& kick, ScaledState& start) {
  start.v += kick.f;
  start.dr += kick.p;
  start.dy += kick.Sp;
}

double scaled_kinetic_energy(const ScaledState& state) { return 0.5 * state.dr.dot(state.dy); }

double scaled_strain_energy(const ScaledState& state, double clip) {
  return 0.5 * clip * clip * state.r.dot(state.y);
}

}  // namespace cbr
