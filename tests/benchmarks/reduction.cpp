// SPDX-License-Identifier: GPL-3.0-or-later
// Reduction of the paper's T1 block, (a) x_max with 80 modes and (c) the whole surface with 500: time by phase, peak memory, and
// the rate of the dense phases beside that of dgemm in the same run. Arguments: refinement r (20r x 10r x 15r hexes; below 1 for
// a smoke run), then cases out of "ac". Writes CSV to stdout.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/program.hpp"
#include "reducer/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace {

using cbr::Index;

double dgemm_rate(Index n) {
  const cbr::Matrix A = cbr::Matrix::Constant(n, n, 0.5), B = cbr::Matrix::Constant(n, n, 0.25);
  cbr::Matrix C = A * B;
  double best = 0;
  for (int i = 0; i < 5; ++i) {
    const auto start = std::chrono::steady_clock::now();
    C.noalias() += A * B;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = std::max(best, 2 * static_cast<double>(n * n * n) / seconds);
  }
  return C(0, 0) > 0 ? best : 0;
}

void run(const std::string& name, const cbr::Mesh& mesh, const std::string& set, Index modes, double dgemm) {
  cbr::ReductionOptions options;
  options.interface_sets = {set};
  options.modes = modes;
  cbr::Report report("reduction", cbr::Verbosity::quiet);
  cbr::ReductionFigures f;
  const cbr::Superelement s =
      cbr::reduce(mesh, cbr::test::properties(mesh, cbr::test::paper_steel()), cbr::MassKind::lumped, options, {}, report, &f);
  for (const char* phase : {"assembly", "factorisation", "fixed-interface modes", "condensation", "diagonal form"}) {
    std::printf("%s,%lld,%lld,%lld,%s,%.3f\n", name.c_str(), static_cast<long long>(f.n_dofs), static_cast<long long>(s.c()),
                static_cast<long long>(s.k()), phase, report.seconds(phase));
  }
  std::printf("# %s: factor %.3g nnz, %.2f GFlop, %.1f GFlop/s; modes by %s\n", name.c_str(), f.factor_nonzeros,
              1e-9 * f.factor_flops, 1e-9 * f.factor_flops / report.seconds("factorisation"), f.mode_method.c_str());
  std::printf("# %s: condensation %.2f GFlop in solves, %.2f in products, %.1f GFlop/s; dgemm %.1f GFlop/s; peak memory %s\n",
              name.c_str(), 1e-9 * f.solve_flops, 1e-9 * f.product_flops,
              1e-9 * (f.solve_flops + f.product_flops) / report.seconds("condensation"), 1e-9 * dgemm,
              cbr::human_bytes(cbr::peak_memory_bytes()).c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double r = argc > 1 ? std::atof(argv[1]) : 1;
  const std::string cases = argc > 2 ? argv[2] : "a";
  const auto elements = [&](double n) { return std::max<Index>(1, static_cast<Index>(r * n + 0.5)); };
  const cbr::Mesh mesh = cbr::test::box_mesh(cbr::test::paper_block(elements(20), elements(10), elements(15)));
  const double dgemm = dgemm_rate(r < 1 ? 200 : 3000);
  std::printf("case,dofs,interface,modes,phase,seconds\n");
  if (cases.find('a') != std::string::npos) run("T1a", mesh, "x_max", r < 1 ? 5 : 80, dgemm);
  if (cases.find('c') != std::string::npos) run("T1c", mesh, "surface", r < 1 ? 5 : 500, dgemm);
  return 0;
}
