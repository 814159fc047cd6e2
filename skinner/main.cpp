// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "common/linalg/blas_kernels.hpp"
#include "common/program.hpp"
#include "skinner/command.hpp"

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  CLI::App app("Puts blocks of fictitious shells on the sidesets of a mesh, or on the surfaces of a scene's instances.",
               "cbr-skin");
  app.footer(
      "examples:\n"
      "  cbr-skin impact.yaml                                    writes skin: mesh of the scene; the scene goes to a pipe\n"
      "  cbr-reduce impact.yaml | cbr-skin - | cbr-dyn - -o results.h5\n"
      "  cbr-skin block.msh --sideset contact -o skinned.msh");
  cbr::CommonOptions common;
  cbr::SkinCommand command;
  cbr::add_common_options(app, common);
  app.add_option("INPUT", command.input, "a scene (YAML), - for a scene on stdin, or a mesh (.msh .exo .e .g)")->required();
  app.add_option("--sideset", command.sidesets, "a sideset of the mesh to skin; may be given more than once")
      ->allow_extra_args(false);
  app.add_option("-o,--output", command.output, "the skinned mesh (.msh .exo .e .g); in a scene it stands under skin: mesh");
  return cbr::run_program(app, argc, argv, [&] {
    cbr::Report report("cbr-skin", common.verbosity(), common.timings);
    cbr::set_threads(common.threads);
    cbr::run_skin(command, cbr::filter_output(), report);
    report.write_timings();
  });
}
