// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/modal_propagator.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace cbr {
namespace {

// sum over m >= 0 of (-x^2)^m / (2 m + k)! times `weight(2 m + k)`: every function below is one of
// these.
template <typename Weight>
double series(double x, int k, const Weight& weight) {
  double factorial = 1;
  for (int i = 2; i <= k; ++i) factorial *= i;
  double power = 1 / factorial, sum = 0;
  for (int n = k; n < k + 24; n += 2) {
    sum += power * weight(n);
    power *= -x * x / ((n + 1.0) * (n + 2.0));
  }
  return sum;
}

struct LoadTerms {
  double a0, a1, b0, b1, i0, i1;  // in units of h^2, h^2, h, h, h^3, h^3
};

LoadTerms load_terms(double x) {
  if (x < 1) {
    // a0 = (sin x - x cos x)/x^3, a1 = (x - sin x)/x^3, b0 = (x sin x + cos x - 1)/x^2, b1 = (1 -
    // cos x)/x^2, i0 = (1/2 - b0)/x^2, i1 = a1 - i0
    const auto one = [](int) { return 1.0; };
    const auto n_less_1 = [](int n) { return n - 1.0; };
    return {series(x, 3, n_less_1), series(x, 3, one),      series(x, 2, n_less_1),
            series(x, 2, one),      series(x, 4, n_less_1), series(x, 4, one)};
  }
  const double sine = std::sin(x), cosine = std::cos(x), x2 = x * x;
  const double a1 = (x - sine) / (x2 * x), b0 = (x * sine + cosine - 1) / x2, i0 = (0.5 - b0) / x2;
  return {(sine - x * cosine) / (x2 * x), a1, b0, (1 - cosine) / x2, i0, a1 - i0};
}

}  // namespace

double modal_energy(const Vector& omega, const ModalState& state) {
  const Vector forces = omega.cwiseProduct(state.eta);
  return 0.5 * (state.v.squaredNorm() + forces.squaredNorm());
}

ModalPropagator modal_propagator(const Vector& omega, double h, bool with_loads) {
  const Index n = omega.size();
  ModalPropagator step;
  step.h = h;
  for (Vector* v : {&step.c, &step.s, &step.t, &step.sign}) v->resize(n);
  for (Index j = 0; j < n; ++j) {
    const double x = omega[j] * h;
    const double cosine = std::cos(x), sine = std::sin(x);
    step.c[j] = cosine;
    step.s[j] = x == 0 ? h : sine / omega[j];
    step.sign[j] = cosine < 0 ? -1 : 1;
    step.t[j] = omega[j] * step.sign[j] * sine / (1 + std::abs(cosine));
  }
  if (!with_loads) return step;
  for (Vector* v : {&step.a0, &step.a1, &step.b0, &step.b1, &step.i0, &step.i1}) v->resize(n);
  for (Index j = 0; j < n; ++j) {
    const LoadTerms terms = load_terms(omega[j] * h);
    step.a0[j] = h * h * terms.a0;
    step.a1[j] = h * h * terms.a1;
    step.b0[j] = h * terms.b0;
    step.b1[j] = h * terms.b1;
    step.i0[j] = h * h * h * terms.i0;
    step.i1[j] = h * h * h * terms.i1;
  }
  return step;
}

namespace {

// phi_k(z) = sum over m of z^m / (m + k)!: e^(z t) integrated k times from 0 to 1. z <= 0.
struct Phi {
  double p0, p1, p2, p3;
};

Phi phi(double z) {
  if (z > -1) {
    const auto sum = [z](int k) {
      double term = 1;
      for (int i = 2; i <= k; ++i) term /= i;
      double all = term;
      for (int m = 1; m < 24; ++m) {
        term *= z / (m + k);
        all += term;
      }
      return all;
    };
    return {std::exp(z), sum(1), sum(2), sum(3)};
  }
  Phi of{std::exp(z), 0, 0, 0};
  of.p1 = (of.p0 - 1) / z;
  of.p2 = (of.p1 - 1) / z;
  of.p3 = (of.p2 - 0.5) / z;
  return of;
}

// g(t) = sum g_n t^n with g_0 = 0, g_1 = 1: integrals of it where neither x nor d is large.
void integrate_series(double x, double d, DampedStep& step) {
  double before = 0, now = 1;
  step.P1 = step.P2 = step.P3 = 0;
  for (int n = 1; n < 60; ++n) {
    step.P1 += now / (n + 1);
    step.P2 += now / ((n + 1.0) * (n + 2.0));
    step.P3 += now / ((n + 1.0) * (n + 2.0) * (n + 3.0));
    const double next = -(d * n * now + x * x * before) / ((n + 1.0) * n);
    before = now;
    now = next;
  }
}

}  // namespace

// With delta = d / 2 and y^2 = |x^2 - delta^2|, below critical damping G = e^-delta sin(y) / y;
// above it the roots are -delta +- y. Integrating the equation gives 1 - slope - d G = x^2 P1, 1 -
// G - d P1 = x^2 P2, 1/2 - P1 - d P2 = x^2 P3.
DampedStep damped_step(double x, double d) {
  DampedStep step{};
  const double delta = 0.5 * d, D = (x - delta) * (x + delta), y = std::sqrt(std::abs(D));
  if (D > 0) {
    const double q = std::exp(-delta);
    step.G = q * (y > 0 ? std::sin(y) / y : 1);
    step.slope = q * std::cos(y) - delta * step.G;
  } else {
    const double slow = std::exp(delta > 0 ? -x * x / (delta + y) : 0);
    step.G = slow * (y > 0 ? -std::expm1(-2 * y) / (2 * y) : 1);
    step.slope = slow * 0.5 * (1 + std::exp(-2 * y)) - delta * step.G;
  }
  if (D < 0 && d > 4 && y > 1) {
    const Phi slow = phi(-x * x / (delta + y)), fast = phi(-delta - y);
    step.P1 = (slow.p1 - fast.p1) / (2 * y);
    step.P2 = (slow.p2 - fast.p2) / (2 * y);
    step.P3 = (slow.p3 - fast.p3) / (2 * y);
  } else if (x >= 1) {
    step.P1 = (1 - step.slope - d * step.G) / (x * x);
    step.P2 = (1 - step.G - d * step.P1) / (x * x);
    step.P3 = (0.5 - step.P1 - d * step.P2) / (x * x);
  } else {
    integrate_series(x, d, step);
  }
  return step;
}

