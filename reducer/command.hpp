// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer: cbr-reduce: its command line, what it tells, and --info.
//
// What the command line of cbr-reduce asks for, and doing it.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"

namespace CLI {
class App;
}

namespace cbr {

class Processes;

struct ReduceCommand {
  std::string input;  // a scene, "-", or a mesh
  // With a mesh: keys of reduction_keys() and their words as given. Empty: not given.
  std::map<std::string, std::vector<std::string>> reduction;
  std::optional<double> youngs_modulus, poissons_ratio, density;
  std::string element, mass, output;
  // With both.
  bool force = false;
  bool info = false;           // print a description of the file INPUT
  std::string export_format;   // write the superelement INPUT for another code; empty: no
  Index first_modal_node = 0;  // with export_format; 0: behind the interface's nodes
  std::string import_format;   // make a superelement of the file INPUT of another code; empty: no
  std::string faces;           // with it: the mesh that names the faces
  bool estimate = false;       // print the costs of the reductions, and reduce nothing
  double memory = 0;
  std::optional<Index> diagonal_limit;
  std::string engine;                    // "petsc", or empty: by the number of processes
  const Processes* processes = nullptr;  // null: this one alone

  bool reduces() const {
    return !info && !estimate && export_format.empty() && import_format.empty();
  }
  bool is_distributed() const;  // by several processes, or as they do it
  bool is_first() const;        // of the processes, which alone writes
};

void add_reduce_options(CLI::App& app, ReduceCommand& command);

// Reduces components that are out of date. Writes a scene to `scene_out` (null: nowhere).
// InputError: mesh options with a scene, missing ones with a mesh, all errors of a component
// (naming it). RunError: disk.
void run_reduce(const ReduceCommand& command, std::ostream* scene_out, Report& report);

// Prints results and costs of the reductions as tables; reduces and writes nothing. InputErrors as
// of run_reduce.
void run_estimate(const ReduceCommand& command, std::ostream& out, Report& report);

// The superelement INPUT for another code. InputErrors as of export_superelement().
void run_export(const ReduceCommand& command, Report& report);

// A superelement of the files INPUT of another code. InputErrors as of import_superelement(), and
// of options that it does not have.
void run_import(const ReduceCommand& command, Report& report);

// A scene with the one component that the options describe.
Scene scene_of_mesh(const ReduceCommand& command);

// --info: what a file of ours is, in words.
// Superelements and groups of them: provenance, dofs, lowest frequencies, faces, mass, errors.
// Results, fields and checkpoints: times, steps, instances. InputError: missing, damaged, or a file
// of another kind.
void print_info(const std::filesystem::path& file, std::ostream& out);

}  // namespace cbr
