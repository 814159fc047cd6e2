// SPDX-License-Identifier: GPL-3.0-or-later
// Reductions of blocks by phase: seconds, flops, the least bytes to and from memory, the rate and
// its share of that of dgemm in the same run, peak memory. CSV to stdout. Arguments, in any order:
// memory=BYTES for Psi and its panels and diagonal=N, as --memory and
// --diagonal-limit of cbr-reduce, and cases: T1a (the paper's block, x_max, 80 modes), T1c (its
// whole surface, 500 modes), or NXxNYxNZ:SET:MODES, a block of so many hexes with that side or
// `surface` as interface, such as 44x44x163:z_max:50.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/linalg/blas_threads.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace {

using cbr::Index;

struct Case {
  std::string name, set;
  Index nx = 0, ny = 0, nz = 0, modes = 0;
};

double dgemm_rate(Index n) {
  const cbr::Matrix A = cbr::Matrix::Constant(n, n, 0.5), B = cbr::Matrix::Constant(n, n, 0.25);
  cbr::Matrix C = A * B;
  double best = 0;
  for (int i = 0; i < 5; ++i) {
    const auto start = std::chrono::steady_clock::now();
    C.noalias() += A * B;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = std::max(best, 2 * static_cast<double>(n * n * n) / seconds);
  }
  return C(0, 0) > 0 ? best : 0;
}

struct Work {
  const char* phase;
  double flops, bytes;
};

// Of the modes and of the diagonal form what they take at the least: one solve a mode; LAPACK's
// counts.
std::vector<Work> work_of(const cbr::ReductionFigures& f, double c, double k) {
  const double n = c + k, reads = f.way == cbr::CondensationWay::second_solve ? 4 : 2;
  return {{"assembly", 0, 0},
          {"factorisation", f.factor_flops, 8 * f.factor_nonzeros},
          {"factorisation and condensation", f.factor_flops + f.front_flops, 8 * f.factor_nonzeros},
          {"fixed-interface modes", 4 * f.factor_nonzeros * static_cast<double>(f.n_candidates),
           16 * f.factor_nonzeros},
          {"condensation", f.solve_flops + f.product_flops,
           reads * 8 * f.factor_nonzeros *
                   std::ceil(c / static_cast<double>(std::max<Index>(f.panel, 1))) +
               16 * c * c},
          {"diagonal form", 20.0 / 3 * n * n * n, 4.0 / 3 * n * n * n}};
}

const char* way(cbr::CondensationWay of) {
  if (of == cbr::CondensationWay::fronts) return "fronts";
  return of == cbr::CondensationWay::second_solve ? "second solve" : "product";
}

void run(const Case& what, const cbr::ReduceSettings& settings, double dgemm) {
  cbr::ReductionOptions options;
  options.interface_sets = {what.set};
  options.modes = what.modes;
  cbr::Report report("reduction", cbr::Verbosity::quiet);
  cbr::ReductionFigures f;
  constexpr double h = 2.54e-3;
  const auto length = [](Index n) { return h * static_cast<double>(n); };
  const cbr::Mesh mesh = cbr::test::box_mesh({{what.nx, what.ny, what.nz},
                                              {length(what.nx), length(what.ny), length(what.nz)},
                                              {0, 0, 0},
                                              0});
  const cbr::Superelement s =
      cbr::reduce(mesh, cbr::test::properties(mesh, cbr::test::paper_steel()),
                  cbr::MassKind::lumped, options, settings, report, &f);
  for (const Work& w : work_of(f, static_cast<double>(s.c()), static_cast<double>(s.k()))) {
    const double seconds = report.seconds(w.phase);
    if (seconds == 0) continue;
    std::printf("%s,%lld,%lld,%lld,%.4g,%s,%.3f,%.4g,%.4g,%.4g,%.3f,%s,%.4g\n", what.name.c_str(),
                static_cast<long long>(f.n_dofs), static_cast<long long>(s.c()),
                static_cast<long long>(s.k()), f.factor_nonzeros, w.phase, seconds, w.flops,
                w.bytes, 1e-9 * w.flops / seconds, w.flops / seconds / dgemm, way(f.way),
                cbr::peak_memory_bytes());
  }
  std::fflush(stdout);
}

bool parse(const std::string& text, Case& result) {
  if (text == "T1a") {
    result = {text, "x_max", 20, 10, 15, 80};
    return true;
  }
  if (text == "T1c") {
    result = {text, "surface", 20, 10, 15, 500};
    return true;
  }
  long long n[4] = {};
  char set[32] = {};
  if (std::sscanf(text.c_str(), "%lldx%lldx%lld:%31[a-z_]:%lld", &n[0], &n[1], &n[2], set, &n[3]) !=
      5)
    return false;
  result = {text, set, n[0], n[1], n[2], n[3]};
  return std::min({n[0], n[1], n[2]}) > 0 && n[3] >= 0;
}

}  // namespace

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  std::vector<Case> cases;
  cbr::ReduceSettings settings;
  Index largest = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    Case next;
    if (text.rfind("memory=", 0) == 0) {
      settings.memory = std::atof(text.c_str() + 7);
    } else if (text.rfind("diagonal=", 0) == 0) {
      settings.diagonal_limit = std::atoll(text.c_str() + 9);
    } else if (parse(text, next)) {
      cases.push_back(next);
      largest = std::max(largest, next.nx * next.ny * next.nz);
    } else {
      std::fprintf(stderr,
                   "bench_reduction: '%s' is none of T1a, T1c, NXxNYxNZ:SET:MODES, memory=BYTES, "
                   "diagonal=N\n",
                   argv[i]);
      return 2;
    }
  }
  if (cases.empty()) {
    cases.push_back({"T1a", "x_max", 20, 10, 15, 80});
    largest = 3000;
  }
  const double dgemm = dgemm_rate(largest < 1000 ? 200 : 3000);
  std::printf("# dgemm %.1f GFlop/s\n", 1e-9 * dgemm);
  std::printf(
      "case,dofs,interface,modes,factor_nonzeros,phase,seconds,flops,bytes,gflops,share_of_dgemm,"
      "way,peak_memory\n");
  for (const Case& c : cases) run(c, settings, dgemm);
  return 0;
}
