// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/modal_propagator.hpp"

#include <cmath>

namespace cbr {
namespace {

// sum over m >= 0 of (-x^2)^m / (2 m + k)! times `weight(2 m + k)`: every function below is one of these.
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
    // a0 = (sin x - x cos x)/x^3, a1 = (x - sin x)/x^3, b0 = (x sin x + cos x - 1)/x^2, b1 = (1 - cos x)/x^2,
    // i0 = (1/2 - b0)/x^2, i1 = a1 - i0
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
    step.a0[j] = h * h * terms.a0, step.a1[j] = h * h * terms.a1;
    step.b0[j] = h * terms.b0, step.b1[j] = h * terms.b1;
    step.i0[j] = h * h * h * terms.i0, step.i1[j] = h * h * h * terms.i1;
  }
  return step;
}

void propagate_free(const ModalPropagator& step, const Vector& eta, const Vector& v, Vector& eta_end, Vector& v_end) {
  const Index n = eta.size();
  eta_end.resize(n), v_end.resize(n);
  const double *s = step.s.data(), *t = step.t.data(), *sign = step.sign.data(), *eta0 = eta.data(), *v0 = v.data();
  double* __restrict eta1 = eta_end.data();
  double* __restrict v1 = v_end.data();
  for (Index j = 0; j < n; ++j) {
    const double half = v0[j] - t[j] * eta0[j], end = sign[j] * eta0[j] + s[j] * half;
    eta1[j] = end;
    v1[j] = sign[j] * half - t[j] * end;
  }
}

void add_load(const ModalPropagator& step, const Vector& f0, const Vector& f1, Vector& eta_end, Vector& v_end) {
  eta_end.array() += step.a0.array() * f0.array() + step.a1.array() * f1.array();
  v_end.array() += step.b0.array() * f0.array() + step.b1.array() * f1.array();
}

double load_work(const ModalPropagator& step, const Vector& eta, const Vector& v, const Vector& eta_end, const Vector& f0,
                 const Vector& f1, const Vector& weight) {
  // By parts: int f eta' dt = f0 (eta1 - eta0) + (f1 - f0) (eta1 - (int eta dt) / h)
  const auto integral = step.s.array() * eta.array() + step.b1.array() * step.h * v.array() + step.i0.array() * f0.array() +
                        step.i1.array() * f1.array();
  const auto work = f0.array() * (eta_end - eta).array() + (f1 - f0).array() * (eta_end.array() - integral / step.h);
  return weight.size() > 0 ? (work * weight.array()).sum() : work.sum();
}

}  // namespace cbr
