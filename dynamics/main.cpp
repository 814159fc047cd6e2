// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn: explicit dynamics of superelements and meshes with contact.
#include <malloc.h>

#include <CLI/CLI.hpp>

#include "common/flush_denormals.hpp"
#include "common/linalg/blas_kernels.hpp"
#include "common/program.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/program.hpp"

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  // Matrices of a step come and go: giving their pages back each time costs more than the step, above all with threads
  mallopt(M_MMAP_THRESHOLD, 1 << 28);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  const cbr::FlushDenormals flush;  // before there are threads
  CLI::App app("Runs a scene of superelements and meshes with contact, and writes the results file.", "cbr-dyn");
  app.footer(
      "examples:\n"
      "  cbr-dyn impact.yaml -o results.h5                       superelements that the scene names are there already "
      "(cbr-reduce)\n"
      "  cbr-reduce impact.yaml | cbr-skin - | cbr-dyn - -o results.h5\n"
      "  cbr-dyn impact.yaml -o results.h5 --check-error         and what half of the modes would change\n"
      "  cbr-dyn impact.yaml -o results.h5 --restart results.checkpoint.h5");
  std::string scene, output, restart;
  cbr::BuildOptions build;
  cbr::CommonOptions common;
  app.add_option("SCENE", scene, "scene file (YAML); - reads standard input")->required();
  app.add_option("-o,--output", output, "results file (HDF5)")->required();
  app.add_option(
         "--diagonal-limit", build.diagonal_limit,
         "central-difference, newmark: superelements up to this many coordinates move in their diagonal form (default: those "
         "whose file has it, and up to 1500)")
      ->check(cbr::whole_number("coordinates", 0));
  app.add_option("--restart", restart, "go on from this checkpoint of the same scene (output.checkpoint)")->type_name("FILE");
  bool check_error = false;
  app.add_flag("--check-error", check_error,
               "run once more with half of the superelements' modes, and print what outputs and energies differ by; takes about "
               "as long again, and changes nothing of the results");
  cbr::add_common_options(app, common);
  return cbr::run_program(app, argc, argv, [&] {
    cbr::set_threads(common.threads == 0 && !restart.empty() ? cbr::threads_of_checkpoint(restart) : common.threads);
    cbr::Report report("cbr-dyn", common.verbosity(), common.timings);
    cbr::run_scene(scene, output, report, build, restart, check_error, common.timings);
    report.write_timings();
  });
}
