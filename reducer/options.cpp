// SPDX-License-Identifier: GPL-3.0-or-later
// The command line of cbr-reduce.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "common/app/program.hpp"
#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/command.hpp"
#include "reducer/exchange/export/export_superelement.hpp"
#include "reducer/exchange/import/import_matrices.hpp"

namespace cbr {
namespace {

std::filesystem::path absolute(const std::string& path) { return std::filesystem::absolute(path).lexically_normal(); }

double number_in(const std::string& option, const std::optional<double>& value, double low, double high,
                 const std::string& allowed) {
  if (!value) throw InputError(option + " is missing: a mesh needs " + option + ", " + allowed);
  if (!std::isfinite(*value) || !(*value > low) || !(*value < high)) {
    throw InputError(option + ": " + std::to_string(*value) + " found, " + allowed + " is allowed");
  }
  return *value;
}

// The first of the words when there is none.
template <typename Value>
Value one_of(const std::string& option, const std::string& found, const Words<Value>& words) {
  if (found.empty()) return words.front().second;
  if (const auto value = value_of(words, found)) return *value;
  const std::vector<std::string> allowed = texts_of(words);
  throw InputError(option + ": '" + found + "' found, allowed: " + join(allowed) + nearest_name(found, allowed));
}

// "4GB", "500 MB", "1e9"
std::string parse_bytes(const std::string& text, double& bytes) {
  char* end = nullptr;
  bytes = std::strtod(text.c_str(), &end);
  std::string unit(end);
  unit.erase(0, unit.find_first_not_of(' '));
  for (char& letter : unit) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  double factor = 0;
  if (unit.empty() || unit == "B") factor = 1;
  if (unit == "KB" || unit == "K") factor = 1e3;
  if (unit == "MB" || unit == "M") factor = 1e6;
  if (unit == "GB" || unit == "G") factor = 1e9;
  if (unit == "TB" || unit == "T") factor = 1e12;
  bytes *= factor;
  const bool valid = end != text.c_str() && factor > 0 && std::isfinite(bytes) && bytes >= 1;
  return valid ? "" : "'" + text + "' is not a size, give one like 500MB or 8GB";
}

bool gives_characteristic(const ReduceCommand& command) {
  return command.characteristic_modes || command.patterns || command.shear || !command.keep.empty() || !command.pressure.empty() ||
         !command.statics.empty();
}

CharacteristicOptions characteristic_of(const ReduceCommand& command, const ReductionOptions& reduction) {
  if (!reduction.is_characteristic())
    throw InputError(
        "--characteristic-modes, --keep, --pressure, --patterns, --shear and --statics require --basis characteristic");
  CharacteristicOptions options;
  options.is_default_modes = !command.characteristic_modes;
  options.modes = command.characteristic_modes.value_or(default_shapes(command.modes));
  options.keep = command.keep, options.pressure = command.pressure;
  options.shear = command.shear;
  options.patterns = command.patterns.value_or(default_patterns(options));
  options.no_statics = command.statics == std::vector<std::string>{"none"};
  if (!options.no_statics) options.statics = command.statics;
  if (options.modes < 0)
    throw InputError("--characteristic-modes: " + std::to_string(options.modes) + " found, 0 or more is allowed");
  if (options.patterns < 0) throw InputError("--patterns: " + std::to_string(options.patterns) + " found, 0 or more is allowed");
  return options;
}

}  // namespace

void add_reduce_options(CLI::App& app, ReduceCommand& command) {
  app.add_option("INPUT", command.input, "scene (YAML), - for a scene on standard input, or mesh (.msh .exo .e .g .inp .bdf .unv .vtk)")->required();
  auto* mesh = app.add_option_group("with a mesh", "description of the component; in a scene these are keys");
  mesh->add_option("--interface", command.interface_sets,
                   "sideset or nodeset whose nodes are kept; may be repeated. Other sets within these nodes are kept too")
      ->allow_extra_args(false)
      ->type_name("NAME");
  auto* modes = mesh->add_option("--modes", command.modes, "number of fixed-interface modes, 0 or more; with --basis characteristic 80 if not given")->type_name("N");
  auto* cutoff = mesh->add_option("--cutoff-hz", command.cutoff_hz, "keep all fixed-interface modes below this frequency")
                     ->type_name("HZ")
                     ->excludes(modes);
  mesh->add_option(
          "--tolerance", command.tolerance,
          "choose the modes by this relative error of the ten lowest squared free frequencies, and of the interior's strain "
          "energy under rigid accelerations of the interface")
      ->type_name("SHARE")
      ->excludes(modes)
      ->excludes(cutoff);
  mesh->add_option("--pick", command.pick,
                   "frequency (default: the lowest modes) or participation (modes that the interface excites most)")
      ->type_name("WORD");
  mesh->add_option("--youngs-modulus", command.youngs_modulus, "in consistent units, like all quantities")->type_name("E");
  mesh->add_option("--poissons-ratio", command.poissons_ratio, "between -1 and 0.5")->type_name("NU");
  mesh->add_option("--density", command.density, "mass per volume")->type_name("RHO");
  mesh->add_option("--element", command.element, "hex8-incompatible (default), hex8 or hex8-hourglass")->type_name("WORD");
  mesh->add_option("--mass", command.mass,
                   "auto (default: consistent for hex20 and tet10, lumped for others), lumped or consistent")
      ->type_name("WORD");
  mesh->add_option(
          "--basis", command.basis,
          "craig-bampton (default: all interface dofs), characteristic (few shapes of the interface) or massless (no mass on "
          "the interface)")
      ->type_name("WORD");
  mesh->add_option("--massless-modes", command.massless_modes,
                   "with massless: free (default; MacNeal), tapered (free modes with a tapered interface part, for impacts) or "
                   "fixed (modified Craig-Bampton)")
      ->type_name("WORD");
  mesh->add_option(
          "--characteristic-modes", command.characteristic_modes,
          "with characteristic: number of modes that replace the interface's dofs, 0 or more (default: a third of --modes, "
          "10 to 40)")
      ->type_name("N");
  mesh->add_option("--keep", command.keep, "with characteristic: set whose nodes keep all their dofs; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option(
          "--pressure", command.pressure,
          "with characteristic: sideset that gets static responses to patterns of pressure (default: those of --statics); may "
          "be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option("--patterns", command.patterns, "number of patterns for each of these sidesets (default: 1, with --shear 3)")
      ->type_name("N");
  mesh->add_flag("--shear", command.shear,
                 "patterns and statics in all directions, for friction (default: normal to the faces only)");
  mesh->add_option(
          "--statics", command.statics,
          "with characteristic: contact sideset whose static compliance is kept in full, or none (default: all sidesets of the "
          "interface); may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option("--domains", command.domains, "number of domains, which are reduced separately and share nodes (default: 1)")
      ->type_name("N");
  mesh->add_flag("--recovery", command.recovery,
                 "store Psi, Phi and the connectivity, to recover the interior's motion and stress");
  mesh->add_option("-o,--output", command.output,
                   "superelement file (default: name of the mesh with .cbr.h5, in the current folder)")
      ->type_name("FILE");
  auto* estimate = app.add_flag(
      "--estimate", command.estimate,
      "print the expected size, memory and time of the reduction, beside Eqs 5-17 of the paper, and do not reduce. A mesh "
      "needs no material for it, except with --cutoff-hz");
  auto* info = app.add_flag(
      "--info", command.info,
      "describe INPUT, which is a superelement, results, fields or checkpoint file: its origin, dofs, lowest frequencies, "
      "faces, mass and known errors");
  auto* exporting = app.add_option("--export", command.export_format,
                                   "write the superelement INPUT for other codes: " + join(export_format_names()) +
                                       "; -o gives the beginning of the files' names (docs/formats.md, \"Files for other codes\")")
                        ->type_name("FORMAT")
                        ->excludes(estimate)
                        ->excludes(info);
  auto* import = app.add_option("--import", command.import_format,
                                "make a superelement of INPUT, a file of another code: " + join(import_format_names()) +
                                    "; -o gives the superelement's name (docs/formats.md, \"Files of other codes\")")
                     ->type_name("FORMAT")
                     ->excludes(estimate)
                     ->excludes(info)
                     ->excludes(exporting);
  app.add_option("--faces", command.faces,
                 "with --import: the mesh of the same component, which gives the superelement its faces and node sets")
      ->type_name("MESH")
      ->needs(import);
  app.add_flag("--force", command.force, "reduce even if the superelement file is up to date");
  app.add_option_function<std::string>(
         "--memory",
         [&command](const std::string& text) {
           const std::string wrong = parse_bytes(text, command.memory);
           if (!wrong.empty()) throw CLI::ValidationError("--memory", wrong);
         },
         "memory for the constraint modes, e.g. 500MB (default: half of RAM minus the factor); less is slower")
      ->type_name("SIZE");
  app.add_option("--diagonal-limit", command.diagonal_limit,
                 "largest number of coordinates for which the diagonal form is stored (default: 6000; 3000 for joined domains)")
      ->type_name("N")
      ->check(whole_number("coordinates", 0));
}

Scene scene_of_mesh(const ReduceCommand& command) {
  Scene scene;
  Component component;
  ReductionOptions reduction;
  component.name = std::filesystem::path(command.input).stem().string();
  component.mesh = absolute(command.input);
  component.material = "material";
  reduction.source.file = component.source.file = "command line";
  const bool no_material = !command.youngs_modulus && !command.poissons_ratio && !command.density;
  if (command.estimate && no_material && !command.cutoff_hz) {
    scene.materials["material"] = {1, 0, 1};  // nothing depends on it
  } else if (no_material && may_hold_materials(component.mesh)) {
    component.material.clear();  // that of the file
  } else {
    scene.materials["material"] = {
        number_in("--youngs-modulus", command.youngs_modulus, 0, INFINITY, "a positive number"),
        number_in("--poissons-ratio", command.poissons_ratio, -1, 0.5, "a number between -1 and 0.5 (both excluded)"),
        number_in("--density", command.density, 0, INFINITY, "a positive number")};
  }
  if (!command.element.empty()) component.element = parse_hex8_formulation(command.element);
  component.mass = one_of("--mass", command.mass, mass_words);
  if (command.interface_sets.empty()) throw InputError("--interface is missing: name the sideset or nodeset whose nodes are kept");
  const bool has_default = command.basis == word_of(basis_words, Basis::characteristic);
  if (!command.modes && !command.cutoff_hz && !command.tolerance && !has_default)
    throw InputError("--modes, --cutoff-hz or --tolerance is missing: give one of them");
  if (command.modes && *command.modes < 0)
    throw InputError("--modes: " + std::to_string(*command.modes) + " found, 0 or more is allowed");
  if (command.cutoff_hz) number_in("--cutoff-hz", command.cutoff_hz, 0, INFINITY, "a positive frequency in Hz");
  if (command.tolerance) number_in("--tolerance", command.tolerance, 0, 1, "a number between 0 and 1 (both excluded)");
  if (command.tolerance && !command.pick.empty())
    throw InputError("--pick requires --modes: with --tolerance the modes are chosen by participation");
  reduction.basis = one_of("--basis", command.basis, basis_words);
  reduction.massless_modes = one_of("--massless-modes", command.massless_modes, massless_words);
  if (!command.massless_modes.empty() && !reduction.is_massless()) throw InputError("--massless-modes requires --basis massless");
  reduction.interface_sets = command.interface_sets;
  reduction.modes = command.modes;
  if (has_default && !command.cutoff_hz && !command.tolerance) reduction.modes = command.modes.value_or(default_modes);
  reduction.cutoff_hz = command.cutoff_hz;
  reduction.tolerance = command.tolerance;
  reduction.pick = one_of("--pick", command.pick, pick_words);
  reduction.domains = command.domains.value_or(1);
  if (reduction.domains < 1) throw InputError("--domains: " + std::to_string(reduction.domains) + " found, 1 or more is allowed");
  reduction.recovery = command.recovery;
  if (reduction.is_characteristic() || gives_characteristic(command))
    reduction.characteristic = characteristic_of(command, reduction);
  check_massless(reduction, "command line");
  check_characteristic(reduction, "command line");
  reduction.superelement = absolute(command.output.empty() ? component.name + ".cbr.h5" : command.output);
  component.reduction = reduction;
  Instance instance;
  instance.name = instance.component = component.name;
  scene.components[component.name] = component;
  scene.instances.push_back(instance);
  return scene;
}

}  // namespace cbr
