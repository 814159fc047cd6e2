// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn: explicit dynamics of superelements and meshes with contact.
#include <CLI/CLI.hpp>

#include "common/app/program.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/huge_pages.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/program.hpp"

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  cbr::keep_heap_on_huge_pages();
  const cbr::FlushDenormals flush;  // before there are threads
  CLI::App app("Simulates a scene of superelements and meshes with contact, and writes results.",
               "cbr-dyn");
  app.footer(
      "examples:\n"
      "  cbr-dyn impact.yaml -o results.h5                       after cbr-reduce impact.yaml\n"
      "  cbr-reduce impact.yaml | cbr-skin - | cbr-dyn - -o results.h5\n"
      "  cbr-dyn impact.yaml -o results.h5 --restart results.checkpoint.h5");
  std::string scene, output, restart;
  cbr::BuildOptions build;
  cbr::CommonOptions common;
  app.add_option("SCENE", scene, "scene (YAML), or - for a scene on standard input")->required();
  app.add_option(
      "-o,--output", output,
      "results file (HDF5); required unless --modes is given, where it gets the mode shapes");
  cbr::Index modes = 0;
  app.add_option("--modes", modes,
                 "run nothing: print the lowest frequencies of each instance or tied group, with "
                 "damping ratios, as CSV")
      ->check(cbr::whole_number("modes", 1));
  bool sweep = false;
  app.add_flag("--sweep", sweep,
               "run nothing: write the harmonic response that the scene's sweep asks for");
  app.add_option("--diagonal-limit", build.diagonal_limit,
                 "with central-difference or newmark: largest number of coordinates for which a "
                 "superelement moves in diagonal form "
                 "(default: 1500, or any number if its file has the form)")
      ->check(cbr::whole_number("coordinates", 0));
  app.add_option("--restart", restart,
                 "continue from this checkpoint of the same scene (output.checkpoint)")
      ->type_name("FILE");
  bool check_error = false;
  app.add_flag("--check-error", check_error)->group("");  // retired
  cbr::add_common_options(app, common);
  return cbr::run_program(app, argc, argv, [&] {
    cbr::set_threads(common.threads == 0 && !restart.empty() ? cbr::threads_of_checkpoint(restart)
                                                             : common.threads);
    cbr::Report report("cbr-dyn", common.verbosity(), common.timings);
    if (check_error)
      throw cbr::InputError(
          "--check-error is retired: cbr.check_error(SCENE) of the Python package cbr runs the "
          "scene twice, with every basis");
    cbr::require_output(modes, sweep, output, restart);
    if (modes > 0) {
      cbr::print_modes(scene, modes, output, report, cbr::table_output());
    } else if (sweep) {
      cbr::sweep_scene(scene, output, report);
    } else {
      cbr::run_scene(scene, output, report, build, restart, common.timings);
    }
    report.write_timings();
  });
}