ModalPropagator damped_propagator(const Vector& omega, const Vector& damping, double h,
                                  bool with_loads) {
  const Index n = omega.size();
  ModalPropagator step;
  step.h = h;
  for (Vector* v : {&step.c, &step.s, &step.back, &step.stay, &step.j0, &step.j1}) v->resize(n);
  if (with_loads)
    for (Vector* v : {&step.a0, &step.a1, &step.b0, &step.b1, &step.i0, &step.i1}) v->resize(n);
  for (Index j = 0; j < n; ++j) {
    const double x = omega[j] * h, d = damping[j] * h;
    const DampedStep of = damped_step(x, d);
    step.c[j] = of.slope + d * of.G;
    step.s[j] = h * of.G;
    step.back[j] = -omega[j] * x * of.G;
    step.stay[j] = of.slope;
    step.j0[j] = h * (of.G + d * of.P1);
    step.j1[j] = h * h * of.P1;
    if (!with_loads) continue;
    step.a0[j] = h * h * (of.P1 - of.P2);
    step.a1[j] = h * h * of.P2;
    step.b0[j] = h * (of.G - of.P1);
    step.b1[j] = h * of.P1;
    step.i0[j] = h * h * h * (of.P2 - of.P3);
    step.i1[j] = h * h * h * of.P3;
  }
  return step;
}

ModalPropagator modal_propagator(const Vector& omega, const ModalRates& damping, double h,
                                 bool with_loads) {
  if (damping.hash == 0) return modal_propagator(omega, h, with_loads);
  ModalPropagator step = damped_propagator(omega, damping.c, h, with_loads);
  step.damping = damping.hash;
  return step;
}

void propagate_free(const ModalPropagator& step, const Vector& eta, const Vector& v,
                    Vector& eta_end, Vector& v_end) {
  const Index n = eta.size();
  eta_end.resize(n);
  v_end.resize(n);
  if (step.is_damped()) {
    eta_end.array() = step.c.array() * eta.array() + step.s.array() * v.array();
    v_end.array() = step.back.array() * eta.array() + step.stay.array() * v.array();
    return;
  }
  const double *s = step.s.data(), *t = step.t.data(), *sign = step.sign.data(), *eta0 = eta.data(),
               *v0 = v.data();
  double* __restrict eta1 = eta_end.data();
  double* __restrict v1 = v_end.data();
  for (Index j = 0; j < n; ++j) {
    const double half = v0[j] - t[j] * eta0[j], end = sign[j] * eta0[j] + s[j] * half;
    eta1[j] = end;
    v1[j] = sign[j] * half - t[j] * end;
  }
}

void add_load(const ModalPropagator& step, const Vector& f0, const Vector& f1, Vector& eta_end,
              Vector& v_end) {
  eta_end.array() += step.a0.array() * f0.array() + step.a1.array() * f1.array();
  v_end.array() += step.b0.array() * f0.array() + step.b1.array() * f1.array();
}

double load_work(const ModalPropagator& step, const Vector& eta, const Vector& v,
                 const Vector& eta_end, const LinearForce& all, const LinearForce& of) {
  const Vector &f0 = of.start, &f1 = of.end;
  // By parts: int f eta' dt = f0 (eta1 - eta0) + (f1 - f0) (eta1 - (int eta dt) / h)
  if (step.is_damped()) {
    const Vector integral = step.j0.cwiseProduct(eta) + step.j1.cwiseProduct(v) +
                            step.i0.cwiseProduct(all.start) + step.i1.cwiseProduct(all.end);
    const Vector work =
        f0.cwiseProduct(eta_end - eta) + (f1 - f0).cwiseProduct(eta_end - integral / step.h);
    return work.sum();
  }
  const auto integral = step.s.array() * eta.array() + step.b1.array() * step.h * v.array() +
                        step.i0.array() * all.start.array() + step.i1.array() * all.end.array();
  const auto work = f0.array() * (eta_end - eta).array() +
                    (f1 - f0).array() * (eta_end.array() - integral / step.h);
  return work.sum();
}

Vector contact_gain(const Vector& omega, double h) {
  Vector gain(omega.size());
  for (Index j = 0; j < omega.size(); ++j) {
    const double x = 0.5 * omega[j] * h;
    assert(x < 0.5 * std::numbers::pi);
    gain[j] = x < 1e-4 ? 1 + x * x / 3 : std::tan(x) / x;
  }
  return gain;
}

Vector contact_gain(const Vector& omega, const Vector& damping, Index n_rigid, double h) {
  Vector gain = Vector::Ones(omega.size());
  for (Index j = n_rigid; j < omega.size(); ++j) {
    const DampedStep of = damped_step(omega[j] * h, damping[j] * h);
    gain[j] = (of.P1 * (1 - of.slope) + of.G * of.G) / of.G;
  }
  return gain;
}

}  // namespace cbr
