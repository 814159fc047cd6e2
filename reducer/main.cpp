// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "common/app/program.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/huge_pages.hpp"
#include "reducer/command.hpp"
#include "reducer/distributed/processes.hpp"

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  cbr::Processes processes;  // after the restart, as it takes stderr of all processes but the first
  cbr::keep_heap_on_huge_pages(0.5 * cbr::machine_memory_bytes());
  cbr::one_heap_for_all_threads();
  CLI::App app(
      "Reduces finite element components to superelements that keep the faces of their interface.",
      "cbr-reduce");
  app.footer(
      "examples:\n"
      "  cbr-reduce impact.yaml                                  all components that instances use "
      "as superelements\n"
      "  cbr-reduce impact.yaml | cbr-skin - | cbr-dyn - -o results.h5\n"
      "  cbr-reduce block.msh --interface contact --modes 80 --youngs-modulus 2.1e11 "
      "--poissons-ratio 0.3 --density 7850 \\\n"
      "             -o block.cbr.h5\n"
      "  cbr-reduce block.msh --interface surface --modes 50 --domains 8 --estimate\n"
      "  cbr-reduce --info block.cbr.h5                          describe a superelement, results "
      "or checkpoint file\n"
      "  cbr-reduce --export dmig block.cbr.h5 -o block          block.dmig for Nastran, and "
      "block.dofs.csv\n"
      "  cbr-reduce --import sierra block.nc4 --faces block.exo -o block.cbr.h5");
  cbr::CommonOptions common;
  cbr::ReduceCommand command;
  cbr::add_common_options(app, common);
  cbr::add_reduce_options(app, command);
  return processes.end(cbr::run_program(app, argc, argv, [&] {
    processes.start(command.engine == "petsc");
    if (processes.is_started() && command.engine == "cholmod")
      throw cbr::InputError(
          "--engine cholmod reduces in one process, and mpirun has started several: leave out "
          "mpirun, or the option");
    if (processes.is_started() && common.threads == 0) common.threads = processes.threads();
    if (!processes.is_first()) common.timings.clear();
    command.processes = &processes;
    cbr::Report report("cbr-reduce", common.verbosity(), common.timings);
    cbr::set_threads(common.threads);
    if (!processes.is_first() && !command.reduces()) return;
    if (command.info) {
      cbr::print_info(command.input, cbr::table_output());
    } else if (!command.export_format.empty()) {
      cbr::run_export(command, report);
    } else if (!command.import_format.empty()) {
      cbr::run_import(command, report);
    } else if (command.estimate) {
      cbr::run_estimate(command, cbr::table_output(), report);
    } else {
      cbr::run_reduce(command, cbr::filter_output(), report);
    }
    report.write_timings();
  }));
}
