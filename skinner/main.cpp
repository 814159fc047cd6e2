// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "common/app/program.hpp"
#include "common/linalg/blas_threads.hpp"
#include "skinner/skin.hpp"

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  CLI::App app(
      "Adds blocks of fictitious shells to sidesets of a mesh, or to surfaces of a scene's "
      "instances.",
      "cbr-skin");
  app.footer(
      "examples:\n"
      "  cbr-skin impact.yaml                                    writes the mesh of skin: mesh\n"
      "  cbr-reduce impact.yaml | cbr-skin - | cbr-dyn - -o results.h5\n"
      "  cbr-skin block.msh --sideset contact -o skinned.msh");
  cbr::CommonOptions common;
  cbr::SkinCommand command;
  cbr::add_common_options(app, common);
  app.add_option("INPUT", command.input,
                 "scene (YAML), - for a scene on standard input, or mesh (.msh .exo .e .g .inp "
                 ".bdf .med .unv .vtk)")
      ->required();
  app.add_option("--sideset", command.sidesets, "sideset of the mesh to skin; may be repeated")
      ->allow_extra_args(false);
  app.add_option("-o,--output", command.output,
                 "output mesh (.msh .exo .e .g); in a scene give skin: mesh instead");
  return cbr::run_program(app, argc, argv, [&] {
    cbr::Report report("cbr-skin", common.verbosity(), common.timings);
    cbr::set_threads(common.threads);
    cbr::run_skin(command, cbr::filter_output(), report);
    report.write_timings();
  });
}
