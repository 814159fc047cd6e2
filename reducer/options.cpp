// SPDX-License-Identifier: GPL-3.0-or-later
// The command line of cbr-reduce.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "common/error.hpp"
#include "common/program.hpp"
#include "reducer/command.hpp"

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

std::string word_in(const std::string& option, const std::string& found, const std::vector<std::string>& allowed) {
  if (found.empty()) return allowed.front();
  for (const auto& word : allowed) {
    if (word == found) return found;
  }
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
        "--characteristic-modes, --keep, --pressure, --patterns, --shear and --statics go with --basis characteristic");
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
  app.add_option("INPUT", command.input, "a scene (YAML), - for a scene on stdin, or a mesh (.msh .exo .e .g)")->required();
  auto* mesh = app.add_option_group("with a mesh", "what a scene says about its component");
  mesh->add_option("--interface", command.interface_sets,
                   "sideset or nodeset whose nodes are kept; may be given more than once. Every other set of the mesh that lies "
                   "within the kept nodes is kept too")
      ->allow_extra_args(false)
      ->type_name("NAME");
  auto* modes = mesh->add_option("--modes", command.modes, "number of fixed-interface modes kept, 0 or more")->type_name("N");
  auto* cutoff = mesh->add_option("--cutoff-hz", command.cutoff_hz, "keep every fixed-interface mode below this frequency")
                     ->type_name("HZ")
                     ->excludes(modes);
  mesh->add_option("--tolerance", command.tolerance,
                   "keep as few modes as get the ten lowest squared frequencies of the free component, and the interior's strain "
                   "energy under rigid accelerations of its interface, right to this relative error")
      ->type_name("SHARE")
      ->excludes(modes)
      ->excludes(cutoff);
  mesh->add_option("--pick", command.pick, "frequency (default): the lowest; participation: those that the interface drives most")
      ->type_name("WORD");
  mesh->add_option("--youngs-modulus", command.youngs_modulus, "in the mesh's units, as all that follows")->type_name("E");
  mesh->add_option("--poissons-ratio", command.poissons_ratio, "between -1 and 0.5")->type_name("NU");
  mesh->add_option("--density", command.density, "mass per volume")->type_name("RHO");
  mesh->add_option("--element", command.element, "hex8-incompatible (default), hex8 or hex8-hourglass")->type_name("WORD");
  mesh->add_option("--mass", command.mass,
                   "auto (default: consistent for hex20 and tet10, lumped for others), lumped or consistent")
      ->type_name("WORD");
  mesh->add_option("--basis", command.basis,
                   "craig-bampton (default); massless: modes with all the mass and an interface without any; or characteristic: an "
                   "interface of few shapes")
      ->type_name("WORD");
  mesh->add_option("--massless-modes", command.massless_modes,
                   "of basis massless: free (default; MacNeal), tapered (free ones that fall off towards the last: for impacts) or "
                   "fixed (modified Craig-Bampton)")
      ->type_name("WORD");
  mesh->add_option("--characteristic-modes", command.characteristic_modes,
                   "of basis characteristic: the interface's own modes that stand for its dofs, 0 or more (default: a third of --modes, 10 to 40)")
      ->type_name("N");
  mesh->add_option("--keep", command.keep,
                   "of basis characteristic: set whose nodes keep their dofs, so that only the rest is reduced; may be given more "
                   "than once")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option("--pressure", command.pressure,
                   "of basis characteristic: sideset that gets static responses to patterns of pressure (default: those of "
                   "--statics); may be given more than once")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option("--patterns", command.patterns, "number of patterns on each of these (default 1, with --shear 3)")
      ->type_name("N");
  mesh->add_flag("--shear", command.shear, "patterns and statics in all directions, not only normal to the faces: for friction");
  mesh->add_option("--statics", command.statics,
                   "of basis characteristic: sideset that will touch, whose statics are kept in full (default: those of the "
                   "interface), or none; may be given more than once")
      ->allow_extra_args(false)
      ->type_name("NAME");
  mesh->add_option("--domains", command.domains, "parts that are reduced each by itself and share nodes (default 1)")
      ->type_name("N");
  mesh->add_flag("--recovery", command.recovery, "store what brings back the interior: Psi, Phi and the connectivity");
  mesh->add_option("-o,--output", command.output, "superelement file (default: the mesh's name with .cbr.h5, in this folder)")
      ->type_name("FILE");
  app.add_flag(
      "--estimate", command.estimate,
      "print what the reduction would give and cost, and reduce nothing: sizes, non-zeros, memory and times from the mesh's "
      "connectivity, beside Eqs 5-17 of the paper. With a mesh no material is needed, but for --cutoff-hz");
  app.add_flag(
      "--info", command.info,
      "print what INPUT is, a superelement, results, fields or a checkpoint: made of what, dofs, lowest frequencies, faces, "
      "mass, known errors");
  app.add_flag("--force", command.force, "reduce again, though nothing has changed");
  app.add_option_function<std::string>(
         "--memory",
         [&command](const std::string& text) {
           const std::string wrong = parse_bytes(text, command.memory);
           if (!wrong.empty()) throw CLI::ValidationError("--memory", wrong);
         },
         "for the constraint modes, as 500MB or 8GB (default: half of this machine's, less beside a large factor); less memory "
         "takes more time")
      ->type_name("SIZE");
  app.add_option(
         "--diagonal-limit", command.diagonal_limit,
         "store the diagonal form of superelements up to this many coordinates (default 6000; 3000 of domains put together)")
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
  } else {
    scene.materials["material"] = {
        number_in("--youngs-modulus", command.youngs_modulus, 0, INFINITY, "a positive number"),
        number_in("--poissons-ratio", command.poissons_ratio, -1, 0.5, "a number between -1 and 0.5 (both excluded)"),
        number_in("--density", command.density, 0, INFINITY, "a positive number")};
  }
  if (!command.element.empty()) component.element = parse_hex8_formulation(command.element);
  const std::string mass = word_in("--mass", command.mass, {"auto", "lumped", "consistent"});
  if (mass != "auto") component.mass = mass == "lumped" ? MassKind::lumped : MassKind::consistent;
  if (command.interface_sets.empty()) throw InputError("--interface is missing: name the sideset or nodeset whose nodes are kept");
  if (!command.modes && !command.cutoff_hz && !command.tolerance)
    throw InputError("--modes, --cutoff-hz or --tolerance is missing: how many modes are kept?");
  if (command.modes && *command.modes < 0)
    throw InputError("--modes: " + std::to_string(*command.modes) + " found, 0 or more is allowed");
  if (command.cutoff_hz) number_in("--cutoff-hz", command.cutoff_hz, 0, INFINITY, "a positive frequency in Hz");
  if (command.tolerance) number_in("--tolerance", command.tolerance, 0, 1, "a number between 0 and 1 (both excluded)");
  if (command.tolerance && !command.pick.empty())
    throw InputError("--pick goes with --modes: a tolerance picks the modes by what they take part in");
  reduction.basis = word_in("--basis", command.basis, {"craig-bampton", "characteristic", "massless"});
  reduction.massless_modes = word_in("--massless-modes", command.massless_modes, {"free", "tapered", "fixed"});
  if (!command.massless_modes.empty() && !reduction.is_massless()) throw InputError("--massless-modes goes with --basis massless");
  reduction.interface_sets = command.interface_sets;
  reduction.modes = command.modes;
  reduction.cutoff_hz = command.cutoff_hz;
  reduction.tolerance = command.tolerance;
  reduction.pick = word_in("--pick", command.pick, {"frequency", "participation"});
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
