// SPDX-License-Identifier: GPL-3.0-or-later
// Impulses of a ball pressed into n x n points: seconds of each method over the number of points.
// Arguments: largest number of points (default 2500), largest dense response in MB (default 1500).
// docs/decisions/contact-solver.md holds a table of it. CSV to stdout.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/solve/augmented_lagrangian.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/newton/contact_newton.hpp"
#include "tests/benchmarks/seconds.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace {

using cbr::ContactLaw;
using cbr::Index;
using cbr::Vector;
using cbr::test::Press;

struct Case {
  std::string response, law;
  Index points = 0;
};

void row(const Case& of, const char* method, double time, int iterations, double residual,
         const cbr::test::Verdict& v) {
  std::printf("%s,%s,%lld,%s,%.4f,%d,%.1e,%lld,%lld,%lld\n", of.response.c_str(), of.law.c_str(),
              static_cast<long long>(of.points), method, time, iterations, residual,
              static_cast<long long>(v.open), static_cast<long long>(v.stick),
              static_cast<long long>(v.slide));
  std::fflush(stdout);
}

void measure(const Case& of, const Press& press) {
  const cbr::ContactProblem problem = cbr::contact_problem(press.W, press.laws);
  const double scale = press.g.lpNorm<Eigen::Infinity>();
  const Vector zero = Vector::Zero(press.g.size());
  const auto report = [&](const char* method, double time, int iterations, const Vector& p,
                          const Vector& gap) {
    const double residual = cbr::law_violations(problem, p, gap).lpNorm<Eigen::Infinity>() / scale;
    row(of, method, time, iterations, residual,
        cbr::test::judge(press.W, press.laws, press.g, {p, gap}));
  };
  const cbr::BlockGaussSeidel sweeps(problem);
  for (const auto linear : {cbr::LinearSolver::factor, cbr::LinearSolver::krylov}) {
    cbr::NewtonResult result;
    const double time = seconds([&] {
      cbr::ContactNewton newton;
      Vector p = zero, gap = press.g;
      sweeps.sweep(problem, of.law == "coulomb" ? 5 : 1, 1e-12 * scale, p, gap);
      result = newton.solve(problem, press.g, p, gap, linear, 30, 1e-12 * scale);
    });
    report(linear == cbr::LinearSolver::factor ? "newton-factor" : "newton-krylov", time,
           result.iterations, result.p, result.gap);
  }
  Vector p = zero, gap = press.g;
  int n = 0;
  double time = seconds([&] { n = sweeps.sweep(problem, 1000, 1e-11 * scale, p, gap); });
  report("sweeps", time, n, p, gap);
  if (press.g.size() > 600) return;  // its rank
  cbr::AugmentedLagrangian::Result result;
  time = seconds([&] {
    result = cbr::AugmentedLagrangian(problem).solve(problem, press.g, zero, 1e-11 * scale);
  });
  report("lagrangian", time, result.steps, result.p, press.g + respond(problem, result.p));
}

}  // namespace

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  const double largest = argc > 1 ? std::atof(argv[1]) : 2500,
               megabytes = argc > 2 ? std::atof(argv[2]) : 1500;
  std::printf("response,law,points,method,seconds,iterations,residual,open,stick,slide\n");
  for (const Index n : {10, 18, 32, 50, 71, 100}) {
    if (static_cast<double>(n * n) > largest) break;
    for (const auto law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
      const std::string name = law == ContactLaw::coulomb ? "coulomb" : "frictionless";
      const double rows = static_cast<double>(n * n * cbr::n_rows(law));
      for (const bool soft : {false, true})
        if (rows * rows * 8e-6 <= megabytes)
          measure({soft ? "dense-soft" : "dense-stiff", name, n * n},
                  cbr::test::dense_press(n, law, 0.3, soft));
      measure({"sparse", name, n * n}, cbr::test::sparse_press(n, law, 0.3));
    }
  }
  return 0;
}
